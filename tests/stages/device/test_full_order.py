"""Devices in full order: matrices, the shipped frame against SciPy, ranks, and interruptions."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI

from impactfem.building.model import assemble_building
from impactfem.device.modes import device_modes
from impactfem.device.mounted import MountedDevice
from impactfem.reduction.loads import Loads
from impactfem.stages.device.full_order import full_checkpoints, full_system

from .conftest import FACTOR, FLOOR, STEP, scipy_matrix, shaken_and_hit
from .full_on_ranks import histories

SCRIPT = Path(__file__).with_name("full_on_ranks.py")


class KilledError(Exception):
    """The end of a run, from outside."""


@pytest.fixture(scope="session")
def given(frame, device, base_plate):
    case, parts = frame
    force, ground = shaken_and_hit()
    return {
        "parts": parts,
        "factor": FACTOR,
        "base_plates": [base_plate],
        "devices": [device],
        "loads": Loads(STEP, ground, (1,), (FLOOR,), force[:, None], 0.0),
        "damping": case.building("F").damping.rayleigh,
        "substeps": 1,
    }


@pytest.fixture(scope="session")
def alone(given, tmp_path_factory):
    """On one rank, with one step in each of the loads."""
    return histories(MPI.COMM_SELF, given, tmp_path_factory.mktemp("alone"))


def test_against_scipy(alone, full):
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


def test_half_the_force_has_half_the_effect(given, alone, tmp_path):
    loads = replace(given["loads"], force=0.5 * given["loads"].force)
    half = histories(MPI.COMM_SELF, given | {"loads": loads}, tmp_path)[1][0].force
    quiet, pounded = (one[0].force for one in alone)
    assert half == pytest.approx(0.5 * (quiet + pounded), abs=1e-7 * np.abs(pounded).max())


def test_smaller_steps(given, tmp_path):
    """The error falls with the square of the step; the samples are those of the loads."""
    whole = given["loads"]
    loads = replace(whole, ground=whole.ground[:201], force=whole.force[:201])
    found = {}
    for n in (1, 2, 4):
        made = histories(MPI.COMM_SELF, given | {"loads": loads, "substeps": n}, tmp_path / str(n))
        found[n] = made[1][0].force
    assert all(force.shape == found[1].shape for force in found.values())
    coarse, fine = (np.abs(found[n][1] - found[2 * n][1]).max() for n in (1, 2))
    assert coarse / fine == pytest.approx(4.0, rel=0.25)


def test_goes_on_after_an_interruption(given, alone, tmp_path, caplog):
    """In the second of the two runs; the first one is not made again."""

    def progress(part):
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


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [2, 3])
def test_ranks(given, on_ranks, tmp_path, ranks):
    """With the impact, which begins at 0.05 s."""
    whole = given["loads"]
    loads = replace(whole, ground=whole.ground[:151], force=whole.force[:151])
    short = given | {"loads": loads}
    alone = histories(MPI.COMM_SELF, short, tmp_path)
    many = on_ranks(SCRIPT, given=short, folder=tmp_path)(ranks)
    for one, other in zip((*many[0], *many[1]), (*alone[0], *alone[1]), strict=True):
        difference = np.abs(one.force - other.force).max() / np.abs(other.force).max()
        assert 0.0 < difference < 1e-8


@pytest.fixture(scope="module")
def made(frame, device, base_plate):
    case, parts = frame
    loads = Loads(STEP, np.zeros((2, 3)), (0, 1, 2), (FLOOR,), np.zeros((2, 1)), 0.0)
    with full_system(
        assemble_building(MPI.COMM_SELF, parts),
        parts.mesh,
        FACTOR,
        [base_plate],
        [MountedDevice(device.name, device)],
        loads,
        damping=case.building("F").damping.rayleigh,
    ) as system:
        yield SimpleNamespace(system=system, ground=assemble_building(MPI.COMM_SELF, parts).ground)


def test_rows(made, device):
    """The device's modes come last."""
    system = made.system
    n, modes = system.M.getSize()[0], device_modes(device).frequency.size
    assert list(system.rows[6:]) == list(range(n - modes, n))
    assert system.patterns.shape == (n, 4) and len(system.attached.M) == 6 + modes


@pytest.mark.parametrize("component", [0, 1, 2])
def test_ground_moves_the_device_too(made, device, component):
    """Its mass with the building's, rigidly: by the rows of translations along the ground."""
    system = made.system
    along = np.zeros(len(system.patterns))
    along[component : len(along) - len(system.rows) + 6 : 6] = 1.0
    building = -(system.patterns[:, component] @ along)
    # Followers hand their load on to the master, so that sums over all rows do not change.
    assert building - made.ground[component::6, component].sum() == pytest.approx(800.0, rel=1e-9)
    assert system.patterns[:, 3] @ along == pytest.approx(-1.0 if component == 1 else 0.0)


def test_matrices(made, device, frame):
    """Symmetric; what is damped beside Rayleigh's damping is the device alone."""
    system = made.system
    K, M, C = (scipy_matrix(one) for one in (system.K, system.M, system.C))
    for matrix in (K, M, C):
        assert abs(matrix - matrix.T).max() < 1e-10 * abs(matrix).max()
    other = np.setdiff1d(np.arange(K.shape[0]), system.rows)
    assert abs(C[other]).max() == 0.0 and abs(C[:, other]).max() == 0.0
    modes = device_modes(device)
    last = slice(-modes.frequency.size, None)
    assert M[last, last].toarray() == pytest.approx(np.eye(modes.frequency.size), abs=1e-12)
    assert K[last, last].diagonal() == pytest.approx(modes.omega**2)
    law = frame[0].building("F").damping.rayleigh
    total = C[last, last].diagonal() + law.modal(modes.omega**2)
    assert total == pytest.approx(2.0 * modes.damping * modes.omega)
