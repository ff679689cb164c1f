"""The response of sticks and 3D models that pound."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from impactfem.coupling.body import Body
from impactfem.coupling.pounding import Pair, Response
from impactfem.system.arrays import Array, Index


@dataclass(frozen=True, kw_only=True)
class Response3D(Response):
    """The response of sticks and 3D models; of a 3D model that of its floors' mass centres.

    The pairs of the system are the lines, then pairs of two sticks. The force of a line is the
    resultant, its gap the least of its points, and its rate that at its middle of floors that are
    rigid, as their mass centres move and turn.
    """

    acceleration: Array  #: relative to the ground, shape (n_t, n)
    gap: Array  #: least one of each line, negative in contact, shape (n_t, n_pairs) [m]
    least_gap: Array  #: with the ends of lines for the outermost points, same shape [m]
    gap_rate: Array  #: at the middles, in storeys the mean of the points, same shape [m/s]
    points: tuple[Pair, ...]  #: the points of contact, line by line, then pairs of two sticks
    pair_of: Index  #: of each of them the index of its pair
    point_force: Array  #: shape (n_t, n_points) [N]
    point_gap: Array  #: same shape [m]
    point_rate: Array | None  #: of the gaps, same shape [m/s]; None for unilateral contact
    work: Array  #: of each pair on the buildings since the start, shape (n_t, n_pairs) [J]
    #: Impulses of Moreau's scheme, which dissipate; contact points without mass are elastic.
    impulsive: bool
    #: Largest force of each pair within the step that ends at the time, shape (n_t, n_pairs) [N];
    #: None where it is that at the times.
    largest: Array | None
    low_bodies: Mapping[str, Body]  #: 3D models on soil by their lowest modes, without ports

    def body(self, building: str) -> Body:
        """See `Response`; of a 3D model its lowest modes."""
        return self.low_bodies.get(building) or super().body(building)

    def closed(self, pairs: Sequence[Pair]) -> Array:
        """Return the closure of the least gap of lines, at a point or an end, (n_t, m) [m]."""
        return np.asarray([pair.gap for pair in pairs] - self.least_gap)

    def exchanged(self, index: int, low: int, high: int) -> tuple[float, float]:
        """Return work of a line's forces between two times, and dissipation by its laws [J].

        Impulses dissipate minus their work; unilateral contact is elastic otherwise.
        """
        work, rate = float(self.work[high, index] - self.work[low, index]), self.point_rate
        if rate is None:
            return work, -work if self.impulsive else 0.0
        here = slice(low, high + 1)
        mine = np.flatnonzero(self.pair_of == index)
        laws = sum(
            self.points[k].law.dissipated(self.point_gap[here, k], rate[here, k]) for k in mine
        )
        return work, laws

    @property
    def largest_forces(self) -> Array:
        """Largest force of each pair by time, within its step where steps have parts [N]."""
        return self.force if self.largest is None else self.largest

    @property
    def exerted(self) -> tuple[tuple[Pair, ...], Array]:
        """The points of contact and their forces."""
        return self.points, self.point_force
