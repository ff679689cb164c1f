import numpy as np
import pytest
from petsc4py import PETSc

from impactfem.dynamics.columns import combined


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
