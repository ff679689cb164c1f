"""What the program says of itself."""

import re

import pytest

from impactfem import __version__
from impactfem.run.stages import stage_names

COMMANDS = ("run", "sweep", "report", "compare", "check", "new", "verify", "bench")


class TestHelp:
    def test_the_program(self, program):
        for ended in (program("--help"), program()):
            assert not [name for name in COMMANDS if name not in ended.out + ended.err]
        assert program("--help").code == 0 and program().code == 2

    @pytest.mark.parametrize("command", COMMANDS)
    def test_each_command(self, program, command):
        ended = program(command, "--help")
        assert ended.code == 0 and re.match(f"Usage: .*impactfem {command} ", ended.out)

    def test_stages_are_named(self, program):
        told = re.findall(r"\w+", program("run", "--help").out)
        assert not set(stage_names()) - set(told)

    def test_version(self, program):
        ended = program("--version")
        assert (ended.code, ended.out) == (0, f"impactfem {__version__}\n")

    @pytest.mark.parametrize(
        "arguments",
        [["run"], ["check"], ["new"], ["walk"], ["run", "a", "b"], ["run", "a", "--stage"], ["-z"]],
        ids=" ".join,
    )
    def test_usage(self, program, tmp_path, monkeypatch, arguments):
        monkeypatch.chdir(tmp_path)
        ended = program(*arguments)
        assert ended.code == 2 and "Error: " in ended.err and ended.out == ""
        assert not list(tmp_path.iterdir())
