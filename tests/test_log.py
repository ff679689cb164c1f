import io
import logging
from pathlib import Path

import pytest
from rich.console import Console

from impactfem import log
from impactfem.errors import ImpactfemError
from impactfem.log import LOGGER, Steps, in_file_only, mirrored, set_up


def speak():
    LOGGER.debug("a detail")
    LOGGER.info("a step")
    LOGGER.warning("a warning")


@pytest.mark.parametrize(
    ("verbose", "heard"),
    [(False, ["a step", "a warning"]), (True, ["a detail", "a step", "a warning"])],
)
def test_standard_error(capsys, verbose, heard):
    set_up(verbose)
    speak()
    found = capsys.readouterr()
    assert found.err.splitlines() == heard and found.out == ""


@pytest.mark.parametrize(
    ("verbose", "heard"), [(False, []), (True, ["a detail", "a step", "a warning"])]
)
def test_in_file_only(capsys, tmp_path, verbose, heard):
    set_up(verbose)
    with mirrored(tmp_path / "run.log"):
        with in_file_only() as warnings:
            speak()
            speak()
            assert warnings == {"a warning"}
        assert capsys.readouterr().err.splitlines() == 2 * heard
        speak()
    assert warnings == {"a warning"} and "a warning" in capsys.readouterr().err
    assert (tmp_path / "run.log").read_text().count("a detail") == 3


def test_setting_up_twice_says_nothing_twice(capsys):
    set_up(True)
    set_up(False)
    speak()
    assert capsys.readouterr().err.splitlines() == ["a step", "a warning"]


def test_only_rank_0_speaks(capsys, tmp_path):
    set_up(True, rank=1)
    with mirrored(tmp_path / "run.log", rank=1):
        speak()
    assert capsys.readouterr().err == "" and not list(tmp_path.iterdir())


def test_the_file_has_the_details_and_is_appended_to(tmp_path):
    path = tmp_path / "run.log"
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


def test_the_file_has_the_details_without_a_command_line(tmp_path):
    """From Python nobody calls `set_up`."""
    path = tmp_path / "run.log"
    LOGGER.setLevel(logging.NOTSET)
    with mirrored(path):
        speak()
    assert len(path.read_text(encoding="utf-8").splitlines()) == 3


def test_steps(capsys):
    with Steps({"first": 1.0, "second": 3.0}) as steps:
        for name in ("first", "second"):
            with steps.step(name):
                pass
    assert list(steps.times) == ["first", "second"]
    assert all(value >= 0.0 for value in steps.times.values())
    found = capsys.readouterr()
    assert found.out == "" and found.err == ""  # quiet in a pipe


def test_a_step_that_fails_is_not_timed():
    with pytest.raises(ValueError), Steps({"first": 1.0}) as steps, steps.step("first"):
        raise ValueError
    assert steps.times == {}


def test_a_bar_on_a_terminal(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(
        log, "Console", lambda stderr: Console(file=stream, force_terminal=True, width=80)
    )
    with Steps({"pounding": 1.0}) as steps, steps.step("pounding"):
        pass
    assert "pounding" in stream.getvalue() and "remaining" in stream.getvalue()


def test_a_full_disk_is_an_error_and_no_traceback(capsys):
    """What is logged is lost then, as all that comes after would be."""
    set_up(False)
    with (
        pytest.raises(ImpactfemError, match="cannot write /dev/full: No space left on device"),
        mirrored(Path("/dev/full")),
    ):
        speak()
    assert "Traceback" not in capsys.readouterr().err
    speak()  # the file is closed
    assert capsys.readouterr().err.splitlines() == ["a step", "a warning"]


def test_a_log_that_cannot_be_opened(tmp_path):
    with (
        pytest.raises(ImpactfemError, match=f"cannot write {tmp_path}: Is a directory"),
        mirrored(tmp_path),
    ):
        speak()
