import numpy as np
import pytest

from impactfem.dynamics.energy import Energy


def test_residual():
    kinetic, elastic = np.array([0.0, 1.0, 2.0]), np.array([0.0, 3.0, 1.0])
    damped = np.array([0.0, 0.5, 1.0])
    assert Energy(kinetic, elastic, damped, np.array([0.0, 4.5, 4.0])).residual == 0.0
    off = Energy(kinetic, elastic, damped, np.array([0.0, 4.5, 5.0]))
    assert off.residual == pytest.approx(1.0 / 5.0)


def test_residual_of_a_start_with_energy():
    """Relative to the energy stored, where no work is done; a part of a history has one too."""
    stored, nothing = np.array([8.0, 6.0]), np.zeros(2)
    damped = np.array([3.0, 4.9])
    assert Energy(stored, nothing, damped, nothing).residual == pytest.approx(0.1 / 8.0)


def test_nothing_moves():
    assert Energy(*np.zeros((4, 3))).residual == 0.0
