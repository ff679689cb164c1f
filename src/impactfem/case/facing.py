"""Floors of neighbouring buildings that face each other and are in no contact pair.

Sticks have axes and levels but no outlines. How far the edge of a floor is from the axis, on each
of the four sides x-, x+, y-, y+, is taken from the first of these that says it:

1. the offset of a contact of this floor on that side, where offset, axes and gap agree;
2. `length` and `width` of the floor (floor table) or of its building, half to either side, then
   those of a generated mesh of the building;
3. the offsets of contacts of the building's other floors on that side, the largest;
4. the offsets on the opposite side, the largest: the axis is in the middle.

Faces of storeys stand `setback` behind the edge of the floor above, unless a contact inside that
storey says where they are. Plans are rectangles along x and y.

Two floors face each other where their levels, from the lower edge of the beams to the upper edge of
the rigid zone, overlap; a floor that is level with no floor of its neighbour faces its storey. A
floor is in a pair with a neighbour when a contact joins it to a point of that neighbour whose depth
overlaps with its own.
"""

from bisect import bisect
from collections import defaultdict
from dataclasses import dataclass
from itertools import combinations

from impactfem.case.buildings import Building, GeneratedMesh
from impactfem.case.contact_checks import allowed, pair_distance
from impactfem.case.contacts import Contact, ContactPoint
from impactfem.case.model import Case

HALF_SLAB = 0.15
"""Half of the least height of a floor's edge [m], where its rigid zones are thinner."""
DRIFT = 0.025
"""Largest drift that counts as possible before anything is computed: ASCE 7-22, table 12.12-1."""
ROUNDING = 1e-6  # of a length or a component of a unit vector

Span = tuple[float, float]


@dataclass(frozen=True)
class Facing:
    """A floor and what it faces, which are in no contact pair."""

    #: The floor; the offset goes to the middle of the facing edges, at the floor's level.
    a: ContactPoint
    b: ContactPoint  #: what it faces, at the same place: a floor, or a point inside a storey
    normal: tuple[float, float, float]  #: unit vector from a to b, along x or y
    gap: float  #: distance at rest [m]; negative where the plans overlap
    level: float  #: elevation [m]
    half: float  #: half of the length over which the edges face each other [m]
    reach: float  #: how far both may move towards each other by a drift of `DRIFT` [m]

    @property
    def name(self) -> str:
        """Both ends, as the name of a pair: ``B.floor_4-C.floor_3``."""
        return f"{self.a.label}-{self.b.label}"

    @property
    def words(self) -> str:
        """Both ends and their distance in words."""
        apart = f"{1e3 * self.gap:.4g} mm apart" if self.gap >= 0.0 else "one inside the other"
        return f"{self.a.label} and {self.b.label} ({apart} at {self.level:.4g} m)"


@dataclass(frozen=True)
class FacingFloors:
    """What was found in a case."""

    pairs: tuple[Facing, ...] = ()  #: floors and what they face outside, in no pair
    #: The same of plans that overlap: buildings one inside the other.
    overlapping: tuple[Facing, ...] = ()
    #: Names of two buildings that have floors in no pair at the same level, and of those of them
    #: whose plan is not known well enough to tell whether these face each other.
    unknown: tuple[tuple[str, str, tuple[str, ...]], ...] = ()

    @property
    def near(self) -> tuple[Facing, ...]:
        """Those that come together within a drift of `DRIFT` of both buildings."""
        return tuple(pair for pair in self.pairs if pair.gap <= pair.reach)

    def lines(self, most: int = 6) -> list[str]:
        """What `check` warns of, one line for each two buildings, so many of them named."""
        by_buildings: dict[tuple[str, ...], list[Facing]] = defaultdict(list)
        for pair in sorted(self.near, key=lambda pair: pair.gap):
            by_buildings[tuple(sorted((pair.a.building, pair.b.building)))].append(pair)
        return [
            "contacts: floors that face each other and are in no pair: "
            + ", ".join(pair.words for pair in pairs[:most])
            + (f" and {len(pairs) - most} more" if len(pairs) > most else "")
            + "; list them in [[contacts]], or give length, width and setback of [[buildings]] "
            "where they cannot meet"
            for pairs in by_buildings.values()
        ]

    @property
    def unknown_lines(self) -> list[str]:
        """What is not known, and which keys would say it; a line for each two buildings."""
        return [
            f"facing floors: whether floors of {a} and {b} that are in no pair meet cannot be "
            f"checked without the plan of {' and '.join(names)}: length and width of [[buildings]] "
            "give it"
            for a, b, names in self.unknown
        ]


def facing_floors(case: Case) -> FacingFloors:
    """Floors of neighbours that face each other, or a storey of each other, in no pair."""
    plans = _Plans(case)
    found = []
    unknown = []
    level_contacts = [one for one in case.contacts if clear_height(one, case) <= ROUNDING]
    for a, b in combinations(case.buildings, 2):
        names = (a.name, b.name)
        lacking: set[str] = set()
        # Floors that a contact joins to a point of the other building at their level.
        paired: set[tuple[str, bool, int]] = set()
        for contact in level_contacts:
            if set(contact.buildings) == set(names):
                floors = [(e.building, e.floor) for e, _ in contact.ends]
                paired |= {(name, False, floor) for name, floor in floors if floor is not None}
        seen: set[tuple[int, int]] = set()
        for building, other in ((a, b), (b, a)):
            for index, level in enumerate(building.elevations):
                here = _Place(building, index, None, level)
                there = place_at(other, level, band(building, level))
                if there is None or paired & {here.key, there.key}:
                    continue
                # Two floors that are level with each other are met twice.
                both = (index, there.index) if building is a else (there.index, index)
                if there.relative_height is None and both in seen:
                    continue
                seen |= {both} if there.relative_height is None else set()
                facing = plans.faced(here, there, lacking)
                found += [] if facing is None else [facing]
        if lacking:
            unknown.append((*names, tuple(name for name in names if name in lacking)))
    return FacingFloors(
        tuple(one for one in found if one.gap >= 0.0),
        tuple(one for one in found if one.gap < 0.0),
        tuple(unknown),
    )


def band(building: Building, z: float) -> Span:
    """Elevations of the lower edge of the beams and the upper edge of a floor at a level z [m]."""
    return z - max(building.rigid_below, HALF_SLAB), z + max(building.rigid_above, HALF_SLAB)


def flexible(building: Building, index: int) -> Span:
    """Lower and upper end of the flexible part of a storey [m]."""
    levels = building.elevations
    low = levels[index - 1] + building.rigid_above if index else building.base
    return low, levels[index] - building.rigid_below


@dataclass(frozen=True)
class _Place:
    """A floor, or a point of a storey, with its level."""

    building: Building
    index: int  #: index of the floor, or of the floor above the storey
    relative_height: float | None  #: height in the storey, 0 to 1; None for a floor
    level: float  #: elevation [m]: of a floor its mass centre, of a storey that of the point

    @property
    def key(self) -> tuple[str, bool, int]:
        number = self.building.floors[self.index].floor
        return self.building.name, self.relative_height is not None, number

    def point(self, offset: list[float]) -> ContactPoint:
        name, of_storey, number = self.key
        return ContactPoint(
            building=name,
            floor=None if of_storey else number,
            storey=number if of_storey else None,
            relative_height=self.relative_height,
            offset=(offset[0], offset[1], offset[2]),
        )


def place_at(building: Building, level: float, depth: Span) -> _Place | None:
    """The nearest floor, else the storey, that meets a floor at a level within its depth [m]."""
    levels = building.elevations
    met = [
        index
        for index, z in enumerate(levels)
        if depth[0] <= z <= depth[1] or band(building, z)[0] <= level <= band(building, z)[1]
    ]
    if met:
        index = min(met, key=lambda k: abs(levels[k] - level))
        return _Place(building, index, None, levels[index])
    if not building.base < level < levels[-1]:
        return None
    index = bisect(levels, level)
    bottom, top = flexible(building, index)
    inside = min(max((level - bottom) / (top - bottom), 1e-3), 1.0 - 1e-3)
    return _Place(building, index, round(inside, 3), level)


class _Plans:
    """How far the edges of floors and the faces of storeys are from the axes."""

    def __init__(self, case: Case) -> None:
        self.contacts = case.contacts
        self.buildings = case.buildings
        every = {one.building: one.mesh for one in case.structures}
        self.meshes = {k: mesh for k, mesh in every.items() if isinstance(mesh, GeneratedMesh)}
        # Largest offset of contacts by building, storey or not, floor, axis and sign [m].
        self.offsets: dict[tuple[str, bool, int, int, int], float] = {}
        for contact in case.contacts:
            distance = pair_distance(contact, case)
            axis = max(range(3), key=lambda c: abs(contact.normal[c]))
            along = abs(contact.normal[axis]) > 1.0 - ROUNDING
            # The gap counts in a computation: offsets that contradict it are no plan.
            if not along or not abs(distance - contact.gap) <= allowed(contact.gap):
                continue
            for end, outward in contact.ends:
                sign = 1 if outward * contact.normal[axis] > 0.0 else -1
                key = (end.building, end.storey is not None, end.level, axis, sign)
                if sign * end.offset[axis] > 0.0:
                    self.offsets[key] = max(sign * end.offset[axis], self.offsets.get(key, 0.0))

    def edge(self, place: _Place, axis: int, sign: int) -> float | None:
        """Distance of the edge of a floor, or of the face of a storey, from the axis [m]."""
        own = self.offsets.get((*place.key, axis, sign))
        if own is not None:
            return own
        building = place.building
        if place.relative_height is not None:
            edge = self.edge(_Place(building, place.index, None, 0.0), axis, sign)
            return None if edge is None else edge - building.setback
        for holder in (building.floors[place.index], building, self.meshes.get(building.name)):
            size: float | None = getattr(holder, ("length", "width")[axis], None)
            if size is not None:
                return 0.5 * size
        for side in (sign, -sign):
            for of_storey, behind in ((False, 0.0), (True, building.setback)):
                known = [
                    distance + behind
                    for (name, storey, _, c, s), distance in self.offsets.items()
                    if (name, storey, c, s) == (building.name, of_storey, axis, side)
                ]
                if known:
                    return max(known)
        return None

    def across(self, place: _Place, axis: int) -> tuple[Span, bool]:
        """From where to where a place reaches along an axis, in plan [m]; whether that is all.

        Where the edges are not known, the points of contacts say how far it reaches at least.
        """
        middle = place.building.axis[axis]
        low, high = (self.edge(place, axis, sign) for sign in (-1, 1))
        if low is not None and high is not None:
            return (middle - low, middle + high), True
        ends = [end for contact in self.contacts for end, _ in contact.ends]
        known = [end.offset[axis] for end in ends if end.building == place.building.name]
        return (middle + min(known, default=0.0), middle + max(known, default=0.0)), False

    def faced(self, here: _Place, there: _Place, lacking: set[str]) -> Facing | None:
        """How a floor faces a place of another building; None where it does not.

        Where their plans are not known well enough to tell, the names of the buildings without one
        are added to those that are lacking.
        """
        unknown: set[str] = set()
        found: list[Facing] = []
        for axis in (0, 1):
            (low_a, high_a), all_a = self.across(here, 1 - axis)
            (low_b, high_b), all_b = self.across(there, 1 - axis)
            low, high = max(low_a, low_b), min(high_a, high_b)
            if all_a and all_b and high - low <= ROUNDING:
                continue  # side by side along the other axis, or corner to corner
            if self._between(here, there, axis, (min(low, high), max(low, high))):
                return None
            a, b = here.building.axis, there.building.axis
            sign = 1 if b[axis] >= a[axis] else -1
            edges = self.edge(here, axis, sign), self.edge(there, axis, -sign)
            known = (all_a, all_b) if high < low else (edges[0] is not None, edges[1] is not None)
            if high < low or edges[0] is None or edges[1] is None:
                places = zip((here, there), known, strict=True)
                unknown |= {place.building.name for place, is_known in places if not is_known}
                continue
            gap = sign * (b[axis] - a[axis]) - edges[0] - edges[1]
            gap = round(gap, 9)  # what adding coordinates leaves behind the nanometre
            gap = max(gap, 0.0) if gap > -allowed(0.0) else gap
            ends = []
            for place, edge, side in ((here, edges[0], sign), (there, edges[1], -sign)):
                offset = [0.0, 0.0, 0.0]
                offset[axis] = side * edge
                offset[1 - axis] = 0.5 * (low + high) - place.building.axis[1 - axis]
                if place.relative_height is None:
                    offset[2] = here.level - place.level
                ends.append(place.point(offset))
            heights = (max(here.level - place.building.base, 0.0) for place in (here, there))
            found.append(
                Facing(
                    a=ends[0],
                    b=ends[1],
                    normal=(0.0, float(sign), 0.0) if axis else (float(sign), 0.0, 0.0),
                    gap=gap,
                    level=here.level,
                    half=0.5 * (high - low),
                    reach=DRIFT * sum(heights),
                )
            )
        # Plans that overlap along both axes are apart along neither.
        outside = [one for one in found if one.gap >= 0.0]
        if outside:
            return min(outside, key=lambda one: one.gap)
        if len(found) == 2:
            return max(found, key=lambda one: one.gap)
        lacking |= unknown
        return None

    def _between(self, here: _Place, there: _Place, axis: int, span: Span) -> bool:
        """Whether a third building stands between two places, at their level."""
        first, last = sorted((here.building.axis[axis], there.building.axis[axis]))
        for building in self.buildings:
            ends = here.building, there.building
            if building in ends or not first < building.axis[axis] < last:
                continue
            place = place_at(building, here.level, (here.level, here.level))
            if place is not None:
                (low, high), _ = self.across(place, 1 - axis)
                if low <= span[1] and high >= span[0]:
                    return True
        return False


def depth_of(point: ContactPoint, building: Building) -> Span:
    """Elevations between which the floor of a point can be touched [m].

    In a storey they are those of the thinnest floor about the point.
    """
    index = [floor.floor for floor in building.floors].index(point.level)
    if point.floor is not None:
        return band(building, building.elevations[index])
    low, high = flexible(building, index)
    z = low + (point.relative_height or 0.0) * (high - low) + point.offset[2]
    return z - HALF_SLAB, z + HALF_SLAB


def clear_height(contact: Contact, case: Case) -> float:
    """Distance in height between the depths of both floors [m]; negative where they overlap.

    A wall is as high as the building.
    """
    depths = [depth_of(end, case.building(end.building)) for end, _ in contact.ends]
    (low_a, high_a), (low_b, high_b) = depths[0], depths[-1]
    return max(low_a - high_b, low_b - high_a)
