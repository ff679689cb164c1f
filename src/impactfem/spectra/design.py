"""From computed to design floor spectra: broadening, reduction of narrow peaks, rigid range.

The frequencies of a building are uncertain, and with them the frequencies at which the floors
amplify. Every ordinate S(f_0) of a computed spectrum is therefore taken for possible over the range
f_0 (1 - l) to f_0 (1 + u), and the design spectrum is the largest of what is possible,

    B(f) = max S(f_0),    f / (1 + u) <= f_0 <= f / (1 - l)                                    (1)

A peak at f_p becomes a plateau from f_p (1 - l) to f_p (1 + u). Its sides are those of the computed
peak, shifted by the factors 1 - l and 1 + u, that is, parallel to them on a logarithmic frequency
axis, as figure 1 of US NRC Regulatory Guide 1.122, revision 1 (1978), draws them. The guide gives
l = u = 0.15 where the uncertainty is not computed, and at least 0.10 where it is. Valleys between
plateaus that do not meet are left as they are.

S is a straight line on doubly logarithmic axes between its frequencies, and (1) is evaluated
exactly for it: the maximum stands at a listed frequency in the window or at one of its ends. The
window is cut at the ends of the list, beyond which nothing is known.

A narrow peak of a spectrum is reached only if the frequencies of building and equipment meet, and
broadening then keeps it over a wide range. ASCE 4-98, section 3.4.2.3, allows the amplitude P of
such a peak of the computed, not yet broadened spectrum to be reduced by 15 %, for equipment with
less than 10 % damping, if

    B = Δf_0.8 / f_c < 0.30                                                                    (2)

where Δf_0.8 is the width of the range around the peak in which the spectrum exceeds 0.8 P and f_c
the middle of this range. Regulatory Guide 1.122 knows no such reduction: whether it may be used is
for the owner of the project to say, and it is off by default.

What is decided here where the rule is silent: a maximum inside the 0.8 P range of a higher one is
a part of that peak, and one whose own range holds a higher one is not reduced; a range that
reaches an end of the list has no known width and is not reduced; nothing is reduced below the
zero-period acceleration. The reduced peak is flat, the spectrum elsewhere is unchanged.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.spectra.frequency_list import (
    SAME,
    checked_frequency,
    checked_values,
    interpolate_frequency,
    merged_frequencies,
)
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

Ratio = float | tuple[float, float]
"""How far peaks may lie off, of their frequency: l = u, or (l, u) [-]."""
LARGEST_LOSS = 1e-3  # what straight lines between the design frequencies may cut off (1)
LARGEST_GAIN = 2e-2  # what they may add to it at a bend


def broaden(
    frequency: npt.ArrayLike,
    values: npt.ArrayLike,
    ratio: Ratio = 0.15,
    wanted: npt.ArrayLike | None = None,
) -> Array:
    """Broaden spectra by (1).

    Args:
        frequency: Frequencies of the spectra, ascending, shape (n_f,) [Hz].
        values: Ordinates S, not negative, shape (..., n_f).
        ratio: l = u, or (l, u), 0 <= l < 1 and 0 <= u [-]; 0 changes nothing.
        wanted: Frequencies of the result, in the range of the list, shape (n,) [Hz]; the list
            itself when left out. Straight lines through the result at the list cut off the corners
            of plateaus: see :func:`corner_frequencies`.

    Gives B, shape (..., n).
    """
    lower, upper = sides(ratio)
    f = checked_frequency(frequency)
    s = checked_values(values, f.size)
    at = f if wanted is None else np.atleast_1d(np.asarray(wanted, dtype=np.float64))
    if np.any(at < f[0] * (1.0 - SAME)) or np.any(at > f[-1] * (1.0 + SAME)):
        raise ImpactfemError(
            f"a spectrum from {f[0]:g} Hz to {f[-1]:g} Hz can be broadened in this range only"
        )
    at = np.clip(at, f[0], f[-1])
    left = np.clip(at / (1.0 + upper), f[0], f[-1])
    right = np.clip(at / (1.0 - lower), f[0], f[-1])
    ends = np.maximum(interpolate_frequency(f, s, left), interpolate_frequency(f, s, right))
    first = np.searchsorted(f, left, side="left")
    last = np.searchsorted(f, right, side="right")
    # Pairs of first and last index: reduceat gives the maximum of each window, then of what is
    # between it and the next, which is dropped. It wants indices inside the array: one is added.
    padded = np.concatenate([s, np.zeros((*s.shape[:-1], 1))], axis=-1)
    pairs = np.stack([first, last], axis=1).ravel()
    inside = np.maximum.reduceat(padded, pairs, axis=-1)[..., ::2]
    return np.asarray(np.maximum(ends, np.where(last > first, inside, 0.0)))


def corner_frequencies(
    frequency: npt.ArrayLike,
    curves: Sequence[tuple[npt.ArrayLike, npt.ArrayLike]],
    ratio: Ratio = 0.15,
) -> Array:
    """Find the frequencies at which broadened spectra must be given in addition to their list.

    Plateaus begin and end between listed frequencies. Candidates are the frequencies of the spectra
    times 1 - l and 1 + u, where (1) has its bends; as many of them are taken as are needed for
    straight lines through the result to lie at the candidates, and so anywhere, no more than 0.1 %
    below (1), and at the candidates no more than 2 % above it. Bends at other places, where two
    sides cross, are such that a straight line lies above them.

    Args:
        frequency: The list, ascending, shape (n_f,) [Hz].
        curves: Spectra over the range of the list, at least one: for each its frequencies,
            ascending, shape (n_k,) [Hz], and its ordinates, not negative, shape (n_k,).
        ratio: As in :func:`broaden`.

    Gives the list and the corners, one list for all spectra, ascending, shape (n,) [Hz].
    """
    lower, upper = sides(ratio)
    f = checked_frequency(frequency)
    if not curves:
        raise ImpactfemError("no spectra were given")
    lists = [checked_frequency(f_k) for f_k, _ in curves]
    shifted = np.concatenate([f_k * side for f_k in lists for side in (1.0 - lower, 1.0 + upper)])
    shifted = shifted[(shifted > f[0]) & (shifted < f[-1])]
    if shifted.size == 0:
        return f
    candidates = merged_frequencies(shifted)
    after = np.clip(np.searchsorted(f, candidates), 1, f.size - 1)
    apart = np.minimum(np.abs(candidates - f[after]), np.abs(candidates - f[after - 1]))
    at = np.sort(np.concatenate([f, candidates[apart > SAME * candidates]]))
    exact = np.stack(
        [broaden(f_k, s, ratio, at) for f_k, (_, s) in zip(lists, curves, strict=True)]
    )
    taken = np.isin(at, f)
    while True:
        straight = interpolate_frequency(at[taken], exact[:, taken], at)
        excess = np.divide(straight, exact, out=np.ones_like(exact), where=exact > 0.0) - 1.0
        off = np.max(np.maximum(excess / LARGEST_GAIN, -excess / LARGEST_LOSS), axis=0)
        worst = np.where(taken, 0.0, off)
        if not np.any(worst > 1.0):
            return at[taken]
        # One in each gap at a time, the worst: what it mends needs no other.
        starts = np.flatnonzero(taken)
        largest = np.maximum.reduceat(worst, starts)
        taken |= (worst > 1.0) & (worst == np.repeat(largest, np.diff([*starts, at.size])))


def sides(ratio: Ratio) -> tuple[float, float]:
    """The l and u of a ratio, which is refused out of its range."""
    lower, upper = ratio if isinstance(ratio, tuple) else (ratio, ratio)
    if not (0.0 <= lower < 1.0 and 0.0 <= upper < np.inf):
        raise ImpactfemError(
            f"peaks are broadened by ratios of at least 0, the lower one below 1; got {ratio!r}"
        )
    return float(lower), float(upper)


GUIDE = 0.1
"""Least broadening of Regulatory Guide 1.122, where the uncertainty is computed."""


def broadening_words(ratio: Ratio) -> str:
    """How far peaks are broadened, in words."""
    both = sides(ratio)
    if not any(both):
        return "peaks not broadened"
    lower, upper = (f"{100.0 * side:g} %" for side in both)
    wide = f"±{lower}" if lower == upper else f"-{lower} and +{upper}"
    least = "" if min(both) >= GUIDE else f"less than the {100.0 * GUIDE:g} % of "
    return f"peaks broadened by {wide} ({least}Regulatory Guide 1.122)"


REDUCTION = 0.15
BAND_LEVEL = 0.8
NARROW = 0.30
LARGEST_DAMPING = 0.10


@dataclass(frozen=True)
class ClippedPeak:
    """A peak that was reduced."""

    frequency: float  #: of the peak [Hz]
    bandwidth: float  #: B of (2) [-]
    before: float  #: its amplitude P, in the unit of the spectrum
    after: float  #: what it was reduced to


def clip_peaks(
    frequency: npt.ArrayLike, values: npt.ArrayLike, zpa: float = 0.0
) -> tuple[Array, Array, tuple[ClippedPeak, ...]]:
    """Reduce the narrow peaks of one spectrum.

    Args:
        frequency: Ascending, shape (n_f,) [Hz].
        values: Ordinates, not negative, shape (n_f,).
        zpa: Zero-period acceleration, in the unit of the ordinates.

    Gives frequencies, with those added at which the reduced peaks are cut [Hz]; the ordinates
    there; the peaks, by frequency.
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
    # From the highest down: what lies in the range of a higher peak is a part of it.
    for k in map(int, maxima[np.argsort(-s[maxima], kind="stable")]):
        peak = float(s[k])
        inside = _range(s, k, BAND_LEVEL * peak)
        if taken[k] or inside is None or float(s[inside].max()) > peak:
            continue
        taken[inside] = True
        ends = (inside.start - 1, inside.stop - 1)
        low, high = (_crossing(f, s, end, BAND_LEVEL * peak) for end in ends)
        bandwidth = (high - low) / (0.5 * (high + low))
        level = max((1.0 - REDUCTION) * peak, zpa)
        cut = _range(s, k, level) if level < peak else None
        if bandwidth >= NARROW or cut is None:
            continue
        # Another summit of the same peak may be higher than the level, too.
        clipped[inside] = np.minimum(s[inside], level)
        above = s[inside.start - 1 : inside.stop + 1] > level
        changes = np.flatnonzero(above[1:] != above[:-1]) + inside.start - 1
        added += [(_crossing(f, s, int(c), level), level) for c in changes]
        peaks.append(ClippedPeak(float(f[k]), bandwidth, peak, level))
    frequencies = np.concatenate([f, [place for place, _ in added]])
    ordinates = np.concatenate([clipped, [level for _, level in added]])
    frequencies, unique = np.unique(frequencies, return_index=True)
    return frequencies, ordinates[unique], tuple(sorted(peaks, key=lambda peak: peak.frequency))


def _range(s: Array, k: int, level: float) -> slice | None:
    """The listed frequencies around k with ordinates above a level; None at an end of the list."""
    below = np.flatnonzero(s <= level)
    left, right = below[below < k], below[below > k]
    return slice(int(left[-1]) + 1, int(right[0])) if left.size and right.size else None


def _crossing(f: Array, s: Array, k: int, level: float) -> float:
    """Where the spectrum between f_k and f_k+1 is at the level, as it is interpolated."""
    a, b = float(s[k]), float(s[k + 1])
    logarithmic = a > 0.0 and b > 0.0
    weight = np.log(level / a) / np.log(b / a) if logarithmic else (level - a) / (b - a)
    return float(f[k] * (f[k + 1] / f[k]) ** weight)


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
) -> Array:
    """Find the listed frequency from which on spectra stay at the zero-period acceleration.

    Args:
        frequency: Ascending, shape (n_f,) [Hz].
        values: Ordinates S, not negative, shape (..., n_f).
        zpa: Zero-period acceleration a of each spectrum, shape (...), in the unit of the ordinates.
        tolerance: t > 0, how far the ordinates may be off: |S - a| <= t a [-].

    Gives the first frequency of the list from which on all are that near, shape (...) [Hz]; nan
    where the last one still is not: such a list ends too early.
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
