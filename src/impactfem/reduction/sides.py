"""Places of the forces of pairs on a 3D building, and their patterns."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from impactfem.building.facade import Strip, facades
from impactfem.building.floor import contact_edge
from impactfem.building.mesh import BuildingMesh
from impactfem.case import Building3D, Contact, ContactPoint
from impactfem.case.contact_checks import calibrated_only, moved_beside, strike_fault
from impactfem.case.contacts import Vector
from impactfem.case.facade import ALIGNED, Facade, Point, axis_in_plan, struck, words_of
from impactfem.case.levels import HALF_SLAB
from impactfem.case.transient import Transient
from impactfem.reduction.edge_force import (
    EdgeForce,
    Shares,
    floor_shares,
    hat_force,
    inward,
    line_shares,
    missing,
    storey_share,
    strip_shares,
)
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault

FACADE = 1e-3
"""Difference of lengths up to which a line contact is as long as the side [m]."""
FLUSH = 0.3
"""Distance from the middle of a wall up to which the point of a pair is on its face: half of the
thickness of a wall of 60 cm [m]."""
Impulses = Mapping[int, Array]
"""Impulse of each point of contact along the edge of a floor, by floor."""


@dataclass(frozen=True, eq=False)
class PairEnd:
    """One end of a pair."""

    building: str  #: Its building; empty for a rigid wall.
    floor: int  #: Number of the floor, or of the one above for a point inside a storey.
    relative_height: float | None  #: Height in the storey, 0 to 1; None for a point of a floor.
    outward: Array  #: Unit vector towards the other end, shape (3,).
    offset: Vector | None = None  #: From the stick's axis to it [m]; None where it is not known.
    #: Of a point of contact of edges, positions along the side where its hat begins, is highest and
    #: ends [m], inside a storey three times where it acts, of a line contact where its part of the
    #: strip begins, is in the middle and ends; None for a pair of points.
    hat: tuple[float, float, float] | None = None
    #: First and last position of its line contact, from the point to the left of `outward` [m].
    span: tuple[float, float] | None = None
    depth: float | None = None  #: Depth of the slab of its line contact [m].

    @classmethod
    def of(cls, point: ContactPoint, outward: Array) -> PairEnd:
        """A point of the case, with the unit vector towards the other end, shape (3,)."""
        return cls(point.building, point.level, point.relative_height, outward, point.offset)

    @classmethod
    def both(cls, contact: Contact) -> tuple[PairEnd, PairEnd]:
        """Both ends of a contact; a rigid wall has no name."""
        n, half, s = np.array(contact.normal), 0.5 * (contact.length or 0.0), contact.along
        a = cls.of(contact.a, n)
        b = cls("", 0, None, -n) if contact.b is None else cls.of(contact.b, -n)
        if contact.length is None:
            return a, b
        return (
            replace(a, span=(-half - s, half - s), depth=contact.depth),
            replace(b, span=(-half + s, half + s), depth=contact.depth),
        )

    def part(self, facade: Facade, position: float) -> tuple[float, float]:
        """First and last position on a side of what its line contact strikes [m]."""
        left = float(-self.outward[1] * facade.along[0] + self.outward[0] * facade.along[1])
        ends = (position + s / left for s in self.span or (-np.inf, np.inf))
        low, high = sorted(min(max(s, 0.0), facade.length) for s in ends)
        return low, high

    @property
    def place(self) -> str:
        """The end in words."""
        if self.building == "":
            return "a rigid wall"
        if self.relative_height is None:
            return f"floor {self.floor} of {self.building}"
        return f"storey {self.floor} of {self.building} at {self.relative_height:.4g} of its height"


def push(end: PairEnd, facade: Facade) -> Vector:
    """Unit vector along which the force of a pair pushes a building.

    At right angles to the side if it nearly is: all such pairs share their patterns.
    """
    x, y = (-float(component) + 0.0 for component in end.outward[:2])
    direction = (x, y, 0.0)
    return inward(facade) if math.dist(direction, inward(facade)) <= ALIGNED else direction


@dataclass(frozen=True, eq=False)
class Sides:
    """Places of the forces of pairs on a building with a 3D model, and their spread."""

    building: Building3D
    mesh: BuildingMesh
    #: Of the impact on the wall, for spread `calibrated`; None before there was one.
    impulses: Impulses | None = None
    _axes: dict[str, Point] = field(default_factory=dict, init=False)

    @cached_property
    def plan(self) -> tuple[Point, Point]:
        """Lowest and highest x and y of all floors [m]."""
        nodes = self.mesh.nodes[np.unique(self.mesh.triangles[self.mesh.triangles_of("floor")])]
        (x0, y0), (x1, y1) = nodes[:, :2].min(axis=0).tolist(), nodes[:, :2].max(axis=0).tolist()
        return (x0, y0), (x1, y1)

    @property
    def spread(self) -> Transient:
        """The section that says how forces are spread; without one they are uniform."""
        return self.building.transient or Transient(time_step=1.0)

    def loaded(self, floor: int) -> Shares:
        """The patterns of a load of the case on the edge of a floor."""
        facade, _ = facades(self.mesh, floor, "")[""]
        transient = self.spread
        uniform = transient.model_copy(update={"spread": "uniform"})
        position = 0.5 * facade.length + transient.eccentricity
        return floor_shares(floor, facade, inward(facade), position, uniform)

    def point(self, end: PairEnd) -> Point:
        """An end of a pair in the plan of the mesh [m]; the axis of the stick where unknown."""
        (x, y), (dx, dy, _) = self._axis(end.building), end.offset or (0.0, 0.0, 0.0)
        return x + dx, y + dy

    def _axis(self, name: str) -> Point:
        """The axis of the stick of the building in the plan of the mesh [m]."""
        if name not in self._axes:
            points = [
                (
                    [one for one, _ in facades(self.mesh, point.floor).values()],
                    point.offset,
                    (sign * contact.normal[0], sign * contact.normal[1], 0.0),
                )
                for contact in self.building.case.contacts
                for point, sign in contact.ends
                if point.building == name and point.floor is not None
            ]
            self._axes[name] = axis_in_plan(
                self.building.case.building(name).axis, *self.plan, points
            )
        return self._axes[name]

    def met(self, path: Path, pair: str, end: PairEnd) -> tuple[Facade, float] | Fault:
        """The side that a pair strikes, and where [m]; none that it does is a fault."""
        inside = end.relative_height is not None
        x, y, z = (float(component) for component in end.outward)
        sides = [one for one, _ in facades(self.mesh, end.floor).values()]
        if not sides:
            known = ", ".join(map(str, self.mesh.floors)) or "none"
            expected = f"expected a floor that is in the mesh, which has {known}"
            return Fault(path, f"pair {pair}", end.place, expected)
        met = struck(sides, self.point(end), (x, y, 0.0)) if abs(z) <= ALIGNED else None
        wrong = strike_fault(
            (x, y, z), end.offset or (0.0, 0.0, 0.0), inside, sides, met is not None
        )
        if wrong is not None or met is None:
            key, expected = wrong or ("", "")
            if key == "normal":
                key, value = f"normal out of {end.building}", words_of((x, y, z))
            else:
                key, value = f"offset on {end.building}", words_of(end.offset or ())
            return Fault(path, f"pair {pair}, {key}", value, expected)
        return met

    def point_force(self, end: PairEnd, facade: Facade) -> EdgeForce | str:
        """The force of a point of contact along a side, or why nothing takes it, in words."""
        before, at, behind = end.hat or (0.0, 0.0, 0.0)
        direction = push(end, facade)
        if end.relative_height is None:
            return hat_force(end.floor, facade, direction, before, at, behind)
        height = self.elevation(end)
        if end.depth is not None and behind > before:
            strip = Strip(before, behind, height, end.depth)
            shares = strip_shares(end.floor, facade, direction, at, strip)
        else:
            shares = storey_share(end.floor, facade, direction, at, height, self.spread)
        if lacking := missing(self.mesh, shares):
            return lacking
        force, outward = shares[0][0], np.array(facade.outward[:2])
        # What stands farther behind the pair's point, as behind a loggia, has another gap.
        nodes = self.mesh.nodes[force.load(self.mesh).nodes, :2]
        depth = outward @ self.point(end) - float((nodes @ outward).max())
        if abs(depth) <= FLUSH:
            return force
        where = "behind" if depth > 0.0 else "in front of"
        return f"its walls and columns stand {abs(depth):.3g} m {where} the point of the pair"

    def shares(self, path: Path, pair: str, end: PairEnd) -> Shares | Fault:
        """The patterns of the force of a pair; what the building cannot take of it is a fault."""
        transient, inside = self.spread, end.relative_height is not None
        met = self.met(path, pair, end)
        if isinstance(met, Fault):
            return met
        facade, position = met
        if end.offset is None:
            position = 0.5 * facade.length
        if end.hat is not None:
            force = self.point_force(end, facade)
            if not isinstance(force, str):
                return ((force, 1.0),)
            return Fault(path, f"pair {pair}", end.place, force)
        if expected := moved_beside((facade, position), transient.eccentricity):
            value = f"{transient.eccentricity:g} m"
            return Fault(self.building.case.path, "transient.eccentricity", value, expected)
        position += transient.eccentricity
        direction = push(end, facade)
        part = end.part(facade, position)
        if inside:
            height = self.elevation(end)
            if end.span is None:
                found = storey_share(end.floor, facade, direction, position, height, transient)
            else:
                strip = Strip(*part, height, end.depth or 2.0 * HALF_SLAB)
                found = strip_shares(end.floor, facade, direction, position, strip)
            if there := missing(self.mesh, found):
                expected = (
                    f"expected walls or columns that take the force: {there}; see offset of the "
                    "pair and [transient] patch_width"
                )
                return Fault(path, f"pair {pair}", end.place, expected)
            return found
        contacts = None
        if transient.spread == "calibrated":
            wall = self.building.wall_impact
            if wall is None or end.floor not in wall.floors or facade.side:
                what = f"{end.place} on {facade.side}" if facade.side else end.place
                expected = calibrated_only(what, end.building)
                return Fault(self.building.case.path, "transient.spread", "calibrated", expected)
            edge = contact_edge(self.mesh, end.floor, wall.contact_spacing)
            # Even ones before `calibrate` has found the impulses.
            impulse = edge.weight if self.impulses is None else self.impulses[end.floor]
            contacts = edge.position, edge.weight, impulse
            if not impulse.sum() > 0.0:
                expected = (
                    f"expected 'uniform' or 'patch': floor {end.floor} took no impulse in the "
                    "first impact on the wall, of the top floor"
                )
                return Fault(self.building.case.path, "transient.spread", "calibrated", expected)
        if transient.spread == "uniform" and part[1] - part[0] < facade.length - FACADE:
            return line_shares(end.floor, facade, direction, position, part)
        return floor_shares(end.floor, facade, direction, position, transient, contacts)

    def elevation(self, end: PairEnd) -> float:
        """Elevation of a point inside a storey, in the mesh [m]."""
        building, levels = self.building.case.building(end.building), self.mesh.elevations
        below = [level for floor, level in levels.items() if floor < end.floor]
        high = levels[end.floor]
        # As high as in the floor table, whose zero may be another than that of the mesh.
        low = max(below, default=high - building.elevations[0] + building.base)
        z = end.offset[2] if end.offset is not None else 0.0
        return low + float(end.relative_height or 0.0) * (high - low) + z
