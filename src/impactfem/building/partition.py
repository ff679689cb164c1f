"""Which rank assembles which cell."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def bisect(points: Array, weights: Array, parts: int) -> Index:
    """Divide points into compact parts of about equal weight by recursive coordinate bisection.

    Args:
        points: Coordinates, shape (n, 3) [m].
        weights: Weight of each point, shape (n,).
        parts: Number of parts; some are empty when there are fewer points.

    Returns:
        Part of each point, 0 to parts − 1, shape (n,). The same for the same input.
    """
    part = np.zeros(len(points), dtype=np.int64)
    _divide(part, np.arange(len(points)), points, weights, 0, parts)
    return part


def _divide(
    part: Index, members: Index, points: Array, weights: Array, first: int, parts: int
) -> None:
    if parts == 1 or members.size == 0:
        part[members] = first
        return
    lower = parts // 2
    axis = int(np.argmax(np.ptp(points[members], axis=0)))
    order = members[np.argsort(points[members, axis], kind="stable")]
    cumulative = np.cumsum(weights[order])
    # Middles of the steps, so that a single point falls on the side where most of it lies.
    middle = cumulative - 0.5 * weights[order]
    cut = int(np.searchsorted(middle, cumulative[-1] * lower / parts))
    _divide(part, order[:cut], points, weights, first, lower)
    _divide(part, order[cut:], points, weights, first + lower, parts - lower)
