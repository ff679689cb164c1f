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

from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from impactfem.dynamics.columns import inner, product
from impactfem.dynamics.factorisation import Factorisation

Array = NDArray[np.float64]
Index = NDArray[np.int64]

DEPENDENT = 1e-9
"""Part of a vector outside the basis, over its length, below which it counts as dependent."""


class KrylovBasis:
    """The basis, built block by block. Making one, `add` and `grow` are collective.

    Args:
        K: Stiffness matrix, positive definite (PETSc AIJ).
        M: Mass matrix, positive definite, on part of the pattern of K.
        shift: σ0 [1/s2].
        capacity: Vectors that memory is set aside for at first.

    Raises:
        SolutionError: The matrices are not positive definite.
    """

    def __init__(self, K: Any, M: Any, shift: float, capacity: int = 64) -> None:
        self.shift = shift
        self._M = M
        self._shifted = K.copy()
        subset = PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN
        self._shifted.axpy(shift, M, structure=subset)
        self._factor = Factorisation(self._shifted, name="the shifted stiffness matrix")
        self._vectors = np.empty((M.getLocalSize()[0], capacity), order="F")
        self._T = np.zeros((capacity, capacity))
        self._R = np.zeros((capacity, 0))
        self._closed = np.zeros(capacity, dtype=bool)
        self._size = 0

    def destroy(self) -> None:
        """Free the factorisation; the basis stays and cannot grow any more. Collective."""
        self._factor.destroy()

    @property
    def size(self) -> int:
        """Number of vectors of the reduced space."""
        return int(self._closed.sum())

    @property
    def V(self) -> Array:
        """The basis at this rank's rows, shape (n_local, size)."""
        if self._closed[: self.size].all():
            return self._vectors[:, : self.size]
        return self._vectors[:, : self._size][:, self._closed[: self._size]]

    @property
    def T(self) -> Array:
        """Vᵀ M A V, shape (size, size) [s2]."""
        T: Array = self._T[np.ix_(self._closed, self._closed)]
        return T

    @property
    def R(self) -> Array:
        """Coordinates of (K + σ0 M)⁻¹ F of each load pattern, shape (size, n_patterns)."""
        R: Array = self._R[self._closed]
        return R

    @property
    def Q(self) -> Array:
        """The tail: what A V has outside the space, shape (n_local, n_tail)."""
        Q: Array = self._vectors[:, np.flatnonzero(self._open())]
        return Q

    @property
    def S(self) -> Array:
        """Qᵀ M A V, shape (n_tail, size) [s2]."""
        S: Array = self._T[np.ix_(self._open(), self._closed)]
        return S

    def shifted_tail(self) -> Array:
        """(K + σ0 M) Q, shape (n_local, n_tail). Collective."""
        return product(self._shifted, np.asfortranarray(self.Q))

    def add(self, F: Array) -> None:
        """Add load patterns; the space of those before stays. Collective.

        Args:
            F: Load patterns at this rank's rows, shape (n_local, m).
        """
        coordinates = self._append(self._factor.solve_block(F))
        R = np.zeros((len(self._R), self._R.shape[1] + F.shape[1]))
        R[:, : self._R.shape[1]] = self._R
        R[: self._size, self._R.shape[1] :] = coordinates
        self._R = R
        self.grow(1)

    def grow(self, steps: int) -> int:
        """Take the space some block steps further. Collective.

        Returns:
            Number of vectors that came into the space; fewer, or none, when it holds all that the
            loads can reach.
        """
        before = self.size
        for _ in range(steps):
            front = np.flatnonzero(self._open())
            if front.size == 0:
                break
            block = np.asfortranarray(self._vectors[:, front])
            coordinates = self._append(self._factor.solve_block(product(self._M, block)))
            self._T[: self._size, front] = coordinates
            self._T[front, : self._size] = coordinates.T
            self._closed[front] = True
        return self.size - before

    def _open(self) -> NDArray[np.bool_]:
        """The vectors whose image under A is not known yet."""
        there = np.arange(len(self._closed)) < self._size
        opened: NDArray[np.bool_] = there & ~self._closed
        return opened

    def _append(self, X: Array) -> Array:
        """Make the basis hold the columns of X; gives their coordinates, shape (size, k)."""
        M = self._M
        length = np.sqrt(np.diag(inner(M, X, product(M, X))))
        k = X.shape[1]
        coordinates = np.zeros((self._size, k))
        factor = np.eye(k)
        for turn in range(2):
            old = self._vectors[:, : self._size]
            known = inner(M, old, product(M, X))
            X -= old @ known
            coordinates += known @ factor
            # Within the block: X = X' B by its Gram matrix, with dependent directions left out.
            gram = inner(M, X, product(M, X))
            left = np.sqrt(np.maximum(np.diag(gram), 0.0))
            scale = np.where(left > 0.0, 1.0 / np.where(left > 0.0, left, 1.0), 0.0)
            values, vectors = np.linalg.eigh(gram * np.outer(scale, scale))
            if turn == 0:
                keep = (values > DEPENDENT) & self._reaches(left, length, vectors)
            else:
                keep = values > 0.5  # nearly orthonormal already
            B = np.sqrt(values[keep])[:, None] * vectors[:, keep].T * left
            X = np.asfortranarray(X @ (scale[:, None] * vectors[:, keep] / np.sqrt(values[keep])))
            factor = B @ factor
        return self._store(X, coordinates, factor)

    @staticmethod
    def _reaches(left: Array, length: Array, vectors: Array) -> NDArray[np.bool_]:
        """Directions of the block that stand out of the space by more than rounding."""
        share = np.where(length > 0.0, left / np.where(length > 0.0, length, 1.0), 0.0)
        outside: NDArray[np.bool_] = (vectors**2).T @ share**2 > DEPENDENT**2
        return outside

    def _store(self, X: Array, coordinates: Array, factor: Array) -> Array:
        new = X.shape[1]
        need = self._size + new
        if need > len(self._closed):
            self._enlarge(max(need, len(self._closed) * 3 // 2))
        self._vectors[:, self._size : need] = X
        self._size = need
        return np.vstack([coordinates, factor])

    def _enlarge(self, capacity: int) -> None:
        have = self._size
        vectors = np.empty((len(self._vectors), capacity), order="F")
        vectors[:, :have] = self._vectors[:, :have]
        self._vectors = vectors
        T = np.zeros((capacity, capacity))
        T[:have, :have] = self._T[:have, :have]
        self._T = T
        R = np.zeros((capacity, self._R.shape[1]))
        R[:have] = self._R[:have]
        self._R = R
        closed = np.zeros(capacity, dtype=bool)
        closed[:have] = self._closed[:have]
        self._closed = closed
