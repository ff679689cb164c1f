"""Where the forces of pairs act on a 3D building, and what patterns they are made of."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from impactfem.building.facade import facades
from impactfem.building.mesh import BuildingMesh
from impactfem.case import Case
from impactfem.case.contact_checks import calibrated_only, moved_beside, strike_fault
from impactfem.case.contacts import Vector
from impactfem.case.facade import ALIGNED, Point, moved_into_plan, struck, words_of
from impactfem.case.transient import Transient
from impactfem.reduction.edge_force import (
    Shares,
    floor_shares,
    inward,
    missing,
    storey_share,
    wall_contacts,
)
from impactfem.system.errors import Fault

Array = NDArray[np.float64]
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

    @property
    def place(self) -> str:
        """The end in words."""
        if self.building == "":
            return "a rigid wall"
        if self.relative_height is None:
            return f"floor {self.floor} of {self.building}"
        return f"storey {self.floor} of {self.building} at {self.relative_height:g} of its height"


@dataclass(frozen=True, eq=False)
class Sides:
    """Where the forces of pairs act on the 3D building of a case, and how they are spread."""

    case: Case
    mesh: BuildingMesh
    #: Of the impact on the wall, for spread `calibrated`; None before there was one.
    impulses: Impulses | None = None

    @cached_property
    def plan(self) -> tuple[Point, Point]:
        """Lowest and highest x and y of all floors [m]."""
        nodes = self.mesh.nodes[np.unique(self.mesh.triangles[self.mesh.triangles_of("floor")])]
        (x0, y0), (x1, y1) = nodes[:, :2].min(axis=0).tolist(), nodes[:, :2].max(axis=0).tolist()
        return (x0, y0), (x1, y1)

    @property
    def spread(self) -> Transient:
        """The section that says how forces are spread; without one they are uniform."""
        return self.case.transient or Transient(time_step=1.0)

    def loaded(self, floor: int) -> Shares:
        """The patterns of a load of the case on the edge of a floor."""
        facade, _ = facades(self.mesh, floor, "")[""]
        transient = self.spread
        uniform = transient.model_copy(update={"spread": "uniform"})
        position = 0.5 * facade.length + transient.eccentricity
        return floor_shares(floor, facade, inward(facade), position, uniform)

    def shares(self, path: Path, pair: str, end: PairEnd) -> Shares | Fault:
        """The patterns of the force of a pair; what the building cannot take of it is a fault."""
        transient, inside = self.spread, end.relative_height is not None
        x, y, z = (float(component) for component in end.outward)
        sides = [one for one, _ in facades(self.mesh, end.floor).values()]
        if not sides:
            known = ", ".join(map(str, self.mesh.floors)) or "none"
            expected = f"expected a floor that is in the mesh, which has {known}"
            return Fault(path, f"pair {pair}", end.place, expected)
        low, high = self.plan
        axis = self.case.building(end.building).axis
        point = moved_into_plan(axis, end.offset or (0.0, 0.0, 0.0), low, high)
        met = struck(sides, point, (x, y, 0.0)) if abs(z) <= ALIGNED else None
        wrong = strike_fault(
            (x, y, z),
            end.offset or (0.0, 0.0, 0.0),
            inside,
            sides,
            met is not None,
        )
        if wrong is not None or met is None:
            key, expected = wrong or ("", "")
            if key == "normal":
                key, value = f"normal out of {end.building}", words_of((x, y, z))
            else:
                key, value = f"offset on {end.building}", words_of(end.offset or ())
            return Fault(path, f"pair {pair}, {key}", value, expected)
        facade, position = met
        if end.offset is None:
            position = 0.5 * facade.length
        if expected := moved_beside((facade, position), transient.eccentricity):
            value = f"{transient.eccentricity:g} m"
            return Fault(self.case.path, "transient.eccentricity", value, expected)
        position += transient.eccentricity
        # At right angles to the side where it is meant so: all such pairs share their patterns.
        direction = (-x + 0.0, -y + 0.0, 0.0)
        if math.dist(direction, inward(facade)) <= ALIGNED:
            direction = inward(facade)
        if inside:
            height = self._elevation(end)
            found = storey_share(end.floor, facade, direction, position, height, transient)
            if there := missing(self.mesh, found):
                expected = (
                    f"expected walls or columns that take the force: {there}; see offset of the "
                    "pair and [transient] patch_width"
                )
                return Fault(path, f"pair {pair}", end.place, expected)
            return found
        contacts = None
        if transient.spread == "calibrated":
            wall = self.case.wall_impact
            if wall is None or end.floor not in wall.floors or facade.side:
                what = f"{end.place} on {facade.side}" if facade.side else end.place
                expected = calibrated_only(what, end.building)
                return Fault(self.case.path, "transient.spread", "calibrated", expected)
            contacts = wall_contacts(self.mesh, end.floor, wall.contact_spacing, self.impulses)
            if not contacts[2].sum() > 0.0:
                expected = (
                    f"expected 'uniform' or 'patch': floor {end.floor} took no impulse in the "
                    "first impact on the wall, of the top floor"
                )
                return Fault(self.case.path, "transient.spread", "calibrated", expected)
        return floor_shares(end.floor, facade, direction, position, transient, contacts)

    def _elevation(self, end: PairEnd) -> float:
        """Elevation of a point inside a storey, between its rigid zones, in the mesh [m]."""
        building, levels = self.case.building(end.building), self.mesh.elevations
        below = [level for floor, level in levels.items() if floor < end.floor]
        low = max(below) + building.rigid_above if below else building.base
        high = levels[end.floor] - building.rigid_below
        z = end.offset[2] if end.offset is not None else 0.0
        return low + float(end.relative_height or 0.0) * (high - low) + z
