"""Bounded least squares from several starts, and what the data say about each unknown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.optimize
import scipy.sparse.csgraph
import scipy.stats

from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError

CONFIDENCE = 0.95
"""With this probability all unknowns together are within their ± (Gaussian errors)."""
BLIND = 1.0
"""A direction that moves the weighted data by less than this across the bounds is not seen."""
SHARED = 0.09  # part of a direction's square from which an unknown belongs to it
ALIKE = 0.9  # correlation from which the data hardly tell two unknowns apart, or not at all


@dataclass(frozen=True, eq=False)
class Minimum:
    """A local minimum of ½ |r(x)|²."""

    x: Array  #: the unknowns, shape (n,)
    cost: float  #: ½ |r|²
    met: bool  #: whether the search ended by its tolerances


def starts_within(first: Array, low: Array, high: Array, count: int, seed: int) -> list[Array]:
    """The first start, and others drawn evenly inside the bounds: `count` in all, each (n,)."""
    rng = np.random.default_rng(seed)
    return [first, *(rng.uniform(low, high) for _ in range(count - 1))]


def minima(
    residuals: Callable[[Array], Array],
    starts: Sequence[Array],
    low: Array,
    high: Array,
    *,
    jacobian: Callable[[Array], Array] | None = None,
    total: tuple[Array, float] | None = None,
    tolerance: float = 1e-10,
) -> list[Minimum]:
    """The minima of ½ |r(x)|² between bounds that starts lead to, the best one first.

    By the trust region reflective method (Branch, Coleman, Li 1999); under a condition, on which
    that method does not stay, by SLSQP (Kraft 1988).

    Args:
        residuals: r(x), shape (m,).
        starts: Starts, shape (n,) each, inside the bounds.
        low: Lower bounds, shape (n,).
        high: Upper bounds, shape (n,).
        jacobian: ∂r/∂x, shape (m, n); by differences when None.
        total: a and b of the condition a · x = b; None for none.
        tolerance: Relative change of the cost below which a search ends.

    SolutionError where no start led to a result.
    """
    found, (a, b) = [], total or (np.zeros_like(low), 0.0)
    condition = {"type": "eq", "fun": lambda x: float(a @ x - b), "jac": lambda x: a}
    ends = dict.fromkeys(("ftol", "xtol", "gtol"), tolerance)
    for start in starts:
        if total is None:
            ended = scipy.optimize.least_squares(
                residuals, start, jacobian or "2-point", (low, high), **ends, max_nfev=200
            )
            one = Minimum(ended.x, float(ended.cost), bool(ended.success))
        else:
            ended = scipy.optimize.minimize(
                lambda x: 0.5 * float((r := residuals(x)) @ r),
                start,
                method="SLSQP",
                bounds=list(zip(low, high, strict=True)),
                constraints=[condition] if a.any() else [],
                options={"ftol": tolerance, "maxiter": 200},
            )
            if a.any() and abs(float(a @ ended.x - b)) >= 1e-6:
                continue
            one = Minimum(ended.x, float(ended.fun), bool(ended.success))
        if np.isfinite(one.cost):
            found.append(one)
    if not found:
        raise SolutionError(f"the least-squares fit found no result from {len(starts)} starts")
    return sorted(found, key=lambda one: one.cost)


def solutions(found: Sequence[Minimum], J: Array) -> list[list[Minimum]]:
    """Return the minima that fit as well as the best one, grouped by solution, the best one first.

    A minimum belongs to the list if |r|² exceeds that of the best one by at most the quantile
    q = χ²(`CONFIDENCE`, n), the likelihood-ratio region. It is another solution if it is outside
    of the linear region |J Δx|² <= q of all others (Seber and Wild, Nonlinear Regression, 1989,
    section 5.3).

    Args:
        found: The minima, the best one first.
        J: ∂r/∂x at the best one, shape (m, n).
    """
    q = float(scipy.stats.chi2.ppf(CONFIDENCE, J.shape[1]))
    groups: list[list[Minimum]] = []
    for one in found:
        if 2.0 * (one.cost - found[0].cost) > q:
            break
        near = (g for g in groups if np.square(J @ (one.x - g[0].x)).sum() <= q)
        group = next(near, None)
        if group is None:
            groups.append([one])
        else:
            group.append(one)
    return groups


@dataclass(frozen=True, eq=False)
class Identification:
    """What data say about unknowns that are scaled to [0, 1] between their bounds.

    Linear in the unknowns, with Gaussian errors: C = (Jᵀ J)⁻¹ of the weighted residuals, with the
    rows of priors where there are some.
    """

    singular_values: Array  #: of the data's J: errors by which each direction moves the data, (n,)
    directions: Array  #: unit vectors of the unknowns that belong to them, in rows, (n, n)
    reach: Array  #: errors by which each unknown alone moves the data across its bounds, (n,)
    deviation: Array  #: standard deviation of each unknown; inf where J has no such row, (n,)
    correlation: Array  #: of the unknowns, shape (n, n); nan of those that nothing determines

    @classmethod
    def of(cls, data: Array, priors: Array) -> Identification:
        """From ∂r/∂x of the data, shape (m, n), and of the priors, shape (k, n)."""
        n = data.shape[1]
        # Rows of zeros, so that there are as many directions as unknowns.
        _, values, directions = np.linalg.svd(np.vstack([data, np.zeros((n, n))]))
        J = np.vstack([data, priors, np.zeros((n, n))])
        _, s, V = np.linalg.svd(J, full_matrices=False)
        lost = s <= 1e-12 * max(float(s[0]), 1e-300)
        C = (V[~lost].T / s[~lost] ** 2) @ V[~lost]
        undetermined = (np.abs(V[lost]) > 1e-6).any(axis=0)
        variance = np.where(undetermined, np.inf, np.diag(C))
        with np.errstate(invalid="ignore", divide="ignore"):
            correlation = C / np.sqrt(np.outer(variance, variance))
        correlation[undetermined] = correlation[:, undetermined] = np.nan
        np.fill_diagonal(correlation, 1.0)
        reach = np.linalg.norm(data, axis=0)
        return cls(values, directions, reach, np.sqrt(variance), correlation)

    @property
    def bound(self) -> Array:
        """± of each unknown: all are within it together with `CONFIDENCE` (Šidák 1967), (n,)."""
        each = CONFIDENCE ** (1.0 / len(self.reach))
        return np.asarray(scipy.stats.norm.ppf(0.5 + 0.5 * each) * self.deviation)

    @property
    def unseen(self) -> list[int]:
        """The unknowns that move the data by less than an error across all of their bounds."""
        return [int(k) for k in np.flatnonzero(self.reach < BLIND)]

    @property
    def mixed(self) -> list[tuple[float, list[int]]]:
        """Groups of unknowns that the data see in combinations: least singular value, unknowns.

        Of the directions that the data do not see, without the `unseen` unknowns. Where two or more
        of these directions have the same singular value, any rotation of them is as good: groups
        are taken from the projection onto all of them, which does not depend on the rotation.
        """
        blind = self.singular_values < BLIND
        projection = np.abs(self.directions[blind].T @ self.directions[blind])
        apart = [*self.unseen, *np.flatnonzero(np.diag(projection) <= SHARED)]
        projection[apart] = projection[:, apart] = 0.0
        n, group = scipy.sparse.csgraph.connected_components(projection > SHARED)
        groups = [[int(k) for k in np.flatnonzero(group == number)] for number in range(n)]
        least = np.where(blind, self.singular_values, np.inf)
        found = []
        for parts in groups:
            if len(parts) > 1:
                # Of the directions that lie in this group, at least in part.
                inside = np.linalg.norm(self.directions[:, parts], axis=1) ** 2 > SHARED
                found.append((float(least[inside].min()), parts))
        return found

    @property
    def alike(self) -> list[tuple[int, int, float]]:
        """Pairs of unknowns that are correlated by `ALIKE` or more, and how much."""
        pairs = zip(*np.triu_indices(len(self.reach), 1), strict=True)
        every = ((int(i), int(j), float(self.correlation[i, j])) for i, j in pairs)
        return [one for one in every if abs(one[2]) >= ALIKE]
