"""`impactfem run`."""

import errno
import json
import os
import re
import signal

import pytest

from impactfem.report.console import HEADER, LINES
from impactfem.run import check
from impactfem.run.folder import locked, open_run
from impactfem.stages.pounding import stage as sticks
from impactfem.system.errors import SolutionError
from impactfem.system.stop import SIGNALS


def hash_of(folder):
    """The case of the last run in a folder."""
    found = re.findall(r"case small.toml, hash (\w{12})", (folder / "run.log").read_text("utf-8"))
    return found[-1]


class TestRun:
    def test_a_pipe_with_blanks_and_accents_in_the_path(self, new_case, tmp_path, process):
        folder = tmp_path / "bâtiments à côté"
        folder.mkdir()
        case = new_case(folder)
        words = ("run", case.name, "--out", "mes résultats")
        ended = process(*words, cwd=folder)
        assert ended.code == 0, ended.err
        assert (folder / "mes résultats" / "summary.json").is_file()
        assert (folder / "mes résultats" / "figures" / "elevation.svg").is_file()
        # No bar, no colour: only text and line ends.
        for text in (ended.out, ended.err):
            assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f]", text)
        lines = ended.out.splitlines()
        assert len(lines) <= LINES and lines[0].split() == " ".join(HEADER).split()
        assert lines[-1] == "report: mes résultats/report.html"
        assert [line.split()[0] for line in lines[1:]].count("impacts") == 1
        assert lines[-2].startswith("published values: ") and lines[-3].startswith("checks: ")
        assert "Deux bâtiments, 2 cm -> mes résultats" in ended.err
        provenance = json.loads((folder / "mes résultats" / "provenance.json").read_text())
        assert provenance["command"] == ["impactfem", *words]
        log = (folder / "mes résultats" / "run.log").read_text(encoding="utf-8")
        assert "DEBUG   pounding: " in log and "Impacts" in log

    def test_again(self, program, copied, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        ended = program("run", copied.name, "--out", "run", "--stage", "pounding", "--resume")
        assert ended.code == 0 and "reused" in ended.err
        assert "stage pounding: starts" not in ended.err and "done in" not in ended.err

    def test_a_stage_says_that_it_starts_before_all_else(self, finished):
        """Then what it found, then that it is done; the next one starts after that."""
        log = (finished.folder / "run.log").read_text(encoding="utf-8")
        told = ["stage pounding: starts", " DEBUG   pounding: ", "stage pounding: done in "]
        told += ["stage report: starts", "stage report: done in "]
        assert [log.count(words) for words in told] == [1, log.count(told[1]), 1, 1, 1]
        assert sorted(told, key=log.index) == told and log.rindex(told[1]) < log.index(told[2])

    @pytest.mark.usefixtures("no_figures")
    def test_another_case_does_not_go_on(self, program, copied, edited, tmp_path):
        """It is refused, and nothing changes; without `--resume` it is computed."""
        words = ("run", copied, "--out", tmp_path / "run", "--stage", "pounding")
        log = (tmp_path / "run" / "run.log").read_bytes()
        before = hash_of(tmp_path / "run")
        edited(copied, ("restitution = 0.65", "restitution = 0.6"))
        ended = program(*words, "--resume")
        assert ended.code == 2 and ended.err.count("\n") == 1
        assert f"a run of small.toml with the hash {before}, and small.toml has" in ended.err
        assert (tmp_path / "run" / "run.log").read_bytes() == log
        assert program(*words).code == 0
        assert hash_of(tmp_path / "run") != before
        assert program(*words, "--resume").code == 0

    def test_a_case_of_another_name_goes_on(self, program, copied, tmp_path):
        other = copied.rename(tmp_path / "other.toml")
        ended = program("run", other, "--out", tmp_path / "run", "--resume", "--stage", "pounding")
        assert ended.code == 0 and "reused" in ended.err

    def test_the_checks_are_told(self, program, copied, tmp_path):
        ended = program("run", copied, "--out", tmp_path / "run", "--stage", "pounding")
        assert "warning: pounding: largest shear stress of a storey" in ended.err
        line = (
            r"stage pounding: .*the largest .* MN up to 100 Hz, at .*, \d+ checks passed, 3 failed"
        )
        assert re.search(line, ended.err)
        assert "displacement in the last period" in ended.err
        assert not re.search(r"time steps in an impact = .* \(at least 16\)", ended.err)

    def test_stores_of_an_earlier_run(self, program, copied, tmp_path):
        """What this run did not reach is not among its results, nor does damage to it count."""
        folder = tmp_path / "run"
        (folder / "transient.nc").write_bytes(b"of other inputs")
        words = ("run", copied, "--out", folder, "--stage", "pounding")
        ended = program(*words)
        assert ended.code == 0 and "\nspectrum, 5 %" in ended.out
        assert "3D model" not in ended.out
        manifest = json.loads((folder / "pounding.stage.json").read_text())
        manifest |= {"files": {"transient.nc": "0" * 64}, "drawings": {}}
        (folder / "transient.stage.json").write_text(json.dumps(manifest))
        ended = program(*words)
        assert ended.code == 0 and ended.out == f"results: {folder}\n"
        assert "warning: cannot read" in ended.err and "transient.nc" in ended.err

    @pytest.mark.usefixtures("no_figures")
    def test_a_building_that_stays_at_rest(self, program, new_case, tmp_path):
        """Loads on its neighbour alone, no ground motion, no impact: its spectra are zero."""
        case = new_case(tmp_path)
        text = case.read_text(encoding="utf-8")
        motion = text[text.index("[[motions]]") : text.index("# Laws of")]
        loads = '[[loads]]\nfile = "push.csv"\ndirection = [0, 1, 0]\n\n'
        case.write_text(text.replace(motion, loads), encoding="utf-8")
        force = "time [s],west.floor_3 [kN]\n0,0\n0.1,500\n0.2,0\n1,0\n"
        (tmp_path / "push.csv").write_text(force, encoding="utf-8")
        ended = program("run", case, "--out", tmp_path / "run", "--stage", "pounding")
        assert ended.code == 0, ended.err
        found = json.loads((tmp_path / "run" / "summary.json").read_text())
        values = {one["name"]: one["value"] for one in found}
        assert values["pounding.impacts"] == 0.0
        details = open_run(tmp_path / "run").details
        assert details["frs.east.floor_3.pfa"].value == 0.0
        assert details["frs.east.floor_3.peak_over_pfa"].value is None
        assert details["frs.floor_3.peak_over_pfa"].value > 1.0

    def test_details_with_v(self, program, copied, tmp_path):
        words = ("-v", "run", copied, "--out", tmp_path / "run", "--stage", "pounding")
        ended = program(*words)
        assert re.search(r"pounding: number of impacts = \d+; largest .* MN at", ended.err)
        assert re.search(r"time steps in an impact = .* \(at least 16\)", ended.err)
        assert re.search(r"motion\.pga\s+3\s+3\s+m/s2", ended.out)

    def test_a_computation_that_fails(self, program, new_case, tmp_path, monkeypatch):
        def fail(*_, **__):
            raise SolutionError("the response grew without bound")

        monkeypatch.setattr(sticks, "run_sticks", fail)
        (tmp_path / "run").mkdir()  # an empty folder may be used
        ended = program("run", new_case(tmp_path), "--out", tmp_path / "run")
        assert ended.code == 1
        assert ended.err.splitlines()[-1] == "error: the response grew without bound"
        assert [path.name for path in (tmp_path / "run").iterdir()] == ["run.log"]

    @pytest.mark.usefixtures("interruptible")
    @pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGXCPU])
    def test_a_signal(self, program, new_case, tmp_path, monkeypatch, number):
        monkeypatch.setattr(sticks, "run_sticks", lambda *_, **__: os.kill(os.getpid(), number))
        ended = program("run", new_case(tmp_path), "--out", tmp_path / "run")
        assert ended.code == 128 + number
        said = SIGNALS[number]
        assert ended.err.splitlines()[-1] == f"{said}; run again with --resume to go on"
        assert [path.name for path in (tmp_path / "run").iterdir()] == ["run.log"]
        last = (tmp_path / "run" / "run.log").read_text(encoding="utf-8").splitlines()[-1]
        assert f" WARNING {said}" in last

    @pytest.mark.usefixtures("interruptible")
    @pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGXCPU])
    def test_a_signal_before_anything_is_written(self, program, finished, monkeypatch, number):
        monkeypatch.setattr(check, "checked", lambda *_, **__: os.kill(os.getpid(), number))
        ended = program("check", finished.case)
        assert (ended.code, ended.err) == (128 + number, f"{SIGNALS[number]}\n")

    def test_the_system_refuses(self, program, new_case, tmp_path, monkeypatch):
        def fail(*_, **__):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "a file")

        monkeypatch.setattr(sticks, "run_sticks", fail)
        ended = program("run", new_case(tmp_path), "--out", tmp_path / "run")
        assert ended.code == 1
        words = "error: cannot read or write a file: No space left on device"
        assert ended.err.splitlines()[-1] == words
        assert "Traceback" in (tmp_path / "run" / "run.log").read_text(encoding="utf-8")

    def test_two_runs_in_one_folder(self, program, copied, tmp_path):
        """The folder of another run stays as it is, and the report, too."""
        before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
        with locked(tmp_path / "run"):
            for words in (("run", copied, "--out", tmp_path / "run"), ("report", tmp_path / "run")):
                ended = program(*words)
                assert ended.code == 2
                assert f"no other run works; process {os.getpid()} on " in ended.err
        assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
