"""The statistics over the members of an ensemble that design asks for, by name.

The empirical 84 % fractile assumes nothing of the distribution, and cannot say more than the
members do; the lognormal one is what codes and fragility analyses take, the median times exp(s)
with the standard deviation s of the logarithms (see :mod:`impactfem.spectra.statistics`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from impactfem.spectra.frequency_list import FloatArray
from impactfem.spectra.product import FloorSpectrumSet
from impactfem.spectra.statistics import fractile, mean
from impactfem.system.errors import ImpactfemError

STATISTICS = {
    "median": "median",
    "mean": "mean",
    "p84": "84 % fractile",
    "p84_lognormal": "lognormal 84 % fractile",
}
"""Names of the statistics, and what they are in words."""
P84 = 0.84


def over_members(values: npt.ArrayLike, name: str) -> FloatArray:
    """Take a statistic over the members.

    Args:
        values: Shape (n_members, ...); above zero for "p84_lognormal".
        name: One of STATISTICS.

    Returns:
        Shape (...).

    Raises:
        ImpactfemError: There is no such statistic, or it cannot be taken of these values.
    """
    array = np.asarray(values, dtype=np.float64)
    axes = ["member", *(str(number) for number in range(1, array.ndim))]
    over = ["member"]
    if name == "mean":
        return mean(array, axes, over)
    if name == "median":
        return fractile(array, axes, over, 0.5)
    if name == "p84":
        return fractile(array, axes, over, P84)
    if name == "p84_lognormal":
        return fractile(array, axes, over, P84, "lognormal")
    raise ImpactfemError(f"a statistic over members is one of {', '.join(STATISTICS)}, got {name}")


def statistic_set(members: FloorSpectrumSet, name: str) -> FloorSpectrumSet:
    """The spectra of an ensemble with a statistic in place of its motions.

    Args:
        members: The spectra of all motions.
        name: One of STATISTICS.

    Raises:
        ImpactfemError: As of :func:`over_members`.
    """
    words = f"{STATISTICS[name]} of {len(members.motions)} motions"
    return replace(
        members,
        psa=over_members(members.psa, name)[None],
        zpa=over_members(members.zpa, name)[None],
        motions=(words,),
        over=words,
    )
