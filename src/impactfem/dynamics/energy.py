"""Energies of a linear response, and how well they balance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Energy:
    """Energies at each time, shape (n_t,) each [J].

    The average acceleration rule satisfies exactly, step by step,

        Δ(½ vᵀ M v) + Δ(½ uᵀ K u) + Δt/4 wᵀ C w = Δt/4 wᵀ (f₀ + f₁),   w = v₀ + v₁ = 2 Δu/Δt.

    Args:
        kinetic: ½ vᵀ M v.
        elastic: ½ uᵀ K u.
        damped: What the damping has taken since step 0.
        input: Work of the loads since step 0.
    """

    kinetic: Array
    elastic: Array
    damped: Array
    input: Array

    @property
    def residual(self) -> float:
        """Largest violation of the identity over the largest energy that came in [-]."""
        stored = self.kinetic + self.elastic
        balance = stored + self.damped - self.input
        scale = max(float(np.max(np.abs(self.input))), float(np.max(stored)))
        return float(np.max(np.abs(balance - balance[0])) / scale) if scale > 0.0 else 0.0
