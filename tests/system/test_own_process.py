"""The process of its own: what goes in, what comes out, what does not come along."""

import os
from pathlib import Path

import pytest

from impactfem.building.read_mesh import read_raw
from impactfem.system.errors import ImpactfemError, InputError
from impactfem.system.own_process import OwnProcessError, in_own_process, read_in_own_process


def test_the_result_comes_back_whatever_is_printed():
    assert in_own_process(os.getpid) != os.getpid()
    assert in_own_process(print, "hello") is None
    assert in_own_process(os.write, 1, b"hello") == 5


def test_what_the_system_refuses(tmp_path):
    with pytest.raises(ImpactfemError, match=f"^cannot read or write {tmp_path}: Is a directory$"):
        in_own_process(Path.read_bytes, tmp_path)


def test_the_launcher_of_mpi_is_not_seen(monkeypatch):
    names = ("OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_SIZE", "PRTE_LAUNCHED", "OMP_NUM_THREADS")
    for name in names:
        monkeypatch.setenv(name, "2")
    assert [in_own_process(os.getenv, name) for name in names] == [None, None, None, None, "2"]


def test_an_input_error_comes_with_its_faults(tmp_path):
    path = tmp_path / "missing.msh"
    with pytest.raises(InputError, match="No such file") as caught:
        in_own_process(read_raw, path)
    assert caught.value.faults[0].file == path


@pytest.mark.parametrize(
    ("call", "words"),
    [((os.abort,), "exit code -6$"), ((os._exit, 3), "exit code 3$"), ((int, "x"), "invalid lite")],
)
def test_a_crash_is_reported_with_the_last_line_of_a_traceback(call, words):
    with pytest.raises(OwnProcessError, match=words) as caught:
        in_own_process(*call)
    assert "Traceback" not in str(caught.value) and "\n" not in str(caught.value)


def test_a_file_in_the_working_folder_is_not_taken_for_a_module(tmp_path, monkeypatch):
    (tmp_path / "numpy.py").write_text("raise SystemError\n")
    monkeypatch.chdir(tmp_path)
    assert in_own_process(max, 1, 2) == 2


def test_a_file_that_crashes_a_library_is_at_fault(tmp_path):
    path = tmp_path / "building.msh"
    with pytest.raises(InputError, match=r"exit code 1: TypeError.*; expected a mesh") as caught:
        read_in_own_process(int, path, "a mesh")
    assert caught.value.faults[0].file == path
    assert read_in_own_process(os.path.basename, path, "a mesh") == "building.msh"
