"""Contact pairs of neighbouring buildings from their plans, levels and depths.

Each floor of a building meets the floor of its neighbour whose depth overlaps with its own, or the
storey at its level, where their plans face each other (`plan.opposites`). Two buildings meet where
the gap is at most what a drift of `DRIFT` of both closes.

The work is of the order of the number of floors: the neighbour's floor is found by bisection, and
lengths that face each other are computed once for each two plans.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations

from impactfem.case.buildings import Building
from impactfem.case.contacts import ContactEnd, ContactEntry, ContactPoint, ContactSearch, Vector
from impactfem.case.levels import LEVEL, Level, band, clear_height, level_at, slab_depth
from impactfem.case.model import Case
from impactfem.case.plan import Opposite, Polygon, apart, crosses, extent, opposites, overlap

DRIFT = 0.025
"""Largest drift that counts as possible before anything is computed: ASCE 7-22, table 12.12-1."""
DECIMALS = 9
"""Of places of pairs, in metres: sums of coordinates leave rounding behind."""


@dataclass(frozen=True)
class Facing:
    """A floor and a floor or storey of a neighbour that face each other over a length."""

    here: Level  #: of the building that is first in the case file
    there: Level
    opposite: Opposite  #: where their plans face each other
    level: float  #: elevation of the contact [m]
    depth: float | None  #: depth of the slab edges in contact [m]; None if not known

    @property
    def a(self) -> ContactPoint:
        """The middle of the length on the first building."""
        return self._point(self.here, self.opposite.a)

    @property
    def b(self) -> ContactPoint:
        """The middle of the length on the second building."""
        return self._point(self.there, self.opposite.b)

    def _point(self, at: Level, place: tuple[float, float]) -> ContactPoint:
        x, y = (p - q for p, q in zip(place, at.building.axis, strict=True))
        z = self.level - at.z
        if at.relative_height is None and at.building.structure is not None:
            z = 0.0  # a 3D model takes the force of a floor in its slab
        elif at.relative_height is None:
            low, high = band(at.building, at.z)
            z = min(max(z, low - at.z), high - at.z)
        name, of_storey, number = at.key
        return ContactPoint(
            building=name,
            floor=None if of_storey else number,
            storey=number if of_storey else None,
            relative_height=at.relative_height,
            offset=(round(x, DECIMALS) + 0.0, round(y, DECIMALS) + 0.0, round(z, DECIMALS) + 0.0),
        )

    @property
    def normal(self) -> Vector:
        """Unit vector from a to b."""
        return self.opposite.normal

    @property
    def gap(self) -> float:
        """Smallest distance at rest [m]."""
        return max(self.opposite.least_gap, 0.0)

    @property
    def half(self) -> float:
        """Half of the common length [m]."""
        return 0.5 * self.opposite.length

    @property
    def reach(self) -> float:
        """Distance that a drift of `DRIFT` of both buildings closes [m]."""
        return reach(self.here.building, self.there.building, self.level)

    @property
    def name(self) -> str:
        """Both ends, as the name of a pair: ``B.floor_4-C.floor_3``."""
        return f"{self.a.label}-{self.b.label}"

    @property
    def words(self) -> str:
        """Both ends and their distance in words."""
        apart = f"{1e3 * self.gap:.4g} mm apart at {self.level:.4g} m"
        return f"{self.a.label} and {self.b.label} ({apart})"


def reach(a: Building, b: Building, z: float) -> float:
    """Return how far both buildings move towards each other by a drift of `DRIFT` at z [m]."""
    return DRIFT * sum(max(z - building.base, 0.0) for building in (a, b))


@dataclass
class FacingFloors:
    """Floors that face each other and are in no contact pair."""

    pairs: list[Facing] = field(default_factory=list)
    #: Pairs of buildings whose plans overlap: their names, and the label of a floor.
    overlapping: list[tuple[str, str, str]] = field(default_factory=list)
    #: Names of two buildings with floors at one level in no pair, and of those without a plan.
    unknown: list[tuple[str, str, tuple[str, ...]]] = field(default_factory=list)

    @property
    def near(self) -> list[Facing]:
        """Those that come together within a drift of `DRIFT` of both buildings."""
        return [pair for pair in self.pairs if pair.gap <= pair.reach]

    def lines(self, most: int = 6) -> list[str]:
        """Return a warning for each two buildings, with at most so many pairs by name."""
        by_buildings: dict[tuple[str, str], list[Facing]] = defaultdict(list)
        for pair in sorted(self.near, key=lambda pair: pair.gap):
            by_buildings[pair.a.building, pair.b.building].append(pair)
        return [
            "contacts: floors that face each other and are in no pair: "
            + ", ".join(pair.words for pair in pairs[:most])
            + (f" and {len(pairs) - most} more" if len(pairs) > most else "")
            + '; type [contact_search] with law = "..." to add them, or give the plan and setback '
            "of [[buildings]] where they cannot meet"
            for pairs in by_buildings.values()
        ]

    @property
    def unknown_lines(self) -> list[str]:
        """Name the missing plans and the keys that give them, a line for each two buildings."""
        return [
            f"facing floors: whether floors of {a} and {b} that are in no pair meet cannot be "
            f"checked without the plan of {' and '.join(names)}: type length and width, or plan, "
            "of [[buildings]]"
            for a, b, names in self.unknown
        ]


def facing_floors(case: Case, buildings: Sequence[str] | None = None) -> FacingFloors:
    """Find floors of neighbours that face each other, or a storey of each other, in no pair.

    Args:
        case: The case.
        buildings: Names of the buildings; default all.
    """
    found = FacingFloors()
    paired = _paired(case)
    chosen = [one for one in case.buildings if buildings is None or one.name in buildings]
    for a, b in combinations(chosen, 2):
        lacking = dict[str, None]()
        overlapping = ""
        for here, there in _levels(a, b, paired):
            plans = here.plan, there.plan
            if plans[0] is None or plans[1] is None:
                ends = [one for one, plan in zip((here, there), plans, strict=True) if plan is None]
                if not any(
                    crosses(plan, a.axis, b.axis)
                    for plan in _others(case.buildings, here, there, (a.axis, b.axis))
                ):
                    lacking |= dict.fromkeys(one.building.name for one in ends)
            elif overlap(*plans):
                overlapping = overlapping or f"{a.name}.floor_{here.key[2]}"
            else:
                corners = (*plans[0], *plans[1])
                between = tuple(_others(case.buildings, here, there, corners))
                level, depth = _contact(here, there)
                found.pairs += [
                    Facing(here, there, one, level, depth) for one in opposites(*plans, between)
                ]
        if overlapping:
            found.overlapping.append((a.name, b.name, overlapping))
        if lacking:
            found.unknown.append((a.name, b.name, tuple(lacking)))
    return found


def searched(case: Case, search: ContactSearch) -> tuple[ContactEntry, ...]:
    """Return the pairs of [contact_search], as tables of [[contacts]].

    Floors with the same pair but for their numbers are one table.
    """
    groups: dict[str, tuple[ContactEntry, list[int], list[int]]] = {}
    for one in facing_floors(case, search.buildings).pairs:
        largest = one.reach if search.largest_gap is None else search.largest_gap
        if one.gap > largest:
            continue
        a, b = one.a, one.b
        law = search.law if a.storey is None and b.storey is None else search.storey_law
        entry = ContactEntry.model_construct(
            a=_end(a, ()),
            b=_end(b, ()),
            normal=one.normal,
            gap=round(one.opposite.gap, DECIMALS),
            law=law or search.law,
            length=round(one.opposite.length, DECIMALS),
            points=search.points,
            depth=None if one.depth is None else round(one.depth, DECIMALS),
            gap_slope=one.opposite.gap_slope,
        )
        _, floors_a, floors_b = groups.setdefault(entry.model_dump_json(), (entry, [], []))
        floors_a.append(a.level)
        floors_b.append(b.level)
    return tuple(
        entry.model_copy(update={"a": _end(entry.a, first), "b": _end(entry.b, second)})
        for entry, first, second in groups.values()
        if entry.b is not None
    )


def _end(of: ContactPoint | ContactEnd, floors: Iterable[int]) -> ContactEnd:
    """Return the end of a table of contacts with the place of a point, on some floors."""
    height, numbers = of.relative_height, tuple(floors)
    on_floor = height is None
    return ContactEnd.model_construct(
        building=of.building,
        floor=numbers if on_floor else None,
        storey=None if on_floor else numbers,
        relative_height=height if isinstance(height, tuple) or height is None else (height,),
        offset=of.offset,
    )


def _paired(case: Case) -> dict[frozenset[str], set[tuple[str, bool, int]]]:
    """Return the floors that a pair joins to a point of another building at their level."""
    paired = defaultdict[frozenset[str], set[tuple[str, bool, int]]](set)
    for contact in case.contacts:
        if contact.b is not None and clear_height(contact, case) <= LEVEL:
            paired[frozenset(contact.buildings)] |= {
                (end.building, False, end.floor) for end, _ in contact.ends if end.floor is not None
            }
    return paired


def _levels(
    a: Building, b: Building, paired: dict[frozenset[str], set[tuple[str, bool, int]]]
) -> Iterator[tuple[Level, Level]]:
    """Yield what meets in height and is in no pair: of the first, of the second building."""
    known = paired.get(frozenset((a.name, b.name)), set())
    seen = set[tuple[int, int]]()
    for building, other in ((a, b), (b, a)):
        for index, z in enumerate(building.elevations):
            here = Level(building, index, None, z)
            there = level_at(other, z, band(building, z))
            if there is None or known & {here.key, there.key}:
                continue
            both = (here, there) if building is a else (there, here)
            # Two floors that are level with each other are met twice.
            floors = both[0].index, both[1].index
            if there.relative_height is None and floors in seen:
                continue
            if there.relative_height is None:
                seen.add(floors)
            yield both


def _others(
    buildings: Iterable[Building], here: Level, there: Level, corners: Polygon
) -> Iterator[Polygon]:
    """Yield the plans of further buildings at the level in the bounding box of some points."""
    (x1, x2), (y1, y2) = (extent(corners, axis) for axis in ((1.0, 0.0), (0.0, 1.0)))
    z = here.z if here.relative_height is None else there.z
    for building in buildings:
        if building in (here.building, there.building):
            continue
        at = level_at(building, z, (z - LEVEL, z + LEVEL))
        plan = None if at is None else at.plan
        if plan is not None and apart(plan, ((x1, y1), (x2, y1), (x2, y2), (x1, y2))) == 0.0:
            yield plan


def _contact(here: Level, there: Level) -> tuple[float, float | None]:
    """Return the elevation of a contact and the depth of the slab edges in contact [m].

    It is that of the floor with a 3D model, else the mean, within both depths.
    """
    floors = [one for one in (here, there) if one.relative_height is None]
    depths = [slab_depth(one.building, one.index) for one in floors]
    known = [depth for depth in depths if depth is not None]
    if len(floors) < 2:
        return floors[0].z, known[0] if known else None
    bands = [band(one.building, one.z) for one in floors]
    low, high = max(span[0] for span in bands), min(span[1] for span in bands)
    in_3d = [one.z for one in floors if one.building.structure is not None]
    middle = in_3d[0] if len(in_3d) == 1 else 0.5 * (here.z + there.z)
    depth = min(*known, high - low) if len(known) == 2 else None
    return min(max(middle, low), high), depth
