"""The elastic design spectrum of EN 1998-1, given by its level and corner periods."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.motion.target import positive_frequencies
from impactfem.system.errors import ImpactfemError

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class DesignSpectrum:
    """Elastic response spectrum of EN 1998-1:2004, 3.2.2.2, equations 3.2 to 3.6.

    With A = a_g S, F = amplification, and T = 1/f:

        0   <= T <= T_B   S_e = A [1 + T/T_B (η F - 1)]                                  (3.2)
        T_B <= T <= T_C   S_e = A η F                                                    (3.3)
        T_C <= T <= T_D   S_e = A η F T_C / T                                            (3.4)
        T_D <= T          S_e = A η F T_C T_D / T²                                       (3.5)
        η = √(10 / (5 + 100 ξ)) >= 0.55                                                  (3.6)

    The standard ends (3.5) at 4 s; here it goes on, at constant displacement.

    Args:
        ground_acceleration: A, soil factor included: the zero-period acceleration [m/s2].
        corner_periods: T_B, T_C, T_D, ascending [s].
        amplification: F of the plateau at 5 % damping; 2.5 in the standard [-].
        damping: Ratio ξ [-].

    Raises:
        ImpactfemError: A value is out of range, or the periods do not ascend.
    """

    ground_acceleration: float
    corner_periods: tuple[float, float, float]
    amplification: float = 2.5
    damping: float = 0.05

    def __post_init__(self) -> None:
        if not (math.isfinite(self.ground_acceleration) and self.ground_acceleration > 0.0):
            raise ImpactfemError(
                f"the ground acceleration must be positive, got {self.ground_acceleration!r} m/s2"
            )
        periods = self.corner_periods
        ascending = len(periods) == 3 and 0.0 < periods[0] <= periods[1] <= periods[2] < math.inf
        if not ascending:
            raise ImpactfemError(
                f"the corner periods must be 0 < T_B <= T_C <= T_D, got {periods!r} s"
            )
        if not (math.isfinite(self.amplification) and self.amplification >= 1.0):
            raise ImpactfemError(
                f"the amplification must be at least 1, got {self.amplification!r}"
            )
        if not 0.0 <= self.damping < 1.0:
            raise ImpactfemError(
                f"the damping must be 0 <= ratio < 1 (5 % is 0.05), got {self.damping!r}"
            )

    @property
    def damping_correction(self) -> float:
        """η of (3.6) [-]."""
        return max(0.55, math.sqrt(10.0 / (5.0 + 100.0 * self.damping)))

    def pseudo_acceleration(self, frequency: npt.ArrayLike) -> FloatArray:
        """Evaluate S_e.

        Args:
            frequency: Any shape [Hz], positive; inf gives the zero-period acceleration.

        Returns:
            The same shape [m/s2].

        Raises:
            ImpactfemError: A frequency is not positive.
        """
        f = positive_frequencies(frequency)
        T = 1.0 / f
        T_B, T_C, T_D = self.corner_periods
        plateau = self.damping_correction * self.amplification
        rising = 1.0 + T / T_B * (plateau - 1.0)
        falling = plateau * (T_C / np.maximum(T, T_C)) * (T_D / np.maximum(T, T_D))
        return np.asarray(self.ground_acceleration * np.where(T < T_B, rising, falling))

    def displacement(self, frequency: npt.ArrayLike) -> FloatArray:
        """Evaluate S_De = S_e (T / 2π)², EN 1998-1 equation 3.7.

        Args:
            frequency: Any shape [Hz], positive.

        Returns:
            The same shape [m].
        """
        f = np.asarray(frequency, dtype=np.float64)
        return np.asarray(self.pseudo_acceleration(f) / (2.0 * np.pi * f) ** 2)
