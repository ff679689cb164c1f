"""Lists of frequencies, and spectra between their frequencies and between their dampings.

A spectrum is a straight line on doubly logarithmic axes between two of its frequencies,

    log S(f) = log S_k + (log S_k+1 - log S_k) (log f - log f_k) / (log f_k+1 - log f_k)     (1)

and, between two dampings, log S is linear in the damping ratio ξ, which is what code_aster takes
for a family of spectra (test SDLD25),

    log S(f, ξ) = log S(f, ξ_j) + (log S(f, ξ_j+1) - log S(f, ξ_j)) (ξ - ξ_j) / (ξ_j+1 - ξ_j)  (2)

A spectrum that is zero has no logarithm: where an ordinate at either side is zero, S itself is
taken linear over the same abscissa. Nothing is extrapolated.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

RG_1_122_ENDS = 0.2, 3.0, 3.6, 5.0, 8.0, 15.0, 18.0, 22.0, 34.0
RG_1_122_INCREMENTS = 0.10, 0.15, 0.20, 0.25, 0.50, 1.0, 2.0, 3.0
"""Ends of the ranges, the lower one of the first included, and the increment in each [Hz]."""
SAME = 1e-9  # frequencies closer than this, relatively, are one


def logarithmic_frequencies(minimum: float, maximum: float, per_decade: int = 100) -> Array:
    """List frequencies that are equidistant on a logarithmic axis.

    They go from a positive minimum to a maximum [Hz]. There are at least so many intervals in each
    factor of ten; the spacing is shrunk a little so that both ends are in the list exactly. The
    list ascends, shape (n,) [Hz]; a range that is empty or not positive, or has no points, is
    refused.
    """
    if not (math.isfinite(minimum) and math.isfinite(maximum) and 0.0 < minimum < maximum):
        raise ImpactfemError(
            f"a frequency list needs 0 < minimum < maximum, got {minimum!r} Hz and {maximum!r} Hz"
        )
    if per_decade < 1:
        raise ImpactfemError(f"a frequency list needs at least 1 point a decade, got {per_decade}")
    # The small allowance keeps 1 Hz to 100 Hz at 100 a decade at 200 intervals, not 201.
    intervals = max(1, math.ceil(per_decade * math.log10(maximum / minimum) - 1e-9))
    return np.asarray(np.geomspace(minimum, maximum, intervals + 1), dtype=np.float64)


def rg_1_122_frequencies(maximum: float | None = None, per_decade: int = 100) -> Array:
    """List the frequencies of Regulatory Guide 1.122, and go on above them on request.

    The 75 frequencies of US NRC Regulatory Guide 1.122, revision 1 (1978), table 1, which ASME III,
    appendix N, table N-1226-1 repeats, run from 0.2 Hz to 34 Hz: an earthquake has nothing above.
    Impacts do, so the list can be continued up to a maximum [Hz], which must be above 34 Hz, with
    at least so many logarithmic intervals in a decade. It ascends, shape (n,) [Hz].
    """
    ranges = [
        start + increment * np.arange(round((end - start) / increment))
        for (start, end), increment in zip(
            pairwise(RG_1_122_ENDS), RG_1_122_INCREMENTS, strict=True
        )
    ]
    last = RG_1_122_ENDS[-1]
    # Decimal values: rounding takes away what the multiples of 0.1 leave in the last digits.
    listed: Array = np.round(np.append(np.concatenate(ranges), last), 6)
    if maximum is None:
        return listed
    if not maximum > last:
        raise ImpactfemError(
            f"the list of Regulatory Guide 1.122 ends at {last:g} Hz; "
            f"it cannot be continued up to {maximum!r} Hz"
        )
    return np.append(listed, logarithmic_frequencies(last, maximum, per_decade)[1:])


def merged_frequencies(*lists: npt.ArrayLike) -> Array:
    """Merge lists of frequencies in any order [Hz]; equal ones, to 1e-9, are taken once.

    The list ascends, shape (n,) [Hz]; none, or one that is not positive and finite, is refused.
    """
    parts = [np.atleast_1d(np.asarray(part, dtype=np.float64)).ravel() for part in lists]
    f = np.sort(np.concatenate(parts)) if parts else np.empty(0)
    if f.size == 0 or not np.all(np.isfinite(f) & (f > 0.0)):
        raise ImpactfemError("frequencies must be positive finite numbers in Hz, at least one")
    return np.asarray(f[np.concatenate([[True], np.diff(f) > SAME * f[1:]])])


def interpolate_frequency(
    frequency: npt.ArrayLike, values: npt.ArrayLike, wanted: npt.ArrayLike
) -> Array:
    """Interpolate spectra by (1).

    Args:
        frequency: f_k, ascending, shape (n_f,) [Hz].
        values: Ordinates S_k, finite and not negative, shape (..., n_f), in any unit.
        wanted: Frequencies in the range of the list, shape (n,) [Hz]; others are refused.

    Gives ordinates of the shape (..., n).
    """
    f = checked_frequency(frequency)
    s = checked_values(values, f.size)
    at = np.atleast_1d(np.asarray(wanted, dtype=np.float64))
    # Products such as f (1 + d) / (1 + d) miss the end of a list by their last digit.
    inside = (at >= f[0] * (1.0 - SAME)) & (at <= f[-1] * (1.0 + SAME))
    if at.size == 0 or not np.all(inside):
        outside = at[~inside]
        named = f"{outside[0]:g} Hz" if outside.size else "no frequency"
        raise ImpactfemError(
            f"the spectrum is known from {f[0]:g} Hz to {f[-1]:g} Hz; {named} was requested"
        )
    at = np.clip(at, f[0], f[-1])
    if f.size == 1:
        return np.repeat(s, at.size, axis=-1)
    k = np.clip(np.searchsorted(f, at, side="right") - 1, 0, f.size - 2)
    weight = np.log(at / f[k]) / np.log(f[k + 1] / f[k])
    return _blend(s[..., k], s[..., k + 1], weight)


def interpolate_damping(
    damping: npt.ArrayLike, values: npt.ArrayLike, wanted: npt.ArrayLike
) -> Array:
    """Interpolate a family of spectra by (2), one damping for each of its frequencies.

    Args:
        damping: ξ_j, ascending, shape (n_d,) [-].
        values: Ordinates, not negative, shape (n_d, n).
        wanted: Damping ratio at each of the n abscissae, within the family's, shape (n,) or ().

    Gives ordinates of the shape (n,).
    """
    xi = np.atleast_1d(np.asarray(damping, dtype=np.float64))
    if xi.ndim != 1 or not np.all(np.diff(xi) > 0.0) or not np.all((xi >= 0.0) & (xi < 1.0)):
        raise ImpactfemError("damping ratios must ascend, with 0 <= ratio < 1")
    s = np.asarray(values, dtype=np.float64)
    if s.ndim != 2 or s.shape[0] != xi.size:
        raise ImpactfemError(
            f"spectra at {xi.size} dampings must have shape (dampings, frequencies), got {s.shape}"
        )
    s = checked_values(s, s.shape[1])
    at = np.broadcast_to(np.asarray(wanted, dtype=np.float64), s.shape[1:])
    outside = ~((at >= xi[0] - SAME) & (at <= xi[-1] + SAME))
    if np.any(outside):
        raise ImpactfemError(
            f"the spectra are known for dampings from {xi[0]:g} to {xi[-1]:g}; "
            f"{at[outside][0]:g} was requested"
        )
    if xi.size == 1:
        return np.array(s[0])
    j = np.clip(np.searchsorted(xi, at, side="right") - 1, 0, xi.size - 2)
    column = np.arange(s.shape[1])
    weight = np.clip((at - xi[j]) / (xi[j + 1] - xi[j]), 0.0, 1.0)
    return _blend(s[j, column], s[j + 1, column], weight)


def at_common_frequencies(
    curves: Sequence[tuple[npt.ArrayLike, npt.ArrayLike]],
) -> tuple[Array, Array]:
    """Bring spectra on different lists to one list.

    Args:
        curves: For each, its frequencies, shape (n_k,) [Hz], and ordinates, shape (..., n_k), the
            leading axes alike.

    Gives all frequencies of all lists in the range that the lists share, shape (n,) [Hz], and the
    ordinates there by (1), shape (number of curves, ..., n). Without a curve, or a shared range,
    they are refused.
    """
    if not curves:
        raise ImpactfemError("no spectra were given")
    lists = [checked_frequency(frequency) for frequency, _ in curves]
    low, high = max(f[0] for f in lists), min(f[-1] for f in lists)
    if low > high:
        raise ImpactfemError("the spectra share no range of frequencies")
    merged = merged_frequencies(*lists)
    common = merged[(merged >= low * (1.0 - SAME)) & (merged <= high * (1.0 + SAME))]
    values = [interpolate_frequency(f, s, common) for f, (_, s) in zip(lists, curves, strict=True)]
    if len({part.shape for part in values}) > 1:
        raise ImpactfemError("spectra that are brought together need the same leading axes")
    return common, np.stack(values)


def checked_frequency(frequency: npt.ArrayLike) -> Array:
    """A list of frequencies [Hz] as an array; refused unless positive and ascending."""
    f = np.atleast_1d(np.asarray(frequency, dtype=np.float64))
    good = f.ndim == 1 and f.size > 0 and np.all(np.isfinite(f)) and f[0] > 0.0
    if not good or not np.all(np.diff(f) > 0.0):
        raise ImpactfemError("frequencies must be positive, finite and ascending, in Hz")
    return f


def checked_values(values: npt.ArrayLike, count: int) -> Array:
    """Ordinates as an array; refused unless `count` in a row, finite, not negative."""
    s = np.asarray(values, dtype=np.float64)
    if s.ndim == 0 or s.shape[-1] != count:
        raise ImpactfemError(
            f"a spectrum at {count} frequencies needs as many ordinates, got shape {s.shape}"
        )
    if not np.all(np.isfinite(s) & (s >= 0.0)):
        raise ImpactfemError("the ordinates of a spectrum must be finite and not negative")
    return s


def _blend(left: Array, right: Array, weight: Array) -> Array:
    """Blend linearly in the logarithm, or in the value where one of the two is zero."""
    positive = (left > 0.0) & (right > 0.0)
    safe_left, safe_right = np.where(positive, left, 1.0), np.where(positive, right, 1.0)
    blended = safe_left * (safe_right / safe_left) ** weight
    return np.where(positive, blended, left + (right - left) * weight)
