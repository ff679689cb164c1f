"""The folder of a run."""

import os
import subprocess

import pytest

from impactfem.errors import InputError
from impactfem.study.folder import LOG, open_folder


@pytest.fixture
def ended():
    """The number of a process that has ended."""
    with subprocess.Popen(["true"]) as process:
        pass
    return process.pid


def test_what_a_kill_left_goes_with_the_next_run(tmp_path, ended):
    (tmp_path / LOG).write_text("before")
    (tmp_path / "tables").mkdir()
    left = [tmp_path / f".sticks.nc.{ended}.part", tmp_path / "tables" / f".a.csv.{ended}.part"]
    of_another_run = tmp_path / f".sticks.nc.{os.getppid()}.part"
    table = tmp_path / "tables" / "a.csv"
    for path in (*left, of_another_run, table):
        path.write_text("half")
    open_folder(tmp_path, resume=True)
    assert not [path for path in left if path.exists()]
    assert of_another_run.is_file() and table.is_file()
    assert (tmp_path / LOG).read_text() == "before"


def test_a_folder_that_holds_no_run_keeps_its_files(tmp_path, ended):
    part = tmp_path / f".notes.txt.{ended}.part"
    part.write_text("of another program")
    with pytest.raises(InputError, match="this one holds other files"):
        open_folder(tmp_path, resume=False)
    assert part.is_file() and not (tmp_path / LOG).exists()


def test_a_file_that_cannot_be_removed(tmp_path, ended, monkeypatch):
    (tmp_path / LOG).touch()
    (tmp_path / f".sticks.nc.{ended}.part").touch()

    def refused(path, missing_ok=False):
        raise PermissionError(13, os.strerror(13))

    monkeypatch.setattr("pathlib.Path.unlink", refused)
    with pytest.raises(InputError, match="a folder that can be written: Permission denied"):
        open_folder(tmp_path, resume=False)
