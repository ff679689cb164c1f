"""Rayleigh damping C = α M + β K."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Rayleigh:
    """Coefficients of C = α M + β K.

    Args:
        alpha: Mass coefficient α [1/s].
        beta: Stiffness coefficient β [s].
    """

    alpha: float
    beta: float

    def ratio(self, frequency: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Damping ratio ξ(f) = α / (2 ω) + β ω / 2 at each frequency [Hz]."""
        w = 2.0 * np.pi * np.asarray(frequency, dtype=float)
        return self.alpha / (2.0 * w) + self.beta * w / 2.0
