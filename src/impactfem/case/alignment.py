"""Alignment of the two points of a contact pair across its normal: along the façade and in height.

A contact force acts on both buildings along one line, so its two points are at one place of the
façades and at one level. Three distances decide whether they can meet:

1. of a point from its own building: from the length of its floor along the façade, and from the
   depth of the floor (lower edge of the beams to upper edge of the slab), or from its storey;
2. of a point from the length over which both floors face each other;
3. of the two points from each other along the façade, and between the depths of their floors.

A pair whose points cannot meet is a fault of the case; a doubtful distance is a warning.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from impactfem.case.buildings import Building
from impactfem.case.contacts import Contact, ContactPoint, Vector
from impactfem.case.levels import (
    Span,
    clear_height,
    depth_of,
    flexible,
    level_at,
    plan_of,
    storey_level,
)
from impactfem.case.model import Case
from impactfem.case.plan import Polygon, extent, rectangle_plan

SLIGHT = 0.1
"""Distance of a point from the depth of its floor up to which there is no warning [m]."""
DOUBTFUL = 1.0
"""Distance along the façade up to which there is no warning [m]; of a point from its own building
the distance up to which the case is valid."""
ESTIMATED = 1.5
"""Factor on the length of a floor that is estimated from its moments of inertia."""
GYRATION = (0.5, 80.0)
"""Usual radius of gyration of a floor, √(J/m) [m]."""
ZERO = 1e-9
"""Component of a unit vector that counts as zero."""


@dataclass(frozen=True)
class Misalignment:
    """A distance between two points of a pair, or of a point from its building."""

    wrong: bool  #: whether the points cannot meet; else a warning
    side: str  #: end of the pair with the fault, "a" or "b"; "" for both
    text: str  #: what was found, and the key and value to type


@dataclass(frozen=True)
class _End:
    """A point of a pair with its building."""

    side: str
    point: ContactPoint
    building: Building

    @cached_property
    def index(self) -> int:
        """Index of the floor, or of the floor above the storey."""
        return [floor.floor for floor in self.building.floors].index(self.point.level)

    @cached_property
    def plan(self) -> tuple[Polygon | None, bool]:
        """Plan of the floor from the axis, and whether the case gives it.

        Else it is that of an evenly loaded rectangle, J = m L² / 12, times `ESTIMATED`; None where
        the moments of inertia are unusual.
        """
        given = plan_of(self.building, self.index)
        if given is not None:
            return given, True
        floor = self.building.floors[self.index]
        radii = [math.sqrt(inertia / floor.mass) for inertia in (floor.Jy, floor.Jx)]
        if not all(GYRATION[0] <= radius <= GYRATION[1] for radius in radii):
            return None, False
        length, width = (2.0 * ESTIMATED * math.sqrt(3.0) * radius for radius in radii)
        return rectangle_plan(length, width), False

    def span(self, t: Vector) -> Span:
        """Ends of the floor along a horizontal unit vector, from the axis [m]."""
        plan = self.plan[0]
        return (-math.inf, math.inf) if plan is None else extent(plan, t)

    @property
    def level(self) -> float:
        """Elevation of the point [m]."""
        height = 1.0 if self.point.floor is not None else self.point.relative_height or 0.0
        return storey_level(self.building, self.index, height) + self.point.offset[2]

    @property
    def heights(self) -> Span:
        """Elevations between which its floor, or its storey, can be touched [m]."""
        if self.point.floor is not None:
            return depth_of(self.point, self.building)
        return flexible(self.building, self.index)

    def moved(self, t: Vector, distance: float) -> str:
        """The offset to type for a point that is moved along a unit vector [m]."""
        values = (x + distance * c for x, c in zip(self.point.offset, t, strict=True))
        return "[" + ", ".join(f'"{round(x, 4) + 0.0:g} m"' for x in values) + "]"


def misalignments(contact: Contact, case: Case) -> Iterator[Misalignment]:
    """Find misaligned points of a pair across its normal: along the façade, then in height."""
    ends = [
        _End(side, point, case.building(point.building))
        for side, (point, _) in zip("ab", contact.ends, strict=False)
    ]
    x, y, z = contact.normal
    flat = math.hypot(x, y)
    directions: list[tuple[str, Vector]] = [("x", (1.0, 0.0, 0.0)), ("y", (0.0, 1.0, 0.0))]
    if flat > ZERO:
        sign = -1.0 if x < y else 1.0  # along x or y, in their positive direction
        t = (-sign * y / flat, sign * x / flat, 0.0)
        directions = [one for one in directions if math.dist(one[1], t) <= ZERO] or [
            ("the façade", t)
        ]
    for name, t in directions:
        yield from _along(ends, name, t)
    if flat > ZERO:
        yield from _off_its_floor(ends)
    if len(ends) == 2 and abs(z) <= ZERO:
        yield from _levels(contact, ends, case)


def _along(ends: Sequence[_End], name: str, t: Vector) -> Iterator[Misalignment]:
    """Along a horizontal unit vector across the normal."""
    own = [sum(c * x for c, x in zip(t, end.point.offset, strict=True)) for end in ends]
    spans = [end.span(t) for end in ends]
    outside = False
    for end, at, (low, high) in zip(ends, own, spans, strict=True):
        if max(low - at, at - high) > DOUBTFUL:
            outside, given = True, end.plan[1]
            size = f"reaches from {low:.4g} to {high:.4g} m"
            if not given:
                about = (high - low) / ESTIMATED
                size = f"has a length of about {about:.3g} m by its moments of inertia"
            text = (
                f"expected a point of {end.building.name}: along {name} {end.point.label} is "
                f"{at:.4g} m from the axis, and the floor {size}; type {end.moved(t, -at)}"
            )
            more = "" if given else ", or give length and width of the building"
            yield Misalignment(True, end.side, text + more)
    # With one axis for both buildings the case gives no plan.
    if outside or len(ends) < 2 or ends[0].building.axis == ends[1].building.axis:
        return
    axes = [sum(c * x for c, x in zip(t, end.building.axis, strict=False)) for end in ends]
    places = [axis + at for axis, at in zip(axes, own, strict=True)]
    reaches = [(axis + low, axis + high) for axis, (low, high) in zip(axes, spans, strict=True)]
    low, high = max(one[0] for one in reaches), min(one[1] for one in reaches)
    if not math.isfinite(high - low):
        return
    names = " and ".join(end.point.label for end in ends)
    by = "" if all(end.plan[1] for end in ends) else " by their moments of inertia"
    if high < low:
        words = " and ".join(f"{first:.4g} to {last:.4g} m" for first, last in reaches)
        text = (
            f"expected floors that face each other: along {name} {names} reach from {words}{by}; "
            "change axis of [[buildings]], or remove the pair"
        )
        yield Misalignment(True, "", text)
        return
    middle = 0.5 * (low + high)
    for end, at, other in zip(ends, places, places[::-1], strict=True):
        if max(low - at, at - high) > DOUBTFUL:
            target = other if low <= other <= high else middle
            text = (
                f"expected a point where the floors face each other: along {name} "
                f"{end.point.label} is at {at:.4g} m, and {names} face each other from {low:.4g} "
                f"to {high:.4g} m{by}; type {end.moved(t, target - at)}"
            )
            yield Misalignment(True, end.side, text)
            return
    apart = abs(places[1] - places[0])
    if apart > DOUBTFUL:
        wrong = apart > 0.5 * (high - low)
        pairs = zip(ends, places, strict=True)
        type_this = " and ".join(f"{e.side}.offset = {e.moved(t, middle - at)}" for e, at in pairs)
        text = (
            f"{'expected points that face each other: ' if wrong else ''}along {name} the points "
            f"of {names} are {apart:.4g} m apart, and two forces that are no pair of opposite "
            "forces along one line turn the buildings: it affects rotations and everything that "
            f"follows from them; type {type_this}"
        )
        yield Misalignment(wrong, "", text)


def _off_its_floor(ends: Sequence[_End]) -> Iterator[Misalignment]:
    """Points above or below the floor, or the storey, that they are on."""
    for end in ends:
        low, high = end.heights
        away = max(low - end.level, end.level - high)
        if away > SLIGHT:
            wrong = away > DOUBTFUL
            what = "floor" if end.point.floor is not None else "storey"
            text = (
                f"{'expected a point of this height: ' if wrong else ''}{end.point.label} is at "
                f"{end.level:.4g} m, and the {what} can be touched from {low:.4g} to {high:.4g} m "
                "(rigid_below, rigid_above); a force outside has a false moment, and the floor "
                f"rotates too much; type {end.moved((0.0, 0.0, 1.0), -end.point.offset[2])}"
            )
            yield Misalignment(wrong, end.side, text)


def _levels(contact: Contact, ends: Sequence[_End], case: Case) -> Iterator[Misalignment]:
    """Floors whose depths do not overlap."""
    clear = clear_height(contact, case)
    if clear <= ZERO:
        return
    far = clear > max(end.building.floors[end.index].storey_height for end in ends)
    wrong = far or "depth" not in case.allow
    depths = [depth_of(end.point, end.building) for end in ends]
    levels = " and ".join(f"{end.level:.4g} m" for end in ends)
    reach = " and ".join(f"{low:.4g} to {high:.4g} m" for low, high in depths)
    text = (
        f"{'expected points at one level: ' if wrong else ''}the points of {contact.name} are at "
        f"{levels}; points that meet are level, and the depths of these floors (rigid_below, "
        f"rigid_above), {reach}, do not overlap: the floors pass each other by {clear:.3g} m and "
        "hit storeys, so the place and the force of the impacts are wrong"
    )
    for end, depth, other in zip(ends, depths, ends[::-1], strict=True):
        met = None if end.point.floor is None else level_at(other.building, end.level, depth)
        if met is not None:
            name, in_storey, number = met.key
            height = f", relative_height = {met.relative_height:.4g}" if in_storey else ""
            where = f"{'storey' if in_storey else 'floor'} = {number}{height}"
            text += f'; type {other.side} = {{ building = "{name}", {where}, ... }}'
            break
    if wrong and not far:
        text += ', or allow = ["depth"] at the top of the file to accept this'
    yield Misalignment(wrong, "", text)
