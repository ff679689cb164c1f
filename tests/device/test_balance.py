import numpy as np
import pytest

from impactfem.device.balance import base_imbalance
from impactfem.device.beam import Beam
from impactfem.device.from_matrices import from_matrices
from impactfem.device.springs import COMPONENTS


def test_forces_and_moments_have_each_their_own_scale(pump):
    forces = np.array([[4e3], [5e3], [0.0], [20.0], [10.0], [0.0]])
    assert base_imbalance(pump(), forces, forces) == 0.0
    for row, worst in ((1, 2e-4), (3, 5e-2)):
        wrong = forces.copy()
        wrong[row] += 1.0
        assert base_imbalance(pump(), forces, wrong) == pytest.approx(worst)


def test_blocked_motions_are_not_compared(pump):
    forces = np.full((6, 3), 100.0)
    springs = forces.copy()
    # Along z and about z the pump's base is blocked.
    springs[[2, 5]] = 0.0
    assert base_imbalance(pump(), forces, springs) == 0.0
    assert base_imbalance(pump(z=1e9), forces, springs) == pytest.approx(1.0)
    assert base_imbalance(pump(), forces[:, :0], springs[:, :0]) == 0.0


def test_masses_on_the_anchor_press_without_a_spring():
    """40 kg of 100 kg sit on the anchor; without its acceleration nothing can be compared."""
    M, k = np.diag([40.0, 60.0]), 5e5
    device = from_matrices("mast", M, k * np.array([[1.0, -1.0], [-1.0, 1.0]]), {0: 1}, 0.02)
    inertia, springs, a = np.zeros((3, 6, 2))
    a[1] = 2.0, 3.0
    springs[1] = -200.0, -100.0
    inertia[1] = springs[1] - 40.0 * a[1]
    assert np.isnan(base_imbalance(device, inertia, springs))
    assert base_imbalance(device, inertia, springs, a) < 1e-15
    assert base_imbalance(device, inertia, springs, 0.5 * a) == pytest.approx(60.0 / 280.0)


def test_a_base_with_everything_blocked_has_nothing_to_compare(pump):
    device = pump(Beam(0.46, 8e7, 8e7), **dict.fromkeys(COMPONENTS, np.inf))
    assert np.isnan(base_imbalance(device, np.ones((6, 2)), np.ones((6, 2))))
