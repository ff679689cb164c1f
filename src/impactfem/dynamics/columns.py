"""Blocks of vectors as arrays: each rank holds the rows that it owns, one vector a column."""

import numpy as np
from petsc4py import PETSc

from impactfem.system.arrays import Array

SEED = 20071221


def combined(k: float, K: PETSc.Mat, m: float, M: PETSc.Mat) -> PETSc.Mat:
    """The matrix k K + m M (AIJ), new, the pattern of M part of that of K. Collective."""
    total = K.copy()
    total.scale(k)
    total.axpy(m, M, structure=PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
    return total


def wrapped(A: PETSc.Mat, array: Array) -> PETSc.Vec:
    """A vector over the rows of A with this rank's rows, contiguous, as its memory. Collective."""
    return PETSc.Vec().createWithArray(array, size=A.getSizes()[0], comm=A.getComm())


def product(A: PETSc.Mat, X: Array, Y: Array | None = None) -> Array:
    """A X of columns X, shape (n_local, k), Fortran order. Collective.

    It is put into Y where that is given, in Fortran order and not X.
    """
    if X.shape[1] == 0:
        return np.zeros(X.shape, order="F")
    # All columns at once: A is read once for four of them.
    X = np.asfortranarray(X, dtype=np.float64)
    if Y is None:
        Y = np.empty((A.getLocalSize()[0], X.shape[1]), order="F")
    sizes = reversed(A.getSizes())
    block, found = (
        PETSc.Mat().createDense((rows, (None, X.shape[1])), array=columns, comm=A.getComm())
        for rows, columns in zip(sizes, (X, Y), strict=True)
    )
    A.matMult(block, found)
    found.destroy()
    block.destroy()
    return Y


def inner(A: PETSc.Mat, X: Array, Y: Array) -> Array:
    """Xᵀ Y, shape (k, l), of columns, shape (n_local, ·), over all ranks of A. Collective."""
    return summed(A, np.ascontiguousarray(X.T @ Y))


def summed(A: PETSc.Mat, local: Array) -> Array:
    """The sum over all ranks of the communicator of A; of one rank without MPI. Collective."""
    comm = A.getComm()
    return np.asarray(local if comm.getSize() == 1 else comm.tompi4py().allreduce(local))


def random_column(A: PETSc.Mat, stream: int = 0) -> Array:
    """Standard normal numbers of a stream at this rank's rows, the same for a row on any ranks."""
    start, end = A.getOwnershipRange()
    every = np.random.default_rng([SEED, stream]).standard_normal(A.getSize()[0])
    return np.array(every[start:end])


def row_of_largest(A: PETSc.Mat, size: Array) -> int:
    """Global row of the largest entry of sizes, not negative, shape (n_local,). Collective.

    The first row on ties, of entries within 1e-6 of the largest: rounding, which differs with the
    number of ranks, shall not decide between them.
    """
    comm = A.getComm().tompi4py()
    start = A.getOwnershipRange()[0]
    largest = max(comm.allgather(float(np.max(size, initial=0.0))))
    among = np.flatnonzero(size >= (1.0 - 1e-6) * largest)
    first = start + int(among[0]) if among.size else A.getSize()[0]
    return int(min(comm.allgather(first)))
