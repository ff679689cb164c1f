"""Plans of floors as polygons, and the lengths over which two plans face each other.

Two sides face each other along the bisector n of their outward normals, n = (n_a − n_b) / |n_a −
n_b|. Along t, n turned by 90 degrees to the left, both are straight lines h_a(s) and h_b(s) of the
height over t. They face each other where both exist and no other side of these or of further plans
lies between them, that is, where no h(s) is between h_a(s) and h_b(s): the bounds are roots of
linear functions. Sides of a skewness above `SKEW` do not face each other.
"""

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any

from pydantic import AfterValidator

from impactfem.case.base import Section, refuse
from impactfem.case.contacts import Vector
from impactfem.case.facade import Facade, Point, side_of
from impactfem.case.leaf import FloorNumbers
from impactfem.case.quantity import Length

Polygon = tuple[Point, ...]
"""Corners of a plan, counterclockwise [m]."""
SHORT = 1e-6
"""Length up to which sides do not face each other [m]."""
TOUCH = 1e-3
"""Overlap of two plans that counts as contact at rest [m]."""
SKEW = math.radians(30.0)
"""Largest angle between two façades that face each other [rad]."""


def rectangle_plan(length: float, width: float, middle: Point = (0.0, 0.0)) -> Polygon:
    """Return a rectangle along x and y with its middle at a point [m]."""
    (x, y), a, b = middle, 0.5 * length, 0.5 * width
    return (x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)


def area(polygon: Sequence[Point]) -> float:
    """Return the area of a polygon [m2], negative for clockwise corners."""
    pairs = zip(polygon, (*polygon[1:], polygon[0]), strict=True)
    return 0.5 * sum(x1 * y2 - x2 * y1 for (x1, y1), (x2, y2) in pairs)


def second_moments(polygon: Sequence[Point]) -> tuple[float, float, float]:
    """Return the area [m2] and ∫ y² dA and ∫ x² dA of a polygon about its centroid [m4].

    By Green's theorem, with c = x_i y_{i+1} − x_{i+1} y_i of each side: A = ½ Σ c,
    A x_s = ⅙ Σ c (x_i + x_{i+1}) and ∫ x² dA = 1/12 Σ c (x_i² + x_i x_{i+1} + x_{i+1}²).
    """
    size = first_x = first_y = about_x = about_y = 0.0
    for (x1, y1), (x2, y2) in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        c = x1 * y2 - x2 * y1
        size += c / 2.0
        first_x += c * (x1 + x2) / 6.0
        first_y += c * (y1 + y2) / 6.0
        about_x += c * (y1 * y1 + y1 * y2 + y2 * y2) / 12.0
        about_y += c * (x1 * x1 + x1 * x2 + x2 * x2) / 12.0
    about_x, about_y = about_x - first_y**2 / size, about_y - first_x**2 / size
    return abs(size), abs(about_x), abs(about_y)


def plan_fault(polygon: Sequence[Point]) -> str:
    """Return the expectation that corners of a plan do not meet; empty for a valid plan."""
    if len(polygon) < 3:
        return f"expected at least three corners [x, y], found {len(polygon)}"
    edges = list(zip(polygon, (*polygon[1:], polygon[0]), strict=True))
    for k, (p, q) in enumerate(edges):
        if math.dist(p, q) <= TOUCH:
            return f"expected corners apart from each other; corner {k + 1} and the next coincide"
    for (i, one), (j, other) in itertools.combinations(enumerate(edges), 2):
        neighbours = j == i + 1 or (i == 0 and j == len(edges) - 1)
        if not neighbours and _cross(one, other):
            return (
                f"expected sides that do not intersect; those from corners {i + 1} and {j + 1} do"
            )
    if abs(area(polygon)) <= TOUCH**2:
        return "expected corners that enclose an area"
    return ""


def counterclockwise(polygon: Sequence[Point]) -> Polygon:
    """Return the corners in counterclockwise order."""
    return tuple(polygon) if area(polygon) > 0.0 else tuple(reversed(polygon))


def _valid(corners: Any) -> Polygon:
    """Refuse corners of the case file that are no plan, and order the others."""
    if wrong := plan_fault(corners):
        raise refuse(wrong, kind="plan")
    return counterclockwise(corners)


Corners = Annotated[tuple[tuple[Length, Length], ...], AfterValidator(_valid)]
"""Corners of a plan in a case file."""


class FloorPlan(Section):
    """The plan of some floors."""

    floors: FloorNumbers
    """Numbers of the floors."""
    plan: Corners
    """Corners (x, y) of the plan in order, from the axis."""


def moved(polygon: Polygon, by: Point) -> Polygon:
    """Return a plan moved by a vector [m]."""
    return tuple((x + by[0], y + by[1]) for x, y in polygon)


@lru_cache(maxsize=1024)
def inset(polygon: Polygon, distance: float) -> Polygon | None:
    """Return the plan with each side moved inwards [m]; None where a side vanishes."""
    if distance == 0.0:
        return polygon
    sides = list(zip(polygon, (*polygon[1:], polygon[0]), strict=True))
    lines = []
    for (x1, y1), (x2, y2) in sides:
        length = math.hypot(x2 - x1, y2 - y1)
        u = (x2 - x1) / length, (y2 - y1) / length
        lines.append(((x1 - distance * u[1], y1 + distance * u[0]), u))
    corners = []
    for (p, u), (q, v) in zip((lines[-1], *lines[:-1]), lines, strict=True):
        turn = u[0] * v[1] - u[1] * v[0]
        if abs(turn) <= SHORT:  # the same line
            corners.append(q)
            continue
        along = ((q[0] - p[0]) * v[1] - (q[1] - p[1]) * v[0]) / turn
        corners.append((p[0] + along * u[0], p[1] + along * u[1]))
    ends = zip(corners, (*corners[1:], corners[0]), lines, strict=True)
    if any((x2 - x1) * u + (y2 - y1) * v <= SHORT for (x1, y1), (x2, y2), (_, (u, v)) in ends):
        return None
    return tuple(corners)


@lru_cache(maxsize=1024)
def sides_of(polygon: Polygon) -> tuple[Facade, ...]:
    """Return the sides of a plan, named "x-", "y+" or by their normal, with #2 for further ones."""
    found, uses = [], dict[str, int]()
    for p, q in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        length = math.dist(p, q)
        outward = (q[1] - p[1]) / length + 0.0, (p[0] - q[0]) / length + 0.0, 0.0
        name = side_of(outward)
        uses[name] = uses.get(name, 0) + 1
        suffix = f"#{uses[name]}" if uses[name] > 1 else ""
        # From the smaller x, or y where the side is closer to the y axis.
        first = 0 if abs(q[0] - p[0]) >= abs(q[1] - p[1]) else 1
        start, end = (p, q) if p[first] < q[first] else (q, p)
        found.append(Facade(name + suffix, start, end, outward))
    return tuple(found)


def extent(polygon: Polygon, t: Sequence[float]) -> tuple[float, float]:
    """Return the first and last position of a plan along a horizontal unit vector [m]."""
    along = [x * t[0] + y * t[1] for x, y in polygon]
    return min(along), max(along)


def apart(a: Polygon, b: Polygon) -> float:
    """Return the distance of the bounding boxes of two plans [m]; 0 where they overlap."""
    gaps = []
    for axis in ((1.0, 0.0), (0.0, 1.0)):
        (low_a, high_a), (low_b, high_b) = extent(a, axis), extent(b, axis)
        gaps.append(max(low_a - high_b, low_b - high_a, 0.0))
    return math.hypot(*gaps)


@lru_cache(maxsize=1024)
def overlap(a: Polygon, b: Polygon) -> bool:
    """Return True if two plans overlap by more than `TOUCH`."""
    if apart(a, b) > 0.0:
        return False
    inner, outer = inset(a, 0.5 * TOUCH), inset(b, 0.5 * TOUCH)
    if inner is None or outer is None:
        return False
    edges = (list(zip(one, (*one[1:], one[0]), strict=True)) for one in (inner, outer))
    return (
        any(_cross(one, other) for one, other in itertools.product(*edges))
        or inside(inner[0], outer)
        or inside(outer[0], inner)
    )


def crosses(polygon: Polygon, start: Point, end: Point) -> bool:
    """Return True if a straight line between two points crosses a plan."""
    edges = zip(polygon, (*polygon[1:], polygon[0]), strict=True)
    return any(_cross((start, end), edge) for edge in edges)


def _cross(one: tuple[Point, Point], other: tuple[Point, Point]) -> bool:
    """Return True if two segments have a point in common."""

    def turn(p: Point, q: Point, r: Point) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    (p, q), (r, s) = one, other
    if turn(p, q, r) * turn(p, q, s) > 0.0 or turn(r, s, p) * turn(r, s, q) > 0.0:
        return False
    # Segments of one line: their boxes decide.
    boxes = (
        max(min(p[c], q[c]), min(r[c], s[c])) <= min(max(p[c], q[c]), max(r[c], s[c]))
        for c in (0, 1)
    )
    return all(boxes)


def inside(point: Point, polygon: Polygon) -> bool:
    """Return True if a point is inside a polygon: a ray meets an odd number of sides."""
    x, y = point
    met = False
    for (x1, y1), (x2, y2) in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        if (y1 > y) != (y2 > y) and x < x1 + (y - y1) / (y2 - y1) * (x2 - x1):
            met = not met
    return met


@dataclass(frozen=True)
class Opposite:
    """A length over which a side of one plan faces a side of another plan."""

    normal: Vector  #: horizontal unit vector from a to b, the bisector of both outward normals
    a: Point  #: middle of the length on the side of a [m]
    b: Point  #: middle of the length on the side of b [m]
    length: float  #: along n turned by 90 degrees to the left [m]
    gap: float  #: distance along the normal at the middle [m]
    gap_slope: float  #: growth of the gap for each metre along the length

    @property
    def least_gap(self) -> float:
        """Smallest distance along the normal, at one end [m]."""
        return self.gap - 0.5 * abs(self.gap_slope) * self.length


@dataclass(frozen=True)
class _Straight:
    """A side as the straight line h(s) = height + slope s over the direction t."""

    low: float
    high: float
    height: float
    slope: float

    @classmethod
    def of(cls, side: Facade, n: Point, t: Point) -> "_Straight | None":
        """Return the line of a side; None for a side along n."""
        (s1, h1), (s2, h2) = sorted(
            (x * t[0] + y * t[1], x * n[0] + y * n[1]) for x, y in (side.start, side.end)
        )
        if s2 - s1 <= SHORT:
            return None
        slope = (h2 - h1) / (s2 - s1)
        return cls(s1, s2, h1 - slope * s1, slope)

    def at(self, s: float) -> float:
        return self.height + self.slope * s


@lru_cache(maxsize=4096)
def opposites(a: Polygon, b: Polygon, between: tuple[Polygon, ...] = ()) -> tuple[Opposite, ...]:
    """Return the lengths over which a plan faces another one, further plans being in the way."""
    found = []
    for one, other in itertools.product(sides_of(a), sides_of(b)):
        (x1, y1, _), (x2, y2, _) = one.outward, other.outward
        facing = -(x1 * x2 + y1 * y2)
        if facing < math.cos(SKEW):
            continue
        n = (x1, y1)
        if facing < 1.0 - SHORT**2:
            size = math.hypot(x1 - x2, y1 - y2)
            n = ((x1 - x2) / size, (y1 - y2) / size)
        t = (-n[1] + 0.0, n[0])
        near, far = _Straight.of(one, n, t), _Straight.of(other, n, t)
        if near is None or far is None:
            continue
        span = max(near.low, far.low), min(near.high, far.high)
        if span[1] - span[0] <= SHORT or min(far.at(s) - near.at(s) for s in span) < -TOUCH:
            continue
        further = (
            _Straight.of(side, n, t)
            for plan in (a, b, *between)
            for side in sides_of(plan)
            if side not in (one, other)
        )
        hidden = [_between(near, far, side) for side in further if side is not None]
        for low, high in _left(span, [span for span in hidden if span is not None]):
            s = 0.5 * (low + high)
            h = near.at(s), far.at(s)
            # Coordinates are sums: what they leave behind the nanometre is rounding.
            gap, slope = round(h[1] - h[0], 9), far.slope - near.slope
            places = [(k * n[0] + s * t[0], k * n[1] + s * t[1]) for k in h]
            found.append(
                Opposite(
                    normal=(n[0], n[1], 0.0),
                    a=places[0],
                    b=places[1],
                    length=high - low,
                    gap=max(gap, 0.0),
                    gap_slope=slope if abs(slope) > SHORT else 0.0,
                )
            )
    return tuple(sorted(found, key=lambda one: one.least_gap))


def _between(near: _Straight, far: _Straight, side: _Straight) -> tuple[float, float] | None:
    """Return from where to where a side is between two others; None if it is nowhere."""
    low, high = max(near.low, far.low, side.low), min(near.high, far.high, side.high)
    # h − h_near > TOUCH and h_far − h > TOUCH: each cuts the interval at one root.
    for above, below in ((side, near), (far, side)):
        slope, height = above.slope - below.slope, above.height - below.height - TOUCH
        if abs(slope) <= SHORT**2:
            if height <= 0.0:
                return None
        elif slope > 0.0:
            low = max(low, -height / slope)
        else:
            high = min(high, -height / slope)
    return (low, high) if high - low > SHORT else None


def _left(
    span: tuple[float, float], hidden: Iterable[tuple[float, float]]
) -> Iterator[tuple[float, float]]:
    """Yield what is left of a span without some parts."""
    low, high = span
    for first, last in sorted(hidden):
        if first - low > SHORT:
            yield low, first
        low = max(low, last)
    if high - low > SHORT:
        yield low, high
