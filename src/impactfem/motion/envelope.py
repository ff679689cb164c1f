"""The envelope of a synthetic motion: rise, strong phase, decay."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.system.errors import ImpactfemError

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Envelope:
    """Quadratic rise, constant strong phase, exponential decay.

    The form is that of Jennings, Housner and Tsai (1968), "Simulated earthquake motions", Caltech
    EERL: with the strong phase from t_1 to t_2 and the duration T,

        e(t) = (t / t_1)²                    0   <= t <= t_1
        e(t) = 1                             t_1 <= t <= t_2
        e(t) = exp(-c (t - t_2))             t_2 <= t <= T,   c = ln(1 / e_T) / (T - t_2)

    so that e_T is left at the end. Over the last twentieth of the duration a straight line takes
    that rest to zero.

    Args:
        duration: T [s].
        strong_phase: t_1 and t_2, 0 <= t_1 < t_2 <= T [s].
        end_level: e_T, 0 < e_T < 1 [-].

    Raises:
        ImpactfemError: The strong phase does not lie inside the duration, or the end level is out
            of range.
    """

    duration: float
    strong_phase: tuple[float, float]
    end_level: float = 0.05

    def __post_init__(self) -> None:
        t_1, t_2 = self.strong_phase
        if not 0.0 <= t_1 < t_2 <= self.duration < math.inf:
            raise ImpactfemError(
                "the strong phase must lie inside the motion, 0 <= begin < end <= duration:"
                f" got {t_1!r} s to {t_2!r} s of {self.duration!r} s"
            )
        if not 0.0 < self.end_level < 1.0:
            raise ImpactfemError(
                f"the envelope's end level must be between 0 and 1, got {self.end_level!r}"
            )

    def at(self, time: npt.ArrayLike) -> FloatArray:
        """Evaluate the envelope.

        Args:
            time: Inside [0, T], shape (n,) [s].

        Returns:
            Shape (n,) [-].
        """
        t = np.asarray(time, dtype=np.float64)
        T = self.duration
        t_1, t_2 = self.strong_phase
        level = np.ones_like(t)
        rising, falling = t < t_1, t > t_2
        level[rising] = (t[rising] / t_1) ** 2
        level[falling] = self.end_level ** ((t[falling] - t_2) / (T - t_2))
        return np.asarray(level * np.clip((T - t) / (0.05 * T), 0.0, 1.0))
