"""Checks of a stage: a sentence each, and whether it is met."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from impactfem.spectra.design import ENDED
from impactfem.system.log import LOGGER

Check = tuple[bool | None, str]
"""Whether it is met, None for a number without a limit, and the sentence with number and limit."""


def end_check(
    stage: str, points: Sequence[str], axes: Sequence[str], ratio: NDArray[np.float64], last: float
) -> Check:
    """Whether spectra have come down, or up, to the peak acceleration at their last frequency.

    Args:
        stage: Name of the stage.
        points: Names of the points.
        axes: Names of the directions.
        ratio: Last ordinate over the peak acceleration, shape (n_points, n_axes) [-]; nan where a
            point is at rest.
        last: The last frequency [Hz].
    """
    if not np.isfinite(ratio).any():
        return None, f"{stage}: no point moves"
    off = np.nan_to_num(np.abs(np.log(ratio)))
    k, c = (int(one) for one in np.unravel_index(int(off.argmax()), off.shape))
    text = (
        f"{stage}: spectra at {last:.4g} Hz are {ratio[k, c]:.3g} times the peak acceleration "
        f"where they are farthest from it ({points[k]}, {axes[c]}) (limit {ENDED:g})"
    )
    late = np.flatnonzero((off > np.log(ENDED)).any(axis=1))
    if not late.size:
        return True, text
    return False, (
        f"{text}; at {late.size} of {len(points)} points they have not ended there, and what the "
        "motion has above may depend on the time step"
    )


def log_checks(checks: Iterable[Check]) -> None:
    """Log checks: those that are not met as warnings, all others in detail."""
    for good, line in checks:
        if good is False:
            LOGGER.warning("warning: %s", line)
        else:
            LOGGER.debug("%s", line)
