"""A block Krylov basis of stiffness, mass and load patterns, which does not depend on damping.

With C = α M + β K the response to the load F at the angular frequency ω solves

    (K + σ M) x = F / (1 + iωβ),   σ = iω (iω + α) / (1 + iωβ).

With one real shift σ0 > 0 and A = (K + σ0 M)⁻¹ M this is (I + (σ − σ0) A) x = x0 / (1 + iωβ),
x0 = (K + σ0 M)⁻¹ F. The columns of x0, A x0, A² x0, ... span one space for all ω, α and β. Its
basis V, with Vᵀ M V = I, fulfils A V = V T + Q S, where the few columns of Q are M-orthogonal to V.

Beattie and Gugercin, Krylov-based model reduction of second-order systems with proportional
damping, CDC 2005; full reorthogonalisation as in Grimme, Sorensen and Van Dooren (1996).
"""

from __future__ import annotations

from types import TracebackType

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc
from scipy.linalg.blas import dgemm

from impactfem.dynamics.columns import inner, product
from impactfem.dynamics.factorisation import Factorisation
from impactfem.dynamics.pencil import combined
from impactfem.errors import SolutionError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

DEPENDENT = 1e-9
"""Part of a vector outside the basis, over its length, up to which it counts as dependent: the
rounding of a solve. What is left out violates A V = V T + Q S by as much."""

SMALL = 0.1
"""Part of a vector inside the others, over its length, that is too much for rounding."""

CHUNK = 64
"""Vectors that memory is set aside for at once. The system gives it when they are written."""


class KrylovBasis:
    """The basis, built block by block. A context manager that frees the factorisation.

    Making one, and its methods but `rows`, are collective.

    Args:
        K: Stiffness, symmetric, positive definite (AIJ).
        M: Mass, symmetric, positive definite (AIJ), on part of the pattern of K.
        shift: σ0 [1/s2].

    Raises:
        SolutionError: K + σ0 M is not positive definite.
    """

    def __init__(self, K: PETSc.Mat, M: PETSc.Mat, shift: float) -> None:
        self.shift = shift
        self.K, self.M = K, M
        shifted = combined(1.0, K, shift, M)
        self._factor = Factorisation(shifted, name="the shifted stiffness matrix")
        shifted.destroy()
        self._chunks: list[Array] = []
        # The vectors: first those of V, then those of Q; and M times the latter.
        self._size = 0
        self._count = 0
        self._MQ: Array = np.zeros((M.getLocalSize()[0], 0), order="F")
        self._T: Array = np.zeros((0, 0))
        self._R: Array = np.zeros((0, 0))
        self._sizes: list[int] = []

    def __enter__(self) -> KrylovBasis:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.destroy()

    def destroy(self) -> None:
        """Free the factorisation; the basis stays and cannot grow any more. Collective."""
        self._factor.destroy()

    @property
    def size(self) -> int:
        """Number of vectors of the reduced space."""
        return self._size

    @property
    def sizes(self) -> tuple[int, ...]:
        """The size after each block step: those of the spaces nested in this one."""
        return tuple(self._sizes)

    @property
    def V(self) -> Array:
        """The basis at this rank's rows, shape (n_local, size): a copy, unless it is small."""
        return self._columns(0, self._size)

    def rows(self, index: Index) -> Array:
        """The basis at some of this rank's rows, without a copy of the others.

        Args:
            index: The rows, counted from the first of this rank, of any shape.

        Returns:
            The shape of `index` with the size of the basis as a further axis.
        """
        pieces = [piece[index] for piece in self._pieces(0, self._size)]
        return np.concatenate([np.empty((*np.shape(index), 0)), *pieces], axis=-1)

    @property
    def T(self) -> Array:
        """Vᵀ M A V, shape (size, size) [s2]."""
        return self._T[: self._size, : self._size]

    @property
    def R(self) -> Array:
        """Coordinates of (K + σ0 M)⁻¹ F of each load pattern, shape (size, n_patterns)."""
        return self._R[: self._size]

    @property
    def Q(self) -> Array:
        """The tail: what A V has outside the space, shape (n_local, n_tail)."""
        return self._columns(self._size, self._count)

    @property
    def S(self) -> Array:
        """Qᵀ M A V, shape (n_tail, size) [s2]."""
        return self._T[self._size :, : self._size]

    def shifted_tail(self) -> Array:
        """(K + σ0 M) Q, shape (n_local, n_tail). Collective."""
        Z = self.shift * self._MQ
        Z += product(self.K, self.Q)
        return Z

    def dual_norm(self, F: Array) -> Array:
        """√(fᵀ (K + σ0 M)⁻¹ f) of each column. Collective.

        Args:
            F: Loads, or the rows of probes as columns, shape (n_local, k).

        Returns:
            Shape (k,).
        """
        squares = np.diag(inner(self.M, F, self._factor.solve_block(F)))
        return np.asarray(np.sqrt(np.maximum(squares, 0.0)), dtype=np.float64)

    def add(self, F: Array) -> None:
        """Add load patterns; the space of those before stays. Collective.

        Patterns that are zero, or that depend on others, bring in no vector.

        Args:
            F: Load patterns at this rank's rows, shape (n_local, m).

        Raises:
            SolutionError: A pattern has values that are not numbers.
        """
        before = self._R.shape[1]
        MQ = self._MQ
        coordinates = self._append(self._factor.solve_block(F), 0)
        self._R = _padded(self._R, self._count, before + F.shape[1])
        self._R[:, before:] = coordinates
        self._MQ = np.hstack([MQ, self._MQ])
        self.grow(1)

    def grow(self, steps: int) -> int:
        """Take the space some block steps further. Collective.

        Returns:
            Number of vectors that came into the space; fewer, or none, when it holds all that the
            loads can reach.
        """
        before = self._size
        for _ in range(steps):
            tail = slice(self._size, self._count)
            if tail.start == tail.stop:
                break
            # A is self-adjoint: A Q has no part in the vectors before the last block step.
            near = self._sizes[-2] if len(self._sizes) > 1 else 0
            coordinates = self._append(self._factor.solve_block(self._MQ), near)
            self._T = _padded(self._T, self._count, self._count)
            self._T[:, tail] = coordinates
            self._T[tail, :] = coordinates.T
            self._R = _padded(self._R, self._count, self._R.shape[1])
            self._size = tail.stop
            self._sizes.append(self._size)
        return self._size - before

    def _append(self, X: Array, near: int) -> Array:
        """Make the basis hold the columns of X, which change; gives their coordinates.

        Args:
            X: The columns, shape (n_local, k), Fortran order.
            near: The first vector in which they have parts, but for rounding.

        Returns:
            Shape (number of vectors, then, k).
        """
        MX = product(self.M, X)
        length = np.sqrt(np.diag(inner(self.M, X, MX)))
        if not np.all(np.isfinite(length)):
            raise SolutionError("a load pattern has values that are not numbers")
        coordinates = np.zeros((self._count, X.shape[1]))
        B: Array = np.eye(X.shape[1])
        # Twice is enough, and needed: what is left of a nearly dependent vector is mostly rounding.
        # Once more, where the second time takes away what is more than rounding.
        first, least = near, DEPENDENT * length
        passes, most = 0, 1.0
        while passes < 2 or most > SMALL:
            known = self._subtract(first, X, MX)
            coordinates[first:] += known @ B
            X, MX, inside = _orthonormal(self.M, X, product(self.M, X), least)
            B = inside @ B
            first, least = 0, np.zeros(X.shape[1])
            most = float(np.abs(known).max(initial=0.0)) if passes else 1.0
            passes += 1
        self._MQ = MX
        self._store(X)
        return np.vstack([coordinates, B])

    def _subtract(self, first: int, X: Array, MX: Array) -> Array:
        """Take V (Vᵀ M X) of the vectors V from the first on off X; gives Vᵀ M X."""
        pieces = self._pieces(first, self._count)
        local = np.concatenate([np.empty((0, MX.shape[1])), *(V.T @ MX for V in pieces)])
        known: Array = self.M.getComm().tompi4py().allreduce(local)
        ends = np.cumsum([V.shape[1] for V in pieces])[:-1]
        for V, part in zip(pieces, np.split(known, ends), strict=False):
            if X.size and part.size:
                # In place: a product of its own would be as large as X, and be added slowly.
                dgemm(-1.0, V, part, beta=1.0, c=X, overwrite_c=True)
        return known

    def _store(self, X: Array) -> None:
        for x in X.T:
            at = self._count % CHUNK
            if at == 0:
                self._chunks.append(np.empty((X.shape[0], CHUNK), order="F"))
            self._chunks[-1][:, at] = x
            self._count += 1

    def _pieces(self, first: int, last: int) -> list[Array]:
        """The vectors of a range, as they are stored."""
        bounds = [
            (chunk, max(first - start, 0), min(last - start, CHUNK))
            for start, chunk in zip(range(0, last, CHUNK), self._chunks, strict=False)
        ]
        return [chunk[:, begin:end] for chunk, begin, end in bounds if begin < end]

    def _columns(self, first: int, last: int) -> Array:
        pieces = self._pieces(first, last)
        if len(pieces) == 1:
            return pieces[0]
        return np.hstack([np.empty((self.M.getLocalSize()[0], 0), order="F"), *pieces])


def _orthonormal(M: PETSc.Mat, X: Array, MX: Array, least: Array) -> tuple[Array, Array, Array]:
    """M-orthonormal columns Q, M Q and B, with X = Q B but for what is left out; X is overwritten.

    Column by column: a Gram matrix of the block would lose half of the digits.

    Args:
        M: Mass.
        X: Columns, shape (n_local, k).
        MX: M X; overwritten.
        least: Length up to which what is left of each column is left out, shape (k,).
    """
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
    return X[:, :n], MX[:, :n], B[:n]


def _padded(A: Array, rows: int, columns: int) -> Array:
    padded = np.pad(A, ((0, rows - A.shape[0]), (0, columns - A.shape[1])))
    return np.asarray(padded, dtype=np.float64)
