import numpy as np
import pytest
from petsc4py import PETSc

from impactfem.dynamics.columns import combined, inner, product, row_of_largest


def test_products(petsc):
    rng = np.random.default_rng(1)
    A, X = rng.standard_normal((5, 5)), rng.standard_normal((5, 3))
    assert product(petsc(A), X) == pytest.approx(A @ X, rel=1e-13)
    assert product(petsc(A), np.asfortranarray(X)).flags.f_contiguous
    assert inner(petsc(A), X, X) == pytest.approx(X.T @ X, rel=1e-13)


def test_row_of_largest(petsc):
    A = petsc(np.eye(4))
    assert row_of_largest(A, np.array([0.0, 3.0, 1.0, 2.0])) == 1
    # Nearly the same counts as the same: the first.
    assert row_of_largest(A, np.array([0.0, 3.0, 1.0, 3.0 + 1e-9])) == 1
    assert row_of_largest(A, np.array([0.0, 3.0, 1.0, 3.0 + 1e-3])) == 3


def dense(A):
    return A.convert("dense").getDenseArray()


def test_combined(petsc, chain):
    K, M = petsc(chain(4)), petsc(np.diag([1.0, 2.0, 3.0, 4.0]))
    S = combined(2.0, K, -0.5, M)
    assert dense(S) == pytest.approx(2.0 * chain(4) - 0.5 * np.diag([1.0, 2.0, 3.0, 4.0]))
    assert dense(K) == pytest.approx(chain(4))


def test_a_mass_off_the_pattern_is_refused(petsc, chain):
    with pytest.raises(PETSc.Error):
        combined(1.0, petsc(np.eye(4)), 1.0, petsc(chain(4)))
