"""A reduced model of a structure whose points come to rest on rigid walls, and leave them.

Three kinds of vectors make up its space, all with the one factor of K + σ0 M, A = (K + σ0 M)⁻¹ M:

- those of the free structure under its loads, a Krylov basis;
- H = (K + σ0 M)⁻¹ G, the response to each contact force at the shift: with them the points of
  contact can take any place;
- those of the structure that is held, Gᵀ x = 0: the chain x, P A x, (P A)² x, ... from the low
  modes of the free one, which is what moves when the points stop. P x = x − H (Gᵀ H)⁻¹ Gᵀ x.

So the space holds the response with all, none or some of the points at rest, as component modes of
a free and a fixed interface do (Craig and Bampton, AIAA Journal 6 (1968) 1313); the model is
Galerkin's on it. Krylov vectors of all contact forces would do, too, but takes many times as many.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from impactfem.dynamics.columns import product
from impactfem.dynamics.krylov import KrylovBasis
from impactfem.dynamics.orthonormal import Orthonormal
from impactfem.dynamics.reduced import reduced_model

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ContactBasis:
    """Modes of the reduced model, φᵀ M φ = 1.

    Args:
        eigenvalue: λ, ascending, shape (r,) [1/s2].
        coordinates: Of the modes in the vectors, shape (number of vectors, r).
        vectors: The vectors.
    """

    eigenvalue: Array
    coordinates: Array
    vectors: Orthonormal

    def rows(self, L: Any) -> Array:
        """Φᵀ L, shape (r, k), the same on all ranks. Collective.

        Args:
            L: Loads, constraints or probes at this rank's rows, shape (n_local, k), an array or of
                `scipy.sparse`.
        """
        seen = self.vectors.seen(L, self.vectors.count) @ self.coordinates
        return np.ascontiguousarray(seen.T)


def contact_basis(free: KrylovBasis, G: Any, *, starts: int = 6, steps: int = 8) -> ContactBasis:
    """Complete the basis of a free structure for its contacts. Collective.

    Args:
        free: The basis of the free structure under its loads; it must not grow afterwards, as its
            vectors become those of the result.
        G: Constraints at this rank's rows, shape (n_local, m), an array or of `scipy.sparse`.
        starts: Number of low modes of the free structure that the held one starts from.
        steps: Length of its chain.
    """
    M, vectors = free.M, free.vectors
    comm = M.getComm().tompi4py()
    low = reduced_model(free).coordinates[:, :starts]
    H = free.solve(G)
    pressed = scipy.linalg.cho_factor(comm.allreduce(np.asarray(G.T @ H)))
    X = sum(
        (V @ part for V, part in zip(*_split(vectors, low), strict=True)),
        np.zeros((len(H), starts)),
    )
    X = free.solve(product(M, X))
    held = Orthonormal(M)
    for _ in range(steps):
        X -= H @ scipy.linalg.cho_solve(pressed, comm.allreduce(np.asarray(G.T @ X)))
        _, MX = held.append(X)
        if MX.shape[1] == 0:
            break
        X = free.solve(MX)
    vectors.append(H)
    vectors.append(np.array(held.columns(0, held.count), order="F"))
    n = vectors.count
    stiffness = np.zeros((n, n))
    first = 0
    for V in vectors.pieces(0, n):
        part = slice(first, first + V.shape[1])
        stiffness[part] = vectors.seen(product(free.K, V), n)
        first = part.stop
    eigenvalue, coordinates = np.linalg.eigh(0.5 * (stiffness + stiffness.T))
    return ContactBasis(eigenvalue, coordinates, vectors)


def _split(vectors: Orthonormal, coordinates: Array) -> tuple[list[Array], list[Array]]:
    """The first vectors as they are stored, and the coordinates that belong to each piece."""
    pieces = vectors.pieces(0, len(coordinates))
    ends = np.cumsum([V.shape[1] for V in pieces])[:-1]
    return pieces, np.split(coordinates, ends)
