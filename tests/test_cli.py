import errno
import json
import os
import re
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from impactfem import __version__, cli, study
from impactfem.bench import suite
from impactfem.bench.figure import Figure
from impactfem.errors import SolutionError
from impactfem.stop import SIGNALS
from impactfem.study import sticks
from impactfem.study.folder import locked
from impactfem.study.stages import stage_names
from impactfem.verify import manual
from impactfem.verify.row import Row

PROGRAM = Path(sys.executable).parent / "impactfem"
COMMANDS = ("run", "sweep", "check", "new", "verify", "bench")
GOOD = Row("good", "a length", 1.0, 1.0, "m", 1e-3, "nowhere")
BAD = Row("bad", "a length", 1.0, 1.1, "m", 1e-3, "nowhere")
NAN = Row("nan", "a length", 1.0, float("nan"), "m", 1e-3, "nowhere")


@dataclass
class Ended:
    code: int
    out: str
    err: str


@pytest.fixture
def program(monkeypatch, capsys):
    """Run the program in this process, from its entry point on."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["impactfem", *map(str, arguments)])
        monkeypatch.setattr(os, "_exit", sys.exit)  # how a signal ends it
        try:
            cli.main()
            code = 0
        except SystemExit as end:
            code = end.code or 0
        found = capsys.readouterr()
        assert "Traceback" not in found.out + found.err
        return Ended(code, found.out, found.err)

    return run


def process(*arguments, **options):
    """Run the program as a process of its own, in a pipe."""
    ended = subprocess.run(
        [PROGRAM, *map(str, arguments)], capture_output=True, check=False, **options
    )
    return Ended(ended.returncode, ended.stdout.decode(), ended.stderr.decode())


def names(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def hash_of(folder):
    """The case of the last run in a folder."""
    found = re.findall(r"case small.toml, hash (\w{12})", (folder / "run.log").read_text("utf-8"))
    return found[-1]


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


class TestBadInput:
    @pytest.mark.parametrize(
        ("file", "change", "expected"),
        [
            ("small.toml", ('gap = "2 cm"', 'gap = "2 kg"'), "gap = '2 kg'.*length"),
            ("small.toml", ('gap = "2 cm"', "gap = 2"), "gap = 2.*unit"),
            ("small.toml", ('gap = "2 cm"\n', ""), r"contacts\[0\].gap.*missing"),
            ("small.toml", ("[pounding]\n", "[pounding]\nupdat = 1\n"), "pounding.updat.*update"),
            ("small.toml", ("poisson_ratio = 0.2", "poisson_ratio = nan"), "poisson_ratio.*nan"),
            ("small.toml", ('gap = "2 cm"', 'gap = "nan cm"'), "gap = 'nan cm'"),
            ("small.toml", ('gap = "2 cm"', 'gap = "-1 mm"'), "gap = '-1 mm'"),
            ("small.toml", ('"small_floors.csv" ', '"absent.csv"  '), "absent.csv.*no such file"),
            ("small.toml", ("[damping]", "[damping"), "not valid TOML"),
            ("small_floors.csv", ("3,192,", "3,-192,"), "line 9.*mass.*-192"),
            ("small_floors.csv", ("3,192,", "3,nan,"), "line 9.*mass.*nan"),
            ("small_floors.csv", ("\n3,192,", "\n2,192,"), "line 9.*floor.*2"),
            ("small_floors.csv", ("mass [t]", "mass [m]"), "mass"),
            ("small_floors.csv", ("mass [t]", "mass"), "mass"),
            ("small_floors.csv", (",3.5\n2,", ",3.5,9\n2,"), "line 7"),
        ],
        ids=[
            "wrong unit",
            "no unit",
            "missing key",
            "unknown key",
            "nan",
            "nan with unit",
            "gap below zero",
            "missing table",
            "no TOML",
            "negative mass",
            "nan in a table",
            "duplicate floor",
            "wrong unit in a table",
            "no unit in a table",
            "a column too many",
        ],
    )
    def test_a_fault(
        self, program, new_case, edited, tmp_path, monkeypatch, file, change, expected
    ):
        monkeypatch.chdir(tmp_path)
        new_case(tmp_path)
        edited(tmp_path / file, change)
        before = names(tmp_path)
        for command in ("run", "check"):
            ended = program(command, "small.toml")
            assert ended.code == 2 and ended.out == ""
            lines = set(ended.err.splitlines())
            # The table is named twice, by two buildings: so is a table that is not there.
            assert len(lines) == (2 if "absent" in expected else 1)
            for line in lines:
                assert line.startswith(f"error: {file}: ") and re.search(expected, line)
            assert names(tmp_path) == before

    @pytest.mark.parametrize(
        ("record", "expected"),
        [
            ("time [s],acceleration [m/s2]\n0,0\n0.02,1\n0.01,1\n", "record.csv: line 4"),
            ("", "the file is empty"),
            (bytes(range(256)) * 8, "not a text file"),
        ],
        ids=["unsorted", "empty", "junk"],
    )
    def test_a_record(self, program, with_record, tmp_path, monkeypatch, record, expected):
        monkeypatch.chdir(tmp_path)
        case = with_record(tmp_path, record)
        before = names(tmp_path)
        ended = program("run", case)
        assert ended.code == 2 and expected in ended.err and ended.err.count("\n") == 1
        assert names(tmp_path) == before

    @pytest.mark.parametrize(
        ("content", "expected"),
        [
            (b"", "the file is empty"),
            (b" \n\n", "the file is empty"),
            (bytes(range(256)), "not a text file"),
            (b"\x89HDF\r\n\x1a\n" + bytes(100), "not a text file"),
            ("directory", "this is a directory"),
            ("missing", "no such file"),
            ("device", "not an ordinary file"),
            (b"a = 1", "missing"),
        ],
        ids=["empty", "blank", "junk", "HDF5", "directory", "missing", "device", "another TOML"],
    )
    def test_a_case_file(self, program, tmp_path, monkeypatch, content, expected):
        monkeypatch.chdir(tmp_path)
        path = tmp_path / "a.toml"
        if isinstance(content, bytes):
            path.write_bytes(content)
        elif content == "directory":
            path.mkdir()
        elif content == "device":
            path = Path("/dev/null")
        before = names(tmp_path)
        ended = program("run", path)
        assert ended.code == 2 and expected in ended.err and ended.out == ""
        assert all(line.startswith("error: ") for line in ended.err.splitlines())
        assert names(tmp_path) == before

    @pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
    def test_a_case_without_permission(self, program, new_case, tmp_path):
        case = new_case(tmp_path)
        case.chmod(0)
        ended = program("check", case)
        assert ended.code == 2 and "cannot be read (Permission denied)" in ended.err

    def test_all_faults_at_once_as_a_process(self, new_case, edited, tmp_path):
        case = new_case(
            tmp_path,
            ('gap = "2 cm"', 'gap = "2 kg"'),
            ("restitution = 0.65", "restitution = 1.65"),
            ('[spectra]\ndamping = ["5 %"]', "[spectra]\ndampings = []"),
        )
        edited(tmp_path / "small_floors.csv", ("3,192,", "3,-192,"))
        before = names(tmp_path)
        ended = process("run", case.name, cwd=tmp_path)
        assert ended.code == 2 and ended.out == "" and "Traceback" not in ended.err
        for key in ("contacts[0].gap", "restitution", "spectra.dampings", "line 9"):
            assert len([line for line in ended.err.splitlines() if key in line]) == 1, key
        assert names(tmp_path) == before

    def test_options(self, program, finished, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        for arguments, expected in (
            (
                ["--stage", "roof"],
                "--stage = 'roof': expected one of the stages building, calibrate, ",
            ),
            (
                ["--resume", "--out", "nowhere"],
                "nowhere: --resume: expected a folder that holds a run",
            ),
            (["--resume", "--fresh"], "command line: --resume: expected without --fresh"),
            (["--out", finished.case], "small.toml: --out: expected a folder, this is a file"),
        ):
            ended = program("run", finished.case, *arguments)
            assert ended.code == 2 and ended.out == "" and expected in ended.err
            assert ended.err.startswith("error: ") and ended.err.count("\n") == 1
        assert not list(tmp_path.iterdir())

    @pytest.mark.parametrize("command", ["run", "check", "new", "out"])
    def test_a_name_that_is_too_long(self, program, finished, tmp_path, command):
        path = tmp_path / ("x" * 300)
        arguments = ["run", finished.case, "--out"] if command == "out" else [command]
        ended = program(*arguments, path)
        assert ended.code == 2 and "File name too long" in ended.err


class TestRun:
    def test_a_pipe_with_blanks_and_accents_in_the_path(self, new_case, tmp_path):
        folder = tmp_path / "bâtiments à côté"
        folder.mkdir()
        case = new_case(folder)
        ended = process("run", case.name, "--out", "mes résultats", cwd=folder)
        assert ended.code == 0, ended.err
        assert (folder / "mes résultats" / "summary.json").is_file()
        assert len(list(folder.glob("mes résultats/figures/figure_*.png"))) == 7
        # No bar, no colour: only text and line ends.
        for text in (ended.out, ended.err):
            assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f]", text)
        assert ended.out.endswith("results: mes résultats\n")
        assert re.search(r"motion\.pga\s+3\s+3\s+m/s2", ended.out)
        assert "Deux bâtiments, 2 cm -> mes résultats" in ended.err
        provenance = json.loads((folder / "mes résultats" / "provenance.json").read_text())
        command = ["impactfem", "run", "small.toml", "--out", "mes résultats"]
        assert provenance["command"] == command
        log = (folder / "mes résultats" / "run.log").read_text(encoding="utf-8")
        assert "DEBUG   pounding: " in log and "Impacts" in log

    def test_again(self, program, copied, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        ended = program("run", copied.name, "--out", "run", "--stage", "sticks", "--resume")
        assert ended.code == 0 and "reused" in ended.err

    def test_another_case_does_not_go_on(self, program, copied, edited, tmp_path):
        """It is refused, and nothing changes; without `--resume` it is computed."""
        words = ("run", copied, "--out", tmp_path / "run", "--stage", "sticks")
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
        ended = program("run", other, "--out", tmp_path / "run", "--resume", "--stage", "sticks")
        assert ended.code == 0 and "reused" in ended.err

    def test_the_checks_are_told(self, program, copied, tmp_path):
        ended = program("run", copied, "--out", tmp_path / "run")
        assert re.search(r"pounding: \d+ impacts, the largest with .* MN at", ended.err)
        assert re.search(r"steps: .* 16 asked", ended.err)
        assert "warning: linear? storey shear" in ended.err

    def test_a_computation_that_fails(self, program, new_case, tmp_path, monkeypatch):
        def fail(*_):
            raise SolutionError("the response grew without bound")

        monkeypatch.setattr(sticks, "run_sticks", fail)
        ended = program("run", new_case(tmp_path), "--out", tmp_path / "run")
        assert ended.code == 1
        assert ended.err.splitlines()[-1] == "error: the response grew without bound"
        assert [path.name for path in (tmp_path / "run").iterdir()] == ["run.log"]

    @pytest.mark.parametrize("number", SIGNALS)
    def test_a_signal(self, program, new_case, tmp_path, monkeypatch, number):
        monkeypatch.setattr(sticks, "run_sticks", lambda *_: os.kill(os.getpid(), number))
        ended = program("run", new_case(tmp_path), "--out", tmp_path / "run")
        assert ended.code == 128 + number
        said = SIGNALS[number]
        assert ended.err.splitlines()[-1] == f"{said}; run again with --resume to go on"
        assert [path.name for path in (tmp_path / "run").iterdir()] == ["run.log"]
        last = (tmp_path / "run" / "run.log").read_text(encoding="utf-8").splitlines()[-1]
        assert last.endswith(f" WARNING {said} by {number.name}")

    @pytest.mark.parametrize("number", SIGNALS)
    def test_a_signal_before_anything_is_written(self, program, finished, monkeypatch, number):
        monkeypatch.setattr(study, "check", lambda *_, **__: os.kill(os.getpid(), number))
        ended = program("check", finished.case)
        assert (ended.code, ended.err) == (128 + number, f"{SIGNALS[number]}\n")

    def test_the_system_refuses(self, program, new_case, tmp_path, monkeypatch):
        def fail(*_):
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


class TestSweep:
    SET = ("--set", "buildings[0].stiffness_factor=0.5,2", "--stage", "sticks")
    SHOW = ("--show", "sticks.west.frequency.1, sticks.east.frequency.1,")

    def test_a_table(self, program, new_case, tmp_path, monkeypatch, no_figures):
        monkeypatch.chdir(tmp_path)
        ended = program("sweep", new_case(tmp_path).name, *self.SET, *self.SHOW)
        assert ended.code == 0
        assert re.search(r"\n +0\.5 +1\.581 +\S+ *\n +2 +3\.161 +", ended.out)
        places = [f"runs/small_sweep/sweep.{ending}" for ending in ("csv", "json", "png")]
        assert ended.out.endswith(f"\nresults: {', '.join(places)}\n")
        lines = ended.err.splitlines()
        assert lines[0] == "2 variants" and len(lines) == 3
        assert re.match("variant 2 of 2, buildings0.stiffness_factor=2: done in .* s", lines[2])
        assert all(Path(place).is_file() for place in places)

    def test_details(self, program, new_case, tmp_path, no_figures):
        case = new_case(tmp_path)
        ended = program("-v", "sweep", case, *self.SET, "--out", tmp_path / "s")
        assert ended.code == 0 and ended.err.count("stage sticks: done in") == 2

    def test_a_variant_that_fails(self, program, new_case, tmp_path, monkeypatch):
        def fail(*_, **__):
            raise SolutionError("the response grew without bound")

        monkeypatch.setattr(sticks, "run_sticks", fail)
        ended = program("sweep", new_case(tmp_path), *self.SET, "--out", tmp_path / "s")
        assert ended.code == 1 and ended.out.count("failed") == 2
        assert ended.err.count("failed: the response grew without bound") == 2

    def test_every_fault_at_once(self, program, new_case, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        case = new_case(tmp_path)
        before = names(tmp_path)
        words = ("--set", "damping.rato=1", "--set", "contacts[0].gap=1:2", "--stage", "roof")
        ended = program("sweep", case, *words)
        assert ended.code == 2 and ended.out == ""
        lines = ended.err.splitlines()
        assert len(lines) == 3 and all(line.startswith("error: command line: ") for line in lines)
        assert "did you mean 'ratio'" in lines[0] and names(tmp_path) == before

    def test_a_value_that_the_case_refuses(self, program, new_case, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        case = new_case(tmp_path)
        before = names(tmp_path)
        ended = program("sweep", case, "--set", "contacts[0].gap=1 cm,1 kg")
        assert ended.code == 2 and names(tmp_path) == before
        assert ended.err.startswith("error: command line: --set contacts[0].gap = '1 kg': ")

    def test_usage(self, program, finished):
        for words in ((), ("--set", "damping.ratio=3 %", "--processes", "0")):
            ended = program("sweep", finished.case, *words)
            assert ended.code == 2 and "Error: " in ended.err

    def test_an_interrupt(self, program, new_case, tmp_path, monkeypatch):
        monkeypatch.setattr(
            sticks, "run_sticks", lambda *_, **__: os.kill(os.getpid(), signal.SIGINT)
        )
        ended = program("sweep", new_case(tmp_path), *self.SET, "--out", tmp_path / "s")
        assert ended.code == 130
        assert ended.err.splitlines()[-1] == "interrupted; run again to go on"


class TestCheckAndNew:
    def test_a_new_case_is_good(self, program, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        ended = program("new", "mine")
        assert ended.code == 0
        assert ended.out == "wrote mine.toml\nwrote mine_floors.csv\n"
        ended = program("check", "mine.toml")
        assert ended.code == 0
        assert ended.out.startswith(
            "mine.toml: good. 2 buildings, 3 contact pairs, 1 ground motion\n"
        )
        assert names(tmp_path) == ["mine.toml", "mine_floors.csv"]

    def test_no_name(self, program, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        ended = program("new", "")
        assert ended.code == 2 and "NAME = '': expected the name of a case" in ended.err
        assert names(tmp_path) == []
        assert program("new", ".").code == 0 and "case.toml" in names(tmp_path)

    def test_a_report_of_no_run(self, program, tmp_path):
        for folder in (tmp_path, tmp_path / "nowhere"):
            ended = program("report", folder)
            assert ended.code == 2 and ended.err.count("\n") == 1
            assert "the folder holds no run to report on: case.json, " in ended.err
        assert names(tmp_path) == []

    def test_nothing_is_overwritten(self, program, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        Path("mine.toml").write_text("precious")
        ended = program("new", "mine")
        assert ended.code == 2 and "exists already" in ended.err
        assert names(tmp_path) == ["mine.toml"] and Path("mine.toml").read_text() == "precious"


class TestVerify:
    def test_rows_and_json(self, program, tmp_path):
        path = tmp_path / "rows é.json"
        ended = program("verify", "--only", "sdll06", "--json", path)
        count = len(json.loads(path.read_text(encoding="utf-8")))
        assert ended.code == 0 and count >= 5
        assert ended.out.endswith(f"\n{count} of {count} within tolerance\n")

    def test_words_are_whole_in_a_pipe(self, program):
        out = program("verify", "--only", "newmark").out
        assert "relative displacement after 3 s in 2400 steps" in out and "…" not in out

    @pytest.mark.parametrize("row", [BAD, NAN], ids=["beyond", "nan"])
    def test_a_row_that_fails(self, program, tmp_path, monkeypatch, row):
        monkeypatch.setattr(manual, "BENCHMARKS", {"one": lambda: [GOOD, row]})
        ended = program("verify")
        assert ended.code == 1 and "FAIL" in ended.out
        assert ended.out.endswith("1 of 2 within tolerance\n")
        path = tmp_path / "rows.json"
        ended = program("verify", "--json", path)
        assert ended.code == 1
        rows = json.loads(path.read_text())
        assert [entry["passed"] for entry in rows] == [True, False]

    def test_rows_that_pass(self, program, monkeypatch):
        monkeypatch.setattr(manual, "BENCHMARKS", {"one": lambda: [GOOD]})
        ended = program("verify")
        assert ended.code == 0 and "FAIL" not in ended.out

    def test_an_unknown_name(self, program):
        ended = program("verify", "--only", "roof")
        assert ended.code == 2 and "--only = 'roof'" in ended.err and "cantilever" in ended.err

    def test_a_file_that_cannot_be_written(self, program, tmp_path):
        ended = program("verify", "--only", "sdll06", "--json", tmp_path / "absent" / "a.json")
        assert ended.code == 1 and ended.err.startswith("error: cannot write")


def test_bench(program, tmp_path, monkeypatch):
    measured = [Figure("a kernel", 0.2, "s", 0.3)]
    monkeypatch.setitem(suite.GROUPS, "sticks", lambda: measured)
    monkeypatch.setitem(suite.GROUPS, "spectra", list)
    ended = program("bench", "--json", tmp_path / "bench.json")
    assert ended.code == 0 and "a kernel" in ended.out and "met" in ended.out
    assert json.loads((tmp_path / "bench.json").read_text())[0]["met"] is True
