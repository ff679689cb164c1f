"""Energy balance of a response, and what the scheme's contact adds or takes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.coupling.pounding import Response

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EnergyBalance:
    """Energies relative to the ground at each time, shape (n_t,) each [J].

    The average acceleration rule satisfies exactly, step by step,

        Δ(½ vᵀ M v) + Δ(½ uᵀ K u) + Δt/4 wᵀ C w = ½ Δuᵀ (f₀ + f₁) + ½ Δδᵀ (F₀ + F₁),

    with w = v₀ + v₁. The right-hand side is the input and the work of the contact forces.

    Args:
        kinetic: ½ vᵀ M v.
        elastic: ½ uᵀ K u.
        damped: Energy that the damping has taken.
        input: Work of the external forces.
        contact: Work of the contact forces on the buildings; negative when they take energy.
    """

    kinetic: Array
    elastic: Array
    damped: Array
    input: Array
    contact: Array

    @property
    def residual(self) -> float:
        """Largest violation of the identity over the largest energy that came in [-]."""
        stored = self.kinetic + self.elastic
        violation = stored - stored[0] + self.damped - self.input - self.contact
        scale = max(float(np.max(np.abs(self.input))), float(np.max(stored)))
        return float(np.max(np.abs(violation)) / scale) if scale > 0.0 else 0.0


def energy_balance(response: Response) -> EnergyBalance:
    """The energies of a response, summed up step by step."""
    system = response.system
    moving = response.moving
    here = np.ix_(moving, moving)
    M, C, K = system.M[here], system.C[here], system.K[here]
    u, v = response.u[:, moving], response.v[:, moving]
    w = v[:-1] + v[1:]
    du = np.diff(u, axis=0)
    f = response.external[:, moving]
    contact: Array = np.zeros(u.shape[0])
    if system.pairs:
        F = response.force
        contact = _accumulated(0.5 * np.sum(np.diff(response.gap, axis=0) * (F[:-1] + F[1:]), 1))
    return EnergyBalance(
        kinetic=0.5 * np.sum(v * (v @ M), axis=1),
        elastic=0.5 * np.sum(u * (u @ K), axis=1),
        damped=_accumulated(response.time_step / 4.0 * np.sum(w * (w @ C), axis=1)),
        input=_accumulated(0.5 * np.sum(du * (f[:-1] + f[1:]), axis=1)),
        contact=contact,
    )


def _accumulated(increments: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(increments)])
