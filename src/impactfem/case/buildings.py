"""Buildings: sticks of storeys and rigid floors, with a 3D model where they have one."""

import itertools
import math
from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    Field,
    StrictBool,
    ValidationInfo,
    field_validator,
)
from pydantic.json_schema import SkipJsonSchema

from impactfem.case.base import Section, refuse, rule
from impactfem.case.damping import DampingEntry, PartDamping, Parts
from impactfem.case.floors import (
    FLOORS,
    UNKNOWN_DAMPING,
    UNKNOWN_MATERIAL,
    Floor,
    Material,
    MaterialOf,
    entry_of,
    read_floors,
)
from impactfem.case.leaf import FileName, FloorNumbers, Name, Text, Whole
from impactfem.case.members import (
    TOUCH,
    Bay,
    Beam,
    Column,
    Member,
    Wall,
    heights_of_storeys,
    misplaced,
    read_bays,
    read_members,
    section_or,
)
from impactfem.case.plan import Corners, FloorPlan
from impactfem.case.quantity import (
    Depth,
    ElementSize,
    Extent,
    Frequency,
    Length,
    PositiveFactor,
    PositiveLength,
    Si,
)
from impactfem.case.reading import TableFile
from impactfem.case.sections import Angle, MemberSection, SectionOf
from impactfem.case.soil import MatrixSoil, SoilEntry, TableSoil
from impactfem.case.storeys import ModalTable, Periods
from impactfem.system.files import LARGEST_MESH

Part = Annotated[float, Si("-", ge=0, le=1)]


class ShellGroup(Section):
    """The thickness of shells, by the names of their physical groups."""

    groups: Text
    """Pattern of the names of the groups, with * and ? as in a shell: `floor_*`."""
    thickness: PositiveLength
    """Thickness of the shells."""


class BeamGroup(Section):
    """The section of beams or columns, by the names of their physical groups."""

    groups: Text
    """Pattern of the names of the groups, with * and ? as in a shell: `column_*`."""
    section: Annotated[MemberSection | None, SectionOf()] = None
    """Rolled section or one of [sections], in place of width and depth; its web is vertical
    (beams) or along x (columns)."""
    width: PositiveLength | None = None
    """Side of a rectangular section: horizontal (beams), along x (columns)."""
    depth: PositiveLength | None = Field(default=None, validate_default=True)
    """Side of a rectangular section: vertical (beams), along y (columns)."""
    angle: Angle = 0.0
    """Turn of the section: of columns in plan, from x towards y; of beams about their axis, which
    points to +x, or to +y across x."""
    offset: Length = 0.0
    """Height of the axis of beams above the line of nodes; negative below it."""

    _one_section = section_or("width", "depth")


class FileMesh(Section):
    """A mesh of second order from a file of gmsh, with named physical groups.

    docs/mesh-groups.md says how the groups are named. Each group of shells or beams matches one
    pattern.
    """

    type: Literal["file"]
    """Read from a file."""
    file: Annotated[Path, FileName("a mesh of gmsh (.msh)", largest=LARGEST_MESH)]
    """The mesh: a .msh file of gmsh."""
    shells: tuple[ShellGroup, ...] = Field(min_length=1)
    """Thicknesses of the groups of shells."""
    beams: tuple[BeamGroup, ...] = ()
    """Sections of the groups of beams and columns."""

    @field_validator("shells", "beams")
    @classmethod
    def _each_pattern_once(cls, value: tuple[ShellGroup | BeamGroup, ...]) -> Any:
        patterns = [entry.groups for entry in value]
        for pattern in patterns:
            if patterns.count(pattern) > 1:
                expected = f"expected each pattern once, found '{pattern}' twice"
                raise refuse(expected, kind="once")
        return value


def _member_file(model: type[Member]) -> TableFile:
    return TableFile(f"a {model.kind} table (CSV)", partial(read_members, model), sited=True)


class Parapet(Section):
    """The low wall on the edges of the top floor."""

    height: PositiveLength
    """Height above the mid-plane of the top slab."""
    thickness: PositiveLength
    """Thickness of the low wall."""


class SlabThickness(Section):
    """The thickness of the slabs of some floors."""

    floors: FloorNumbers
    """Numbers of the floors."""
    thickness: PositiveLength
    """Thickness of their slabs."""


class WallThickness(Section):
    """The thickness of some walls in some storeys."""

    walls: Text
    """Pattern of the names of the walls, with * and ? as in a shell: `gable_*`."""
    storeys: FloorNumbers
    """Numbers of the storeys."""
    thickness: PositiveLength
    """Thickness of the walls there."""


class Openings(Section):
    """A change of the openings in some walls."""

    walls: Text
    """Pattern of the names of the walls, with * and ? as in a shell: `gable_*`."""
    storeys: FloorNumbers
    """Numbers of the storeys."""
    width: PositiveFactor
    """Factor on the widths of the bays there, each about its middle."""


class GeneratedMesh(Section):
    """A mesh made by the generator: a rectangular plan, with floors at the levels of the building.

    Positions in plan are counted from a corner of the building, x along its length, y across.
    """

    type: Literal["generated"]
    """Made by the generator from tables."""
    length: Extent
    """Length of the rectangular plan, along x."""
    width: Extent
    """Width of the plan, along y."""
    slab_thickness: PositiveLength
    """Thickness of the slabs."""
    slabs: tuple[SlabThickness, ...] = ()
    """Thickness of the slabs of some floors, in place of slab_thickness."""
    walls: Annotated[tuple[Wall, ...], _member_file(Wall)] = ()
    """Wall table: a CSV file, one row a wall; default none."""
    thicknesses: tuple[WallThickness, ...] = Field(default=())
    """Thickness of walls in some storeys, in place of that of the wall table."""
    bays: Annotated[tuple[Bay, ...], TableFile("a bay table (CSV)", read_bays, sited=True)] = ()
    """Bay table: a CSV file, one row an opening in a wall."""
    wall_setback: tuple[Depth, Depth] = (0.0, 0.0)
    """Inward shift (x, y) of walls on the edges of the plan: half of their thickness if the edges
    are outer faces. Walls that end on such an edge are shortened; openings keep their place."""
    openings: tuple[Openings, ...] = Field(default=(), validate_default=True)
    """Factors on the widths of openings, by walls and storeys; several for one bay multiply."""
    beams: Annotated[tuple[Beam, ...], _member_file(Beam)] = ()
    """Beam table: a CSV file, one row a beam."""
    columns: Annotated[tuple[Column, ...], _member_file(Column)] = ()
    """Column table: a CSV file, one row a column."""
    parapet: Parapet | None = None
    """Low wall on the edges of the top floor; default none."""
    impact_edge: Literal["x-", "x+", "y-", "y+"]
    """Side of the plan that faces the other building."""
    size: ElementSize
    """Target size of the elements."""
    floor_size: ElementSize | None = None
    """Target size in the slabs, in place of size."""
    storey_size: ElementSize | None = None
    """Target size in the walls, in place of size."""
    beam_size: ElementSize | None = None
    """Target size along the beams, in place of size."""
    column_size: ElementSize | None = None
    """Target size along the columns, in place of size."""

    @rule("slabs", sited=True)
    @staticmethod
    def _each_floor_once(slabs: tuple[SlabThickness, ...], info: ValidationInfo) -> Iterator[str]:
        yield from _floors_once([one.floors for one in slabs], info)

    @rule("wall_setback", "length", "width")
    @staticmethod
    def _inside(setback: tuple[float, float], length: float, width: float) -> Iterator[str]:
        for behind, side in zip(setback, (length, width), strict=True):
            if 2.0 * behind >= side - TOUCH:
                yield f"expected less than half of the plan's {side:g} m, found {behind:g} m"

    @rule("openings", "length", "width", "walls", "bays", "wall_setback", sited=True)
    @staticmethod
    def _in_their_walls(
        openings: tuple[Openings, ...],
        length: float,
        width: float,
        walls: tuple[Wall, ...],
        bays: tuple[Bay, ...],
        setback: tuple[float, float],
        info: ValidationInfo,
    ) -> Iterator[str]:
        for one in openings:
            if not any(_opened(one, bay) for bay in bays):
                storeys = ", ".join(map(str, one.storeys))
                yield f"no bay of storeys {storeys} is in walls '{one.walls}'; expected one or more"
        # Bays in walls that are missing have a fault already.
        there = {bay.wall for bay in bays} <= {wall.wall for wall in walls}
        if there and (openings or any(setback)):
            walls, bays = _built(walls, bays, (length, width), setback, openings)
            words = [""] * len(bays)
            for k, _, expected in misplaced(bays, walls, heights_of_storeys(info), words):
                of = f"with wall_setback and openings, bay {bays[k].bay} of {bays[k].wall}"
                yield f"{of}, storey {bays[k].storey}: {expected}"

    @rule("thicknesses", "walls")
    @staticmethod
    def _walls_once(
        thicknesses: tuple[WallThickness, ...], walls: tuple[Wall, ...]
    ) -> Iterator[str]:
        for one in thicknesses:
            if not any(_thick(one, wall, k) for wall in walls for k in wall.storeys):
                storeys = ", ".join(map(str, one.storeys))
                yield f"expected a pattern of walls in storeys {storeys}, found '{one.walls}'"
        for wall in walls:
            for k in wall.storeys:
                if sum(_thick(one, wall, k) for one in thicknesses) > 1:
                    yield f"expected one thickness of {wall.wall} in storey {k}, found several"

    def slab(self, floor: int) -> float:
        """Thickness of the slab of a floor [m]."""
        own = (one.thickness for one in self.slabs if floor in one.floors)
        return next(own, self.slab_thickness)

    def wall_thickness(self, wall: Wall, storey: int) -> float:
        """Thickness of a wall in a storey [m]."""
        own = (one.thickness for one in self.thicknesses if _thick(one, wall, storey))
        return next(own, wall.thickness)

    @property
    def built(self) -> tuple[tuple[Wall, ...], tuple[Bay, ...]]:
        """The walls and the bays as they are built: those of the tables, moved and widened."""
        plan = self.length, self.width
        return _built(self.walls, self.bays, plan, self.wall_setback, self.openings)


def _thick(of: WallThickness, wall: Wall, storey: int) -> bool:
    return storey in of.storeys and fnmatchcase(wall.wall, of.walls)


def _opened(of: Openings, bay: Bay) -> bool:
    return bay.storey in of.storeys and fnmatchcase(bay.wall, of.walls)


def _built(
    walls: tuple[Wall, ...],
    bays: tuple[Bay, ...],
    plan: tuple[float, float],
    setback: tuple[float, float],
    openings: tuple[Openings, ...],
) -> tuple[tuple[Wall, ...], tuple[Bay, ...]]:
    moved, before = {}, {wall.wall: wall for wall in walls}
    for wall in walls:
        ends = wall.coordinates
        for name, at in ends.items():
            side, behind = plan["xy".index(name[0])], setback["xy".index(name[0])]
            if min(at, side - at) <= TOUCH:
                ends[name] = behind if at <= TOUCH else side - behind
        moved[wall.wall] = wall.model_copy(update=ends)
    built = []
    for bay in bays:
        old, new = before[bay.wall], moved[bay.wall]
        (x1, y1), (x2, y2) = old.ends
        along = (new.x1 - x1) * (x2 - x1) + (new.y1 - y1) * (y2 - y1)
        factor = math.prod(one.width for one in openings if _opened(one, bay))
        changed = {"centre": bay.centre - along / old.length, "width": bay.width * factor}
        built.append(bay.model_copy(update=changed))
    return tuple(moved.values()), tuple(built)


def _floors_once(groups: Sequence[tuple[int, ...]], info: ValidationInfo) -> Iterator[str]:
    """Each floor in one entry at most, and all of them floors of the building."""
    given = [k for group in groups for k in group]
    if len(set(given)) < len(given):
        yield f"expected each floor once, found {max(given, key=given.count)} twice"
    known = heights_of_storeys(info)
    absent = [k for k in given if known and k not in known]
    if absent:
        yield f"expected floors of the building, {', '.join(map(str, known))}; found {absent[0]}"


Mesh = GeneratedMesh | FileMesh


class FrequencyFit(Section):
    """Fit of the factor on walls and columns to a known frequency."""

    frequency: Frequency
    """Frequency of the first bending mode to reach."""
    direction: Literal["x", "y"]
    """Direction in which that mode moves."""


class PartMaterial(Parts):
    """The material of some parts of the 3D model, in place of that of the structure."""

    material: Annotated[Material, MaterialOf(dense=True)]
    """Name of the material, which has a density."""


class AddedMass(Section):
    """Position on some floors of the mass that floor_masses adds: in strips, the rest uniform."""

    floors: FloorNumbers
    """Numbers of the floors."""
    across: Literal["x", "y"]
    """Direction across the strips, from edge to edge of the slab."""
    edges: Part = 0.0
    """Part of the added mass in strips along both edges, half along each, for example façades."""
    middle: Part = 0.0
    """Part in a strip in the middle, for example an inner wall."""
    strip: PositiveLength
    """Width of each strip."""

    @rule("middle", "edges")
    @staticmethod
    def _at_most_all(middle: float, edges: float) -> Iterator[str]:
        if middle + edges > 1.0 + 1e-9:
            yield f"expected at most {1.0 - edges:g}: both parts are at most 1 together"


class Structure(Section):
    """The 3D model of a building: shells and beams, clamped at the base.

    Levels, masses of the floors and damping are those of the building; parts may have another
    material and another damping.
    """

    building: SkipJsonSchema[str] = Field(default="", validate_default=True)
    """Name of the building, which is not written here."""
    material: Annotated[Material, MaterialOf(dense=True)] = Field(
        default=None, validate_default=True
    )
    """Name of the material, which has a density; default that of the building."""
    materials: tuple[PartMaterial, ...] = ()
    """Materials of parts of the 3D model in place of that of the structure. An own stick has one
    material."""
    storey_stiffness_factor: PositiveFactor = 1.0
    """Factor on the stiffness of walls and columns, not of slabs and beams; initial value with
    calibration."""
    calibration: FrequencyFit | None = None
    """Fit of storey_stiffness_factor to a frequency."""
    floor_masses: StrictBool = True
    """Add mass to each floor up to that of the floor table."""
    added_mass: tuple[AddedMass, ...] = ()
    """Position of the added mass on some floors; default uniform over the slab."""
    mass_eccentricity: tuple[Length, Length] = (0.0, 0.0)
    """Shift (x, y) of the centre of mass of each floor of the 3D model. EN 1998-1 (4.3.2) requires
    5 % of the floor's length. Own sticks have no shift."""
    modes: Annotated[int, Whole(1, 10_000)] = 20
    """Number of modes."""
    drilling: PositiveFactor = 1.0
    """Factor on the drilling stiffness of the shells, shear modulus by thickness."""
    damping: tuple[PartDamping, ...] = ()
    """Damping of parts of the 3D model in place of that of the building; only with [transient]
    solver 'full'."""
    mesh: Annotated[Mesh, Field(discriminator="type")]
    """The mesh: generated from tables, or from a file."""

    @field_validator("building", mode="before")
    @classmethod
    def _named(cls, value: Any, info: ValidationInfo) -> Any:
        if value and info.context is not None:
            expected = "expected no key building: the 3D model is that of its [[buildings]]"
            raise refuse(expected, kind="extra_forbidden")
        return value if info.context is None else info.context.building

    @field_validator("material", mode="before")
    @classmethod
    def _that_of_the_building(cls, value: Any, info: ValidationInfo) -> Any:
        if value is not None or info.context is None:
            return value
        name = entry_of(info.data.get("building", ""), info).get("material")
        if name not in (info.context.names("materials") or ()):
            return UNKNOWN_MATERIAL  # a fault of the building
        return name

    @rule("added_mass", "building", "floor_masses", sited=True)
    @staticmethod
    def _each_floor_once(
        added: tuple[AddedMass, ...], building: str, masses: bool, info: ValidationInfo
    ) -> Iterator[str]:
        if added and not masses:
            yield "expected none without floor_masses: no mass is added"
        yield from _floors_once([one.floors for one in added], info)

    def material_of(self, group: str) -> Material:
        """Material of a part of the mesh, by the name of its group."""
        own = (
            entry.material
            for entry in self.materials
            if any(fnmatchcase(group, pattern) for pattern in entry.parts)
        )
        return next(own, self.material)

    @property
    def key(self) -> str:
        """Key in a case file, with the name of its building."""
        return f"buildings.{self.building}.structure"


def structure_files(structure: Structure) -> tuple[Path, ...]:
    """The files a structure is made from besides those of the case: its mesh, where it has one."""
    return (structure.mesh.file,) if isinstance(structure.mesh, FileMesh) else ()


class Building(Section):
    """A building as a stick of storeys and rigid floors, clamped at its base or on soil."""

    name: Name
    """Name of the building, unique in the file."""
    material: Annotated[Material, MaterialOf()]
    """Name of the material of the storeys."""
    floors: Annotated[tuple[Floor, ...], TableFile(FLOORS, read_floors)]
    """Floor table: a CSV file, one row a floor, bottom to top."""
    axis: tuple[Length, Length] = (0.0, 0.0)
    """Position (x, y) of the stick's vertical axis in plan."""
    base: Length = 0.0
    """Elevation of the base: where it is clamped, or the top of the raft on soil."""
    length: PositiveLength | None = None
    """Length of the floors along x, centred on the axis, for the contact search and the checks of
    [[contacts]]. Default: that of a generated mesh."""
    width: PositiveLength | None = None
    """Width of the floors along y, as length."""
    plan: Corners | None = None
    """Corners (x, y) of the floors in order, from the axis, in place of length and width: L, T or U
    shapes, and sides along any direction."""
    plans: tuple[FloorPlan, ...] = ()
    """Plans of some floors in place of that of the building."""
    setback: Depth = 0.0
    """Distance of columns and walls behind the edges of the floors, for the contact search."""
    slab_depth: PositiveLength | None = None
    """Depth of the edges of the slabs, for contact areas of the contact search. Default: the slabs
    of a generated mesh."""
    rigid_below: Depth = 0.0
    """Depth of a floor from its mass centre down to the lower edge of its beams, where other floors
    touch it. Storeys with areas and second moments are rigid there: they deform over less height
    and are stiffer."""
    rigid_above: Depth = 0.0
    """Depth of a floor from its mass centre up to the upper edge of its beams, as rigid_below."""
    periods: Periods | None = None
    """First periods along x and y: they scale the storey stiffness of the floor table, or give it,
    with a straight mode, to a table without one."""
    modal_table: ModalTable | None = None
    """Modes from another program (ETABS, SAP2000), which give the storey stiffness to a floor table
    without one."""
    stiffness_factor: PositiveFactor = 1.0
    """Factor on all stiffnesses of the storeys."""
    second_moment_factor: PositiveFactor = 1.0
    """Factor on the second moments of area I_x and I_y of the storeys."""
    stick: Literal["structure", "own"] | None = None
    """Stiffness and masses of the stick: of the 3D model, or "own", of the floor table. Default
    "structure" with a 3D model, unless [calibration] has targets of the building."""
    damping: DampingEntry = Field(default=None, validate_default=True)
    """Damping of this building in place of [damping]; on soil, of its motion relative to the
    raft."""
    soil: SoilEntry | None = None
    """Soil under the raft; without it, the base is clamped."""
    # Not in the hash of the buildings: what depends on them alone is reused with another 3D model.
    structure: Structure | None = Field(default=None, exclude=True)
    """3D model of the building."""

    @field_validator("damping", mode="before")
    @classmethod
    def _own_or_that_of_all(cls, value: Any, info: ValidationInfo) -> Any:
        if value is None and info.context is not None:
            return info.context.values.get("damping") or UNKNOWN_DAMPING
        return value

    @rule("plan", "length", "width")
    @staticmethod
    def _one_plan(plan: Any, length: float | None, width: float | None) -> Iterator[str]:
        if plan is not None and (length is not None or width is not None):
            yield "expected either plan, or length and width, not both: remove one"

    @rule("modal_table", "floors", "periods")
    @staticmethod
    def _one_stiffness(
        table: ModalTable | None, floors: tuple[Floor, ...], periods: Periods | None
    ) -> Iterator[str]:
        if table is not None and (floors[0].section or floors[0].kx is not None):
            yield "expected no storey stiffness in the floor table: remove one of both"
        if table is not None and periods is not None:
            yield "expected either periods or modal_table, not both: remove one"

    @rule("stiffness_factor", "periods")
    @staticmethod
    def _scaled_once(factor: float, periods: Periods | None) -> Iterator[str]:
        if factor != 1.0 and periods is not None:
            yield "expected either stiffness_factor or periods, not both: remove one"

    @rule("plans", "name", sited=True)
    @staticmethod
    def _plans_of_floors(
        plans: tuple[FloorPlan, ...], name: str, info: ValidationInfo
    ) -> Iterator[str]:
        given = [k for one in plans for k in one.floors]
        if len(set(given)) < len(given):
            yield f"expected each floor once, found {max(given, key=given.count)} twice"
        known = [floor.floor for floor in info.data.get("floors", ())]
        absent = [k for k in given if known and k not in known]
        if absent:
            yield f"expected floors of {name}, {', '.join(map(str, known))}; found {absent[0]}"

    @property
    def elevations(self) -> tuple[float, ...]:
        """Elevation of the mass centre of each floor [m], bottom to top."""
        heights = itertools.accumulate((f.storey_height for f in self.floors), initial=self.base)
        return tuple(heights)[1:]

    @property
    def frequency_on_soil(self) -> float | None:
        """Lowest frequency of the rigid building on the given springs of its soil [Hz], or None."""
        if not isinstance(self.soil, MatrixSoil | TableSoil):
            return None
        mass = float(self.soil.raft.inertia[0, 0]) + sum(floor.mass for floor in self.floors)
        return math.sqrt(min(self.soil.springs) / mass) / (2.0 * math.pi)

    @property
    def levels(self) -> dict[int, float]:
        """Elevation of the mass centre by the number of the floor [m]."""
        numbers = [floor.floor for floor in self.floors]
        return dict(zip(numbers, self.elevations, strict=True))
