"""The reduced model in modal form: one for all dampings.

In the space of a Krylov basis (see `krylov`) the response to the load p(t) of a pattern is
x = Φ z with Φ = V Y, where T Y = Y Θ, Yᵀ Y = I, and

    z̈ + (α + β λ) ż + λ z = b p(t),   λ = 1/θ − σ0,   b = Θ⁻¹ Yᵀ R.

Its residual at the angular frequency ω, for p = exp(iωt), lies in a few directions,
r = −(σ − σ0) (1 + iωβ) (K + σ0 M) Q S Y z.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from impactfem.dynamics.columns import inner
from impactfem.dynamics.factorisation import Factorisation
from impactfem.dynamics.krylov import KrylovBasis

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """Modal equations of a Krylov space.

    Args:
        eigenvalue: λ, ascending, shape (r,) [1/s2].
        load: b, shape (r, n_patterns).
        coordinates: Y, shape (size of the basis, r).
        shift: σ0 [1/s2].
        tail: S Y, shape (n_tail, r).
    """

    eigenvalue: Array
    load: Array
    coordinates: Array
    shift: float
    tail: Array

    @property
    def frequency(self) -> Array:
        """√λ / 2π, shape (r,) [Hz]. The low ones are natural frequencies of the structure."""
        return np.asarray(np.sqrt(np.maximum(self.eigenvalue, 0.0)) / (2.0 * math.pi))

    def shapes(self, basis: Array) -> Array:
        """Φ at some rows of the basis.

        Args:
            basis: Rows of V, shape (n, size of the basis).

        Returns:
            The same rows of Φ, shape (n, r).
        """
        return np.asarray(basis @ self.coordinates, dtype=np.float64)

    def amplitude(self, omega: Array, alpha: float, beta: float) -> Complex:
        """Modal coordinates z for the loads exp(iωt), one pattern at a time.

        Args:
            omega: ω, shape (n,) [rad/s].
            alpha: α [1/s].
            beta: β [s].

        Returns:
            Shape (n, r, n_patterns).
        """
        s = 1j * np.asarray(omega)[:, None]
        transfer = 1.0 / (s * s + (alpha + beta * self.eigenvalue) * s + self.eigenvalue)
        return np.asarray(transfer[:, :, None] * self.load)


def reduced_model(basis: KrylovBasis, size: int | None = None) -> ReducedModel:
    """The modal equations of a basis, or of the first vectors of it: a nested, coarser model.

    Args:
        basis: The basis.
        size: Number of its vectors to take; all when None.
    """
    n = basis.size if size is None else min(size, basis.size)
    T, R = basis.T, basis.R
    # What A V_n has outside V_n: the later vectors of the basis, and the tail.
    outside = np.vstack([T[n:, :n], basis.S[:, :n]])
    theta, Y = np.linalg.eigh(0.5 * (T[:n, :n] + T[:n, :n].T))
    keep = theta > 1e-14 * theta[-1]
    theta, Y = theta[keep][::-1], Y[:, keep][:, ::-1]
    return ReducedModel(
        eigenvalue=1.0 / theta - basis.shift,
        load=(Y.T @ R[:n]) / theta[:, None],
        coordinates=np.ascontiguousarray(Y),
        shift=basis.shift,
        tail=outside @ Y,
    )


class Residual:
    """Norms of the residual, √(rᴴ M⁻¹ r). Making one is collective.

    Args:
        basis: The basis as it stands.
        M: Mass matrix.
        F: Its load patterns, shape (n_local, n_patterns).
    """

    def __init__(self, basis: KrylovBasis, M: PETSc.Mat, F: Array) -> None:
        Z = basis.shifted_tail()
        with Factorisation(M, name="the mass matrix") as factor:
            self._gram = inner(M, Z, factor.solve_block(Z))
            self.load_norm: Array = np.sqrt(np.diag(inner(M, F, factor.solve_block(F))))

    def norms(self, model: ReducedModel, omega: Array, alpha: float, beta: float) -> Array:
        """‖r‖ for the loads exp(iωt), shape (n, n_patterns); of the full basis' model only.

        Args:
            model: The reduced model of all of the basis.
            omega: ω, shape (n,) [rad/s].
            alpha: α [1/s].
            beta: β [s].
        """
        s = 1j * np.asarray(omega)
        sigma = s * (s + alpha) / (1.0 + s * beta)
        z = model.amplitude(omega, alpha, beta)
        w = np.einsum("tr,nrm->ntm", model.tail, z)
        squares = np.einsum("ntm,tu,num->nm", w.conj(), self._gram, w).real
        scale = np.abs((sigma - model.shift) * (1.0 + s * beta))
        return np.asarray(scale[:, None] * np.sqrt(np.maximum(squares, 0.0)))
