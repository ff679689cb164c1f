"""Small matrices by hand, and their way into PETSc."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from petsc4py import PETSc


@pytest.fixture
def petsc() -> Iterator[Callable[[Any], PETSc.Mat]]:
    """Make a PETSc matrix (AIJ, one rank) of a dense or sparse one."""
    made = []

    def make(matrix: Any) -> PETSc.Mat:
        csr = sp.csr_matrix(matrix)
        made.append(
            PETSc.Mat().createAIJ(
                csr.shape, csr=(csr.indptr, csr.indices, csr.data), comm=PETSc.COMM_SELF
            )
        )
        return made[-1]

    yield make
    for matrix in made:
        matrix.destroy()


@pytest.fixture(scope="session")
def chain() -> Callable[..., np.ndarray]:
    """Stiffness of n unit masses in a row, between springs of 1 N/m; free ends on request."""

    def make(n: int, *, first: bool = True, last: bool = True) -> np.ndarray:
        K = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
        K[0, 0] -= not first
        K[-1, -1] -= not last
        return K

    return make
