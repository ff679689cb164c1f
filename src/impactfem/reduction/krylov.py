"""A block Krylov basis of stiffness, mass and load patterns, which does not depend on damping.

With C = α M + β K the response to the load F at the angular frequency ω solves

    (K + σ M) x = F / (1 + iωβ),   σ = iω (iω + α) / (1 + iωβ).

With one real shift σ0 > 0 and A = (K + σ0 M)⁻¹ M this is (I + (σ − σ0) A) x = x0 / (1 + iωβ),
x0 = (K + σ0 M)⁻¹ F. The columns of x0, A x0, A² x0, ... span one space for all ω, α and β. Its
basis V, with Vᵀ M V = I, fulfils A V = V T + Q S, where the few columns of Q are M-orthogonal to V.

Beattie and Gugercin, Krylov-based model reduction of second-order systems with proportional
damping, CDC 2005; reorthogonalised as in Simon, Mathematics of Computation 42 (1984) 115.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from petsc4py import PETSc

from impactfem.dynamics.columns import combined, inner, product
from impactfem.dynamics.factorisation import Factorisation, Held
from impactfem.reduction.orthonormal import Orthonormal
from impactfem.system.arrays import Array, Index
from impactfem.system.parallel import meanwhile

AT_ONCE = 64
"""Columns that are solved for and used at once: all vectors are read once for so many of them."""

ROUNDING = 1e-10
"""Part of a unit vector in those before it up to which it is what rounding left there."""

LOSS = 1e-12
"""Largest entry of Vᵀ M Q, as estimated, up to which Q is not made orthogonal again."""

EPS = float(np.finfo(np.float64).eps)


class KrylovBasis(Held):
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
        # First the vectors of V, then those of Q; M times the latter, and A times.
        self.vectors = Orthonormal(M)
        self._size = 0
        self._MQ: Array = np.zeros((M.getLocalSize()[0], 0), order="F")
        self._AQ = self._MQ
        self._T: Array = np.zeros((0, 0))
        self._R: Array = np.zeros((0, 0))
        self._sizes: list[int] = []
        self._loss = 0.0  # largest entry of Vᵀ M Q, as estimated
        self.clean = 0  # how many of the last blocks in a row were made orthogonal again

    def destroy(self) -> None:
        """Free the factorisation; the basis stays and cannot grow any more. Collective."""
        self._factor.destroy()

    def solve(self, F: Any) -> Array:
        """(K + σ0 M)⁻¹ F, (n_local, k), Fortran order; F may be of `scipy.sparse`. Collective."""
        return self._factor.solve_block(F)

    def solutions(self, F: Any) -> Iterator[tuple[slice, Array]]:
        """(K + σ0 M)⁻¹ F in parts of a few columns, with their slices. Collective, each part.

        All at once would take as much memory as many vectors. F may be of `scipy.sparse`.
        """
        for first in range(0, F.shape[1], AT_ONCE):
            part = slice(first, first + AT_ONCE)
            yield part, self.solve(F[:, part])

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
        return self.vectors.columns(0, self._size)

    def seen(self, L: Any) -> Array:
        """Lᵀ V, shape (k, size), the same on all ranks; L may be of `scipy.sparse`. Collective."""
        return self.vectors.seen(L, self._size)

    def rows(self, index: Index, first: int = 0) -> Array:
        """V from the first vector on, at some of this rank's rows, as of `Orthonormal.rows`."""
        return self.vectors.rows(index, first, self._size)

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
        return self.vectors.columns(self._size, len(self._T))

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
        """√(fᵀ (K + σ0 M)⁻¹ f) of each column f, loads or probe rows, shape (k,). Collective."""
        squares = np.empty(F.shape[1])
        for part, X in self.solutions(F):
            squares[part] = np.diag(inner(self.M, F[:, part], X))
        return np.asarray(np.sqrt(np.maximum(squares, 0.0)), dtype=np.float64)

    def add(self, F: Any) -> None:
        """Add load patterns, shape (n_local, m), an array or of `scipy.sparse`. Collective.

        The space of those before stays. Patterns that are zero, or that depend on others, bring in
        no vector; those with values that are not numbers are refused.
        """
        before = self._R.shape[1]
        coordinates, image = self.vectors.append(self.solve(F))
        self._R = _padded(self._R, self.vectors.count, before + F.shape[1])
        self._R[:, before:] = coordinates
        self._MQ = np.hstack([self._MQ, image])
        self._AQ = np.asfortranarray(np.hstack([self._AQ, self.solve(image)]))
        self.grow(1)

    def grow(self, steps: int) -> int:
        """Take the space some block steps further; the number of vectors that came in. Collective.

        Fewer come in, or none, when it holds all that the loads can reach.
        """
        before = self._size
        for _ in range(steps):
            tail = slice(self._size, self.vectors.count)
            if tail.start == tail.stop:
                break
            # A is self-adjoint: A Q has no part in the vectors before the last block step.
            near = self._sizes[-2] if len(self._sizes) > 1 else 0
            coordinates, self._MQ = self.vectors.append(self._AQ, near, attempts=1)
            self._size = tail.stop
            self._sizes.append(self._size)
            self._know(tail, coordinates)
            self._settle(tail)
            self._R = _padded(self._R, self.vectors.count, self._R.shape[1])
        return self._size - before

    def _know(self, last: slice, coordinates: Array) -> None:
        """Enter the coordinates of A V of some of the last vectors, shape (count, k)."""
        n = self._size
        self._T = _padded(self._T[:n, :n], self.vectors.count, self.vectors.count)
        self._T[:, last] = coordinates
        self._T[last, :] = coordinates.T

    def _settle(self, last: slice) -> None:
        """Apply A to the new tail Q, and take off rounding where it has grown. Collective."""
        # A step multiplies the rounding in Vᵀ M Q by ‖T‖ at most, as A is applied, and divides it
        # by the least singular value of S, as the new columns are scaled to unit length. The next
        # block follows from the last two: when both are orthogonal again, the growth starts anew.
        new = np.linalg.svd(self.S[:, last], compute_uv=False).min(initial=np.inf)
        self._loss = (self._loss + EPS) * float(np.linalg.norm(self.T, np.inf))
        if self.clean != 1 and self._loss < LOSS * new:
            self._loss /= new
            self._AQ, self.clean = self.solve(self._MQ), 0
            return
        self._loss, self.clean = 0.0, self.clean + 1
        # Q = Q' + V c, with the small c = Vᵀ M Q. What was taken off Q counts in A V = V T + Q S,
        # and as A V c = V T c + Q S c is to be taken off A Q; left there, it would grow step by
        # step. The images of the last vectors under A brought in the tail.
        n, vectors = self._size, self.vectors
        with meanwhile(lambda: self.solve(self._MQ)) as solved:
            c = vectors.seen(self._MQ, n).T
            known = self.T @ c
            inside = vectors.combination(np.hstack([c, known]))
            vectors.replace(n, self.Q - inside[:, : c.shape[1]])
        coordinates = self._T[:, last].copy()
        coordinates[:n] += c @ coordinates[n:]
        if np.abs(c).max(initial=0.0) > ROUNDING:
            # Q was nearly dependent on the vectors before it: some of it may be rounding alone.
            outside, self._MQ = vectors.append(vectors.drop(n))
            coordinates[:n] += outside[:n] @ coordinates[n:]
            coordinates = np.vstack([coordinates[:n], outside[n:] @ coordinates[n:]])
            self._AQ = self.solve(self._MQ)
        else:
            self._AQ = solved()
            self._AQ -= inside[:, c.shape[1] :]
            self._AQ -= self.Q @ (self.S @ c)
        self._know(last, coordinates)


def _padded(A: Array, rows: int, columns: int) -> Array:
    padded = np.pad(A, ((0, rows - A.shape[0]), (0, columns - A.shape[1])))
    return np.asarray(padded, dtype=np.float64)
