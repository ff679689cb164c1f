"""Envelope, mean and fractiles of spectra over named axes: points, floors, motions.

All spectra of an array stand at the same frequencies; lists that differ are brought together by
:func:`impactfem.spectra.interpolation.at_common_frequencies` first. Statistics are taken frequency
by frequency.

Two kinds of fractiles are offered. "empirical" sorts the n values and interpolates linearly
between them at the positions

    p_k = (k - 1/2) / n                                                                        (1)

(Hazen; number 5 of Hyndman and Fan, The American Statistician 50 (1996) 361-365), which makes no
assumption about the distribution, is symmetric, and gives the largest value from p = 1 - 1/(2n)
on: n motions say nothing about rarer ones. "lognormal" takes

    S_p = exp(m + z(p) s)                                                                      (2)

with the mean m and the standard deviation s (divisor n - 1) of log S and the standard normal
quantile z(p); right where the amplification is a product of many factors, and smoother for few
motions, but not where impacts happen in some motions and not in others.
"""

from __future__ import annotations

from collections.abc import Sequence
from statistics import NormalDist
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from impactfem.spectra.frequency_list import FloatArray
from impactfem.system.errors import ImpactfemError

FractileMethod = Literal["empirical", "lognormal"]
Statistic = Literal["envelope", "mean"] | float
"""A statistic by name, or the probability of a fractile: 0.5 is the median."""


def envelope(values: npt.ArrayLike, axes: Sequence[str], over: Sequence[str]) -> FloatArray:
    """Take the largest value over some axes.

    Args:
        values: Spectra, any shape.
        axes: Name of each axis of them.
        over: Names of the axes that disappear.

    Returns:
        The other axes in their order.

    Raises:
        ImpactfemError: The names do not fit the array, or an axis to be taken is unknown.
    """
    array, numbers = _named(values, axes, over)
    return np.asarray(array.max(axis=numbers))


def mean(values: npt.ArrayLike, axes: Sequence[str], over: Sequence[str]) -> FloatArray:
    """Take the arithmetic mean over some axes; arguments as :func:`envelope`."""
    array, numbers = _named(values, axes, over)
    return np.asarray(array.mean(axis=numbers))


def fractile(
    values: npt.ArrayLike,
    axes: Sequence[str],
    over: Sequence[str],
    probability: float,
    method: FractileMethod = "empirical",
) -> FloatArray:
    """Take a fractile over some axes by (1) or (2).

    Args:
        values: Spectra, any shape.
        axes: Name of each axis of them.
        over: Names of the axes that disappear; their values count as one sample.
        probability: p, 0 < p < 1 [-]; 0.5 is the median.
        method: See above.

    Returns:
        The other axes in their order.

    Raises:
        ImpactfemError: The names do not fit, the probability or the method is unknown, or a
            lognormal fractile is asked of fewer than two values or of values that are not positive.
    """
    if not 0.0 < probability < 1.0:
        raise ImpactfemError(f"a fractile needs a probability between 0 and 1, got {probability!r}")
    if method not in get_args(FractileMethod):
        raise ImpactfemError(f"fractiles are one of {get_args(FractileMethod)}, got {method!r}")
    array, numbers = _named(values, axes, over)
    if method == "empirical":
        return np.asarray(np.quantile(array, probability, axis=numbers, method="hazen"))
    count = int(np.prod([array.shape[number] for number in numbers]))
    if count < 2 or not np.all(array > 0.0):
        raise ImpactfemError(
            "a lognormal fractile needs at least two values, all of them above zero"
        )
    logs = np.log(array)
    z = NormalDist().inv_cdf(probability)
    return np.asarray(np.exp(logs.mean(axis=numbers) + z * logs.std(axis=numbers, ddof=1)))


def combine(
    values: npt.ArrayLike, axes: Sequence[str], over: Sequence[str], statistic: Statistic
) -> FloatArray:
    """Take a statistic by its name, or an empirical fractile by its probability.

    Args:
        values: Spectra, any shape.
        axes: Name of each axis of them.
        over: Names of the axes that disappear.
        statistic: "envelope", "mean" or a probability.

    Raises:
        ImpactfemError: The names do not fit, or there is no such statistic.
    """
    if not isinstance(statistic, str):
        return fractile(values, axes, over, statistic)
    named = {"envelope": envelope, "mean": mean}
    if statistic not in named:
        raise ImpactfemError(
            f"a statistic is 'envelope', 'mean' or the probability of a fractile, got {statistic!r}"
        )
    return named[statistic](values, axes, over)


def statistic_words(statistic: Statistic) -> str:
    """A statistic in words, for labels."""
    if isinstance(statistic, str):
        return statistic
    return "median" if statistic == 0.5 else f"{100.0 * statistic:g} % fractile"


def _named(
    values: npt.ArrayLike, axes: Sequence[str], over: Sequence[str]
) -> tuple[FloatArray, tuple[int, ...]]:
    array = np.asarray(values, dtype=np.float64)
    if len(axes) != array.ndim or len(set(axes)) != len(axes):
        raise ImpactfemError(
            f"an array of shape {array.shape} cannot have the axes {', '.join(axes)}"
        )
    unknown = [name for name in over if name not in axes]
    if unknown or not over or isinstance(over, str) or len(set(over)) != len(over):
        raise ImpactfemError(
            f"cannot take statistics over {', '.join(unknown) or repr(over)}; the axes are "
            f"{', '.join(axes)}"
        )
    numbers = tuple(axes.index(name) for name in over)
    if any(array.shape[number] == 0 for number in numbers):
        raise ImpactfemError(f"there is no spectrum over {', '.join(over)}")
    return array, numbers
