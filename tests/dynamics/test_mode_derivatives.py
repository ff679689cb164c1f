"""Derivatives of modes against differences, and against what a closed form says."""

import numpy as np
import pytest
from petsc4py import PETSc

from impactfem.dynamics.mode_derivatives import mode_derivatives
from impactfem.dynamics.modes import Modes, modes
from impactfem.system.errors import SolutionError


def chain(n=40):
    """Springs and masses in a row, all different, clamped at one end."""
    rng = np.random.default_rng(3)
    k, m = rng.uniform(1.0, 2.0, n), rng.uniform(1.0, 2.0, n)
    K = np.diag(k + np.append(k[1:], 0.0)) - np.diag(k[1:], 1) - np.diag(k[1:], -1)
    return K, np.diag(m)


def matrix(dense, pattern):
    found = PETSc.Mat().createAIJ(dense.shape, comm=PETSc.COMM_SELF)
    found.setUp()
    rows, columns = np.nonzero(pattern)
    for i, j in zip(rows, columns, strict=True):
        found[i, j] = dense[i, j]
    found.assemble()
    return found


def solved(K, M, count=8):
    return modes(matrix(K, K), matrix(M, M), count)


@pytest.fixture
def change():
    """Of a stiffness and of a mass in the middle: dK and dM."""
    K, M = chain()
    dK, dM = np.zeros_like(K), np.zeros_like(M)
    dK[10:12, 10:12] = [[1.0, -1.0], [-1.0, 1.0]]
    dM[20, 20] = 1.0
    return K, M, dK, dM


def test_against_differences(change):
    K, M, dK, dM = change
    found, numbers, h = solved(K, M), [0, 2, 5], 1e-4
    φ = found.shapes[:, numbers]
    dλ, dφ = mode_derivatives(matrix(K, K), matrix(M, M), found, numbers, [(dK @ φ, dM @ φ)])
    low, high = (solved(K + s * dK, M + s * dM) for s in (-h, h))
    by_differences = ((2.0 * np.pi) ** 2 * (high.frequency**2 - low.frequency**2) / (2.0 * h))[
        numbers
    ]
    assert dλ[0] == pytest.approx(by_differences, rel=1e-6)
    shapes = (high.shapes - low.shapes)[:, numbers] / (2.0 * h)
    assert dφ[0] == pytest.approx(shapes, abs=1e-6 * np.abs(shapes).max())
    # A twin: without the rest beyond the known modes the shapes are not the same.
    part = φ @ (φ.T @ M @ dφ[0])
    assert np.abs(part - shapes).max() > 1e-2 * np.abs(shapes).max()


def test_all_stiffness_alike(change):
    """dK = K, dM = 0: λ goes with the factor and no shape changes."""
    K, M, _, _ = change
    found = solved(K, M)
    φ = found.shapes[:, :3]
    dλ, dφ = mode_derivatives(matrix(K, K), matrix(M, M), found, [0, 1, 2], [(K @ φ, 0.0 * φ)])
    assert dλ[0] == pytest.approx((2.0 * np.pi * found.frequency[:3]) ** 2, rel=1e-9)
    assert np.abs(dφ).max() < 1e-8


def test_equal_frequencies_are_refused(change):
    K, M, _, _ = change
    found = solved(K, M)
    twice = Modes(found.frequency[[0, 0, 1]], found.shapes[:, [0, 0, 1]], found.residual[:3])
    φ = twice.shapes[:, :1]
    with pytest.raises(SolutionError, match="no derivatives of their own"):
        mode_derivatives(matrix(K, K), matrix(M, M), twice, [0], [(K @ φ, M @ φ)])
