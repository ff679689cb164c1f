"""A design spectrum given by points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.motion.target import positive_frequencies
from impactfem.system.errors import ImpactfemError

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TableSpectrum:
    """Pseudo-acceleration at given frequencies, straight between them on logarithmic axes.

    Above the last frequency the acceleration stays (zero-period acceleration), below the first
    the displacement does, S_a ~ f². Neither is part of the table: `range` says where it holds.

    Args:
        frequency: Ascending, positive, shape (n,), n >= 2 [Hz].
        acceleration: Positive, shape (n,) [m/s2].
        damping: Ratio ξ the table was made for [-].

    Raises:
        ImpactfemError: A value is out of range, or the frequencies do not ascend.
    """

    frequency: FloatArray
    acceleration: FloatArray
    damping: float = 0.05

    def __post_init__(self) -> None:
        f = np.array(self.frequency, dtype=np.float64)
        a = np.array(self.acceleration, dtype=np.float64)
        if f.ndim != 1 or f.shape != a.shape or f.size < 2:
            raise ImpactfemError(
                f"a table spectrum needs at least 2 points, got shapes {f.shape} and {a.shape}"
            )
        if not (np.all(np.isfinite(f)) and f[0] > 0.0 and np.all(np.diff(f) > 0.0)):
            raise ImpactfemError("the frequencies of a table spectrum must be positive and ascend")
        if not (np.all(np.isfinite(a)) and np.all(a > 0.0)):
            raise ImpactfemError("the accelerations of a table spectrum must be positive")
        if not 0.0 <= self.damping < 1.0:
            raise ImpactfemError(
                f"the damping must be 0 <= ratio < 1 (5 % is 0.05), got {self.damping!r}"
            )
        for name, values in (("frequency", f), ("acceleration", a)):
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest frequency of the table [Hz]."""
        return float(self.frequency[0]), float(self.frequency[-1])

    def pseudo_acceleration(self, frequency: npt.ArrayLike) -> FloatArray:
        """Evaluate the spectrum.

        Args:
            frequency: Any shape [Hz], positive; inf gives the zero-period acceleration.

        Returns:
            The same shape [m/s2].

        Raises:
            ImpactfemError: A frequency is not positive.
        """
        f = positive_frequencies(frequency)
        inside = np.exp(np.interp(np.log(f), np.log(self.frequency), np.log(self.acceleration)))
        return np.asarray(inside * np.minimum(f / self.frequency[0], 1.0) ** 2)
