"""An accelerogram, one component of ground motion linear between its samples; its measures."""

import math
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from impactfem.records.recording import Recording
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError
from impactfem.system.quantity import results, si

STANDARD_GRAVITY = 9.80665  # m/s2, by definition


@dataclass(frozen=True, eq=False)
class Accelerogram:
    """One component of ground acceleration, at rest before its first sample.

    The samples are copied and read-only. A step that is not positive, and samples that are too few
    or not finite, are refused.
    """

    time_step: float  #: h [s]
    acceleration: Array  #: samples at 0, h, 2h, ..., shape (n,), n >= 2 [m/s2]
    name: str = ""  #: in tables and figures
    origin: str = ""  #: where it comes from: a file, or how it was made
    #: Step at which it was sampled, before a treatment changed it [s]; default `time_step`.
    sampling_step: float = math.nan
    recording: Recording = field(
        default_factory=Recording
    )  #: what the header of its file says of it

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
        if math.isnan(self.sampling_step):
            object.__setattr__(self, "sampling_step", h)
        object.__setattr__(self, "acceleration", a)

    @property
    def time(self) -> Array:
        """Times of the samples, shape (n,) [s]."""
        return np.asarray(np.arange(self.acceleration.size) * self.time_step, dtype=np.float64)

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return (self.acceleration.size - 1) * self.time_step

    @property
    def velocity(self) -> Array:
        """Ground velocity v_n+1 = v_n + h (a_n + a_n+1) / 2, shape (n,) [m/s].

        Exact for acceleration that is linear between the samples.
        """
        a = self.acceleration
        return _accumulated(0.5 * self.time_step * (a[:-1] + a[1:]))

    @property
    def displacement(self) -> Array:
        """Ground displacement d_n+1 = d_n + h v_n + h² (2 a_n + a_n+1) / 6, shape (n,) [m].

        Exact for acceleration that is linear between the samples.
        """
        a, h = self.acceleration, self.time_step
        return _accumulated(h * self.velocity[:-1] + h**2 / 6.0 * (2.0 * a[:-1] + a[1:]))

    def scaled(self, factor: float) -> Self:
        """The motion times a number, which must be finite and not zero."""
        if not np.isfinite(factor) or factor == 0.0:
            raise ImpactfemError(f"the scale of an accelerogram must not be {factor!r}")
        note = f"{self.origin}; scaled by {factor:.12g}" if self.origin else ""
        return replace(self, acceleration=self.acceleration * factor, origin=note)

    def scaled_to_pga(self, pga: float) -> Self:
        """The motion at another peak [m/s2], positive; one that is zero throughout is refused."""
        peak = float(np.abs(self.acceleration).max())
        if not (np.isfinite(pga) and pga > 0.0) or peak == 0.0:
            raise ImpactfemError(
                f"an accelerogram with peak {peak!r} m/s2 cannot be scaled to {pga!r} m/s2"
            )
        return self.scaled(pga / peak)


@results
class Measures:
    """Measures of the strength of a ground motion, peaks at its samples.

    The significant duration is that between 5 % and 95 % of the Arias intensity, 0 for a motion
    that is zero throughout; velocity and displacement of the end are those at the last sample.
    """

    pga: float = si("m/s2", "peak ground acceleration")
    time_of_pga: float = si("s", "time of the peak ground acceleration")
    pgv: float = si("m/s", "peak ground velocity")
    pgd: float = si("m", "peak ground displacement")
    arias: float = si("m/s", "Arias intensity", name="arias_intensity")
    duration_5_95: float = si("s", "significant duration, 5 to 95 % of the Arias intensity")
    end_velocity: float = si("m/s", "velocity at the end")
    end_displacement: float = si("m", "displacement at the end")


def measures(accelerogram: Accelerogram) -> Measures:
    """Measure a ground motion.

    The Arias intensity I = π/(2g) ∫ a² dt (Arias 1970) is exact for acceleration that is linear
    between the samples: each step gives h (a_n² + a_n a_n+1 + a_n+1²) / 3. The two instants of the
    significant duration are interpolated linearly between the samples of I(t).
    """
    a, h, t = accelerogram.acceleration, accelerogram.time_step, accelerogram.time
    steps = h / 3.0 * (a[:-1] ** 2 + a[:-1] * a[1:] + a[1:] ** 2)
    intensity = np.pi / (2.0 * STANDARD_GRAVITY) * np.concatenate([[0.0], np.cumsum(steps)])
    arias = float(intensity[-1])
    start, end = np.interp([0.05 * arias, 0.95 * arias], intensity, t)
    peak = int(np.argmax(np.abs(a)))
    velocity, displacement = accelerogram.velocity, accelerogram.displacement
    return Measures(
        pga=float(abs(a[peak])),
        time_of_pga=float(t[peak]),
        pgv=float(np.abs(velocity).max()),
        pgd=float(np.abs(displacement).max()),
        arias=arias,
        duration_5_95=float(end - start) if arias > 0.0 else 0.0,
        end_velocity=float(velocity[-1]),
        end_displacement=float(displacement[-1]),
    )


def _accumulated(increments: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(increments)])
