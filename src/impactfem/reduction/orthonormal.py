"""Vectors that are orthonormal in a mass, which grow in number block by block; their memory."""

import mmap
import os
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse
from petsc4py import PETSc
from scipy.linalg.blas import dgemm, dtrsm

from impactfem.dynamics.columns import inner, product, summed
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError
from impactfem.system.log import LOGGER
from impactfem.system.memory import available_memory, disk_folder, give_back
from impactfem.system.parallel import all_blas_threads

DEPENDENT = 1e-9
"""Part of a vector outside the basis, over its length, up to which it counts as dependent: the
rounding of a solve."""

INDEPENDENT = 1e-6
"""Least eigenvalue of the Gram matrix of vectors of length one from which its rounding is small."""

GONE = 0.5
"""Length that is left of a vector of length one up to which it was not there but by rounding."""

TINY = np.finfo(np.float64).tiny
"""Square of the length of a vector of zeros, so that it has one."""

CHUNK = 64
"""Vectors that memory is set aside for at once. The system gives it when they are written."""

ROWS = 4096
"""Rows whose columns are combined at once."""

LEFT = 4
"""Blocks of vectors that must have room together with the one that is set up: their copies and
products with a matrix."""


@dataclass(frozen=True, eq=False)
class Room:
    """An array in memory, or in a file."""

    array: Array  #: Shape (rows, columns), Fortran order.
    pages: mmap.mmap | None  #: The file's, None in memory.

    def fetch(self) -> Array:
        """The array; that of a file is read as a whole, and not page by page when it is used."""
        if self.pages is not None:
            self.pages.madvise(mmap.MADV_WILLNEED)
        return self.array


def room(rows: int, columns: int, processes: int = 1) -> Room:
    """An array for columns, not yet filled: in memory, or in a file where memory runs short.

    The file is in the folder of the environment variable TMPDIR, else in /var/tmp; it has no name
    and goes with the array, also when the process is killed. So many processes set up as much on
    this machine at the same time. SolutionError where there is room neither in memory nor in the
    folder.
    """
    size = 8 * rows * columns
    if (1 + LEFT) * size * processes > available_memory():
        give_back()  # blocks that are free again stay with the allocator
    if not size or (1 + LEFT) * size * processes <= available_memory():
        return Room(np.empty((rows, columns), order="F"), None)
    folder = disk_folder()
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            # A full disk would end the process when the pages are written.
            os.posix_fallocate(file.fileno(), 0, size)
            pages = mmap.mmap(file.fileno(), size)
    except OSError as error:
        raise SolutionError(
            f"the vectors of the reduced model need {1e-9 * size:.2g} GB beyond the memory, and no "
            f"file of this size can be made in {folder} ({error.strerror or error}): name another "
            "folder by TMPDIR"
        ) from error
    LOGGER.info(
        "memory runs short: %.2g GB of the vectors of a reduced model go to a file in %s",
        1e-9 * size,
        folder,
    )
    return Room(np.frombuffer(pages).reshape((rows, columns), order="F"), pages)


class Orthonormal:
    """Columns V with Vᵀ M V = I, each rank holding its rows.

    The last of them may be (X − V C) E of vectors X that are stored as they came in, C = Vᵀ M X of
    the others (`append_kept`). Methods are collective, but `rows` and `columns`.

    Args:
        M: Mass, symmetric, positive definite (AIJ).
    """

    def __init__(self, M: PETSc.Mat) -> None:
        self.M = M
        self.count = 0
        self._chunks: list[Room] = []
        self.stored = 0  # V and X
        self._gram: Array = np.zeros((0, 0))  # C, and below it Xᵀ M X
        self._E: Array = np.zeros((0, 0))

    @all_blas_threads()
    def append(
        self, X: Array, near: int = 0, dependent: float = DEPENDENT, attempts: int = 3
    ) -> tuple[Array, Array]:
        """Take in what X, shape (n_local, k), Fortran order, has outside the columns; it is lost.

        Of a vector that has at most the part `dependent` of its length outside, nothing comes in.
        `near` is the first of the columns in which X has large parts. The first of so many attempts
        at most takes off these alone, the others those in all columns. Gives the coordinates of X
        in all columns, shape (count, k); and M times the new ones, shape (n_local, number of new
        columns). SolutionError where x has values that are not numbers; ValueError after
        `append_kept`.
        """
        if len(self._E):
            raise ValueError("vectors that stay as they are must be the last ones")
        MX = product(self.M, X)
        length = np.sqrt(np.diag(inner(self.M, X, MX)))
        if not np.all(np.isfinite(length)):
            raise SolutionError("a load pattern has values that are not numbers")
        coordinates = np.zeros((self.count, X.shape[1]))
        B: Array = np.eye(X.shape[1])
        # Twice is enough, and needed: what is left of a nearly dependent vector is mostly rounding.
        # Once more, where the second time takes away more than rounding; a vector that is then not
        # there any more was rounding itself.
        first, least = near, dependent * length
        for attempt in range(attempts):
            known = self._subtract(first, X, MX)
            coordinates[first:] += known @ B
            X, MX, inside = _orthonormal(self.M, X, product(self.M, X, MX), least)
            B = inside @ B
            if attempt > 0 and np.all(np.diag(inside) > GONE):
                break
            first, least = 0, np.full(X.shape[1], 0.0 if attempt == 0 else GONE)
        self._store(X)
        return np.vstack([coordinates, B]), MX

    @all_blas_threads()
    def append_kept(self, X: Array, dependent: float) -> None:
        """Take in vectors that are stored as they are, shape (n_local, k), Fortran order.

        What these and those before have outside the others comes in, but for directions in which no
        combination of vectors of length one has more than `dependent`. The square of what is there
        is a difference, of which 1e-15 is rounding, so that this is not to be small; it takes a
        third of the time of `append`, which must not follow. SolutionError where x has values that
        are not numbers.
        """
        n, m, MX = self.count - self._E.shape[1], len(self._E), product(self.M, X)
        self._store(X)
        self.count = n  # V alone, until it is known what comes in
        seen = [summed(self.M, piece.T @ MX) for piece in self.pieces(0, self.stored)]
        gram = np.pad(self._gram, ((0, n + m + X.shape[1] - len(self._gram)), (0, X.shape[1])))
        gram[:, m:] = np.concatenate(seen)
        gram[n + m :, :m] = gram[n : n + m, m:].T
        if not np.all(np.isfinite(gram)):
            raise SolutionError("a load pattern has values that are not numbers")
        C, size = gram[:n], 1.0 / np.sqrt(np.maximum(np.diag(gram[n:]), TINY))
        square, U = np.linalg.eigh((gram[n:] - C.T @ C) * size * size[:, None])
        come = square > dependent**2
        self._gram, self._E = gram, size[:, None] * U[:, come] / np.sqrt(square[come])
        self.count = n + self._E.shape[1]

    def replace(self, first: int, X: Array) -> None:
        """Put others in place of the columns from one on, shape (n_local, number of them)."""
        self.count = self.stored = first
        self._store(X)

    def drop(self, first: int) -> Array:
        """Take out the columns from one on, shape (n_local, number of them), Fortran order."""
        X = np.array(self.columns(first, self.count), order="F")
        self.count = self.stored = first
        return X

    def rows(self, index: Index, first: int, last: int) -> Array:
        """Some of this rank's rows of a range of columns, without a copy of the others.

        The rows are counted from the first of this rank, of any shape; the columns are a further
        axis.
        """
        begin, end = self._stored_for(first, last)
        flat, start = np.empty((np.size(index), end - begin)), 0
        for piece in self.pieces(begin, end):
            # Column by column: a row of the piece is spread over all of its memory.
            flat[:, start : start + piece.shape[1]] = piece.T.take(np.ravel(index), axis=1).T
            start += piece.shape[1]
        if self.kept(last)[1].size:
            # In place, some rows at a time: a copy of all of them may take gigabytes.
            for k in range(0, len(flat), ROWS):
                part = flat[k : k + ROWS]
                part[:, : last - first] = self._outside(part, first, last)
        return flat[:, : last - first].reshape(*np.shape(index), last - first)

    def seen(self, L: Any, last: int) -> Array:
        """Lᵀ V of the first columns, shape (k, last), the same on all ranks.

        L, shape (n_local, k), is an array or of `scipy.sparse`.
        """
        if scipy.sparse.issparse(L):
            # SciPy would copy all of a piece for the few rows that count.
            rows = np.unique(L.nonzero()[0])
            return summed(self.M, np.asarray(L.tocsr()[rows].T @ self.rows(rows, 0, last)))
        pieces = [L.T @ piece for piece in self.pieces(*self._stored_for(0, last))]
        found = np.concatenate([np.empty((L.shape[1], 0)), *pieces], axis=1)
        return self._outside(summed(self.M, found), 0, last)

    def combination(self, coordinates: Array) -> Array:
        """V c of the first columns, shape (n_local, k), Fortran order; c one row a column."""
        X = np.zeros((self.M.getLocalSize()[0], coordinates.shape[1]), order="F")
        C, E = self.kept(len(coordinates))
        if E.size:
            own = E @ coordinates[len(C) :]
            coordinates = np.vstack([coordinates[: len(C)] - C @ own, own])
        first = 0
        for V in self.pieces(0, len(coordinates)):
            if X.size:
                dgemm(1.0, V, coordinates[first : first + V.shape[1]], 1.0, X, overwrite_c=True)
            first += V.shape[1]
        return X

    def _subtract(self, first: int, X: Array, MX: Array) -> Array:
        """Take V (Vᵀ M X) of the vectors V from the first on off X; gives Vᵀ M X."""
        known = [np.empty((0, MX.shape[1]))]
        for V in self.pieces(first, self.count):
            known.append(summed(self.M, V.T @ MX))
            if X.size and V.size:
                # In place: a separate product would be as large as X, and be added slowly.
                dgemm(-1.0, V, known[-1], beta=1.0, c=X, overwrite_c=True)
        return np.concatenate(known)

    def _store(self, X: Array) -> None:
        for x in X.T:
            if self.stored == CHUNK * len(self._chunks):
                self._chunks.append(room(X.shape[0], CHUNK, self.M.getComm().getSize()))
            self._chunks[self.stored // CHUNK].array[:, self.stored % CHUNK] = x
            self.count, self.stored = self.count + 1, self.stored + 1

    def pieces(self, first: int, last: int) -> Iterator[Array]:
        """A range of what is stored, V and then X: blocks of memory side by side.

        One after the other: those in files may be too large to have all of them at hand.
        """
        for start, chunk in zip(range(0, last, CHUNK), self._chunks, strict=False):
            begin, end = max(first - start, 0), min(last - start, CHUNK)
            if begin < end:
                yield chunk.fetch()[:, begin:end]

    def columns(self, first: int, last: int) -> Array:
        """The columns of a range, shape (n_local, last - first): a copy, unless they are few."""
        pieces = list(self.pieces(*self._stored_for(first, last)))
        if len(pieces) != 1:
            pieces = [np.hstack([np.empty((self.M.getLocalSize()[0], 0), order="F"), *pieces])]
        return self._outside(pieces[0], first, last)

    def kept(self, last: int) -> tuple[Array, Array]:
        """C and E of those of the first columns that are of X, shapes (n, m) and (m, k)."""
        n = self.count - self._E.shape[1]
        if last <= n:
            return np.zeros((last, 0)), np.zeros((0, 0))
        return self._gram[:n], self._E[:, : last - n]

    @property
    def gram(self) -> Array:
        """Xᵀ M X of what is stored as it came in, shape (m, m)."""
        return self._gram[len(self._gram) - len(self._E) :]

    def _stored_for(self, first: int, last: int) -> tuple[int, int]:
        """The range of what is stored that a range of columns needs."""
        C, E = self.kept(last)
        return (0, len(C) + len(E)) if E.size else (first, last)

    def _outside(self, stored: Array, first: int, last: int) -> Array:
        """Rows of a range of columns from those of what is stored for it."""
        C, E = self.kept(last)
        if not E.size:
            return stored
        n = len(C)
        return np.hstack([stored[:, :n], (stored[:, n:] - stored[:, :n] @ C) @ E])[:, first:]


def _orthonormal(M: PETSc.Mat, X: Array, MX: Array, least: Array) -> tuple[Array, Array, Array]:
    """M-orthonormal columns Q, M Q and B, with X = Q B but for what is left out; X is overwritten.

    `least` is the length up to which what is left of each column is left out, shape (k,).
    """
    gram = inner(M, X, MX)
    size = np.sqrt(np.maximum(np.diag(gram), TINY))
    if not size.size or np.linalg.eigvalsh(gram / size / size[:, None]).min() <= INDEPENDENT:
        return _one_by_one(M, X, MX, least)
    # All at once by Cholesky's factor; a second time, as the first leaves some rounding.
    B: Array = np.eye(len(size))
    for _ in range(2):
        R = scipy.linalg.cholesky(gram)  # upper
        if np.any(np.diag(R) <= least):
            return _one_by_one(M, X, MX, least)
        if X.size:
            X, MX = (dtrsm(1.0, R, one, side=1, overwrite_b=True) for one in (X, MX))  # X R⁻¹
        B, gram, least = R @ B, inner(M, X, MX), np.zeros(len(least))
    return X, MX, B


def _one_by_one(M: PETSc.Mat, X: Array, MX: Array, least: Array) -> tuple[Array, Array, Array]:
    """The same for columns that may depend on each other: their Gram matrix has half the digits."""
    B = np.zeros((X.shape[1], X.shape[1]))
    n = 0
    for j in range(X.shape[1]):
        x, Mx = X[:, j], MX[:, j]
        # Twice, too: one pass over many nearly dependent columns leaves none of them orthogonal.
        for _ in range(2):
            known = inner(M, X[:, :n], Mx[:, None])[:, 0]
            x -= X[:, :n] @ known
            Mx -= MX[:, :n] @ known
            B[:n, j] += known
        left = float(np.sqrt(max(inner(M, x[:, None], Mx[:, None])[0, 0], 0.0)))
        if left > least[j]:
            X[:, n], MX[:, n] = x / left, Mx / left
            B[n, j] = left
            n += 1
    # M times them anew: what was taken along has lost digits where little of a column is left.
    return X[:, :n], product(M, X[:, :n], MX[:, :n]), B[:n]
