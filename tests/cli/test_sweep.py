"""`impactfem sweep`."""

import os
import re
import signal
from pathlib import Path

import pytest

from impactfem.stages.pounding import stage as sticks
from impactfem.system.errors import SolutionError


class TestSweep:
    SET = ("--set", "buildings[0].stiffness_factor=0.5,2", "--stage", "pounding")
    SHOW = ("--show", "sticks.west.frequency.1, sticks.east.frequency.1,")

    def test_a_table(self, program, new_case, tmp_path, monkeypatch, no_figures):
        monkeypatch.chdir(tmp_path)
        ended = program("-v", "sweep", new_case(tmp_path).name, *self.SET, *self.SHOW)
        assert ended.code == 0 and ended.err.count("stage pounding: done in") == 2
        assert re.search(r"\n +0\.5 +1\.581 +\S+ *\n +2 +3\.161 +", ended.out)
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
            assert ended.code == 2 and "Error: " in ended.err
        words = ("--set", "damping.rato=1", "--set", "contacts[0].gap=1:2", "--stage", "roof")
        ended = program("sweep", finished.case, *words)
        assert ended.code == 2 and ended.out == ""
        assert ended.err.count("error: command line: ") == ended.err.count("\n") == 3

    @pytest.mark.usefixtures("interruptible")
    def test_an_interrupt(self, program, new_case, tmp_path, monkeypatch):
        monkeypatch.setattr(
            sticks, "run_sticks", lambda *_, **__: os.kill(os.getpid(), signal.SIGINT)
        )
        ended = program("sweep", new_case(tmp_path), *self.SET, "--out", tmp_path / "s")
        assert ended.code == 130
        assert ended.err.splitlines()[-1] == "interrupted; run again to go on"
