"""The memory of this process."""

import ctypes
from types import SimpleNamespace

import numpy as np
import psutil
import pytest

from impactfem.system import memory


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


@pytest.mark.parametrize(("most", "total"), [(500, 500), ("max", 2000)])
def test_the_whole_memory_of_machine_and_job(machine, most, total):
    machine(10, ("job", most, 499, STAT))
    assert memory.available_memory(whole=True) == total


def test_a_system_without_these_files(monkeypatch, tmp_path):
    for name in ("GROUP", "GROUPS", "STATUS", "RESET"):
        monkeypatch.setattr(memory, name, tmp_path / "nowhere")
    assert (
        memory.available_memory()
        <= memory.available_memory(whole=True)
        == psutil.virtual_memory().total
    )
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
