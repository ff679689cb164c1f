"""Statistics of spectra over the motions of an ensemble, frequency by frequency.

All spectra of an array stand at the same frequencies; lists that differ are brought together by
:func:`impactfem.spectra.frequency_list.at_common_frequencies` first.

Two kinds of fractiles are offered. "empirical" sorts the n values and interpolates linearly
between them at the positions

    p_k = (k - 1/2) / n                                                                        (1)

(Hazen; number 5 of Hyndman and Fan, The American Statistician 50 (1996) 361-365), which makes no
assumption about the distribution, is symmetric, and gives the largest value from p = 1 - 1/(2n)
on: n motions say nothing about rarer ones. "lognormal" takes

    S_p = exp(m + z(p) s)                                                                      (2)

with the mean m and the standard deviation s (divisor n - 1) of log S and the standard normal
quantile z(p), as codes and fragility analyses do; right where the amplification is a product of
many factors, and smoother for few motions, but not where impacts happen in some motions and not in
others.
"""

from statistics import NormalDist
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

FractileMethod = Literal["empirical", "lognormal"]
Statistic = Literal["envelope", "mean"] | float
"""A statistic by name, or the probability of an empirical fractile: 0.5 is the median."""

STATISTICS = {
    "median": "median",
    "mean": "mean",
    "p84": "84 % fractile",
    "p84_lognormal": "lognormal 84 % fractile",
}
"""Names of the statistics of an ensemble, and what they are in words."""
P84 = 0.84


def fractile(
    values: npt.ArrayLike, probability: float, method: FractileMethod = "empirical"
) -> Array:
    """Take a fractile over the first axis of values, shape (n, ...), n >= 1, by (1) or (2).

    Its probability p is between 0 and 1 [-], 0.5 the median. A lognormal fractile needs two values
    at least, all above zero. The result has shape (...).
    """
    if not 0.0 < probability < 1.0:
        raise ImpactfemError(f"a fractile needs a probability between 0 and 1, got {probability!r}")
    if method not in get_args(FractileMethod):
        raise ImpactfemError(f"fractiles are one of {get_args(FractileMethod)}, got {method!r}")
    array = _sample(values)
    if method == "empirical":
        return np.asarray(np.quantile(array, probability, axis=0, method="hazen"))
    if array.shape[0] < 2 or not np.all(array > 0.0):
        raise ImpactfemError(
            "a lognormal fractile needs at least two values, all of them above zero"
        )
    logs = np.log(array)
    z = NormalDist().inv_cdf(probability)
    return np.asarray(np.exp(logs.mean(axis=0) + z * logs.std(axis=0, ddof=1)))


def combine(values: npt.ArrayLike, statistic: Statistic) -> Array:
    """Envelope, mean or empirical fractile over the first axis, shape (n, ...), n >= 1."""
    if not isinstance(statistic, str):
        return fractile(values, statistic)
    if statistic not in {"envelope", "mean"}:
        raise ImpactfemError(
            f"a statistic is 'envelope', 'mean' or the probability of a fractile, got {statistic!r}"
        )
    array = _sample(values)
    return np.asarray(array.max(axis=0) if statistic == "envelope" else array.mean(axis=0))


def over_members(values: npt.ArrayLike, name: str) -> Array:
    """Take a statistic of an ensemble, one of `STATISTICS`, over the first axis.

    The values have shape (n_members, ...) and are above zero for "p84_lognormal"; an unknown name
    is refused.
    """
    if name == "p84_lognormal":
        return fractile(values, P84, "lognormal")
    named: dict[str, Statistic] = {"mean": "mean", "median": 0.5, "p84": P84}
    if name not in named:
        raise ImpactfemError(
            f"a statistic over members is one of {', '.join(STATISTICS)}, got {name}"
        )
    return combine(values, named[name])


def _sample(values: npt.ArrayLike) -> Array:
    """Values over the first axis, at least one."""
    array = np.atleast_1d(np.asarray(values, dtype=np.float64))
    if array.shape[0] == 0:
        raise ImpactfemError("a statistic needs at least one value")
    return array


def statistic_words(statistic: Statistic) -> str:
    """A statistic in words, for labels."""
    if isinstance(statistic, str):
        return statistic
    return "median" if statistic == 0.5 else f"{100.0 * statistic:g} % fractile"
