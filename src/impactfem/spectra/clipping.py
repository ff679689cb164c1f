"""Reduction of narrow peaks of floor response spectra.

A narrow peak of a spectrum is reached only if the frequencies of building and equipment meet, and
broadening then keeps it over a wide range. ASCE 4-98, section 3.4.2.3, allows the amplitude P of
such a peak of the computed, not yet broadened spectrum to be reduced by 15 %, for equipment with
less than 10 % damping, if

    B = Δf_0.8 / f_c < 0.30                                                                    (1)

where Δf_0.8 is the width of the range around the peak in which the spectrum exceeds 0.8 P and f_c
the middle of this range. Regulatory Guide 1.122 knows no such reduction: whether it may be used is
for the owner of the project to say, and it is off unless asked for.

What is decided here where the rule is silent: a maximum inside the 0.8 P range of a higher one is
a part of that peak, and one whose own range holds a higher one is not reduced; a range that
reaches an end of the list has no known width and is not reduced; nothing is reduced below the
zero-period acceleration. The reduced peak is flat, the spectrum elsewhere is unchanged.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.spectra.frequency_list import FloatArray
from impactfem.spectra.interpolation import checked_frequency, checked_values
from impactfem.system.errors import ImpactfemError

REDUCTION = 0.15
BAND_LEVEL = 0.8
NARROW = 0.30
LARGEST_DAMPING = 0.10


@dataclass(frozen=True)
class ClippedPeak:
    """A peak that was reduced.

    Args:
        frequency: Of the peak [Hz].
        bandwidth: B of (1) [-].
        before: Its amplitude P, in the unit of the spectrum.
        after: What it was reduced to.
    """

    frequency: float
    bandwidth: float
    before: float
    after: float


def clip_peaks(
    frequency: npt.ArrayLike, values: npt.ArrayLike, zpa: float = 0.0
) -> tuple[FloatArray, FloatArray, tuple[ClippedPeak, ...]]:
    """Reduce the narrow peaks of one spectrum.

    Args:
        frequency: Ascending, shape (n_f,) [Hz].
        values: Ordinates, not negative, shape (n_f,).
        zpa: Zero-period acceleration, in the unit of the ordinates.

    Returns:
        Frequencies, with those added at which the reduced peaks are cut [Hz]; the ordinates there;
        the peaks, by frequency.

    Raises:
        ImpactfemError: The spectrum is not usable.
    """
    f = checked_frequency(frequency)
    s = checked_values(values, f.size)
    if s.ndim != 1:
        raise ImpactfemError(f"peaks are clipped one spectrum at a time, got shape {s.shape}")
    clipped = s.copy()
    added: list[tuple[float, float]] = []
    peaks: list[ClippedPeak] = []
    inner = np.arange(1, f.size - 1)
    maxima = inner[(s[1:-1] >= s[:-2]) & (s[1:-1] >= s[2:]) & (s[1:-1] > 0.0)]
    taken = np.zeros(f.size, dtype=bool)
    for k in map(int, maxima[np.argsort(-s[maxima], kind="stable")]):
        peak = float(s[k])
        inside = _range(s, k, BAND_LEVEL * peak)
        if taken[k] or inside is None or float(s[inside].max()) > peak:
            continue
        taken[inside] = True
        low, high = _edges(f, s, inside, BAND_LEVEL * peak)
        bandwidth = (high - low) / (0.5 * (high + low))
        level = max((1.0 - REDUCTION) * peak, zpa)
        cut = _range(s, k, level) if level < peak else None
        if bandwidth >= NARROW or cut is None:
            continue
        # Another summit of the same peak may be higher than the level, too.
        clipped[inside] = np.minimum(s[inside], level)
        added += _cuts(f, s, inside, level)
        peaks.append(ClippedPeak(float(f[k]), bandwidth, peak, level))
    frequencies = np.concatenate([f, [place for place, _ in added]])
    ordinates = np.concatenate([clipped, [level for _, level in added]])
    frequencies, unique = np.unique(frequencies, return_index=True)
    return frequencies, ordinates[unique], tuple(sorted(peaks, key=lambda one: one.frequency))


def _range(s: FloatArray, k: int, level: float) -> slice | None:
    """The listed frequencies around k with ordinates above a level; None at an end of the list."""
    below = np.flatnonzero(s <= level)
    left, right = below[below < k], below[below > k]
    return slice(int(left[-1]) + 1, int(right[0])) if left.size and right.size else None


def _edges(f: FloatArray, s: FloatArray, inside: slice, level: float) -> tuple[float, float]:
    """The frequencies at which the spectrum crosses the level, to either side of a range."""
    first, last = inside.start, inside.stop - 1
    return _crossing(f, s, first - 1, level), _crossing(f, s, last, level)


def _cuts(f: FloatArray, s: FloatArray, inside: slice, level: float) -> list[tuple[float, float]]:
    """All crossings of a level in a range, as frequencies and the level."""
    above = s[inside.start - 1 : inside.stop + 1] > level
    changes = np.flatnonzero(above[1:] != above[:-1]) + inside.start - 1
    return [(_crossing(f, s, int(k), level), level) for k in changes]


def _crossing(f: FloatArray, s: FloatArray, k: int, level: float) -> float:
    """Where the spectrum between f_k and f_k+1 is at the level, as it is interpolated."""
    a, b = float(s[k]), float(s[k + 1])
    logarithmic = a > 0.0 and b > 0.0
    weight = np.log(level / a) / np.log(b / a) if logarithmic else (level - a) / (b - a)
    return float(f[k] * (f[k + 1] / f[k]) ** weight)
