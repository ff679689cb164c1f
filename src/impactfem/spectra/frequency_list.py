"""Lists of frequencies at which spectra are computed."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from impactfem.system.errors import ImpactfemError

FloatArray = npt.NDArray[np.float64]

RG_1_122_INTERVALS: tuple[tuple[float, float], ...] = (
    (3.0, 0.10),
    (3.6, 0.15),
    (5.0, 0.20),
    (8.0, 0.25),
    (15.0, 0.50),
    (18.0, 1.0),
    (22.0, 2.0),
    (34.0, 3.0),
)
"""Upper end of each range [Hz] and the increment in it [Hz]; the first range begins at 0.2 Hz."""
RG_1_122_START = 0.2
SAME = 1e-9  # frequencies closer than this, relatively, are one


def logarithmic_frequencies(minimum: float, maximum: float, per_decade: int = 100) -> FloatArray:
    """List frequencies that are equidistant on a logarithmic axis.

    Args:
        minimum: First frequency [Hz], positive.
        maximum: Last frequency [Hz], above the minimum.
        per_decade: At least so many intervals in each factor of ten [-]. The spacing is shrunk a
            little so that both ends are in the list exactly.

    Returns:
        Frequencies, ascending, shape (n,) [Hz].

    Raises:
        ImpactfemError: The range is empty or not positive, or there are no points in it.
    """
    if not (math.isfinite(minimum) and math.isfinite(maximum) and 0.0 < minimum < maximum):
        raise ImpactfemError(
            f"a frequency list needs 0 < minimum < maximum, got {minimum!r} Hz and {maximum!r} Hz"
        )
    if per_decade < 1:
        raise ImpactfemError(f"a frequency list needs at least 1 point a decade, got {per_decade}")
    # The small allowance keeps 1 Hz to 100 Hz at 100 a decade at 200 intervals, not 201.
    intervals = max(1, math.ceil(per_decade * math.log10(maximum / minimum) - 1e-9))
    frequencies = np.geomspace(minimum, maximum, intervals + 1)
    frequencies[0], frequencies[-1] = minimum, maximum
    return np.asarray(frequencies, dtype=np.float64)


def rg_1_122_frequencies(maximum: float | None = None, per_decade: int = 100) -> FloatArray:
    """List the frequencies of Regulatory Guide 1.122, and go on above them if asked.

    The 75 frequencies of US NRC Regulatory Guide 1.122, revision 1 (1978), table 1, which ASME
    III, appendix N, table N-1226-1 repeats, run from 0.2 Hz to 34 Hz: an earthquake has nothing
    above. Impacts do, so the list can be continued on a logarithmic axis.

    Args:
        maximum: Last frequency of the continuation [Hz], above 34 Hz; none when left out.
        per_decade: Least number of intervals in a decade of the continuation [-].

    Returns:
        Frequencies, ascending, shape (n,) [Hz].

    Raises:
        ImpactfemError: The maximum is not above 34 Hz, or there are no points in a decade.
    """
    ranges = []
    start = RG_1_122_START
    for end, increment in RG_1_122_INTERVALS:
        count = round((end - start) / increment)
        # Decimal values: rounding takes away what the multiples of 0.1 leave in the last digits.
        ranges.append(np.round(start + increment * np.arange(count), 6))
        start = end
    listed = np.append(np.concatenate(ranges), start)
    if maximum is None:
        return listed
    if not maximum > start:
        raise ImpactfemError(
            f"the list of Regulatory Guide 1.122 ends at {start:g} Hz; "
            f"it cannot be continued up to {maximum!r} Hz"
        )
    return np.append(listed, logarithmic_frequencies(start, maximum, per_decade)[1:])


def structural_frequencies(frequencies: npt.ArrayLike, spread: float = 0.0) -> FloatArray:
    """List frequencies of a structure for a spectrum, with the ends of their uncertainty.

    The peaks of a floor spectrum stand at the structure's frequencies; a fixed list may pass them
    by. Regulatory Guide 1.122 therefore asks for them beside the list.

    Args:
        frequencies: Natural frequencies f, shape (n,) [Hz], in any order.
        spread: s, adds f (1 - s) and f (1 + s), 0 <= s < 1 [-]; 0 adds nothing.

    Returns:
        Ascending, without repetitions [Hz].

    Raises:
        ImpactfemError: A frequency is not positive and finite, or the spread is out of range.
    """
    if not 0.0 <= spread < 1.0:
        raise ImpactfemError(f"the spread must be at least 0 and below 1, got {spread!r}")
    f = np.atleast_1d(np.asarray(frequencies, dtype=np.float64))
    return merged_frequencies(f, f * (1.0 - spread), f * (1.0 + spread))


def merged_frequencies(*lists: npt.ArrayLike) -> FloatArray:
    """Merge lists of frequencies into one.

    Args:
        lists: Frequencies in any order [Hz]; equal ones, to 1e-9, are kept once.

    Returns:
        Ascending, shape (n,) [Hz].

    Raises:
        ImpactfemError: There is no frequency, or one is not positive and finite.
    """
    parts = [np.atleast_1d(np.asarray(one, dtype=np.float64)).ravel() for one in lists]
    f = np.sort(np.concatenate(parts)) if parts else np.empty(0)
    if f.size == 0 or not np.all(np.isfinite(f) & (f > 0.0)):
        raise ImpactfemError("frequencies must be positive finite numbers in Hz, at least one")
    kept = np.concatenate([[True], np.diff(f) > SAME * f[1:]])
    return np.asarray(f[kept], dtype=np.float64)
