"""Devices in full order: the shipped frame against SciPy, ranks, and interruptions."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpi4py import MPI

from impactfem.device.mounted import MountedHistory
from impactfem.reduction.loads import EdgeForce, Loads
from impactfem.stages.device.full_run import full_checkpoints, remove_full_checkpoints

from .conftest import FACTOR, STEP, shaken_and_hit
from .full_on_ranks import histories

SCRIPT = Path(__file__).with_name("full_on_ranks.py")
Found = tuple[tuple[MountedHistory, ...], tuple[MountedHistory, ...]]


class KilledError(Exception):
    """The end of a run, from outside."""


@pytest.fixture(scope="session")
def given(frame: Any, device: Any, base_plate: Any) -> dict[str, Any]:
    case, parts = frame
    force, ground = shaken_and_hit()
    return {
        "parts": parts,
        "factor": FACTOR,
        "base_plates": [base_plate],
        "devices": [device],
        "loads": Loads(
            time_step=STEP,
            ground=ground,
            directions=(1,),
            edges=(EdgeForce("floor 2", 2, (0.0, -1.0, 0.0)),),
            force=force[:, None],
            impulse_error=0.0,
        ),
        "damping": case.building("F").damping.rayleigh,
        "substeps": 1,
    }


@pytest.fixture(scope="session")
def alone(given: dict[str, Any], tmp_path_factory: pytest.TempPathFactory) -> Found:
    """On one rank, with one step in each of the loads."""
    return histories(MPI.COMM_SELF, given, tmp_path_factory.mktemp("alone"))


def test_against_scipy(alone: Found, full: Any) -> None:
    """The same scheme on other matrices, with the coupling written down once more."""
    quiet, pounded = (one[0].force for one in alone)
    assert pounded.shape == full.shape
    for kind in (slice(3), slice(3, 6)):
        largest = np.abs(full[kind]).max()
        assert np.abs(pounded[kind] - full[kind]).max() < 1e-6 * largest
    # Before the impact both are the same, afterwards not.
    before = int(0.05 / STEP)
    assert np.abs(quiet - pounded)[:, :before].max() < 1e-9 * np.abs(full).max()
    assert np.abs(quiet - pounded).max() > 0.1 * np.abs(full).max()


def test_half_the_force_has_half_the_effect(
    given: dict[str, Any], alone: Found, tmp_path: Path
) -> None:
    loads = given["loads"]
    half = histories(
        MPI.COMM_SELF, given | {"loads": replace(loads, force=0.5 * loads.force)}, tmp_path
    )
    quiet, pounded = (one[0].force for one in alone)
    assert half[1][0].force == pytest.approx(
        0.5 * (quiet + pounded), abs=1e-7 * np.abs(pounded).max()
    )


def test_smaller_steps(given: dict[str, Any], alone: Found, tmp_path: Path) -> None:
    """The error falls with the square of the step; the samples are those of the loads."""
    found = {1: alone[1][0].force} | {
        n: histories(MPI.COMM_SELF, given | {"substeps": n}, tmp_path / str(n))[1][0].force
        for n in (2, 4)
    }
    assert all(force.shape == found[1].shape for force in found.values())
    coarse, fine = (np.abs(found[n][1] - found[2 * n][1]).max() for n in (1, 2))
    assert coarse / fine == pytest.approx(4.0, rel=0.25)


def test_goes_on_after_an_interruption(
    given: dict[str, Any], alone: Found, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """In the second of the two runs; the first one is not made again."""

    def progress(part: float) -> None:
        if part > 0.8:
            raise KilledError

    with pytest.raises(KilledError):
        histories(MPI.COMM_SELF, given, tmp_path, progress=progress)
    assert all(place.is_dir() for place in full_checkpoints(tmp_path))
    with caplog.at_level("INFO", "impactfem"):
        again = histories(MPI.COMM_SELF, given, tmp_path)
    told = [record.getMessage() for record in caplog.records]
    assert told == ["device: going on from 0.400 s", "device: going on from 0.200 s"]
    for one, other in zip((*again[0], *again[1]), (*alone[0], *alone[1]), strict=True):
        np.testing.assert_array_equal(one.force, other.force)
    remove_full_checkpoints(tmp_path)
    assert not any(place.exists() for place in full_checkpoints(tmp_path))
    remove_full_checkpoints(tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [2, 3])
def test_ranks(
    given: dict[str, Any],
    alone: Found,
    under_mpirun: Callable[..., Any],
    tmp_path: Path,
    ranks: int,
) -> None:
    (tmp_path / "given").write_bytes(pickle.dumps(given))
    ended = under_mpirun(ranks, sys.executable, SCRIPT, tmp_path / "given", tmp_path)
    assert ended.returncode == 0, ended.stderr
    many: Found = pickle.loads((tmp_path / "found").read_bytes())
    for one, other in zip((*many[0], *many[1]), (*alone[0], *alone[1]), strict=True):
        difference = np.abs(one.force - other.force).max() / np.abs(other.force).max()
        assert 0.0 < difference < 1e-8
