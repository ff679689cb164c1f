import io
import logging
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from rich.console import Console

from impactfem.system import log
from impactfem.system.errors import ImpactfemError
from impactfem.system.log import LOGGER, Steps, collected_warnings, mirrored, set_up


def speak():
    LOGGER.debug("a detail")
    LOGGER.info("a step")
    LOGGER.warning("a warning")


EVERY = ["a detail", "a step", "a warning"]


@pytest.mark.parametrize(("verbose", "heard"), [(False, EVERY[1:]), (True, EVERY)])
def test_standard_error(capsys, verbose, heard):
    set_up(not verbose)  # nothing is said twice after two calls
    set_up(verbose)
    speak()
    found = capsys.readouterr()
    assert found.err.splitlines() == heard and found.out == ""


@pytest.mark.parametrize(("verbose", "heard"), [(False, []), (True, EVERY)])
def test_progress_and_warnings_alone(capsys, tmp_path, verbose, heard):
    set_up(verbose)
    with mirrored(tmp_path / "run.log"):
        with collected_warnings("progress") as warnings:
            speak()
            speak()
        assert capsys.readouterr().err.splitlines() == 2 * heard
        speak()
        with collected_warnings("nothing"):
            assert not capsys.readouterr().err.count("a detail") - verbose
            speak()
        assert capsys.readouterr().err == ""
    assert warnings == ["a warning"]
    assert (tmp_path / "run.log").read_text().count("a detail") == 4


def test_control_characters_are_escaped(capsys, tmp_path):
    """Names of files and values of others come into messages."""
    set_up(False)
    with mirrored(tmp_path / "run.log"):
        LOGGER.warning("%s", "a\x1b[31m\u2028b\rc\nd")
    heard = ["a\\x1b[31m\\u2028b\\rc", "d"]
    assert capsys.readouterr().err.splitlines() == heard
    lines = (tmp_path / "run.log").read_text().splitlines()
    assert [line.rpartition(" ")[2] for line in lines] == heard


def test_only_rank_0_speaks(capsys, tmp_path):
    set_up(True, rank=1)
    with mirrored(tmp_path / "run.log", rank=1):
        speak()
    assert capsys.readouterr().err == "" and not list(tmp_path.iterdir())


@pytest.mark.parametrize("called", [True, False], ids=["command line", "Python"])
def test_the_file_has_the_details_and_is_appended_to(tmp_path, called):
    """From Python nobody calls `set_up`."""
    path = tmp_path / "run.log"
    LOGGER.setLevel(logging.NOTSET)
    if called:
        set_up(False)
    for _ in range(2):
        with mirrored(path):
            speak()
    LOGGER.info("after")
    lines = path.read_text(encoding="utf-8").splitlines()
    assert [line.split(" ", 2)[2].split() for line in lines[:3]] == [
        ["DEBUG", "a", "detail"],
        ["INFO", "a", "step"],
        ["WARNING", "a", "warning"],
    ]
    assert len(lines) == 6


def test_the_file_is_closed_after_an_error(tmp_path):
    with pytest.raises(ValueError), mirrored(tmp_path / "run.log"):
        raise ValueError
    assert not [h for h in LOGGER.handlers if isinstance(h, logging.FileHandler)]


def test_steps_are_timed_where_they_do_not_fail(capsys):
    names = ("first", "second", "third")
    with pytest.raises(ValueError), Steps(dict.fromkeys(names, 1.0)) as steps:
        for name in names:
            with steps.step(name):
                if name == "third":
                    raise ValueError
    assert list(steps.times) == ["first", "second"] and min(steps.times.values()) >= 0.0
    found = capsys.readouterr()
    assert found.out == "" and found.err == ""  # quiet in a pipe


@pytest.fixture
def terminal(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(
        log, "Console", lambda stderr: Console(file=stream, force_terminal=True, width=80)
    )
    return stream


def test_a_bar_on_a_terminal(terminal):
    with Steps({"pounding": 1.0}, "stage pounding") as steps, steps.step("pounding"):
        pass
    assert "stage pounding: pounding" in terminal.getvalue() and "remaining" in terminal.getvalue()


class Clock:
    """A time that passes when it is set."""

    time = 100.0

    def __call__(self):
        return self.time


NEVER = 1e6
"""Time between two lines, so long that the test ends before the first."""


@pytest.fixture
def stage():
    """A stage of two steps with a clock of its own, whose lines come when `report` is called."""
    clock = Clock()
    with Steps({"mesh": 1.0, "basis": 3.0}, "stage a", every=NEVER, clock=clock) as steps:
        yield steps, clock


def test_lines_where_no_terminal_is(capsys, stage):
    """A step that says nothing is at work; one that says its part has a time left."""
    set_up(False)
    steps, clock = stage
    steps.report()
    with steps.step("mesh"):
        clock.time += 119.0
        steps.report()
        clock.time += 61.0
        steps.report()
    with steps.step("basis"):
        steps.within("basis", 0.0)
        clock.time += 30.0
        steps.within("basis", 0.25)
        steps.report()
        clock.time += 10.0
        steps.report()
        clock.time += 2.0 * 3600.0
        steps.report()
        steps.within("basis", 1.0)
        steps.report()
    lines = capsys.readouterr().err.splitlines()
    elapsed = ["0 s", "119 s", "3 min", "30 s", "40 s", "2.0 h", "2.0 h"]
    remaining = ["", "", "", "90 s", "80 s", "0 s", ""]
    for line, time, rest in zip(lines, elapsed, remaining, strict=True):
        assert f"{time} elapsed" in line and line.endswith("remaining") == bool(rest)
        assert rest in line
    assert ["mesh" in line for line in lines] == [False, True, True, *[False] * 4]
    assert [line.partition(" %")[0][-2:] for line in lines[3:]] == ["25", "25", "25", "99"]
    assert steps.times == {"mesh": 180.0, "basis": 7240.0}


def test_work_of_an_earlier_run_took_no_time(capsys, stage):
    """80 % are there at once, 10 % more take 20 s: so do the last 10 %."""
    set_up(False)
    steps, clock = stage
    with steps.step("basis"):
        clock.time += 1.0
        steps.within("basis", 0.8)
        steps.report()
        clock.time += 20.0
        steps.within("basis", 0.9)
        steps.report()
    first, second = capsys.readouterr().err.splitlines()
    assert "1 s elapsed, 80 %" in first and "remaining" not in first
    assert "21 s elapsed, 90 %" in second and "20 s remaining" in second


def test_a_terminal_with_a_bar_has_no_lines_and_the_file_has(capsys, terminal, tmp_path):
    set_up(False)
    own = Steps({"mesh": 1.0}, "stage a", every=NEVER)
    with mirrored(tmp_path / "run.log"), own as steps, steps.step("mesh"):
        steps.report()
    assert capsys.readouterr().err == "" and "mesh" in terminal.getvalue()
    text = (tmp_path / "run.log").read_text()
    assert "stage a: mesh" in text and "elapsed" in text
    # Without the bar it is as elsewhere.
    with Steps({"mesh": 1.0}, "stage a", bar=False, every=NEVER) as steps:
        steps.report()
    assert capsys.readouterr().err.startswith("stage a, ")


def test_lines_come_by_themselves_until_the_stage_ends():
    """By a thread of rank 0; it ends with the block, also by an error."""
    told = threading.Event()

    class Told(logging.Handler):
        def emit(self, record):
            told.set()

    set_up(False)
    handler = Told()
    LOGGER.addHandler(handler)
    before = set(threading.enumerate())  # others may end meanwhile
    with pytest.raises(ValueError), Steps({"mesh": 1.0}, "stage a", every=0.0):
        assert len(set(threading.enumerate()) - before) == 1
        assert told.wait(600.0)
        raise ValueError
    assert set(threading.enumerate()) <= before
    with Steps({"mesh": 1.0}, "stage a", every=0.0, quiet=True):  # another rank
        assert set(threading.enumerate()) <= before


def test_lines_that_cannot_be_written_end_quietly(capsys):
    """A full disk: what the stage itself logs next is the error, as it is without lines."""
    set_up(False)
    with (
        pytest.raises(ImpactfemError, match="cannot write /dev/full"),
        mirrored(Path("/dev/full")),
        Steps({"mesh": 1.0}, "stage a", every=0.0) as steps,
    ):
        steps._reporter.join(600.0)
        assert not steps._reporter.is_alive()
        speak()
    assert "Traceback" not in capsys.readouterr().err


def test_progress_passes_where_reports_go_to_files_only(capsys, stage):
    set_up(False)
    steps, _ = stage
    with collected_warnings("progress"):
        speak()
        steps.report()
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("stage a, ")


def test_a_full_disk_is_an_error_and_no_traceback(capsys, tmp_path):
    """What is logged is lost then, as all that comes after would be."""
    set_up(False)
    refused = pytest.raises(ImpactfemError, match="/dev/full: No space")
    with refused, mirrored(Path("/dev/full")):
        speak()
    assert "Traceback" not in capsys.readouterr().err
    speak()  # the file is closed
    assert capsys.readouterr().err.splitlines() == ["a step", "a warning"]
    with pytest.raises(ImpactfemError, match=f"write {tmp_path}: Is a dir"), mirrored(tmp_path):
        speak()


def test_a_script_keeps_its_root_logger(copied):
    """FFCx calls `logging.basicConfig` when it is imported, and a run logs its details."""
    script = copied.with_name("script.py")
    script.write_text(
        "import logging, pathlib, warnings\n"
        "shown = warnings.showwarning\n"
        "from impactfem import _fenicsx\nfrom impactfem.run import loop\n"
        f"loop.run(pathlib.Path({str(copied)!r}), out=pathlib.Path('run'), draw=False)\n"
        "print(logging.getLogger().handlers, warnings.showwarning is shown)\n"
        "logging.getLogger('impactfem').warning('heard')\n"
        "logging.getLogger('impactfem').info('not heard')\n"
        "logging.basicConfig(level=logging.DEBUG, format='root: %(message)s')\n"
        "logging.getLogger('impactfem').warning('once')\n"
    )
    ended = subprocess.run(
        [sys.executable, script], cwd=copied.parent, capture_output=True, text=True, check=False
    )
    assert ended.stdout == "[] True\n", ended.stderr
    lines = ended.stderr.splitlines()
    assert lines[-2:] == ["heard", "once"]
    assert all(line.startswith("warning: ") for line in lines[:-2])
    assert "DEBUG   case" in (copied.parent / "run" / "run.log").read_text()
