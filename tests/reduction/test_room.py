"""Where the vectors of a large model have room."""

import errno
import os
from types import SimpleNamespace

import numpy as np
import psutil
import pytest

from impactfem.reduction import orthonormal
from impactfem.reduction.krylov import KrylovBasis
from impactfem.system import memory
from impactfem.system.errors import SolutionError


@pytest.fixture
def machine(monkeypatch, tmp_path):
    """Set what the machine has left [kB], and a folder for files."""

    def make(available):
        left = SimpleNamespace(available=1024 * available)
        monkeypatch.setattr(psutil, "virtual_memory", lambda: left)
        monkeypatch.setattr(memory, "GROUP", tmp_path / "nowhere")
        monkeypatch.setenv("TMPDIR", str(tmp_path))

    return make


@pytest.mark.parametrize(("processes", "file"), [(1, False), (2, True)])
def test_memory_first(machine, tmp_path, processes, file):
    """8 kB, and four times as much to spare: 40 kB for one process, 80 for two."""
    machine(40)
    found = orthonormal.room(1000, 1, processes)
    assert (found.pages is not None) is file
    assert found.array.shape == (1000, 1) and found.array.flags.f_contiguous
    found.array[:] = 1.0
    assert found.fetch().sum() == 1000.0
    # No name is left behind, also of a process that is killed.
    assert sorted(path.name for path in tmp_path.iterdir()) == []


def test_nothing_needs_no_file(machine):
    machine(0)
    assert orthonormal.room(0, 64).array.shape == (0, 64)


def test_no_room_at_all(machine, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    machine(0)
    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(SolutionError, match=r"8e-06 GB beyond the memory.*No space left.*TMPDIR"):
        orthonormal.room(1000, 1)
    monkeypatch.setenv("TMPDIR", "/nowhere/at/all")
    with pytest.raises(SolutionError, match=r"/nowhere/at/all \(No such file"):
        orthonormal.room(1000, 1)


def test_a_basis_in_files_is_that_in_memory(machine, membrane, petsc, monkeypatch):
    model, found = membrane(), []
    monkeypatch.setattr(orthonormal, "CHUNK", 8)
    for available in (10**9, 0):
        machine(available)
        basis = KrylovBasis(petsc(model.K), petsc(model.M), 1e5)
        basis.add(model.loads)
        basis.grow(8)
        chunks = basis.vectors._chunks
        assert len(chunks) > 3
        assert all((one.pages is not None) is (available == 0) for one in chunks)
        found.append(basis.V)
    assert np.array_equal(*found)
