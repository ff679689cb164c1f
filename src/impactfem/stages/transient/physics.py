"""Comparison of spectra, arrivals of waves, and power spectra of forces, as functions of arrays.

The findings of the stage (`findings`) are computed by them.
"""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy import signal

from impactfem.coupling.force_history import around_peak
from impactfem.spectra.response_spectrum import upsample
from impactfem.stages.transient.selection import inward, main_impact, of_kind
from impactfem.system.arrays import Array

HALF = 0.5
"""Part of its peak at which a wave's arrival is read, in addition to the peak itself."""
FIRST = 0.45
"""Part of the largest peak in the window that the first peak of a wave reaches at least: what comes
back to a free edge is up to twice as large."""
NOTHING = 0.01
"""Part of the largest acceleration of all that counts as none."""
LATEST = 1.5
"""End of the search for a wave, in crossings (closed form) after its peak at the first point: its
reflection then returns to the near half of the line."""
FINER = 20
"""Steps of the interpolated histories in one of the response."""
QUIET_STEPS = 6
"""Steps before the impact where resampled forces are zero to 0.04 %."""
SEGMENT = 1.0
"""Length of the segments of a record [s]."""
SILENT = 1e-6
"""Part of the largest force below which nothing acts any more."""
RESOLUTION = 0.5
"""Spacing of the frequencies of an impact's spectrum, which is smooth [Hz]."""


def far_highest_below(near: Array, far: Array, frequency: Array) -> float | None:
    """Find the frequency above which the spectrum near the impact exceeds that far from it [Hz].

    Upwards from the largest ratio far / near, linear in log f between two frequencies; the highest
    frequency if the near one never exceeds the far one, None if the far one is nowhere higher.
    Both are envelopes of a half of the line, shape (n_f,).
    """
    ahead = np.log(far / near)
    most = int(np.argmax(ahead))
    if not ahead[most] > 0.0:
        return None
    behind = np.flatnonzero(ahead[most:] <= 0.0)
    if not behind.size:
        return float(frequency[-1])
    return _zero(frequency, ahead, most + int(behind[0]) - 1)


def longest_above(first: Array, second: Array, frequency: Array) -> tuple[float, float] | None:
    """Find the widest interval, in octaves, in which the first spectrum exceeds the second [Hz].

    Its ends are linear in log f between two frequencies; None if there is no such interval.
    """
    ahead = np.log(first / second)
    above = np.concatenate([[False], ahead > 0.0, [False]])
    starts = np.flatnonzero(~above[:-1] & above[1:])
    ends = np.flatnonzero(above[:-1] & ~above[1:])
    found = []
    for start, end in zip(starts, ends, strict=True):
        low = _zero(frequency, ahead, start - 1) if start else float(frequency[0])
        high = _zero(frequency, ahead, end - 1) if end < len(ahead) else float(frequency[-1])
        found.append((low, high))
    return max(found, key=lambda ends: ends[1] / ends[0]) if found else None


def _zero(frequency: Array, values: Array, k: int) -> float:
    """Find the zero of values between k and k + 1, linear in log f [Hz]."""
    a, b = values[k], values[k + 1]
    share = a / (a - b) if a != b else 0.0
    return float(frequency[k] * (frequency[k + 1] / frequency[k]) ** share)


@dataclass(frozen=True, eq=False)
class Arrivals:
    """Arrival times of the wave of an impact at points; nan without an arrival."""

    peak: Array  #: of its peak, shape (n_points,) [s]
    half: Array  #: of half of its peak, before it, shape (n_points,) [s]


def arrivals(
    time: Array,
    acceleration: Array,
    sense: float,
    impact: tuple[float, float],
    crossing: float | None = None,
) -> Arrivals:
    """Find the arrival times of the wave of an impact at points, by its peak and by half of it.

    The histories are refined by band-limited interpolation: acceleration along the push, minus its
    value shortly before the impact. The peak is the first one near the largest in the window; later
    ones are reflections. The window ends after twice the duration of the impact; at the points
    after the first one, one and a half crossings after the peak there, if the speed is known in
    closed form. The foot of the wave does not show its speed: damping that grows with the frequency
    has no front, and resampled forces push before an impact.

    Args:
        time: Equidistant, shape (n_t,) [s].
        acceleration: Shape (n_points, n_t) [m/s2].
        sense: 1 or −1, the sense in which the impact pushes.
        impact: Its start and end [s].
        crossing: Of a wave from the first point to the last, closed form [s]; None if not known.
    """
    step = float(time[1] - time[0])
    start = int(np.searchsorted(time, impact[0] - 1e-9 * step))
    quiet = max(0, start - QUIET_STEPS)
    end = impact[1] + max(impact[1] - impact[0], step)
    peak, half = (np.full(len(acceleration), math.nan) for _ in range(2))
    pushed = upsample(sense * (acceleration - acceleration[:, quiet : quiet + 1]), FINER)
    first = FINER * quiet
    for k, history in enumerate(pushed):
        if k == 1 and crossing and math.isfinite(peak[0]):
            end = peak[0] + LATEST * crossing
        last = FINER * (int(np.searchsorted(time, end, side="right")) - 1)
        values = history[first : last + 1]
        inner = values[1:-1]
        tops = 1 + np.flatnonzero((inner > values[:-2]) & (inner >= values[2:]))
        largest = float(values[tops].max(initial=0.0))
        # What interpolation makes of a wave that comes after the window is no arrival.
        if not largest > NOTHING * float(np.abs(acceleration).max()):
            continue
        tops = tops[values[tops] >= FIRST * largest]
        top = int(tops[0])
        after = int(np.argmax(values >= HALF * values[top]))
        peak[k] = time[0] + step * (first + top) / FINER
        half[k] = time[0] + step * (first + after) / FINER
    return Arrivals(peak, half)


def crossing_time(distance: Array, arrival: Array) -> float | None:
    """Compute the time a wave takes from the first point of a line to the last [s].

    The length of the line times the slope of the straight line through the arrivals, by least
    squares; nan is no arrival. None with fewer than two, or when they do not come later farther
    away.
    """
    known = np.isfinite(arrival)
    if np.count_nonzero(known) < 2:
        return None
    d, t = distance[known] - distance[known].mean(), arrival[known] - arrival[known].mean()
    spread = float(d @ d)
    slope = float(d @ t) / spread if spread > 0.0 else 0.0
    return slope * float(distance[-1] - distance[0]) if slope > 0.0 else None


def line_arrivals(response: xr.Dataset) -> Arrivals | None:
    """Find the arrivals of the wave of the main impact along the line; None without such a wave."""
    impact, sense = main_impact(response), inward(response)
    if impact is None or sense == 0.0:
        return None
    histories = of_kind(response, "line")["acceleration"].transpose("probe", "time").values
    crossing = response.get("loaded_wave_crossing")
    limit = None if crossing is None else float(crossing)
    return arrivals(response["time"].values, histories, sense, impact, limit)


@dataclass(frozen=True, eq=False)
class ForceSpectra:
    """Power spectral densities of the main impacts."""

    frequency: Array  #: shape (n_f,) [Hz]
    density: Array  #: one-sided, shape (n_forces, n_f) [N²/Hz]
    duration: float  #: over which the power is taken [s]


def power_spectrum(record: Array, time_step: float) -> tuple[Array, Array]:
    """Compute the one-sided power spectral density by Welch's method, Hann windows, half overlap.

    Of records of shape (..., n): frequencies [Hz] and densities [their unit squared per Hz].
    """
    frequency, density = signal.welch(
        record,
        fs=1.0 / time_step,
        window="hann",
        nperseg=min(record.shape[-1], round(SEGMENT / time_step)),
        detrend=False,
    )
    return np.asarray(frequency), np.asarray(density)


def force_spectra(force: Array, time_step: float) -> ForceSpectra:
    """Compute spectra of the main impact of each force, alone and over the same duration.

    S(f) = 2 |Δt Σ_n F_n e^(−2πi f n Δt)|² / T, with the duration T for which the longest of the
    impacts presses: so the densities of the forces, shape (n_t, n_forces) [N], can be compared. The
    samples before and after it, in which resampling rings, belong to its impulse and not to T.
    """
    # Each ends where nothing acts: tension at its end belongs to it.
    impacts = [around_peak(np.abs(column), SILENT) for column in force.T]
    longest = max(last - first for first, last in impacts)
    T = time_step * max(behind - first for first, behind in map(around_peak, force.T))
    count = max(longest, round(1.0 / (RESOLUTION * time_step)))
    densities = []
    frequency = np.fft.rfftfreq(count, time_step)
    for (first, last), column in zip(impacts, force.T, strict=True):
        alone = np.zeros(longest)
        alone[: last - first] = column[first:last]
        frequency, density = signal.periodogram(
            alone, fs=1.0 / time_step, window="boxcar", nfft=count, detrend=False
        )
        densities.append(density * (longest * time_step / T))
    return ForceSpectra(np.asarray(frequency), np.array(densities), T)
