"""Galerkin's reduced model on vectors of any kind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.dynamics.columns import product
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.orthonormal import Orthonormal

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GalerkinModes:
    """Modes of Vᵀ K V with Vᵀ M V = I: φᵀ M φ = 1, φᵀ K φ = λ."""

    eigenvalue: Array  #: λ, ascending, shape (r,) [1/s2].
    coordinates: Array  #: Of the modes in the vectors, shape (number of vectors, r).
    vectors: Orthonormal  #: The vectors V.

    def rows(self, L: Any) -> Array:
        """Φᵀ L, shape (r, k), the same on all ranks. Collective.

        Args:
            L: Loads, constraints or probes at this rank's rows, shape (n_local, k), an array or of
                `scipy.sparse`.
        """
        seen = self.vectors.seen(L, self.vectors.count) @ self.coordinates
        return np.ascontiguousarray(seen.T)


def galerkin_modes(basis: KrylovBasis) -> GalerkinModes:
    """The modes on all vectors of a basis, those included that were appended to it. Collective."""
    vectors = basis.vectors
    n = vectors.count
    stiffness = np.zeros((n, n))
    first = 0
    for V in vectors.pieces(0, n):
        part = slice(first, first + V.shape[1])
        stiffness[part, : part.stop] = vectors.seen(product(basis.K, V), part.stop)
        first = part.stop
    eigenvalue, coordinates = np.linalg.eigh(stiffness, UPLO="L")
    return GalerkinModes(eigenvalue, coordinates, vectors)
