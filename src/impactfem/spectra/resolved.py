"""The resolved band: the frequencies up to which a response gives converged spectra.

Four causes limit it from the input alone: time steps, oscillators, mesh and contact; the reduced
basis and the refinement of the steps limit it by what they change in the spectra of the run.
Impacts are sensitive to the step: measured on two buildings, half of all steps predicts within 3 %
the frequency up to which a quarter of them changes the spectra by 5 %
(docs/how-to/time-step-mesh-band.md).
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
from scipy import signal

from impactfem.spectra.response_spectrum import ResponseSpectra
from impactfem.system.arrays import Array
from impactfem.system.quantity import quantities, results, si

POINTS = 10.0
"""Least number of time steps in a cycle of a resolved frequency: a peak between two samples is then
at most 4.9 % higher."""
BANDS = (33.0, 100.0)
"""Ends of the bands in which peaks are reported: rigid equipment without impact, and impacts."""
CHANGE = 0.05
"""Largest change of a resolved ordinate with a finer computation."""
COUNTS = 0.1
"""Part of the largest ordinate below which the change of an ordinate does not count."""
ZPA = "zero-period acceleration, peak of the history in the resolved band"
ORDER = 4
"""Order of the low-pass filter of the ZPA, in each of its two passes."""
FILTERED = 0.9
"""Part of the Nyquist frequency from which on a history is not filtered."""
PADDING = 3.0
"""Periods of the corner frequency by which a history is continued at both ends."""
QUARTER = 0.75
"""Share of an error of first order in the time step that a quarter of the step removes."""


@results
class ResolvedBand:
    """Limits of the frequency by cause; infinite where a cause sets no limit."""

    time_step: float = si("Hz", "time step of the response", name="limit_time_step")
    oscillators: float = si(
        "Hz", "samples and highest frequency of the spectra", name="limit_oscillators"
    )
    mesh: float = si("Hz", "mesh of the slabs", name="limit_mesh")
    basis: float = si("Hz", "reduced basis", name="limit_basis")
    contact: float = si("Hz", "time steps per impact", name="limit_contact")
    refinement: float = si("Hz", "sensitivity to the time steps", name="limit_refinement")

    @property
    def causes(self) -> dict[str, float]:
        """The limit of each cause in words [Hz], the lowest first."""
        kind: type = type(self)
        limits = {one.text: getattr(self, name) for name, one in quantities(kind).items()}
        return dict(sorted(limits.items(), key=lambda limit: limit[1]))

    @property
    def frequency(self) -> float:
        """End of the resolved band, the lowest limit [Hz]."""
        return min(self.causes.values())

    @property
    def governing(self) -> str:
        """The cause of the lowest limit in words."""
        return next(iter(self.causes))

    @property
    def attributes(self) -> dict[str, Any]:
        """End of the band and its cause, as attributes of a results file."""
        return {"resolved_frequency": self.frequency, "resolved_by": self.governing}


def band_peaks(frequency: Array, psa: Array) -> list[tuple[float, float]]:
    """Return peak and frequency [Hz] of a spectrum in each band: below, between, above `BANDS`.

    Nan where the spectrum has no ordinate in a band.
    """
    found = []
    for low, high in pairwise((-math.inf, *BANDS, math.inf)):
        inside = np.flatnonzero((frequency > low) & (frequency <= high * (1.0 + 1e-9)))
        k = inside[psa[inside].argmax()] if inside.size else -1
        found.append((float(psa[k]), float(frequency[k])) if k >= 0 else (math.nan, math.nan))
    return found


def band_limited(acceleration: Array, time_step: float, end: float) -> Array:
    """Return histories limited to the resolved band.

    By a Butterworth low-pass filter of the order `ORDER` with its corner at the end of the band,
    forward and backward: without a phase shift, and with half of the amplitude at the corner.
    Samples alone have what the time step does not resolve. A history that ends below the corner is
    not filtered.

    Args:
        acceleration: Histories, shape (n_t, ...) [m/s2].
        time_step: Their step [s].
        end: End of the resolved band [Hz].

    Returns:
        Same shape [m/s2].
    """
    if end >= FILTERED * 0.5 / time_step:
        return acceleration
    sections = signal.butter(ORDER, end, fs=1.0 / time_step, output="sos")
    padded = min(len(acceleration) - 1, int(PADDING / (end * time_step)))
    return np.asarray(
        signal.sosfiltfilt(sections, acceleration, axis=0, padtype="constant", padlen=padded)
    )


def band_limited_zpa(acceleration: Array, time_step: float, end: float) -> Array:
    """Return the zero-period acceleration (ZPA) of histories limited to the resolved band.

    It is the largest absolute value of `band_limited`; arguments as there.

    Returns:
        Shape (...) [m/s2].
    """
    return np.asarray(np.abs(band_limited(acceleration, time_step, end)).max(axis=0))


def step_limit(time_step: float) -> float:
    """Return the highest frequency with `POINTS` time steps [s] per cycle [Hz]."""
    return 1.0 / (POINTS * time_step)


def sampling_limit(spectra: ResponseSpectra) -> float:
    """Return the highest frequency of spectra with `POINTS` samples per cycle [Hz]."""
    highest = float(spectra.frequency.max())
    return highest * min(1.0, spectra.points_per_cycle / POINTS)


def agreement(frequency: Array, psa: Array, other: Array, weight: float = 1.0) -> float:
    """Return the frequency up to which two computations of the same spectra agree [Hz].

    Ordinates of at least `COUNTS` times the largest one at the same damping count.

    Args:
        frequency: Ascending, shape (n_f,) [Hz].
        psa: Ordinates, shape (n_dampings, ..., n_f).
        other: Those of the other computation, same shape.
        weight: Factor on the change, which is at most `CHANGE` in the band.

    Returns:
        The last frequency before the first ordinate that changes more, at least the lowest one;
        infinity where none does.
    """
    largest = psa.max(axis=tuple(range(1, psa.ndim)), keepdims=True, initial=0.0)
    counts = (psa >= COUNTS * largest) & (psa > 0.0)
    late = counts & (weight * np.abs(other - psa) > CHANGE * psa)
    first = np.flatnonzero(late.any(axis=tuple(range(psa.ndim - 1))))
    return float(frequency[max(0, first[0] - 1)]) if first.size else math.inf


def refinement_limit(frequency: Array, psa: Array, other: Array, ratio: float) -> float:
    """Return the frequency up to which a quarter of the time step changes spectra little [Hz].

    The error e of contact is of the first order in the step, e(h) = c h: a run with the step r h
    shows c h |1 - r|, and a quarter of the step would show 3/4 c h.

    Args:
        frequency: As of `agreement`.
        psa: Ordinates with the step h.
        other: Ordinates with the step r h.
        ratio: r, not 1.
    """
    return agreement(frequency, psa, other, QUARTER / abs(1.0 - ratio))
