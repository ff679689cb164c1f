"""Matrices of a building with a device in it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from mpi4py import MPI
from numpy.typing import NDArray

from impactfem.building.model import assemble_building
from impactfem.device.modes import device_modes
from impactfem.device.mounted import MountedDevice
from impactfem.reduction.loads import EdgeForce, Loads
from impactfem.stages.device.full_system import FullSystem, full_system

from .conftest import FACTOR, scipy_matrix

Array = NDArray[np.float64]


@dataclass
class Made:
    system: FullSystem
    ground: Array


@pytest.fixture(scope="module")
def made(frame: Any, device: Any, base_plate: Any) -> Iterator[Made]:
    case, parts = frame
    loads = Loads(
        time_step=1e-3,
        ground=np.zeros((2, 3)),
        directions=(0, 1, 2),
        edges=(EdgeForce("floor 2", 2, (0.0, -1.0, 0.0)),),
        force=np.zeros((2, 1)),
        impulse_error=0.0,
    )
    with full_system(
        assemble_building(MPI.COMM_SELF, parts),
        parts.mesh,
        FACTOR,
        [base_plate],
        [MountedDevice(device.name, device)],
        loads,
        eccentricity=0.0,
        damping=case.building("F").damping.rayleigh,
    ) as system:
        yield Made(system, assemble_building(MPI.COMM_SELF, parts).ground)


def test_rows(made: Made, device: Any) -> None:
    """The device's modes come last."""
    system = made.system
    n, modes = system.M.getSize()[0], device_modes(device).frequency.size
    assert list(system.rows[6:]) == list(range(n - modes, n))
    assert system.patterns.shape == (n, 4) and len(system.attached.M) == 6 + modes


@pytest.mark.parametrize("component", [0, 1, 2])
def test_ground_moves_the_device_too(made: Made, device: Any, component: int) -> None:
    """Its mass with the building's, rigidly: by the rows of translations along the ground."""
    system = made.system
    along = np.zeros(len(system.patterns))
    along[component : len(along) - len(system.rows) + 6 : 6] = 1.0
    building = -(system.patterns[:, component] @ along)
    # Followers hand their load on to the master, so that sums over all rows do not change.
    assert building - made.ground[component::6, component].sum() == pytest.approx(800.0, rel=1e-9)
    assert system.patterns[:, 3] @ along == pytest.approx(-1.0 if component == 1 else 0.0)


def test_matrices(made: Made, device: Any, frame: Any) -> None:
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
