"""Peak broadening of floor response spectra.

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
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from impactfem.spectra.frequency_list import SAME, FloatArray, merged_frequencies
from impactfem.spectra.interpolation import (
    checked_frequency,
    checked_values,
    interpolate_frequency,
)
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
) -> FloatArray:
    """Broaden spectra by (1).

    Args:
        frequency: Frequencies of the spectra, ascending, shape (n_f,) [Hz].
        values: Ordinates S, not negative, shape (..., n_f).
        ratio: l = u, or (l, u), 0 <= l < 1 and 0 <= u [-]; 0 changes nothing.
        wanted: Frequencies of the result, in the range of the list, shape (n,) [Hz]; the list
            itself when left out. Straight lines through the result at the list cut off the corners
            of plateaus: see :func:`corner_frequencies`.

    Returns:
        B, shape (..., n).

    Raises:
        ImpactfemError: The spectra, the ratio or the wanted frequencies are not usable.
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
) -> FloatArray:
    """Find the frequencies at which broadened spectra must be given beside their list.

    Plateaus begin and end between listed frequencies. Candidates are the frequencies of the spectra
    times 1 - l and 1 + u, where (1) has its bends; as many of them are taken as are needed for
    straight lines through the result to lie at the candidates, and so anywhere, no more than 0.1 %
    below (1), and at the candidates no more than 2 % above it. Bends at other places, where two
    sides cross, are such that a straight line lies above them.

    Args:
        frequency: The list, ascending, shape (n_f,) [Hz].
        curves: Spectra over the range of the list: for each its frequencies, ascending, shape
            (n_k,) [Hz], and its ordinates, not negative, shape (n_k,).
        ratio: As in :func:`broaden`.

    Returns:
        The list and the corners, one list for all spectra, ascending, shape (n,) [Hz].

    Raises:
        ImpactfemError: The list, a spectrum or the ratio is not usable.
    """
    lower, upper = sides(ratio)
    f = checked_frequency(frequency)
    if not curves:
        raise ImpactfemError("no spectra were given")
    lists = [checked_frequency(one) for one, _ in curves]
    shifted = np.concatenate([one * side for one in lists for side in (1.0 - lower, 1.0 + upper)])
    shifted = shifted[(shifted > f[0]) & (shifted < f[-1])]
    if shifted.size == 0:
        return f
    candidates = merged_frequencies(shifted)
    after = np.clip(np.searchsorted(f, candidates), 1, f.size - 1)
    apart = np.minimum(np.abs(candidates - f[after]), np.abs(candidates - f[after - 1]))
    at = np.sort(np.concatenate([f, candidates[apart > SAME * candidates]]))
    exact = np.stack(
        [broaden(one, s, ratio, at) for one, (_, s) in zip(lists, curves, strict=True)]
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
    """Give l and u of a ratio.

    Raises:
        ImpactfemError: It is out of range.
    """
    lower, upper = ratio if isinstance(ratio, tuple) else (ratio, ratio)
    if not (0.0 <= lower < 1.0 and 0.0 <= upper < np.inf):
        raise ImpactfemError(
            f"peaks are broadened by ratios of at least 0, the lower one below 1; got {ratio!r}"
        )
    return float(lower), float(upper)
