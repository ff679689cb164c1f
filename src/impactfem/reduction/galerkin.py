"""Galerkin's model on a Krylov basis that is completed for contacts and for local loads.

A structure whose points come to rest on rigid walls, and leave them, needs these kinds of vectors.
All come from the one factor of K + σ0 M, A = (K + σ0 M)⁻¹ M:

- those of the free structure under its loads, the Krylov basis;
- H = (K + σ0 M)⁻¹ G (1), the response to each contact force at the shift: with them the points of
  contact can take any place;
- the motion towards it: at a rigid wall that of the structure that is held, Gᵀ x = 0, by the chain
  x, P A x, (P A)² x, ... (2) from the low modes of the free one (`append_contacts`), with
  P x = x − H (Gᵀ H)⁻¹ Gᵀ x (3); where buildings pound in 3D by the response to each contact force
  at higher shifts, (K + σ M)⁻¹ G (4) (`append_forces`), and by a separate chain for loads that many
  points share (`append_chain`).

At a wall the space holds the response with all, none or some of the points at rest, as component
modes of a free and a fixed interface do (Craig and Bampton, AIAA Journal 6 (1968) 1313). A response
at the shift σ reaches about a wave's length at √σ: those at several shifts are a rational Krylov
space of each force (Ruhe, Linear Algebra and its Applications 58 (1984) 391), which holds what is
near it up to high frequencies with few vectors. The model is Galerkin's. Krylov vectors of all
contact forces would do, too, but take many times as many.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse

from impactfem.dynamics.columns import combined, product, summed
from impactfem.dynamics.factorisation import Factorisation
from impactfem.reduction.krylov import AT_ONCE, KrylovBasis
from impactfem.reduction.orthonormal import Orthonormal
from impactfem.reduction.reduced import reduced_model
from impactfem.system.arrays import Array
from impactfem.system.parallel import all_blas_threads

DEPENDENT = 1e-8
"""Square of the part of a constraint that others do not have, up to which it combines these."""
NEAR = 1e-4
"""Part of a vector outside the others up to which it does not count, where it is one of many that
may be next to each other. What is smaller has its direction by rounding: of two small frames that
pound, forces differ by 1e-8 for one unit of rounding in K with 1e-9, and by 1e-11 with 1e-4."""
LOCAL = 1.5e-3
"""Like NEAR, for responses to forces along the lines where buildings pound in 3D. With 7e-4 spectra
of floors and edges are as far from those in full order, with 3e-3 those of floors 5 % farther
(`pounding_reduced_against_full`). Forces of `row_of_three_3d` with B in 3D differ on 1 to 3 ranks
by up to 5e-9 with 7e-4, too."""


def append_contacts(free: KrylovBasis, G: Any, *, starts: int = 6, steps: int = 8) -> None:
    """Complete the basis of a free structure for rigid walls. Collective.

    G are the constraints at this rank's rows, shape (n_local, m), an array or of `scipy.sparse`.
    The chain of the held structure has so many steps and starts from as many low modes of the free
    one. The basis must not grow afterwards.
    """
    M, vectors = free.M, free.vectors
    low = reduced_model(free).coordinates[:, :starts]
    # A x of the low modes, the start of the chain (2).
    X = free.solve(product(M, vectors.combination(low)))
    # H is kept as its coordinates in the basis, where it is now: as vectors it may be too much.
    # (1) and the flexibility Gᵀ H, block by block.
    coordinates, flexibility = [], [np.empty((G.shape[1], 0))]
    for _, H in free.solutions(G):
        flexibility.append(np.asarray(G.T @ H))
        coordinates.append(vectors.append(H)[0])
        del H  # not to be held while the next ones are solved for
    known = np.hstack(
        [np.zeros((vectors.count, 0))]
        + [np.pad(one, ((0, vectors.count - len(one)), (0, 0))) for one in coordinates]
    )
    pressed = scipy.linalg.cho_factor(summed(M, np.hstack(flexibility)))
    held = Orthonormal(M)
    for _ in range(steps):
        # (3): the contact forces (Gᵀ H)⁻¹ Gᵀ x hold the points.
        forces = scipy.linalg.cho_solve(pressed, summed(M, np.asarray(G.T @ X)))
        X -= vectors.combination(known @ forces)
        _, MX = held.append(X)
        if MX.shape[1] == 0:
            break
        # (2): A times what is new.
        X = free.solve(MX)
    # Among themselves they are made orthogonal column by column, so not too many at once.
    for first in range(0, held.count, AT_ONCE):
        last = min(first + AT_ONCE, held.count)
        vectors.append(np.array(held.columns(first, last), order="F"), dependent=NEAR)


def append_forces(free: KrylovBasis, G: Any, shift: float) -> None:
    """Append the responses (K + σ M)⁻¹ G to forces at a shift σ [1/s2], as they are. Collective.

    G as of `append_contacts`. At another shift than that of the basis its factor is not needed, and
    may be gone: there may not be room for both. Nothing else is to be appended afterwards.
    """
    if shift == free.shift:
        for _, X in free.solutions(G):
            free.vectors.append_kept(X, LOCAL)
        return
    # (4), with a factor of K + σ M.
    shifted = combined(1.0, free.K, shift, free.M)
    with Factorisation(shifted, name="the stiffness matrix at a further shift") as factor:
        shifted.destroy()
        for first in range(0, G.shape[1], AT_ONCE):
            free.vectors.append_kept(factor.solve_block(G[:, first : first + AT_ONCE]), LOCAL)


def independent(contacts: Sequence[Any], comm: Any) -> Any:
    """Constraints of several contacts without those that combine others. Collective.

    Those of one contact alone, of `scipy.sparse` at this rank's rows, are as they are.
    """
    if len(contacts) == 1:
        return contacts[0]
    G = scipy.sparse.csc_matrix(scipy.sparse.hstack(contacts))
    gram = np.asarray(comm.allreduce((G.T @ G).toarray()), dtype=np.float64)
    size = 1.0 / np.sqrt(np.diag(gram))
    _, pivots, rank, _ = scipy.linalg.lapack.dpstrf(
        gram * size[:, None] * size, tol=DEPENDENT, lower=True
    )
    return scipy.sparse.csr_matrix(G[:, np.sort(pivots[:rank] - 1)])


def append_responses(free: KrylovBasis, F: Any, *, steps: int = 2) -> None:
    """Append the first vectors of loads that the structure answers to locally. Collective.

    (K + σ0 M)⁻¹ F, A (K + σ0 M)⁻¹ F, ..., so many for each of the loads F at this rank's rows,
    shape (n_local, k), an array or of `scipy.sparse`. The basis must not grow afterwards.
    """
    for step in range(1, steps + 1):
        images = []
        for _, X in free.solutions(F):
            if step < steps:
                images.append(product(free.M, X))
            free.vectors.append(X)
        F = np.hstack(images) if images else F


def append_chain(free: KrylovBasis, F: Any, *, steps: int) -> None:
    """Append vectors of loads that reach far, but that the space is not grown for. Collective.

    W, what (K + σ0 M)⁻¹ F has outside the space, and then, again and again, what A W has outside
    it: so many for each of the loads F at this rank's rows, shape (n_local, k), an array or of
    `scipy.sparse`. After as many steps A ... A (K + σ0 M)⁻¹ F would have nothing outside but
    rounding. The basis must not grow afterwards.
    """
    near = start = 0
    for _ in range(steps):
        # A is self-adjoint: A W has large parts in W and in the W before. They are taken off first.
        last = free.vectors.count
        images = [free.vectors.append(X, near, LOCAL)[1] for _, X in free.solutions(F)]
        F = np.hstack(images) if images else F
        near, start = start, last


@dataclass(frozen=True, eq=False)
class GalerkinModes:
    """Modes of Vᵀ K V with Vᵀ M V = I: φᵀ M φ = 1, φᵀ K φ = λ."""

    eigenvalue: Array  #: λ, ascending, shape (r,) [1/s2].
    coordinates: Array  #: Of the modes in the vectors, shape (number of vectors, r).
    vectors: Orthonormal  #: The vectors V.

    @classmethod
    @all_blas_threads()
    def of(cls, basis: KrylovBasis) -> GalerkinModes:
        """The modes on all vectors of a basis, also those that were appended to it. Collective.

        Of the Krylov space V no product with K is needed. With K̃ = K + σ0 M, W for the tail Q and
        what was appended, all orthogonal to V in the mass, T Y = Y Θ and P = S Y Θ⁻¹,

            K̃ V Y = M V Y Θ⁻¹ − K̃ Q P:  Yᵀ Vᵀ K̃ V Y = Θ⁻¹ + Pᵀ Qᵀ K̃ Q P,  Wᵀ K̃ V Y = −Wᵀ K̃ Q P (5)
        """
        vectors, size, shift = basis.vectors, basis.size, basis.shift
        known, C, E = reduced_model(basis), *vectors.kept(vectors.count)
        r, tail = len(known.eigenvalue), len(known.tail)
        # P of (5), with Θ⁻¹ = λ + σ0.
        P = known.tail * (known.eigenvalue + shift)
        # Wᵀ K̃ W, with X, as they are stored, in the place of (X − V C) E.
        first, end = size, vectors.stored
        pushed = np.zeros((end - size, end - size))
        for W in vectors.pieces(size, end):
            KW, last = product(basis.K, W), first + W.shape[1]
            seen = np.hstack([KW.T @ one for one in vectors.pieces(size, last)])
            pushed[first - size : last - size, : last - size] = summed(basis.M, seen)
            first = last
        pushed = np.tril(pushed) + np.tril(pushed, -1).T
        others = np.eye(len(C) - size)
        pushed += shift * np.block([[others, C[size:]], [C[size:].T, vectors.gram]])
        # (5): the Krylov block, and its coupling to what was appended.
        stiffness = np.zeros((r + len(pushed), r + len(pushed)))
        stiffness[:r, :r] = np.diag(known.eigenvalue + shift) + P.T @ pushed[:tail, :tail] @ P
        stiffness[r:, :r], stiffness[r:, r:] = -pushed[:, :tail] @ P, pushed
        if E.size:
            # Vectors kept as (X - V C) E: take their coordinates C in the others off.
            C = np.vstack([known.coordinates.T @ C[:size], C[size:]])
            n = len(C)
            stiffness[n:, :r] += C[:r].T * (known.eigenvalue + shift)
            stiffness[:r, r:] = stiffness[r:, :r].T
            own = E.T @ (stiffness[n:] - C.T @ stiffness[:n])
            by, own = own[:, :n], (own[:, n:] - own[:, :n] @ C) @ E
            by[:, :r] = -by[:, r : r + tail] @ P  # but for rounding it is that already
            stiffness = np.block([[stiffness[:n, :n], by.T], [by, own]])
        # From K̃ to K: Vᵀ M V = I.
        stiffness[np.diag_indices_from(stiffness)] -= shift
        # The first vectors are smooth and the last ones rough, so that entries grow along the
        # diagonal: reduced from the last row on, as of an upper triangle, the lowest modes keep
        # their digits (1e-12, where from the first row on they had 1e-10).
        eigenvalue, coordinates = np.linalg.eigh(stiffness.T, UPLO="U")
        krylov = known.coordinates @ coordinates[:r]
        return cls(eigenvalue, np.vstack([krylov, coordinates[r:]]), vectors)

    def within(self, columns: Array) -> tuple[Array, Array]:
        """λ and coordinates of Galerkin's model in a part of the space of the vectors.

        Args:
            columns: Coordinates of what spans it, orthonormal, shape (number of vectors, k).
        """
        own = self.coordinates.T @ columns
        eigenvalue, part = np.linalg.eigh(own.T @ (self.eigenvalue[:, None] * own))
        return eigenvalue, columns @ part

    def rows(self, L: Any) -> Array:
        """Φᵀ L, shape (r, k), the same on all ranks. Collective.

        L: loads, constraints or probes at this rank's rows, shape (n_local, k), an array or sparse.
        """
        seen = self.vectors.seen(L, self.vectors.count) @ self.coordinates
        return np.ascontiguousarray(seen.T)
