"""What the generator builds: a rectangular building of slabs, walls, beams and columns.

The plan is 0 ≤ x ≤ length and 0 ≤ y ≤ width; floor k lies at `levels[k]`, storey k stands between
`levels[k - 1]` and `levels[k]`. Walls and slabs are their mid-planes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from impactfem.building.mesh import Part
from impactfem.building.section import BeamSection, Sections, ShellSection

Plan = tuple[float, float]
SIDES = ("x-", "x+", "y-", "y+")
ACROTERION = "acroterion"


@dataclass(frozen=True)
class Wall:
    """A straight wall.

    Args:
        name: The group's name behind the storey's number.
        storeys: The storeys it stands in.
        start: Plan position (x, y) where the places along it are counted from [m].
        end: Plan position of its other end [m].
        thickness: Its thickness [m].
    """

    name: str
    storeys: tuple[int, ...]
    start: Plan
    end: Plan
    thickness: float


@dataclass(frozen=True)
class Bay:
    """A rectangular opening in a wall.

    Args:
        name: Its name in the table.
        wall: Name of the wall.
        storey: The storey.
        centre: Its middle, along the wall from the wall's start [m].
        sill: Its lower edge above the slab below [m].
        width: Along the wall [m].
        height: Upwards from the sill [m].
    """

    name: str
    wall: str
    storey: int
    centre: float
    sill: float
    width: float
    height: float


@dataclass(frozen=True)
class Beam:
    """A straight beam in the plane of slabs, rectangular.

    Args:
        name: The group's name behind the floor's number.
        floors: The floors it lies in.
        start: Plan position of an end [m].
        end: Plan position of the other end [m].
        width: Horizontal side [m].
        depth: Vertical side [m].
        offset: Its axis above the slab's mid-plane, negative below [m].
    """

    name: str
    floors: tuple[int, ...]
    start: Plan
    end: Plan
    width: float
    depth: float
    offset: float = 0.0


@dataclass(frozen=True)
class Column:
    """A vertical column, rectangular.

    Args:
        name: The group's name behind the storey's number.
        storeys: The storeys it stands in.
        place: Plan position [m].
        width_x: Side along x [m].
        width_y: Side along y [m].
    """

    name: str
    storeys: tuple[int, ...]
    place: Plan
    width_x: float
    width_y: float


@dataclass(frozen=True)
class Acroterion:
    """A low wall on all edges of the top floor; it goes with the floor, not with a storey.

    Args:
        height: Above the slab's mid-plane [m].
        thickness: Its thickness [m].
    """

    height: float
    thickness: float


@dataclass(frozen=True)
class MeshSize:
    """Target lengths of the elements' edges.

    Where parts meet, the smaller size counts.

    Args:
        floor: Of slabs and the acroterion [m].
        storey: Of walls [m].
        beam: Of beams [m].
        column: Of columns [m].
    """

    floor: float
    storey: float
    beam: float
    column: float

    @classmethod
    def uniform(cls, size: float) -> MeshSize:
        """One size for all parts [m]."""
        return cls(size, size, size, size)


@dataclass(frozen=True)
class Geometry:
    """A building for the generator.

    Args:
        length: Along x [m].
        width: Along y [m].
        levels: Elevations of the base and of the floors, ascending [m].
        slab_thickness: Of all slabs [m].
        walls: The walls.
        size: Target size of the elements.
        bays: Openings in the walls.
        beams: The beams.
        columns: The columns.
        acroterion: The low wall on the top floor, where there is one.
        impact_edge: Side of the plan that faces the other building: one of `SIDES`.
    """

    length: float
    width: float
    levels: tuple[float, ...]
    slab_thickness: float
    walls: tuple[Wall, ...]
    size: MeshSize
    bays: tuple[Bay, ...] = ()
    beams: tuple[Beam, ...] = ()
    columns: tuple[Column, ...] = ()
    acroterion: Acroterion | None = None
    impact_edge: str = "y+"

    @property
    def floors(self) -> range:
        """Numbers of the floors, bottom to top; those of the storeys are the same."""
        return range(1, len(self.levels))

    def part_sections(self) -> dict[Part, ShellSection | BeamSection]:
        """The section of every part that the generator makes."""
        sections: dict[Part, ShellSection | BeamSection] = {
            Part("floor", k): ShellSection(self.slab_thickness) for k in self.floors
        }
        if self.acroterion is not None:
            top = Part("floor", self.floors[-1], ACROTERION)
            sections[top] = ShellSection(self.acroterion.thickness)
        for wall in self.walls:
            for k in wall.storeys:
                sections[Part("storey", k, wall.name)] = ShellSection(wall.thickness)
        for beam in self.beams:
            for k in beam.floors:
                section = BeamSection.beam(beam.width, beam.depth, beam.offset)
                sections[Part("beam", k, beam.name)] = section
        for column in self.columns:
            for k in column.storeys:
                section = BeamSection.column(column.width_x, column.width_y)
                sections[Part("column", k, column.name)] = section
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

    Args:
        cut: Height of the cut above the floor below [m].
        A: Area of walls and columns [m²].
        A_vy: Shear area along y: columns, and of each wall the part A sin²α, with α from x [m²].
        A_vz: Shear area along x, so named in the paper's Appendix A: columns and A cos²α [m²].
        I_x: Second moment of area for bending about x, about the centroid [m⁴].
        I_y: Second moment of area for bending about y, about the centroid [m⁴].
    """

    cut: float
    A: float
    A_vy: float
    A_vz: float
    I_x: float
    I_y: float


@dataclass(frozen=True)
class _Rectangle:
    """A rectangle in plan: centre, length a along (c, s), and width b across."""

    x: float
    y: float
    a: float
    b: float
    c: float
    s: float

    @property
    def area(self) -> float:
        return self.a * self.b

    def second_moments(self, x_c: float, y_c: float) -> tuple[float, float]:
        """I_x and I_y about axes through a point: of the rectangle, and of its distance.

        ∫ y² dA about the centre is A (a² s² + b² c²) / 12, ∫ x² dA is A (a² c² + b² s²) / 12.
        """
        a2, b2, c2, s2 = self.a**2, self.b**2, self.c**2, self.s**2
        I_x = self.area * ((a2 * s2 + b2 * c2) / 12.0 + (self.y - y_c) ** 2)
        I_y = self.area * ((a2 * c2 + b2 * s2) / 12.0 + (self.x - x_c) ** 2)
        return I_x, I_y


def storey_sections(geometry: Geometry) -> dict[int, StoreySection]:
    """The section of each storey that has walls or columns, by its number."""
    sections = {storey: storey_section(geometry, storey) for storey in geometry.floors}
    return {storey: section for storey, section in sections.items() if section is not None}


def storey_section(geometry: Geometry, storey: int) -> StoreySection | None:
    """The section of a storey at the lowest of the heights where its area is least.

    Args:
        geometry: The building.
        storey: Number of the storey.

    Returns:
        The section, or None for a storey without walls and columns.
    """
    height = geometry.levels[storey] - geometry.levels[storey - 1]
    walls = [wall for wall in geometry.walls if storey in wall.storeys]
    columns = [column for column in geometry.columns if storey in column.storeys]
    bays = [bay for bay in geometry.bays if bay.storey == storey]
    edges = {0.0, height, *(bay.sill for bay in bays), *(bay.sill + bay.height for bay in bays)}
    levels = sorted(z for z in edges if 0.0 <= z <= height)
    cuts = [0.5 * (low + high) for low, high in itertools.pairwise(levels)]
    sections = [s for cut in cuts if (s := _section(walls, columns, bays, cut)) is not None]
    # Rounding must not choose between cuts that are equal but for it.
    return min(sections, key=lambda section: (round(section.A, 9), section.cut), default=None)


def _section(
    walls: Iterable[Wall], columns: Iterable[Column], bays: Iterable[Bay], cut: float
) -> StoreySection | None:
    open_here = [bay for bay in bays if bay.sill < cut < bay.sill + bay.height]
    posts = [
        _Rectangle(*column.place, column.width_x, column.width_y, 1.0, 0.0) for column in columns
    ]
    panels = [
        panel
        for wall in walls
        for panel in _panels(wall, [bay for bay in open_here if bay.wall == wall.name])
    ]
    pieces = [*panels, *posts]
    A = math.fsum(piece.area for piece in pieces)
    if A == 0.0:
        return None
    x_c = math.fsum(piece.area * piece.x for piece in pieces) / A
    y_c = math.fsum(piece.area * piece.y for piece in pieces) / A
    moments = [piece.second_moments(x_c, y_c) for piece in pieces]
    A_columns = math.fsum(post.area for post in posts)
    return StoreySection(
        cut=cut,
        A=A,
        A_vy=A_columns + math.fsum(panel.area * panel.s**2 for panel in panels),
        A_vz=A_columns + math.fsum(panel.area * panel.c**2 for panel in panels),
        I_x=math.fsum(I_x for I_x, _ in moments),
        I_y=math.fsum(I_y for _, I_y in moments),
    )


def _panels(wall: Wall, bays: Iterable[Bay]) -> Iterator[_Rectangle]:
    """What stands of a wall between its bays."""
    (x1, y1), (x2, y2) = wall.start, wall.end
    L = math.dist(wall.start, wall.end)
    c, s = (x2 - x1) / L, (y2 - y1) / L
    begin = 0.0
    openings = sorted((bay.centre - bay.width / 2.0, bay.centre + bay.width / 2.0) for bay in bays)
    for left, right in [*openings, (L, L)]:
        if left > begin:
            middle = 0.5 * (begin + left)
            yield _Rectangle(x1 + c * middle, y1 + s * middle, left - begin, wall.thickness, c, s)
        begin = max(begin, right)
