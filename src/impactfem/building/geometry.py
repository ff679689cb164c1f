"""What the generator builds: a rectangular building of slabs, walls, beams and columns.

The plan is 0 ≤ x ≤ length and 0 ≤ y ≤ width; floor k lies at `levels[k]`, storey k stands between
`levels[k - 1]` and `levels[k]`. Walls and slabs are their mid-planes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from impactfem.building.mesh import Part
from impactfem.building.section import BeamSection, Sections, ShellSection

Plan = tuple[float, float]
SIDES = ("x-", "x+", "y-", "y+")
PARAPET = "parapet"


@dataclass(frozen=True)
class Wall:
    """A straight wall."""

    name: str  #: The group's name behind the storey's number.
    storeys: tuple[int, ...]  #: The storeys it stands in.
    start: Plan  #: Plan position (x, y) where the places along it are counted from [m].
    end: Plan  #: Plan position of its other end [m].
    thickness: float  #: Its thickness [m].


@dataclass(frozen=True)
class Bay:
    """A rectangular opening in a wall."""

    name: str  #: Its name in the table.
    wall: str  #: Name of the wall.
    storey: int  #: The storey.
    centre: float  #: Its middle, along the wall from the wall's start [m].
    sill: float  #: Its lower edge above the slab below [m].
    width: float  #: Along the wall [m].
    height: float  #: Upwards from the sill [m].


@dataclass(frozen=True)
class Beam:
    """A straight beam in the plane of slabs."""

    name: str  #: The group's name behind the floor's number.
    floors: tuple[int, ...]  #: The floors it lies in.
    start: Plan  #: Plan position of an end [m].
    end: Plan  #: Plan position of the other end [m].
    section: BeamSection  #: Its section, with the offset of its axis from the slab's mid-plane.


@dataclass(frozen=True)
class Column:
    """A vertical column."""

    name: str  #: The group's name behind the storey's number.
    storeys: tuple[int, ...]  #: The storeys it stands in.
    place: Plan  #: Plan position [m].
    section: BeamSection  #: Its section.


@dataclass(frozen=True)
class Parapet:
    """A low wall on all edges of the top floor; it goes with the floor, not with a storey."""

    height: float  #: Above the slab's mid-plane [m].
    thickness: float  #: Its thickness [m].


@dataclass(frozen=True)
class MeshSize:
    """Target lengths of the elements' edges [m]; where parts meet, the smaller size counts."""

    floor: float  #: Of slabs and the parapet.
    storey: float  #: Of walls.
    beam: float  #: Of beams.
    column: float  #: Of columns.

    @classmethod
    def uniform(cls, size: float) -> MeshSize:
        """One size for all parts [m]."""
        return cls(size, size, size, size)


@dataclass(frozen=True)
class Geometry:
    """A building for the generator."""

    length: float  #: Along x [m].
    width: float  #: Along y [m].
    levels: tuple[float, ...]  #: Elevations of the base and of the floors, ascending [m].
    slab_thickness: float  #: Of slabs [m].
    walls: tuple[Wall, ...]
    size: MeshSize  #: Target size of the elements.
    bays: tuple[Bay, ...] = ()  #: Openings in the walls.
    beams: tuple[Beam, ...] = ()
    columns: tuple[Column, ...] = ()
    parapet: Parapet | None = None  #: The low wall on the top floor, where there is one.
    #: Thickness of the slabs of some floors, in place of slab_thickness, by their numbers [m].
    slabs: Mapping[int, float] = field(default_factory=dict)
    impact_edge: str = "y+"  #: Side of the plan that faces the other building: one of `SIDES`.

    @property
    def floors(self) -> range:
        """Numbers of the floors, bottom to top; those of the storeys are the same."""
        return range(1, len(self.levels))

    def part_sections(self) -> dict[Part, ShellSection | BeamSection]:
        """The section of every part that the generator makes."""
        sections: dict[Part, ShellSection | BeamSection] = {
            Part("floor", k): ShellSection(self.slabs.get(k, self.slab_thickness))
            for k in self.floors
        }
        if self.parapet is not None:
            top = Part("floor", self.floors[-1], PARAPET)
            sections[top] = ShellSection(self.parapet.thickness)
        for wall in self.walls:
            for k in wall.storeys:
                sections[Part("storey", k, wall.name)] = ShellSection(wall.thickness)
        for beam in self.beams:
            for k in beam.floors:
                sections[Part("beam", k, beam.name)] = beam.section
        for column in self.columns:
            for k in column.storeys:
                sections[Part("column", k, column.name)] = column.section
        return sections

    def sections(self, shell_parts: tuple[Part, ...], beam_parts: tuple[Part, ...]) -> Sections:
        """The sections of the parts of the mesh that was generated, in the mesh's order."""
        known = self.part_sections()
        shells = tuple(s for p in shell_parts if isinstance(s := known[p], ShellSection))
        beams = tuple(s for p in beam_parts if isinstance(s := known[p], BeamSection))
        return Sections(shells, beams)


@dataclass(frozen=True)
class StoreySection:
    """Gross section of a storey, cut horizontally.

    As in the shells, walls are as long as their mid-planes, and where two meet both count.
    The geometry alone: parts of another material count with their whole area, as of one material.
    """

    cut: float  #: Height of the cut above the floor below [m].
    A: float  #: Area of walls and columns [m²].
    A_vy: float  #: Shear area along y: columns, and of each wall the part A sin²α, α from x [m²].
    A_vx: float  #: Shear area along x: with A cos²α; A_vz of the paper's Appendix A [m²].
    I_x: float  #: Second moment of area for bending about x, about the centroid [m⁴].
    I_y: float  #: Second moment of area for bending about y, about the centroid [m⁴].


def storey_sections(geometry: Geometry) -> dict[int, StoreySection]:
    """The section of each storey that has walls or columns, by its number.

    Each is cut at the lowest of the heights where the area of the storey is least.
    """
    sections = {}
    for storey in geometry.floors:
        height = geometry.levels[storey] - geometry.levels[storey - 1]
        bays = [bay for bay in geometry.bays if bay.storey == storey]
        edges = {0.0, height, *(bay.sill for bay in bays), *(bay.sill + bay.height for bay in bays)}
        levels = sorted(z for z in edges if 0.0 <= z <= height)
        cuts = [0.5 * (low + high) for low, high in itertools.pairwise(levels)]
        cut_sections = [s for cut in cuts if (s := _section(geometry, storey, bays, cut))]
        if cut_sections:
            # Rounding must not choose between cuts that are equal but for it.
            sections[storey] = min(cut_sections, key=lambda s: (round(s.A, 9), s.cut))
    return sections


def _section(
    geometry: Geometry, storey: int, bays: Iterable[Bay], cut: float
) -> StoreySection | None:
    """The section at a height; walls are rectangles a by b, a along (c, s), with centres x, y."""
    opened = [bay for bay in bays if bay.sill < cut < bay.sill + bay.height]
    # What stands of each wall between its bays.
    panels = []
    for wall in geometry.walls:
        if storey not in wall.storeys:
            continue
        (x1, y1), (x2, y2) = wall.start, wall.end
        L, begin = math.dist(wall.start, wall.end), 0.0
        c, s = (x2 - x1) / L, (y2 - y1) / L
        own = [bay for bay in opened if bay.wall == wall.name]
        ends = sorted((b.centre - b.width / 2.0, b.centre + b.width / 2.0) for b in own)
        for left, right in [*ends, (L, L)]:
            if left > begin:
                at = 0.5 * (begin + left)
                panels.append((x1 + c * at, y1 + s * at, left - begin, wall.thickness, c, s))
            begin = max(begin, right)
    parts = [
        # ∫ y² dA about the centre of a rectangle is A (a² s² + b² c²) / 12.
        (x, y, a * b, a * b * c**2, a * b * s**2, *(a * b * i / 12.0 for i in own))
        for x, y, a, b, c, s in panels
        for own in [((a * s) ** 2 + (b * c) ** 2, (a * c) ** 2 + (b * s) ** 2)]
    ]
    parts += [
        (*column.place, column.section.A, *column.section.in_plan())
        for column in geometry.columns
        if storey in column.storeys
    ]
    if not parts:
        return None
    x, y, area, A_x, A_y, I_x, I_y = np.array(parts).T
    A = area.sum()
    dx, dy = x - area @ x / A, y - area @ y / A
    return StoreySection(
        cut,
        float(A),
        A_vy=float(A_y.sum()),
        A_vx=float(A_x.sum()),
        I_x=float((I_x + area * dy**2).sum()),
        I_y=float((I_y + area * dx**2).sum()),
    )
