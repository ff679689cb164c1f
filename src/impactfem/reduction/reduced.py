"""The reduced model in modal form: one for all dampings.

In the space of a Krylov basis (see `krylov`) the response to the load p(t) of a pattern is
x = Φ z with Φ = V Y, where T Y = Y Θ, Yᵀ Y = I, and

    z̈ + d ż + λ z = b p(t),   λ = 1/θ − σ0,   b = Θ⁻¹ Yᵀ R.

with d of any law of damping, α + β λ of Rayleigh's. With the latter, its residual at the angular
frequency ω, for p = exp(iωt), lies in a few directions,

    r = F − (K + iωC − ω²M) x = −(σ − σ0) (1 + iωβ) (K + σ0 M) Q S Y z.
"""

from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc

from impactfem.dynamics.columns import product
from impactfem.dynamics.damping import DampingLaw, Rayleigh
from impactfem.dynamics.modes import Modes, modes, number_below, with_signs
from impactfem.reduction.krylov import KrylovBasis
from impactfem.system.arrays import Array, Complex
from impactfem.system.errors import SolutionError

ABOVE = 1e-4
"""Relative distance in ω² above the last wanted mode at which those up to there are counted."""


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """Modal equations of a Krylov space."""

    #: λ, ascending, shape (r,) [1/s2]. The low ones are those of the structure.
    eigenvalue: Array
    load: Array  #: b, shape (r, n_patterns).
    coordinates: Array  #: Y, shape (size of the basis, r).
    shift: float  #: σ0 [1/s2].
    tail: Array  #: S Y, shape (n_tail, r) [s2].

    def shapes(self, basis: Array) -> Array:
        """Φ, shape (n, r), at rows of V, shape (n, size), of this basis or one it is nested in."""
        return np.asarray(basis[:, : len(self.coordinates)] @ self.coordinates, dtype=np.float64)

    def amplitude(self, omega: Array, damping: DampingLaw) -> Complex:
        """Modal coordinates z for the loads exp(iωt), one pattern at a time, (n, r, n_patterns)."""
        return np.asarray(self._factor(omega, damping)[:, :, None] * self.load)

    def transfer(self, basis: Array, omega: Array, damping: DampingLaw) -> Complex:
        """Displacements at rows of V, as of `shapes`, under the loads exp(iωt), one at a time.

        ω has the shape (n_freq,) [rad/s]; gives shape (n_freq, n, n_patterns) [m per unit of the
        load].
        """
        shapes, factor = self.shapes(basis), self._factor(omega, damping)
        return np.stack([factor @ (shapes * b).T for b in self.load.T], axis=-1)

    def outside(self, omega: Array, damping: DampingLaw) -> Complex:
        """Part of A x outside the space under the loads exp(iωt), w = S Y z, by pattern.

        Shape (n, n_tail, n_patterns); its norm is that of A x there in the mass.
        """
        return np.asarray(self.tail @ self.amplitude(omega, damping))

    def _factor(self, omega: Array, damping: DampingLaw) -> Complex:
        """1 / (λ + iω d − ω²), shape (n_freq, r)."""
        s = 1j * np.asarray(omega)[:, None]
        d = damping.modal(self.eigenvalue)
        return np.asarray(1.0 / (s * s + d * s + self.eigenvalue), dtype=np.complex128)


def reduced_model(basis: KrylovBasis, size: int | None = None) -> ReducedModel:
    """The modal equations of a basis, or of its first vectors: a nested, coarser model.

    The sizes of `basis.sizes` give the models that the basis had on its way.

    Raises:
        SolutionError: There are not so many vectors, or they do not hold all load patterns.
    """
    n = basis.size if size is None else size
    if not 0 <= n <= basis.size:
        raise SolutionError(f"{n} vectors of a reduced basis of {basis.size}")
    T, R = basis.T, basis.R
    if np.any(R[n:]):
        raise SolutionError(f"the first {n} vectors of the reduced basis do not hold all loads")
    # What A V_n has outside V_n: the later vectors of the basis, and the tail.
    outside = np.vstack([T[n:, :n], basis.S[:, :n]])
    theta, Y = np.linalg.eigh(0.5 * (T[:n, :n] + T[:n, :n].T))
    # As M is definite, θ > 0 but for rounding.
    keep = theta > 1e-14 * np.max(theta, initial=0.0)
    theta, Y = theta[keep][::-1], Y[:, keep][:, ::-1]
    return ReducedModel(
        eigenvalue=1.0 / theta - basis.shift,
        load=(Y.T @ R[:n]) / theta[:, None],
        coordinates=np.ascontiguousarray(Y),
        shift=basis.shift,
        tail=outside @ Y,
    )


def modes_near(
    K: PETSc.Mat,
    M: PETSc.Mat,
    start: Array,
    count: int,
    *,
    fields: Array | None = None,
    tolerance: float = 1e-7,
) -> Modes:
    """The lowest modes of a model that is near one with known modes. Collective.

    They are those of the reduced model with the loads M φ of the known ones, which grows until all
    of their residuals are small. Where it does not hold so many, or one is missing by the Sturm
    count, `modes` finds them.

    Args:
        K: Stiffness, symmetric, positive definite (AIJ).
        M: Mass, symmetric, positive definite (AIJ), on part of the pattern of K.
        start: The known modes, shape (n_local, k).
        count: Number of modes wanted.
        fields: Displacements that give the shapes their signs, as of `modes`.
        tolerance: Largest residual of a mode; an eigenvalue's error is of the order of its square.

    Raises:
        SingularMatrixError: The stiffness is singular: the model is a mechanism.
        SolutionError: As `modes`.
    """
    with KrylovBasis(K, M, 0.0) as basis:
        basis.add(product(M, start))
        while True:
            model = reduced_model(basis)
            residual = np.linalg.norm(model.tail, axis=0) * model.eigenvalue
            found = len(residual) >= count and bool(np.all(residual[:count] <= tolerance))
            if found or not basis.grow(1):
                break
        shapes = basis.vectors.combination(model.coordinates[:, :count])
    if found and number_below(K, M, model.eigenvalue[count - 1] * (1.0 + ABOVE)) == count:
        return with_signs(M, model.eigenvalue[:count], shapes, residual[:count], fields)
    return modes(K, M, count, fields=fields)


def shift_of(omega: Array, damping: Rayleigh) -> Complex:
    """σ = iω (iω + α) / (1 + iωβ) of each ω, shape (n,) [1/s2]."""
    s = 1j * np.asarray(omega)
    return np.asarray(s * (s + damping.alpha) / (1.0 + s * damping.beta), dtype=np.complex128)


def residual_norms(gram: Array, model: ReducedModel, omega: Array, damping: Rayleigh) -> Array:
    """‖r‖ = √(rᴴ (K + σ0 M)⁻¹ r) of the model of all of a basis, for the loads exp(iωt).

    One pattern at a time, shape (n, n_patterns); they are |σ − σ0| |1 + iωβ| √(wᴴ G w) with
    w = S Y z and `gram` G = Qᵀ (K + σ0 M) Q, shape (n_tail, n_tail), of the basis as it stands:
    this norm costs no solve. ω has the shape (n,) [rad/s].
    """
    w = model.outside(omega, damping)
    squares = np.sum(w.conj() * (gram @ w), axis=1).real
    away = np.abs(shift_of(omega, damping) - model.shift)
    scale = away * np.abs(1.0 + 1j * damping.beta * np.asarray(omega))
    return np.asarray(scale[:, None] * np.sqrt(np.maximum(squares, 0.0)))
