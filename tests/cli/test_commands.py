"""`impactfem verify` and `bench`."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import typer.main

from bench import suite
from bench.suite import Figure
from docs.commands import faults as shell_faults
from impactfem import __version__, cli
from impactfem.case.template import PARTS
from impactfem.run.stages import stage_names
from impactfem.stages.pounding import stage as sticks
from impactfem.system import files
from impactfem.system.errors import SolutionError, printable
from impactfem.verify import manual
from impactfem.verify.row import Row

GEOMETRY = Path(__file__).parents[2] / "geometry"
GOOD = Row("good", "a length", 1.0, 1.0, "m", 1e-3, "nowhere")
BAD = Row("bad", "a length", 1.0, 1.1, "m", 1e-3, "nowhere")
NAN = Row("nan", "a length", 1.0, float("nan"), "m", 1e-3, "nowhere")


class TestVerify:
    def test_rows_and_json(self, program, tmp_path):
        path = tmp_path / "rows é.json"
        ended = program("verify", "--only", "sdll06", "--json", path)
        count = len(json.loads(path.read_text(encoding="utf-8")))
        assert ended.code == 0 and count >= 5
        assert ended.out.endswith(f"\n{count} of {count} within tolerance\n")

    def test_words_are_whole_in_a_pipe(self, program):
        out = program("verify", "--only", "newmark").out
        assert "displacement after 3 s in 2400" in out and "…" not in out

    @pytest.mark.parametrize("row", [GOOD, BAD, NAN], ids=["within", "beyond", "nan"])
    def test_a_row_that_fails(self, program, tmp_path, monkeypatch, row):
        monkeypatch.setattr(manual, "BENCHMARKS", {"one": lambda: [GOOD, row]})
        path, passed = tmp_path / "rows.json", row is GOOD
        for words in ((), ("--json", path)):
            ended = program("verify", *words)
            assert ended.code == (0 if passed else 1) and ("FAIL" in ended.out) != passed
            assert ended.out.endswith(f"{1 + passed} of 2 within tolerance\n")
        assert [entry["passed"] for entry in json.loads(path.read_text())] == [True, passed]

    def test_an_unknown_name(self, program):
        ended = program("verify", "--only", "roof")
        assert ended.code == 2 and "--only = 'roof'" in ended.err and "cantilever" in ended.err

    def test_a_file_that_cannot_be_written(self, program, tmp_path):
        ended = program("verify", "--only", "sdll06", "--json", tmp_path / "absent" / "a.json")
        assert ended.code == 1 and ended.err.startswith("error: cannot write")


def test_check_of_a_fit(program, tmp_path):
    """The shipped case and its fit; the case's own line follows."""
    case, fit = (GEOMETRY / f"updating{end}.toml" for end in ("", "_fit"))
    few = tmp_path / "few.toml"
    few.write_text(
        '[free."damping.ratio"]\nbounds = ["1 %", "9 %"]\n[[targets]]\n'
        'result = "building.mass"\nvalue = "600 t"\ndeviation = "200 %"\n'
    )
    ended = program("check", case, "--fit", few)
    assert ended.code == 0 and "1 parameter, 1 observation\n" in ended.out
    assert re.fullmatch(rf"{few}: valid, \d+ warnings?", ended.out.splitlines()[-2])
    assert "warning: " in ended.err and "targets[0].deviation = '200 %': more than" in ended.err
    ended = program("check", case, "--fit", fit)
    assert ended.code == 0 and ended.out.startswith("4 parameters, 120 observations\n")
    assert ended.out.splitlines()[-2:] == [f"{fit}: valid", f"{case}: valid"]
    assert "warning" not in ended.err


@pytest.mark.parametrize("sign", ["\x1b]0;title\x07", "\x9b31m", "\r", "\u202e"])
def test_names_command_no_terminal(program, new_case, tmp_path, sign):
    """The name of a case on the last line of `check`, and names of missing files and folders."""
    case = new_case(tmp_path)
    named = case.rename(case.with_name(f"a{sign}b.toml"))
    ended = program("check", named)
    assert ended.code == 0 and sign not in ended.out + ended.err
    assert printable(named.name) in ended.out
    ended = program("check", tmp_path / f"{sign}.toml")
    assert ended.code == 2 and sign not in ended.out + ended.err
    ended = program("sweep", named, "--set", "damping.ratio=5 %", "--out", tmp_path / sign)
    assert ended.code == 2 and sign not in ended.out + ended.err


def test_bench(program, tmp_path, monkeypatch):
    measured = [Figure("a kernel", 0.2, "s", 0.3)]
    monkeypatch.setitem(suite.GROUPS, "sticks", lambda: measured)
    monkeypatch.setitem(suite.GROUPS, "spectra", list)
    ended = program("bench", "--json", tmp_path / "bench.json")
    assert ended.code == 0 and "a kernel" in ended.out and "met" in ended.out
    assert json.loads((tmp_path / "bench.json").read_text())[0]["met"] is True


def test_bench_without_the_source_tree(program, tmp_path, monkeypatch):
    """As from a wheel."""
    monkeypatch.setattr(files, "_ROOT", tmp_path)
    ended = program("bench")
    assert ended.code == 1 and ended.err.startswith("error: ")
    assert "bench/suite.py is not there: this needs a clone of the source tree" in ended.err


COMMANDS = (
    *("run", "sweep", "fit", "report", "compare", "check", "new", "examples", "explain"),
    *("verify", "bench", "contacts"),
)


def test_contact_pairs_as_text(program):
    ended = program("contacts", GEOMETRY / "npp_pair_coupled.toml")
    assert ended.code == 0
    assert ended.out.count("[[contacts]]") == 1 and "floor = [1, 2, 3]" in ended.out
    assert program("contacts", GEOMETRY / "frame.toml").code == 2  # no contact law


class TestHelp:
    def test_the_program(self, program):
        for ended in (program("--help"), program()):
            assert not [name for name in COMMANDS if name not in ended.out + ended.err]
        assert program("--help").code == 0 and program().code == 2

    @pytest.mark.parametrize("command", COMMANDS)
    def test_each_command(self, program, command):
        ended = program(command, "--help")
        assert ended.code == 0 and re.match(f"Usage: .*impactfem {command} ", ended.out)
        assert re.search(f"(?m)^ +Example:\\n +impactfem {command} ", ended.out)

    def test_examples_are_commands_of_the_program(self, program):
        for command in COMMANDS:
            text = program(command, "--help").out.partition("Example:\n")[2]
            lines = "\n".join(x for x in text.splitlines() if x.startswith("    impactfem "))
            assert lines and not list(shell_faults(lines)), command
        assert list(shell_faults("impactfem fit --nothing"))

    def test_all_commands_are_tested(self):
        assert set(typer.main.get_command(cli.app).commands) == set(COMMANDS)

    def test_stages_are_named(self, program):
        told = re.findall(r"\w+", program("run", "--help").out)
        assert not set(stage_names()) - set(told)

    def test_version(self, program):
        ended = program("--version")
        assert (ended.code, ended.out) == (0, f"impactfem {__version__}\n")

    @pytest.mark.parametrize("module", ["impactfem", "impactfem.cli"])
    def test_as_a_module(self, module, tmp_path):
        def python_m(*words):
            return subprocess.run(
                [sys.executable, "-m", module, *words],
                cwd=tmp_path,
                capture_output=True,
                text=True,
                check=False,
            )

        assert python_m("--version").stdout == f"impactfem {__version__}\n"
        refused = python_m("check", "absent.toml")
        assert refused.returncode == 2 and refused.stderr.startswith("error: absent.toml: no such")

    @pytest.mark.parametrize(
        "arguments",
        [["run"], ["check"], ["new"], ["walk"], ["run", "a", "b"], ["run", "a", "--stage"], ["-z"]],
        ids=" ".join,
    )
    def test_usage(self, program, tmp_path, monkeypatch, arguments):
        monkeypatch.chdir(tmp_path)
        ended = program(*arguments)
        assert ended.code == 2 and "rror: " in ended.err and ended.out == ""
        assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("word", "near"), [("chek", "check"), ("explian", "explain"), ("examplse", "examples")]
)
def test_an_unknown_command(program, word, near):
    ended = program(word, "towers.toml")
    assert ended.code == 2 and ended.err.count("\n") == 1 and f"'{near}'" in ended.err
    ended = program("qqqq")
    assert ended.code == 2 and "run, sweep, fit" in ended.err


class TestSweep:
    SET = ("--set", "buildings[0].stiffness_factor=0.5,2", "--stage", "pounding")
    SHOW = ("--show", "sticks.west.frequency.1, sticks.east.frequency.1,")

    def test_a_table(self, program, new_case, tmp_path, monkeypatch, no_figures):
        monkeypatch.chdir(tmp_path)
        ended = program("-v", "sweep", new_case(tmp_path).name, *self.SET, *self.SHOW)
        assert ended.code == 0 and ended.err.count("stage pounding: done in") == 2
        assert re.search(r"\n +0\.5 +2\.355 +\S+ *\n +2 +4\.71 +", ended.out)
        places = [f"runs/small_sweep/sweep.{ending}" for ending in ("csv", "json", "svg")]
        assert ended.out.endswith(f"\nresults: {', '.join(places)}\n")
        lines = ended.err.splitlines()
        name = "variant 2 of 2, buildings0.stiffness_factor=2"
        assert lines.index("2 variants") < lines.index(f"{name}: starts")
        assert re.search(f"^{name}: done in .* s", ended.err, re.MULTILINE)
        assert all(Path(place).is_file() for place in places)

    def test_a_variant_that_fails(self, program, new_case, tmp_path, monkeypatch):
        def fail(*_, **__):
            raise SolutionError("the response grew without bound")

        monkeypatch.setattr(sticks, "run_sticks", fail)
        ended = program("sweep", new_case(tmp_path), *self.SET, "--out", tmp_path / "s")
        assert ended.code == 1 and ended.out.count("failed") == 2
        assert ended.err.count("failed: the response grew without bound") == 2

    def test_usage(self, program, finished):
        """What the command line refuses by itself, and the faults of the sweep, a line each."""
        for words in ((), ("--set", "damping.ratio=3 %", "--processes", "0")):
            ended = program("sweep", finished.case, *words)
            assert ended.code == 2 and "rror: " in ended.err
        words = ("--set", "damping.rato=1", "--stage", "roof")
        ended = program("sweep", finished.case, *words)
        assert ended.code == 2 and ended.out == ""
        assert ended.err.count("error: command line: ") == ended.err.count("\n") == 2

    @pytest.mark.usefixtures("interruptible")
    def test_an_interrupt(self, program, new_case, tmp_path, monkeypatch):
        monkeypatch.setattr(
            sticks, "run_sticks", lambda *_, **__: os.kill(os.getpid(), signal.SIGINT)
        )
        ended = program("sweep", new_case(tmp_path), *self.SET, "--out", tmp_path / "s")
        assert ended.code == 130
        assert ended.err.splitlines()[-1] == "interrupted; run again to go on"
        assert not (tmp_path / "s" / "sweep.csv").exists()


class TestCheckAndNew:
    def test_a_new_case_is_good(self, program, tmp_path, monkeypatch, names):
        monkeypatch.chdir(tmp_path)
        ended = program("new", "mine")
        assert ended.code == 0
        wrote = "wrote mine.toml\nwrote mine_floors.csv\n"
        assert ended.out == f"{wrote}next: impactfem check mine.toml\n"
        ended = program("check", "mine.toml")
        assert ended.code == 0
        assert ended.out.startswith("2 buildings, 3 contact pairs, 1 ground motion\n")
        assert ended.out.endswith("\nmine.toml: valid\n")
        assert names(tmp_path) == ["mine.toml", "mine_floors.csv"]

    def test_the_verdict_comes_last(self, new_case, tmp_path, process):
        """In one log of both streams: warnings, then the verdict with their number."""
        name = new_case(
            tmp_path, ('gap = "2 cm"', 'gap = "2 m"'), ("title = ", 'allow = "gap"\ntitle = ')
        ).name
        ended = process("check", name, cwd=tmp_path, joined=True)
        lines = ended.out.splitlines()
        count = sum(line.startswith("warning: ") for line in lines)
        assert ended.code == 0 and count > 1
        assert lines[-1] == f"{name}: valid, {count} warnings"
        first = next(k for k, line in enumerate(lines) if not line.startswith("warning: "))
        assert not any(line.startswith("warning: ") for line in lines[first:])
        wrong = tmp_path / "wrong"
        wrong.mkdir()
        new_case(wrong, ('gap = "2 cm"', 'gap = "2 kg"'))
        ended = process("check", name, cwd=wrong, joined=True)
        assert ended.code == 2 and ended.out.splitlines()[-1] == f"{name}: invalid, 1 error"

    def test_with_parts(self, program, tmp_path, monkeypatch, names):
        monkeypatch.chdir(tmp_path)
        assert program("new", "mine", "--minimal", "--with", "devices, ensemble").code == 0
        text = Path("mine.toml").read_text(encoding="utf-8")
        assert "[[devices]]" in text and "[ensemble]" in text and "#" not in text
        assert "mine_walls.csv" in names(tmp_path)
        assert program("check", "mine.toml").code == 0
        words = re.findall(r"\w+", program("new", "--help").out)
        assert set(PARTS) <= set(words)
        ended = program("new", "other", "--with", "roof,")
        assert ended.code == 2 and "--with = 'roof': known: structure" in ended.err

    def test_no_name(self, program, tmp_path, monkeypatch, names):
        monkeypatch.chdir(tmp_path)
        ended = program("new", "")
        assert ended.code == 2 and "NAME = '': expected the name of a case" in ended.err
        assert names(tmp_path) == []
        assert program("new", ".").code == 0 and "case.toml" in names(tmp_path)

    def test_a_report_of_no_run(self, program, tmp_path, names):
        for folder in (tmp_path, tmp_path / "nowhere"):
            ended = program("report", folder)
            assert ended.code == 2 and ended.err.count("\n") == 1
            assert "the folder holds no run to report on: case.json, " in ended.err
        assert names(tmp_path) == []

    def test_runs_that_cannot_be_compared(self, program, finished, tmp_path):
        """No run, the same run twice, and a frequency that is not positive."""
        shutil.copytree(finished.folder, tmp_path / "other")
        for highest in ("-1.0", "0.0", "nan", "inf"):
            ended = program("compare", finished.folder, tmp_path / "other", "--to", highest)
            assert ended.code == 2
            assert ended.err.startswith(f"error: command line: --to = {highest}: expected a posit")
        for one, other, words in (
            (tmp_path / "other", tmp_path / "." / "other", "expected the folder of another run"),
            (tmp_path, finished.folder, "the folder holds no run"),
        ):
            ended = program("compare", one, other)
            assert ended.code == 2 and words in ended.err
        assert [path.name for path in tmp_path.iterdir()] == ["other"]
