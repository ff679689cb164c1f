"""Measures of the strength of a ground motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from impactfem.motion.accelerogram import Accelerogram

STANDARD_GRAVITY = 9.80665  # m/s2, by definition


@dataclass(frozen=True)
class Measures:
    """What an engineer asks of a ground motion first.

    Args:
        pga: Peak ground acceleration, largest sample [m/s2].
        time_of_pga: Time of that sample [s].
        pgv: Peak ground velocity at the samples [m/s].
        pgd: Peak ground displacement at the samples [m].
        arias: Arias intensity [m/s].
        duration_5_95: Significant duration: between 5 % and 95 % of the Arias intensity [s];
            0 for a motion that is zero throughout.
        end_velocity: Ground velocity at the last sample [m/s].
        end_displacement: Ground displacement at the last sample [m].
    """

    pga: float
    time_of_pga: float
    pgv: float
    pgd: float
    arias: float
    duration_5_95: float
    end_velocity: float
    end_displacement: float


def measures(accelerogram: Accelerogram) -> Measures:
    """Measure a ground motion.

    The Arias intensity I = π/(2g) ∫ a² dt (Arias 1970) is exact for acceleration that is linear
    between the samples: each step gives h (a_n² + a_n a_n+1 + a_n+1²) / 3. The two instants of the
    significant duration are interpolated linearly between the samples of I(t).

    Args:
        accelerogram: The motion.

    Returns:
        Its measures.
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
