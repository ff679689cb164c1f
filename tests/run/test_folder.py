"""The folder of a run."""

import errno
import fcntl
import os
import re
import socket
import subprocess
import sys

import pytest

from impactfem.run.folder import LOCK, LOG, locked, open_folder
from impactfem.system.errors import InputError


@pytest.fixture
def ended():
    """The number of a process that has ended."""
    with subprocess.Popen(["true"]) as process:
        pass
    return process.pid


def test_what_a_kill_left_goes_with_the_next_run(tmp_path, ended):
    (tmp_path / LOG).write_text("before")
    (tmp_path / "tables").mkdir()
    left = [tmp_path / f".pounding.nc.{ended}.part", tmp_path / "tables" / f".a.csv.{ended}.part"]
    of_another_run = tmp_path / f".pounding.nc.{os.getppid()}.part"
    table = tmp_path / "tables" / "a.csv"
    for path in (*left, of_another_run, table):
        path.write_text("half")
    with open_folder(tmp_path, resume=True):
        pass
    assert not [path for path in left if path.exists()]
    assert of_another_run.is_file() and table.is_file()
    assert (tmp_path / LOG).read_text() == "before"


@pytest.mark.parametrize(
    ("name", "words"),
    [("", "this one holds other files$"), ("a\nb", "without control characters$")],
)
def test_a_folder_that_is_refused_keeps_its_files(tmp_path, ended, name, words):
    part = tmp_path / f".notes.txt.{ended}.part"
    part.write_text("of another program")
    with (
        pytest.raises(InputError, match=f"^command line: --out = .*{words}"),
        open_folder(tmp_path / name, resume=False),
    ):
        pass
    assert list(tmp_path.iterdir()) == [part]


def test_a_file_that_cannot_be_removed(tmp_path, ended, monkeypatch):
    (tmp_path / LOG).touch()
    (tmp_path / f".pounding.nc.{ended}.part").touch()

    def refused(path, missing_ok=False):
        raise PermissionError(13, os.strerror(13))

    monkeypatch.setattr("pathlib.Path.unlink", refused)
    with (
        pytest.raises(InputError, match="written: Permission denied"),
        open_folder(tmp_path, resume=False),
    ):
        pass


HOLD = """
import sys
from pathlib import Path
from impactfem.run.folder import (open_folder)
with open_folder(Path(sys.argv[1]), resume=False):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that works in the folder until its input ends."""
    command = [sys.executable, "-c", HOLD, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"held\n"
        yield process


def test_one_run_at_a_time(tmp_path, holder):
    who = f"no other run works; process {holder.pid} on {re.escape(socket.gethostname())} does now"
    with pytest.raises(InputError, match=who), open_folder(tmp_path, resume=True):
        pass
    with pytest.raises(InputError, match=who), locked(tmp_path):
        pass
    holder.communicate()
    assert holder.returncode == 0
    with open_folder(tmp_path, resume=True):
        assert (tmp_path / LOCK).read_text().startswith(f"process {os.getpid()} on ")
    assert [path.name for path in tmp_path.iterdir()] == [LOG]


def test_a_run_that_was_killed_is_in_nobodys_way(tmp_path, holder):
    holder.kill()
    holder.communicate()
    assert (tmp_path / LOCK).read_text().startswith(f"process {holder.pid} on ")
    with open_folder(tmp_path, resume=True):
        pass
    assert not (tmp_path / LOCK).exists()


def test_the_lock_goes_with_an_error(tmp_path):
    with pytest.raises(ValueError), open_folder(tmp_path, resume=False):
        raise ValueError
    with locked(tmp_path):
        pass


def test_a_lock_that_is_removed_while_another_process_opens_it(tmp_path, monkeypatch):
    """The file that was locked is no longer the one in the folder: the next one is taken."""
    real, files = fcntl.flock, []

    def flock(file, how):
        files.append(file)
        if len(files) == 1:
            (tmp_path / LOCK).unlink()
        real(file, how)

    monkeypatch.setattr(fcntl, "flock", flock)
    with locked(tmp_path):
        assert len(files) == 2 and (tmp_path / LOCK).is_file()
        with pytest.raises(InputError, match="other run works"), locked(tmp_path):
            pass


def test_a_file_system_without_locks_is_told(tmp_path, monkeypatch, caplog):
    def flock(file, how):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", flock)
    with open_folder(tmp_path, resume=False):
        pass
    assert "(No locks available)" in caplog.text


@pytest.mark.parametrize("name", ["run.log", "tables", "design/members"])
def test_nothing_is_written_through_a_link(tmp_path, name):
    """The folder may be a link; what is in it may not."""
    run, elsewhere = tmp_path / "run", tmp_path / "elsewhere"
    (run / name).parent.mkdir(parents=True)
    (run / LOG).write_text("before")
    if name == LOG:
        (run / LOG).unlink()
        elsewhere.write_text("precious")
    else:
        elsewhere.mkdir()
    (run / name).symlink_to(elsewhere)
    for opened in (lambda: open_folder(run, resume=False), lambda: locked(run)):
        with pytest.raises(InputError, match=f"symbolic links.*{name}"), opened():
            pass
    assert name != LOG or elsewhere.read_text() == "precious"
    (run / name).unlink()
    (run / LOG).write_text("before")
    (tmp_path / "link").symlink_to(run)
    with open_folder(tmp_path / "link", resume=True):
        pass
