"""What a motion is compared with: any pseudo-acceleration spectrum at one damping."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from impactfem.system.errors import ImpactfemError


def positive_frequencies(frequency: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Frequencies as an array of the same shape [Hz].

    Raises:
        ImpactfemError: A frequency is not positive.
    """
    f = np.asarray(frequency, dtype=np.float64)
    if not np.all(f > 0.0):
        raise ImpactfemError("the frequencies of a design spectrum must be positive")
    return f


class Target(Protocol):
    """A pseudo-acceleration spectrum that a motion is matched to or judged by."""

    @property
    def damping(self) -> float:
        """Damping ratio ξ [-]."""

    def pseudo_acceleration(self, frequency: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Evaluate it.

        Args:
            frequency: Any shape [Hz], positive.

        Returns:
            The same shape [m/s2].
        """
