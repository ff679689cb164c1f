"""The process of its own: what goes in, what comes out, what does not come along."""

import os
from pathlib import Path

import pytest

from impactfem.building.read_mesh import read_raw
from impactfem.system.errors import ImpactfemError, InputError
from impactfem.system.own_process import (
    OwnProcessError,
    in_own_process,
    read_in_own_process,
)


def test_the_result_comes_back():
    assert in_own_process(max, 3, 5) == 5
    assert in_own_process(os.getpid) != os.getpid()


def test_what_is_printed_does_not_spoil_the_result():
    assert in_own_process(print, "hello") is None
    assert in_own_process(os.write, 1, b"hello") == 5


def test_what_the_system_refuses(tmp_path):
    with pytest.raises(ImpactfemError, match=f"^cannot read or write {tmp_path}: Is a directory$"):
        in_own_process(Path.read_bytes, tmp_path)


def test_the_launcher_of_mpi_is_not_seen(monkeypatch):
    for name in ("OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_SIZE", "PRTE_LAUNCHED"):
        monkeypatch.setenv(name, "2")
        assert in_own_process(os.getenv, name) is None
    monkeypatch.setenv("IMPACTFEM_TEST", "kept")
    assert in_own_process(os.getenv, "IMPACTFEM_TEST") == "kept"


def test_an_input_error_comes_with_its_faults(tmp_path):
    path = tmp_path / "missing.msh"
    with pytest.raises(InputError, match="No such file") as caught:
        in_own_process(read_raw, path)
    assert caught.value.faults[0].file == path


def test_a_crash_is_told():
    with pytest.raises(ImpactfemError, match="exit code -6"):
        in_own_process(os.abort)
    with pytest.raises(ImpactfemError, match="exit code 3"):
        in_own_process(os._exit, 3)


def test_an_unexpected_error_is_told_with_its_words():
    with pytest.raises(ImpactfemError, match="invalid literal"):
        in_own_process(int, "x")


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


def test_of_a_traceback_only_the_end_is_told():
    with pytest.raises(OwnProcessError) as caught:
        in_own_process(int, "x")
    assert "Traceback" not in str(caught.value) and "\n" not in str(caught.value)
