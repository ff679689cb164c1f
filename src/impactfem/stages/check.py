"""Checks of a stage: whether each is met, and a line with its quantity, value and limit."""

from collections.abc import Iterable, Sequence

import numpy as np

from impactfem.spectra.design import ENDED
from impactfem.system.arrays import Array
from impactfem.system.log import LOGGER

QUIET = 0.01
"""Peak acceleration over the largest one along the same axis up to which a point is at rest."""
HALVED = 0.05
"""Change of the largest force, and ordinate of floor spectra, with half of the points of contact or
steps twice as long."""

POINTS = 10.0
"""Least number of time steps in a cycle of a resolved frequency: a peak between two samples is then
at most 4.9 % higher."""

Check = tuple[bool | None, str]
"""Whether it is met, None for a number without a limit, and the line with number and limit."""


def limited(
    quantity: str, value: float, limit: float, unit: str = "", *, least: bool = False
) -> Check:
    """The check of a value that has a limit: `quantity value unit (limit 5 unit)`.

    The quantity begins with the name of its stage; a value that is nan is not met. The unit "%",
    alone or with the whole that it is of, is for parts of one; the limit may be the `least` value.
    """
    percent = unit.startswith("%")
    scale, short = (100.0, " %") if percent else (1.0, f" {unit}" if unit else "")
    behind = f" {unit}" if unit else ""
    met = bool(value >= limit if least else value <= limit)
    number, bound = digits(scale * value), digits(scale * limit)
    if not met and number == bound:
        number = f"{scale * value:.6g}"  # just beyond it, and not "5 % (limit 5 %)"
    word = "at least" if least else "limit"
    return met, f"{quantity} {number}{behind} ({word} {bound}{short})"


def resolved_frequency(time_step: float, highest: float) -> float:
    """Return the frequency up to which a time step and a model resolve spectra [Hz].

    Args:
        time_step: Step of the histories [s].
        highest: Highest frequency of the model and of the oscillators [Hz].
    """
    return min(highest, 1.0 / (POINTS * time_step))


def digits(value: float) -> str:
    """A number in three digits, a small one in two with its power of ten: 15.7, 8.9e-16."""
    if 0.0 < abs(value) < 1e-3:
        mantissa, _, power = f"{value:.1e}".partition("e")
        return f"{mantissa.removesuffix('.0')}e{int(power)}"
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


def end_check(
    stage: str,
    points: Sequence[str],
    axes: Sequence[str],
    ratio: Array,
    last: float,
    *,
    jumps: bool = True,
) -> Check:
    """Whether spectra have come down, or up, to the peak acceleration at their last frequency [Hz].

    By the ratio of the last ordinate to the peak acceleration, shape (n_points, n_axes) [-]; nan
    where a point is at rest. `jumps` says whether a force may begin with a jump.
    """
    if not np.isfinite(ratio).any():
        return None, f"{stage}: no point moves"
    off = np.nan_to_num(np.abs(np.log(ratio)))
    k, c = (int(one) for one in np.unravel_index(int(off.argmax()), off.shape))
    text = (
        f"{stage}: spectra at {last:.4g} Hz over the peak acceleration {ratio[k, c]:.3g} "
        f"(limit {ENDED:g} or 1/{ENDED:g}) at {points[k]}, {axes[c]}"
    )
    late = np.flatnonzero((off > np.log(ENDED)).any(axis=1))
    if not late.size:
        return True, text
    text += (
        f"; so it is at {late.size} of {len(points)} points: raise the highest frequency of "
        "[spectra]"
    )
    if jumps:
        text += (
            "; under a law whose force begins with a jump (kelvin-voigt) they may end nowhere, and "
            "what is there depends on the time step"
        )
    return False, text


def log_checks(checks: Iterable[Check]) -> None:
    """Log checks: those that are not met as warnings, all others in detail."""
    for good, line in checks:
        if good is False:
            LOGGER.warning("warning: %s", line)
        else:
            LOGGER.debug("%s", line)
