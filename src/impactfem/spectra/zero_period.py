"""From which frequency on a floor response spectrum is that of a rigid oscillator."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from impactfem.spectra.frequency_list import FloatArray
from impactfem.spectra.interpolation import checked_frequency, checked_values
from impactfem.system.errors import ImpactfemError

ZPA_TOLERANCE = 0.05
ENDED = 1.1
"""Largest factor between the last ordinate of a spectrum and the peak acceleration that it tends to
with which it has ended. Under a sine of the frequency g a stiff oscillator of the frequency f shows
1/(1 − (g/f)²) of it, which is 1.1 at g = 0.3 f: within the factor the motion holds little above."""


def rigid_frequency(
    frequency: npt.ArrayLike,
    values: npt.ArrayLike,
    zpa: npt.ArrayLike,
    tolerance: float = ZPA_TOLERANCE,
) -> FloatArray:
    """Find the listed frequency from which on spectra stay at the zero-period acceleration.

    Args:
        frequency: Ascending, shape (n_f,) [Hz].
        values: Ordinates, not negative, shape (..., n_f).
        zpa: Zero-period acceleration a of each spectrum, shape (...), in the unit of the ordinates.
        tolerance: t, how far the ordinates may be off: |S - a| <= t a [-].

    Returns:
        The first frequency of the list from which on all are that near, shape (...) [Hz]; nan where
        the last one still is not: such a list ends too early.

    Raises:
        ImpactfemError: The spectra are not usable, or the tolerance is not positive.
    """
    if not tolerance > 0.0:
        raise ImpactfemError(f"the tolerance must be positive, got {tolerance!r}")
    f = checked_frequency(frequency)
    s = checked_values(values, f.size)
    a = np.asarray(zpa, dtype=np.float64)
    if a.shape != s.shape[:-1]:
        raise ImpactfemError(
            f"spectra of shape {s.shape} need zero-period accelerations of shape {s.shape[:-1]}"
        )
    off = np.abs(s - a[..., None]) > tolerance * a[..., None]
    trailing = np.where(off.any(axis=-1), np.argmax(off[..., ::-1], axis=-1), f.size)
    first = f.size - trailing
    return np.where(trailing > 0, f[np.minimum(first, f.size - 1)], np.nan)
