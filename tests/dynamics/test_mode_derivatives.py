"""Derivatives of modes against differences, and against what a closed form says."""

import numpy as np
import pytest

from impactfem.dynamics.mode_derivatives import mode_derivatives
from impactfem.dynamics.modes import Modes, modes
from impactfem.system.errors import SolutionError


@pytest.fixture
def row():
    """Stiffness and mass of 40 springs and masses in a row, all different, clamped at one end."""
    k, m = np.random.default_rng(3).uniform(1.0, 2.0, (2, 40))
    K = np.diag(k + np.append(k[1:], 0.0)) - np.diag(k[1:], 1) - np.diag(k[1:], -1)
    return K, np.diag(m)


def test_against_differences(petsc, row):
    """Of a spring and of a mass in the middle."""
    (K, M), numbers, h = row, [0, 2, 5], 1e-4
    dK, dM = np.zeros((2, *K.shape))
    dK[10:12, 10:12] = [[1.0, -1.0], [-1.0, 1.0]]
    dM[20, 20] = 1.0
    found, low, high = (modes(petsc(K + s * dK), petsc(M + s * dM), 8) for s in (0.0, -h, h))
    φ = found.shapes[:, numbers]
    dλ, dφ = mode_derivatives(petsc(K), petsc(M), found, numbers, [(dK @ φ, dM @ φ)])
    by_differences = (2.0 * np.pi) ** 2 * (high.frequency**2 - low.frequency**2) / (2.0 * h)
    assert dλ[0] == pytest.approx(by_differences[numbers], rel=1e-6)
    shapes = (high.shapes - low.shapes)[:, numbers] / (2.0 * h)
    assert dφ[0] == pytest.approx(shapes, abs=1e-6 * np.abs(shapes).max())
    # A twin: without the rest beyond the known modes the shapes are not the same.
    part = φ @ (φ.T @ M @ dφ[0])
    assert np.abs(part - shapes).max() > 1e-2 * np.abs(shapes).max()


def test_all_stiffness_alike(petsc, row):
    """dK = K, dM = 0: λ goes with the factor and no shape changes."""
    K, M = map(petsc, row)
    found = modes(K, M, 8)
    φ = found.shapes[:, :3]
    dλ, dφ = mode_derivatives(K, M, found, [0, 1, 2], [(row[0] @ φ, 0.0 * φ)])
    assert dλ[0] == pytest.approx((2.0 * np.pi * found.frequency[:3]) ** 2, rel=1e-9)
    assert np.abs(dφ).max() < 1e-8


def test_equal_frequencies_are_refused(petsc, row):
    K, M = map(petsc, row)
    found = modes(K, M, 8)
    twice = Modes(found.frequency[[0, 0, 1]], found.shapes[:, [0, 0, 1]], found.residual[:3])
    φ = twice.shapes[:, :1]
    with pytest.raises(SolutionError, match="no derivatives"):
        mode_derivatives(K, M, twice, [0], [(row[0] @ φ, row[1] @ φ)])
