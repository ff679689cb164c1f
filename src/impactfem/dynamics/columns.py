"""Blocks of vectors as arrays: each rank holds the rows that it owns, one vector a column."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

Array = NDArray[np.float64]
SEED = 20071221


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


def wrapped(A: PETSc.Mat, array: Array) -> PETSc.Vec:
    """A vector over the rows of A that uses an array as its memory. Collective.

    Args:
        A: Square matrix, whose rows are distributed as those of the vector.
        array: The rows of this rank, shape (n_local,), contiguous.
    """
    return PETSc.Vec().createWithArray(array, size=A.getSizes()[0], comm=A.getComm())


def product(A: PETSc.Mat, X: Array) -> Array:
    """A X, shape (n_local, k), Fortran order. Collective.

    Args:
        A: Square matrix.
        X: Columns, shape (n_local, k).
    """
    if X.shape[1] == 0:
        return np.zeros(X.shape, order="F")
    # All columns at once: A is read once for four of them.
    columns = np.asfortranarray(X, dtype=np.float64)
    size = (A.getSizes()[1], (None, X.shape[1]))
    block = PETSc.Mat().createDense(size, array=columns, comm=A.getComm())
    found = A.matMult(block)
    Y: Array = found.getDenseArray().copy(order="F")
    found.destroy()
    block.destroy()
    return Y


def inner(A: PETSc.Mat, X: Array, Y: Array) -> Array:
    """Xᵀ Y summed over all ranks of the communicator of A, shape (k, l). Collective.

    Args:
        A: Matrix whose communicator counts.
        X: Columns, shape (n_local, k).
        Y: Columns, shape (n_local, l).
    """
    local = np.ascontiguousarray(X.T @ Y)
    total: Array = A.getComm().tompi4py().allreduce(local)
    return total


def random_column(A: PETSc.Mat, stream: int = 0) -> Array:
    """Standard normal numbers, the same for each global row on any number of ranks.

    Args:
        A: Matrix whose rows count.
        stream: Another number gives other columns.

    Returns:
        The rows of this rank, shape (n_local,).
    """
    start, end = A.getOwnershipRange()
    every = np.random.default_rng([SEED, stream]).standard_normal(A.getSize()[0])
    mine: Array = every[start:end].copy()
    return mine


def row_of_largest(A: PETSc.Mat, size: Array, slack: float = 1e-6) -> int:
    """Global row of the largest entry; the first row on ties. Collective.

    Args:
        A: Matrix whose rows count.
        size: Sizes of the entries, not negative, shape (n_local,).
        slack: Entries within this fraction of the largest count as ties: rounding, which differs
            with the number of ranks, shall not decide between them.
    """
    comm = A.getComm().tompi4py()
    start = A.getOwnershipRange()[0]
    largest = max(comm.allgather(float(np.max(size, initial=0.0))))
    among = np.flatnonzero(size >= (1.0 - slack) * largest)
    first = start + int(among[0]) if among.size else A.getSize()[0]
    return int(min(comm.allgather(first)))
