"""What the generator builds: a rectangular building of slabs, walls, beams and columns.

The plan is 0 ≤ x ≤ length and 0 ≤ y ≤ width; floor k lies at `levels[k]`, storey k stands between
`levels[k - 1]` and `levels[k]`. Walls and slabs are their mid-planes.
"""

from __future__ import annotations

from dataclasses import dataclass

from impactfem.building.part import Part
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
