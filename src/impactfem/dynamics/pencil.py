"""A stiffness and a mass, added with factors."""

from __future__ import annotations

from petsc4py import PETSc


def combined(k: float, K: PETSc.Mat, m: float, M: PETSc.Mat) -> PETSc.Mat:
    """The matrix k K + m M, new, with the pattern of K. Collective.

    Args:
        k: Factor of K.
        K: Stiffness (AIJ).
        m: Factor of M.
        M: Mass (AIJ), on part of the pattern of K.
    """
    total = K.copy()
    total.scale(k)
    total.axpy(m, M, structure=PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
    return total
