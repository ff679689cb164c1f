"""An accelerogram: one component of base acceleration, linear between its samples."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from impactfem.spectra.sampling import upsample
from impactfem.system.errors import ImpactfemError

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Accelerogram:
    """One component of ground acceleration, at rest before its first sample.

    Args:
        time_step: Step h [s].
        acceleration: Samples at 0, h, 2h, ..., shape (n,), n >= 2 [m/s2]; copied, read-only.
        name: What it is called in tables and figures.
        origin: Where it comes from: a file, or how it was made.

    Raises:
        ImpactfemError: The step is not positive, or the samples are too few or not finite.
    """

    time_step: float
    acceleration: FloatArray
    name: str = ""
    origin: str = ""

    def __post_init__(self) -> None:
        h = float(self.time_step)
        a = np.array(self.acceleration, dtype=np.float64)
        if not (np.isfinite(h) and h > 0.0):
            raise ImpactfemError(f"an accelerogram's time step must be positive, got {h!r} s")
        if a.ndim != 1 or a.size < 2:
            raise ImpactfemError(
                f"an accelerogram needs at least 2 samples in a row, got shape {a.shape}"
            )
        if not np.all(np.isfinite(a)):
            first = int(np.argmin(np.isfinite(a)))
            raise ImpactfemError(f"sample {first} of an accelerogram is not a finite number")
        a.flags.writeable = False
        object.__setattr__(self, "time_step", h)
        object.__setattr__(self, "acceleration", a)

    @property
    def time(self) -> FloatArray:
        """Times of the samples, shape (n,) [s]."""
        return np.asarray(np.arange(self.acceleration.size) * self.time_step, dtype=np.float64)

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return (self.acceleration.size - 1) * self.time_step

    @property
    def velocity(self) -> FloatArray:
        """Ground velocity v_n+1 = v_n + h (a_n + a_n+1) / 2, shape (n,) [m/s].

        Exact for acceleration that is linear between the samples.
        """
        a = self.acceleration
        return _accumulated(0.5 * self.time_step * (a[:-1] + a[1:]))

    @property
    def displacement(self) -> FloatArray:
        """Ground displacement d_n+1 = d_n + h v_n + h² (2 a_n + a_n+1) / 6, shape (n,) [m].

        Exact for acceleration that is linear between the samples.
        """
        a, h = self.acceleration, self.time_step
        return _accumulated(h * self.velocity[:-1] + h**2 / 6.0 * (2.0 * a[:-1] + a[1:]))

    def at(self, time: npt.ArrayLike) -> FloatArray:
        """Give the acceleration at any times: linear between samples, zero outside the record.

        Args:
            time: Any shape [s].

        Returns:
            The same shape [m/s2].
        """
        t = np.asarray(time, dtype=np.float64)
        return np.asarray(np.interp(t, self.time, self.acceleration, left=0.0, right=0.0))

    def scaled(self, factor: float) -> Accelerogram:
        """Multiply the acceleration by a number.

        Args:
            factor: Finite, not zero [-].

        Raises:
            ImpactfemError: The factor is zero or not finite.
        """
        if not np.isfinite(factor) or factor == 0.0:
            raise ImpactfemError(f"the scale of an accelerogram must not be {factor!r}")
        note = f"{self.origin}; scaled by {factor:.12g}" if self.origin else ""
        return replace(self, acceleration=self.acceleration * factor, origin=note)

    def scaled_to_pga(self, pga: float) -> Accelerogram:
        """Scale to a peak ground acceleration.

        Args:
            pga: Peak wanted, positive [m/s2].

        Raises:
            ImpactfemError: The peak wanted is not positive, or the record is zero throughout.
        """
        peak = float(np.abs(self.acceleration).max())
        if not (np.isfinite(pga) and pga > 0.0) or peak == 0.0:
            raise ImpactfemError(
                f"an accelerogram with peak {peak!r} m/s2 cannot be scaled to {pga!r} m/s2"
            )
        return self.scaled(pga / peak)

    def refined(self, factor: int) -> Accelerogram:
        """Insert band-limited samples (:func:`impactfem.spectra.sampling.upsample`).

        Args:
            factor: How many new steps an old one is cut into [-].
        """
        fine = upsample(self.acceleration[None, :], factor)[0]
        note = f"{self.origin}; refined {factor} times, band-limited" if self.origin else ""
        return replace(self, time_step=self.time_step / factor, acceleration=fine, origin=note)


def _accumulated(increments: FloatArray) -> FloatArray:
    return np.concatenate([[0.0], np.cumsum(increments)])
