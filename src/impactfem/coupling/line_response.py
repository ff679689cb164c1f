"""Line contacts: the points along a line as one pair.

Forces act at the points, and turn the floors. What is reported is the pair of floors: the resultant
of the points at each time, from the first contact of a point to the separation of the last one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from impactfem.coupling.pounding import End, Pair, Response, opening
from impactfem.system.arrays import Array, Index


@dataclass(frozen=True, kw_only=True)
class LineResponse(Response):
    """A response whose pairs are whole lines, and pairs of single points.

    The force of a line is the resultant of its points, its gap the least of theirs, and its rate
    that at its middle.
    """

    acceleration: Array  #: relative to the ground, shape (n_t, n)
    gap: Array  #: least one of each line, negative in contact, shape (n_t, n_pairs) [m]
    closure: Array  #: gap of each line at rest less its least gap, same shape [m]
    gap_rate: Array  #: at the middles, same shape [m/s]
    points: tuple[Pair, ...]  #: the points of contact
    pair_of: Index  #: of each of them the index of its pair
    point_force: Array  #: shape (n_t, n_points) [N]
    point_gap: Array  #: same shape [m]
    point_rate: Array | None  #: of the gaps, same shape [m/s]; None for unilateral contact
    work: Array  #: of each pair on the buildings since the start, shape (n_t, n_pairs) [J]

    def closed(self, pairs: Sequence[Pair]) -> Array:
        """Return the approach of all lines from rest, where it is largest, (n_t, m) [m]."""
        return self.closure

    def exchanged(self, index: int, low: int, high: int) -> tuple[float, float]:
        """Return work of a line's forces between two times, and dissipation by its laws [J]."""
        work, rate = float(self.work[high, index] - self.work[low, index]), self.point_rate
        if rate is None:
            return work, 0.0
        here = slice(low, high + 1)
        laws = sum(
            self.points[k].law.dissipated(self.point_gap[here, k], rate[here, k])
            for k in np.flatnonzero(self.pair_of == index)
        )
        return work, laws

    @property
    def exerted(self) -> tuple[tuple[Pair, ...], Array]:
        """The points of contact and their forces."""
        return self.points, self.point_force


def line_pairs(points: Sequence[Pair]) -> tuple[tuple[Pair, ...], Index]:
    """Return one pair for each line of points, and the index of the pair of each point.

    The pair of a line is at its middle, with the law and the area of the whole; its gap is the
    least one. A point of no line is its own pair.
    """
    lines: dict[str, list[Pair]] = {}
    for point in points:
        lines.setdefault(point.line or point.name, []).append(point)
    index = {name: k for k, name in enumerate(lines)}
    pair_of = np.array([index[point.line or point.name] for point in points], dtype=np.int64)
    return tuple(_whole(members) for members in lines.values()), pair_of


def _whole(points: Sequence[Pair]) -> Pair:
    first = points[0]
    if not first.line:
        return first
    # Each point has its share of the effective mass of the line, as of the stiffness.
    mass = np.array([point.law.mass for point in points])
    areas = [point.area for point in points if point.area is not None]
    ends = [point.b for point in points if point.b is not None]
    return replace(
        first,
        name=first.line,
        a=_middle([point.a for point in points], mass),
        b=_middle(ends, mass) if ends else None,
        gap=min(point.gap for point in points),
        law=first.law.part(float(mass.sum() / mass[0])),
        area=sum(areas) if len(areas) == len(points) else None,
        hats=None,
        line="",
    )


def _middle(ends: Sequence[End], weight: Array) -> End:
    x, y, z = (weight @ [end.offset for end in ends] / weight.sum()).tolist()
    return replace(ends[0], offset=(x, y, z))


def least_gap(gap: Array, pair_of: Index) -> Array:
    """Return the least gap of the points of each pair, (n_t, n_points) to (n_t, n_pairs)."""
    return np.column_stack([gap[:, pair_of == k].min(axis=1) for k in np.unique(pair_of)])


def sums_of_pairs(pair_of: Index) -> Array:
    """Return columns that sum the points of each pair, shape (n_points, n_pairs)."""
    return np.eye(1 + max(pair_of, default=-1))[pair_of]


def with_lines(response: Response, points: Sequence[Pair]) -> Response:
    """Join the points of each line to one pair; without lines the response itself is returned.

    Args:
        response: The response with contact of all points, or without contact.
        points: The points, in the order of the forces.
    """
    if not any(point.line for point in points):
        return response
    pairs, pair_of = line_pairs(points)
    touched = bool(response.system.pairs)
    by_point = replace(response.system, pairs=tuple(points))
    rest = np.array([point.gap for point in points])
    gap = rest + opening(by_point, response.u, response.relative)
    least, force = least_gap(gap, pair_of), response.force
    content = {one.name: getattr(response, one.name) for one in fields(response)}
    content |= {
        "acceleration": response.acceleration,
        "gap": least,
        "closure": np.array([pair.gap for pair in pairs]) - least,
        "points": by_point.pairs if touched else (),
        "pair_of": pair_of if touched else pair_of[:0],
        "point_force": force,
    }
    if not touched:
        content |= {"gap_rate": force, "point_gap": force, "point_rate": force, "work": force}
        return LineResponse(**content)
    sums, system = sums_of_pairs(pair_of), replace(response.system, pairs=pairs)
    work = np.zeros_like(force)
    np.cumsum(0.5 * (force[:-1] + force[1:]) * np.diff(gap, axis=0), axis=0, out=work[1:])
    content |= {
        "system": system,
        "force": force @ sums,
        "gap_rate": opening(system, response.v, response.relative, 1),
        "point_gap": gap,
        "point_rate": opening(by_point, response.v, response.relative, 1),
        "work": work @ sums,
    }
    return LineResponse(**content)
