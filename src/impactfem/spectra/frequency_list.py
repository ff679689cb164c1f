"""Lists of frequencies at which spectra are computed."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from impactfem.errors import ImpactfemError


def logarithmic_frequencies(
    minimum: float, maximum: float, per_decade: int = 100
) -> npt.NDArray[np.float64]:
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
