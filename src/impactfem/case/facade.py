"""The straight sides of a floor in plan, and where a pair strikes them."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from impactfem.case.contacts import Vector

Point = tuple[float, float]
"""Coordinates x and y of a point [m], or components of a vector."""

ALIGNED = 1e-3
"""Largest difference of unit vectors that count as the same."""
GRAZING = 0.1
"""Cosine of the angle between the normals of pair and side from which on a side is met at all."""
NEAR = 0.5
"""Distance from a side at which a point still counts as being on it [m]."""
ROUNDING = 1e-3
"""Largest distance of a point beyond the end of a side [m]."""


@dataclass(frozen=True)
class Facade:
    """A straight side of a floor in plan; positions s along it are counted from its start."""

    #: "" for the edge of the mesh's group edge_K, or of impact_edge; else "x-", "y+", or its normal
    #: in words, with #2 and so on for further ones.
    side: str
    start: Point  #: The end with the smaller x, or y where it is closer to the y axis [m].
    end: Point  #: The other end [m].
    outward: Vector  #: Horizontal unit vector at right angles to it, out of the building.

    @property
    def length(self) -> float:
        """Its length [m]."""
        return math.dist(self.start, self.end)

    @property
    def along(self) -> Vector:
        """Horizontal unit vector from start to end."""
        x, y = (b - a for a, b in zip(self.start, self.end, strict=True))
        return x / self.length, y / self.length, 0.0

    def meets(self, point: Point, normal: Vector) -> tuple[float, float]:
        """Intersect the line through a point along a horizontal unit vector with the side's line.

        Gives the distance from the point along the vector, and the position s [m].
        """
        n, t = self.outward, self.along
        away = [a - p for a, p in zip(self.start, point, strict=True)]
        distance = (away[0] * n[0] + away[1] * n[1]) / (normal[0] * n[0] + normal[1] * n[1])
        s = sum((distance * normal[c] - away[c]) * t[c] for c in range(2))
        return distance, s


def struck(facades: Iterable[Facade], point: Point, normal: Vector) -> tuple[Facade, float] | None:
    """The side that a force on a point acts on, and the position s where it does [m].

    The force acts along the line through the point [m] along the pair's normal, out of the
    building. Of the sides that this line meets it is the one that the point is on, else the
    outermost one; None where it meets none, and for a point on another side.
    """
    best: tuple[tuple[bool, float, float], Facade, float] | None = None
    on_another = False
    for facade in facades:
        n = facade.outward
        facing = sum(a * b for a, b in zip(n, normal, strict=True))
        if facing < GRAZING:
            behind, s = facade.meets(point, n)
            on_another |= abs(behind) <= NEAR and 0.0 <= s <= facade.length
            continue
        # Normals that are meant to be at right angles to the side may be off by rounding.
        distance, s = facade.meets(point, n if math.dist(n, normal) <= ALIGNED else normal)
        here = abs(distance) <= NEAR
        order = (here, 0.0 if here else distance, facing)
        if -ROUNDING <= s <= facade.length + ROUNDING and (best is None or order > best[0]):
            best = order, facade, s
    if best is None or (on_another and not best[0][0]):
        return None
    return best[1:]


def rectangle(length: float, width: float, impact_edge: str) -> tuple[Facade, ...]:
    """The sides of a generated floor, from (0, 0) to its length and width [m]."""
    found = []
    for side, start, end, outward in (
        ("x-", (0.0, 0.0), (0.0, width), (-1.0, 0.0, 0.0)),
        ("x+", (length, 0.0), (length, width), (1.0, 0.0, 0.0)),
        ("y-", (0.0, 0.0), (length, 0.0), (0.0, -1.0, 0.0)),
        ("y+", (0.0, width), (length, width), (0.0, 1.0, 0.0)),
    ):
        found.append(Facade("" if side == impact_edge else side, start, end, outward))
    return tuple(found)


def axis_in_plan(
    axis: Point,
    low: Point,
    high: Point,
    points: Sequence[tuple[Sequence[Facade], Vector, Vector]] = (),
) -> Point:
    """The axis of a stick in the coordinates of the mesh [m].

    Args:
        axis: Of the stick in plan [m].
        low: Lowest x and y of the plan of the mesh [m].
        high: Highest x and y of it [m].
        points: Of each pair on a floor of the building the sides of the floor, the offset from the
            axis [m], and the normal out of the building.

    A stick has the coordinates of the mesh where its axis is within the plan, or others: then its
    axis counts as the middle of the plan. So it does within the plan where all points are on a side
    by the middle, and none as they stand: it is there by chance.
    """
    middle = 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])
    if not all(a < x < b for x, a, b in zip(axis, low, high, strict=True)):
        return middle
    own, moved = (
        [_on_one(sides, (x + dx, y + dy), normal) for sides, (dx, dy, _), normal in points]
        for x, y in (axis, middle)
    )
    return middle if moved and all(moved) and not any(own) else axis


def _on_one(sides: Iterable[Facade], point: Point, normal: Vector) -> bool:
    """Return True if a point is on a side that a normal leads out through."""
    for facade in sides:
        if sum(a * b for a, b in zip(facade.outward, normal, strict=True)) >= GRAZING:
            distance, s = facade.meets(point, facade.outward)
            if abs(distance) <= NEAR and -ROUNDING <= s <= facade.length + ROUNDING:
                return True
    return False


def side_of(vector: Vector) -> str:
    """The side of a building that a horizontal unit vector points to: "y+", or the vector."""
    for axis, name in enumerate("xy"):
        if abs(vector[1 - axis]) <= ALIGNED and vector[axis] != 0.0:
            return f"{name}{'+' if vector[axis] > 0.0 else '-'}"
    return words_of(vector)


def words_of(vector: Iterable[float]) -> str:
    """A vector in words, without signs of zeros."""
    return "({})".format(", ".join(f"{float(x) + 0.0:g}" for x in vector))
