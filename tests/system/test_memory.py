"""The memory of this process."""

import ctypes
import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import psutil
import pytest

from impactfem.building.read_mesh import read_raw
from impactfem.system import memory
from impactfem.system.errors import ImpactfemError, InputError
from impactfem.system.executor import OwnProcessError, in_own_process, read_in_own_process


@pytest.fixture
def machine(monkeypatch, tmp_path):
    """Set what the machine has left [byte] and the groups of the job: name, max, current, stat."""

    def make(available, *groups, own="/job/step"):
        found = SimpleNamespace(available=available, total=2000)
        (tmp_path / "own").write_text(f"4:memory:/other\n0::{own}\n")
        for name, most, current, stat in groups:
            folder = tmp_path / "groups" / name
            folder.mkdir(parents=True, exist_ok=True)
            (folder / "memory.max").write_text(f"{most}\n")
            (folder / "memory.current").write_text(f"{current}\n")
            (folder / "memory.stat").write_text(stat)
        monkeypatch.setattr(psutil, "virtual_memory", lambda: found)
        monkeypatch.setattr(memory, "GROUP", tmp_path / "own")
        monkeypatch.setattr(memory, "GROUPS", tmp_path / "groups")

    return make


STAT = "anon 500\ninactive_file 30\nactive_file 20\nslab 7\n"


@pytest.mark.parametrize(
    ("groups", "left"),
    [
        ((), 1000),
        ((("job/step", "max", 700, STAT),), 1000),
        ((("job/step", 1000, 700, STAT),), 350),
        ((("job/step", 1000, 700, STAT), ("job", 900, 700, STAT)), 250),
        ((("elsewhere", 1, 0, ""),), 1000),
        ((("job/step", 1000, "none", STAT),), 1000),
    ],
)
def test_what_is_left(machine, groups, left):
    machine(1000, *groups)
    assert memory.available_memory() == left


STAT_1 = "inactive_file 9\nactive_file 9\ntotal_inactive_file 30\ntotal_active_file 20\n"


@pytest.mark.parametrize("controllers", ["memory", "cpu,memory", "cpu"])
@pytest.mark.parametrize("folder", [".", "docker", "docker/own"])
def test_what_is_left_in_a_group_of_version_1(machine, tmp_path, controllers, folder):
    # In a container the group has a path that is not there; what is there is its own.
    machine(1000)
    group = tmp_path / "groups" / "memory" / folder
    group.mkdir(parents=True)
    (tmp_path / "own").write_text(f"7:pids:/\n4:{controllers}:/docker/own\n0::/\n")
    values = {"limit_in_bytes": 1000, "usage_in_bytes": 700, "stat": STAT_1}
    for name, value in values.items():
        (group / f"memory.{name}").write_text(f"{value}\n")
    assert memory.available_memory() == (1000 if controllers == "cpu" else 350)
    assert memory.available_memory(whole=True) == (2000 if controllers == "cpu" else 1000)


@pytest.mark.parametrize(("most", "total"), [(500, 500), ("max", 2000)])
def test_the_whole_memory_of_machine_and_job(machine, most, total):
    machine(10, ("job", most, 499, STAT))
    assert memory.available_memory(whole=True) == total


def test_a_system_without_these_files(monkeypatch, tmp_path):
    for name in ("GROUP", "GROUPS", "STATUS", "RESET"):
        monkeypatch.setattr(memory, name, tmp_path / "nowhere")
    whole = memory.available_memory(whole=True)
    assert memory.available_memory() <= whole == psutil.virtual_memory().total
    memory.forget_peak()
    assert memory.peak_memory() is None


def test_the_peak_since_it_was_forgotten():
    memory.give_back()  # an array may take what tests before have left
    memory.forget_peak()
    before = memory.peak_memory()
    taken = np.ones(20_000_000)
    assert memory.peak_memory() > before + 0.8 * taken.nbytes
    size = taken.nbytes
    del taken
    memory.give_back()
    memory.forget_peak()
    assert memory.peak_memory() < before + 0.5 * size


def test_a_system_that_cannot_give_back(monkeypatch):
    monkeypatch.setattr(ctypes, "CDLL", lambda _: object())
    memory.give_back()


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
    with pytest.raises(InputError, match="no such file") as caught:
        in_own_process(read_raw, path)
    assert caught.value.faults[0].file == path


@pytest.mark.parametrize("call", [(os.abort,), (os._exit, 3)])
def test_a_crash_is_reported(call):
    with pytest.raises(OwnProcessError, match=call[0].__name__):
        in_own_process(*call)


def test_an_error_of_the_function_is_raised():
    with pytest.raises(ValueError, match="invalid literal"):
        in_own_process(int, "x")


def test_a_file_in_the_working_folder_is_not_taken_for_a_module(tmp_path, monkeypatch):
    (tmp_path / "numpy.py").write_text("raise SystemError\n")
    monkeypatch.chdir(tmp_path)
    assert in_own_process(max, 1, 2) == 2


def test_a_file_that_crashes_a_library_is_at_fault(tmp_path):
    path = tmp_path / "building.msh"
    with pytest.raises(InputError, match=r"TypeError.*expected a mesh") as caught:
        read_in_own_process(int, path, "a mesh")
    assert caught.value.faults[0].file == path
    assert read_in_own_process(os.path.basename, path, "a mesh") == "building.msh"
