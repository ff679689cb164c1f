"""Floors and storeys of a building at an elevation: their depth, their plan, and what meets them.

The depth of a floor is from the lower edge of its beams to the upper edge of its rigid zone. Two
floors meet where their depths overlap. A floor that meets no floor of its neighbour meets the
storey at its level.
"""

from bisect import bisect
from dataclasses import dataclass
from functools import cached_property

from impactfem.case.buildings import Building, GeneratedMesh
from impactfem.case.contacts import HEIGHT_DECIMALS, Contact, ContactPoint
from impactfem.case.facade import axis_in_plan
from impactfem.case.model import Case
from impactfem.case.plan import Polygon, inset, moved

HALF_SLAB = 0.15
"""Half of the least height of a floor's edge [m], where its rigid zones are thinner."""
LEVEL = 1e-6
"""Overlap of depths up to which floors do not meet [m]."""

Span = tuple[float, float]


def band(building: Building, z: float) -> Span:
    """Elevations of the lower edge of the beams and the upper edge of a floor at a level z [m]."""
    return z - max(building.rigid_below, HALF_SLAB), z + max(building.rigid_above, HALF_SLAB)


def flexible(building: Building, index: int) -> Span:
    """Lower and upper end of the flexible part of a storey [m]."""
    levels = building.elevations
    low = levels[index - 1] + building.rigid_above if index else building.base
    return low, levels[index] - building.rigid_below


def storey_level(building: Building, index: int, relative_height: float) -> float:
    """Return the elevation of a relative height in a storey, from floor to floor [m]."""
    top, height = building.elevations[index], building.floors[index].storey_height
    return top - (1.0 - relative_height) * height


def plan_of(building: Building, index: int) -> Polygon | None:
    """Return the plan of a floor from the axis; None where the case does not give it.

    In this order: `plans`, length and width of the floor, `plan`, length and width of the building,
    and those of a generated mesh.
    """
    floor = building.floors[index]
    own = next((one.plan for one in building.plans if floor.floor in one.floors), None)
    if own is not None:
        return own
    if building.plan is not None and floor.length is None and floor.width is None:
        return building.plan
    mesh = building.structure.mesh if building.structure is not None else None
    sides = (mesh.length, mesh.width) if isinstance(mesh, GeneratedMesh) else None
    spans = list[Span]()
    for c, key in enumerate(("length", "width")):
        size = getattr(floor, key) or getattr(building, key)
        if size is None and sides is None:
            return None
        at = 0.5 * (size or 0.0)
        if size is None and sides is not None:
            size, at = sides[c], axis_in_plan(building.axis, (0.0, 0.0), sides)[c]
        spans.append((-at, size - at))
    (x1, x2), (y1, y2) = spans
    return (x1, y1), (x2, y1), (x2, y2), (x1, y2)


def slab_depth(building: Building, index: int) -> float | None:
    """Return the depth of the edge of a slab [m]; None where the case does not give it."""
    mesh = building.structure.mesh if building.structure is not None else None
    if building.slab_depth is None and isinstance(mesh, GeneratedMesh):
        return mesh.slab(building.floors[index].floor)
    return building.slab_depth


@dataclass(frozen=True)
class Level:
    """A floor, or a point of a storey, with its elevation."""

    building: Building
    index: int  #: index of the floor, or of the floor above the storey
    relative_height: float | None  #: height in the storey, 0 to 1; None for a floor
    z: float  #: elevation [m]: of a floor its mass centre, of a storey that of the point

    @property
    def key(self) -> tuple[str, bool, int]:
        """Name of the building, whether it is a storey, and number of the floor."""
        number = self.building.floors[self.index].floor
        return self.building.name, self.relative_height is not None, number

    @cached_property
    def plan(self) -> Polygon | None:
        """Global plan of its edges, of a storey of its columns and walls; None if not known."""
        plan = plan_of(self.building, self.index)
        if plan is not None and self.relative_height is not None:
            plan = inset(plan, self.building.setback)
        return None if plan is None else moved(plan, self.building.axis)


def level_at(building: Building, z: float, depth: Span) -> Level | None:
    """Return the nearest floor that a floor at a level z meets within its depth, else the storey.

    None above the roof and below the base.
    """
    levels = building.elevations
    # Floors are in ascending order: those beyond the depth of the highest band are skipped.
    reach = max(building.rigid_below, building.rigid_above, HALF_SLAB)
    first, last = bisect(levels, depth[0] - reach - LEVEL), bisect(levels, depth[1] + reach + LEVEL)
    bands = {k: band(building, levels[k]) for k in range(first, last)}
    met = [
        k for k, (low, high) in bands.items() if min(high, depth[1]) - max(low, depth[0]) > LEVEL
    ]
    if met:
        index = min(met, key=lambda k: abs(levels[k] - z))
        return Level(building, index, None, levels[index])
    if not building.base < z < levels[-1]:
        return None
    index = bisect(levels, z)
    bottom, top = flexible(building, index)
    height = building.floors[index].storey_height
    inside = min(max(z, bottom + 1e-3 * height), top - 1e-3 * height)
    relative = round(1.0 - (levels[index] - inside) / height, HEIGHT_DECIMALS)
    return Level(building, index, relative, z)


def depth_of(point: ContactPoint, building: Building) -> Span:
    """Elevations between which the floor of a point can be touched [m].

    In a storey they are those of the thinnest floor about the point.
    """
    index = [floor.floor for floor in building.floors].index(point.level)
    if point.floor is not None:
        return band(building, building.elevations[index])
    z = storey_level(building, index, point.relative_height or 0.0) + point.offset[2]
    return z - HALF_SLAB, z + HALF_SLAB


def clear_height(contact: Contact, case: Case) -> float:
    """Distance in height between the depths of both floors [m]; negative where they overlap.

    A wall is as high as the building.
    """
    depths = [depth_of(end, case.building(end.building)) for end, _ in contact.ends]
    (low_a, high_a), (low_b, high_b) = depths[0], depths[-1]
    return max(low_a - high_b, low_b - high_a)
