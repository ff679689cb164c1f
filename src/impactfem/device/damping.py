"""Rayleigh damping of a device, C = α M + β K."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Rayleigh:
    """Coefficients of C = α M + β K.

    Args:
        alpha: Mass coefficient α, not negative [1/s].
        beta: Stiffness coefficient β, not negative [s].

    Raises:
        ImpactfemError: A coefficient is negative or not finite.
    """

    alpha: float
    beta: float

    def __post_init__(self) -> None:
        if not all(math.isfinite(c) and c >= 0.0 for c in (self.alpha, self.beta)):
            raise ImpactfemError(
                f"Rayleigh damping with α = {self.alpha!r} 1/s and β = {self.beta!r} s: both must"
                " be finite and not negative"
            )

    @classmethod
    def through(cls, ratio: float, low: float, high: float) -> Rayleigh:
        """The damping with one ratio ξ at two frequencies.

        α = 2 ξ ω₁ ω₂ / (ω₁ + ω₂), β = 2 ξ / (ω₁ + ω₂).

        Args:
            ratio: ξ, 0 <= ξ < 1 [-].
            low: First frequency [Hz].
            high: Second frequency [Hz].

        Raises:
            ImpactfemError: The ratio is negative or 100 % and more, or the frequencies do not
                ascend.
        """
        checked_ratio(ratio)
        if not 0.0 < low < high < math.inf:
            raise ImpactfemError(
                f"damping at {low!r} Hz and {high!r} Hz: expected two frequencies, the lower first"
            )
        omega = 2.0 * math.pi * low, 2.0 * math.pi * high
        beta = 2.0 * ratio / sum(omega)
        return cls(beta * omega[0] * omega[1], beta)

    def ratio(self, frequency: npt.ArrayLike) -> Array:
        """Damping ratio ξ(f) = (α / ω + β ω) / 2 at each frequency, shape (n,) [Hz]."""
        omega = 2.0 * np.pi * np.asarray(frequency, dtype=np.float64)
        return np.asarray(0.5 * (self.alpha / omega + self.beta * omega), dtype=np.float64)


def checked_ratio(ratio: float) -> float:
    """Give a damping ratio back; refuse one that is none.

    Raises:
        ImpactfemError: It is not 0 <= ξ < 1.
    """
    if not 0.0 <= ratio < 1.0:
        raise ImpactfemError(
            f"a damping ratio of {ratio!r}: expected 0 <= ratio < 1 (2 % is 0.02); from 100 % on"
            " nothing oscillates, and there is no response spectrum"
        )
    return ratio
