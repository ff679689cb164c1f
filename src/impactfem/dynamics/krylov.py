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
        self._count = 0
        # Columns of the chunks: those of V in their order, then those of Q, of which some are left
        # where they are, and some lead on.
        self._inside: list[int] = []
        self._left: list[int] = []
        self._ahead: list[int] = []
        # The vectors that came last, and M times them.
        self._newest = 0
        self._images: Array = np.zeros((M.getLocalSize()[0], 0), order="F")
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
        return len(self._inside)

    @property
    def sizes(self) -> tuple[int, ...]:
        """The size after each block step: those of the spaces nested in this one."""
        return tuple(self._sizes)

    @property
    def V(self) -> Array:
        """The basis at this rank's rows, shape (n_local, size)."""
        return self._columns(self._inside)

    def rows(self, index: Index) -> Array:
        """The basis at some of this rank's rows, without a copy of the others.

        Args:
            index: The rows, counted from the first of this rank, of any shape.

        Returns:
            The shape of `index` with the size of the basis as a further axis.
        """
        found: Array = np.empty((*np.shape(index), self.size))
        for at, column in enumerate(self._inside):
            found[..., at] = self._column(column)[index]
        return found

    @property
    def T(self) -> Array:
        """Vᵀ M A V, shape (size, size) [s2]."""
        return self._T[np.ix_(self._inside, self._inside)]

    @property
    def R(self) -> Array:
        """Coordinates of (K + σ0 M)⁻¹ F of each load pattern, shape (size, n_patterns)."""
        return self._R[self._inside]

    @property
    def Q(self) -> Array:
        """The tail: what A V has outside the space, shape (n_local, n_tail)."""
        return self._columns(self._outside)

    @property
    def S(self) -> Array:
        """Qᵀ M A V, shape (n_tail, size) [s2]."""
        return self._T[np.ix_(self._outside, self._inside)]

    def shifted_tail(self) -> Array:
        """(K + σ0 M) Q, shape (n_local, n_tail). Collective."""
        Q = self.Q
        Z = product(self.M, Q)
        Z *= self.shift
        Z += product(self.K, Q)
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

    def add(self, F: Array, *, follow: bool = True) -> None:
        """Add load patterns; the space of those before stays. Collective.

        Patterns that are zero, or that depend on others, bring in no vector.

        Args:
            F: Load patterns at this rank's rows, shape (n_local, m).
            follow: Whether `grow` takes these patterns further. If not, the space holds their
                response at the shift, and what of A V comes from them stays outside.

        Raises:
            SolutionError: A pattern has values that are not numbers.
        """
        before = self._R.shape[1]
        older = self._count
        coordinates, _ = self._append(self._factor.solve_block(F))
        self._R = _padded(self._R, self._count, before + F.shape[1])
        self._R[:, before:] = coordinates
        fresh = range(older, self._count)
        # All of them, as the responses have parts in every vector there is.
        leading = [*self._ahead, *(fresh if follow else ())]
        resting = [*self._left, *(() if follow else fresh)]
        self._expand(leading, resting)

    def grow(self, steps: int) -> int:
        """Take the space some block steps further. Collective.

        Returns:
            Number of vectors that came into the space; fewer, or none, when it holds all that the
            loads can reach.
        """
        before = self.size
        for _ in range(steps):
            if not self._ahead:
                break
            self._expand(self._ahead, [])
        return self.size - before

    @property
    def _outside(self) -> list[int]:
        return [*self._left, *self._ahead]

    def _expand(self, leading: list[int], resting: list[int]) -> None:
        """Take vectors of the tail into the space; what `resting` ones lead to is left."""
        block = [*leading, *resting]
        if not block:
            return
        first = self._sizes[-2] if len(self._sizes) > 1 else 0
        # A is self-adjoint: A times these vectors has no part in those long before them.
        near = [*self._inside[first:], *self._outside]
        older = self._count
        X = self._factor.solve_block(self._image(block))
        coordinates, source = self._append(X, near)
        self._T = _padded(self._T, self._count, self._count)
        self._T[:, block] = coordinates
        self._T[block, :] = coordinates.T
        self._R = _padded(self._R, self._count, self._R.shape[1])
        self._inside += block
        self._sizes.append(len(self._inside))
        self._left = [i for i in self._left if i not in block]
        self._ahead = []
        for column, number in enumerate(source, older):
            (self._ahead if number < len(leading) else self._left).append(column)

    def _image(self, block: list[int]) -> Array:
        """M times some of the vectors, shape (n_local, len(block)); collective unless all new."""
        if min(block) >= self._newest:
            return self._images[:, [i - self._newest for i in block]]
        return product(self.M, self._columns(block))

    def _append(self, X: Array, near: list[int] | None = None) -> tuple[Array, list[int]]:
        """Make the basis hold the columns of X, which change.

        Args:
            X: The columns, shape (n_local, k), Fortran order.
            near: The vectors in which they have parts but for rounding; None for all.

        Returns:
            Their coordinates, shape (number of vectors, then, k); and from which of them each new
            vector comes.
        """
        MX = product(self.M, X)
        length = np.sqrt(np.diag(inner(self.M, X, MX)))
        if not np.all(np.isfinite(length)):
            raise SolutionError("a load pattern has values that are not numbers")
        coordinates = np.zeros((self._count, X.shape[1]))
        B: Array = np.eye(X.shape[1])
        source = list(range(X.shape[1]))
        every = [*range(self._count)]
        columns, least = every if near is None else sorted(near), DEPENDENT * length
        # Twice is enough, and needed: what is left of a nearly dependent vector is mostly rounding.
        # Once more, where the second time takes away what is more than rounding.
        passes, most = 0, 1.0
        while passes < 2 or most > SMALL:
            known = self._subtract(columns, X, MX)
            coordinates[columns] += known @ B
            X, MX, inside, kept = _orthonormal(self.M, X, product(self.M, X), least)
            B = inside @ B
            source = [source[i] for i in kept]
            columns, least = every, np.zeros(X.shape[1])
            most = float(np.abs(known).max(initial=0.0)) if passes else 1.0
            passes += 1
        self._newest, self._images = self._count, MX
        self._store(X)
        return np.vstack([coordinates, B]), source

    def _subtract(self, columns: list[int], X: Array, MX: Array) -> Array:
        """Take V (Vᵀ M X) of some columns V from X; gives Vᵀ M X, shape (len(columns), k)."""
        pieces = self._pieces(columns)
        local = np.concatenate([np.empty((0, MX.shape[1])), *(V.T @ MX for V in pieces)])
        known: Array = self.M.getComm().tompi4py().allreduce(local)
        at = 0
        for V in pieces:
            part = known[at : at + V.shape[1]]
            at += V.shape[1]
            if X.size:
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

    def _column(self, number: int) -> Array:
        return self._chunks[number // CHUNK][:, number % CHUNK]

    def _pieces(self, columns: list[int]) -> list[Array]:
        """Some vectors, ascending, as they are stored: consecutive ones without a copy."""
        pieces = []
        for begin, end in _runs(columns):
            while begin < end:
                stop = min(end, (begin // CHUNK + 1) * CHUNK)
                at = begin % CHUNK
                pieces.append(self._chunks[begin // CHUNK][:, at : at + stop - begin])
                begin = stop
        return pieces

    def _columns(self, columns: list[int]) -> Array:
        """Some vectors, in the order that is asked, shape (n_local, len(columns)): a copy."""
        found: Array = np.empty((self.M.getLocalSize()[0], len(columns)), order="F")
        for at, column in enumerate(columns):
            found[:, at] = self._column(column)
        return found


def _runs(numbers: list[int]) -> list[tuple[int, int]]:
    """Ranges that make up ascending numbers."""
    runs: list[tuple[int, int]] = []
    for number in numbers:
        if runs and runs[-1][1] == number:
            runs[-1] = (runs[-1][0], number + 1)
        else:
            runs.append((number, number + 1))
    return runs


def _orthonormal(
    M: PETSc.Mat, X: Array, MX: Array, least: Array
) -> tuple[Array, Array, Array, list[int]]:
    """M-orthonormal columns Q, M Q and B, with X = Q B but for what is left out; X is overwritten.

    Column by column: a Gram matrix of the block would lose half of the digits.

    Args:
        M: Mass.
        X: Columns, shape (n_local, k).
        MX: M X; overwritten.
        least: Length up to which what is left of each column is left out, shape (k,).

    Returns:
        Q, M Q, B, and which columns of X brought in those of Q.
    """
    B = np.zeros((X.shape[1], X.shape[1]))
    kept: list[int] = []
    for j in range(X.shape[1]):
        x, Mx = X[:, j], MX[:, j]
        n = len(kept)
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
            kept.append(j)
    n = len(kept)
    return X[:, :n], MX[:, :n], B[:n], kept


def _padded(A: Array, rows: int, columns: int) -> Array:
    padded = np.pad(A, ((0, rows - A.shape[0]), (0, columns - A.shape[1])))
    return np.asarray(padded, dtype=np.float64)
