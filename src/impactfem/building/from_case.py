"""From the case to a building's geometry, and from its mesh file to what is assembled."""

from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from impactfem.building import geometry
from impactfem.building.geometry import Geometry
from impactfem.building.mesh import BuildingMesh, Part, place
from impactfem.building.parts import (
    BuildingParts,
    FloorMassError,
    FloorMasses,
    PartDamping,
    Strips,
    floor_masses,
)
from impactfem.building.read_mesh import read_mesh
from impactfem.building.section import (
    RIGID,
    BeamSection,
    Material,
    Materials,
    Sections,
    ShellSection,
    Vector,
    beam_reference,
    column_reference,
)
from impactfem.case import Building3D
from impactfem.case.buildings import (
    BeamGroup,
    Building,
    FileMesh,
    GeneratedMesh,
    ShellGroup,
    Structure,
)
from impactfem.case.facade import words_of
from impactfem.case.members import Wall
from impactfem.case.sections import MemberSection
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import Fault, InputError

HEIGHT = 0.1
"""Largest difference of a storey's height in the mesh from that in the floor table [m].

A level may be that of the mass centre or of the middle of the slab.
"""


PARALLEL = 1e-6
"""Sine of the angle between directions that are the same."""

Sides = tuple[float | None, float | None]
"""Sides of a rectangular section [m]; None of another section."""

Group = TypeVar("Group", ShellGroup, BeamGroup)


def geometry_of(building: Building3D) -> Geometry:
    """The geometry that the generator builds, with floors at the elevations of the floor table.

    Raises:
        ValueError: The mesh of the building is not generated.
    """
    mesh, entry = building.structure.mesh, building.entry
    if not isinstance(mesh, GeneratedMesh):
        raise ValueError(f"the mesh of {building.name} is not generated")
    return _geometry(mesh, (entry.base, *entry.elevations))


def sections_of(structure: Structure, mesh: BuildingMesh) -> Sections:
    """The sections of the parts of a structure's mesh, generated or read from the user's file.

    Raises:
        InputError: A group of the user's mesh matches no entry of the case file, or two; an entry
            matches no group; a beam stands along the reference direction of its section.
    """
    if isinstance(structure.mesh, GeneratedMesh):
        base = float(mesh.nodes[mesh.base, 2].min())
        built = _geometry(structure.mesh, (base, *mesh.elevations.values()))
        return built.sections(mesh.shell_parts, mesh.beam_parts)
    file_mesh = structure.mesh
    faults: list[Fault] = []
    shells = _matched(file_mesh, "shells", file_mesh.shells, mesh.shell_parts, faults)
    beams = _matched(file_mesh, "beams", file_mesh.beams, mesh.beam_parts, faults)
    if faults:
        raise InputError(faults)
    ends = mesh.nodes[mesh.lines[:, :2]]
    sections = []
    for number, (part, entry) in enumerate(zip(mesh.beam_parts, beams, strict=True)):
        own = ends[mesh.line_part == number]
        along = own[:, 1] - own[:, 0]
        if part.family == "column":
            section = column_section(entry.section, (entry.width, entry.depth), entry.angle)
            upright = "a column along y; expected a group beam_<k>"
            if entry.offset != 0.0:
                expected = "an offset; expected none for columns"
                faults.append(Fault(file_mesh.file, part.group, entry.offset, expected))
        else:
            sides = entry.width, entry.depth
            section = beam_section(entry.section, sides, entry.angle, along[0], entry.offset)
            upright = "a vertical beam; expected a group column_<k>"
            unit = along / np.linalg.norm(along, axis=1)[:, None]
            if entry.angle and np.linalg.norm(np.cross(unit, unit[0]), axis=1).max() > PARALLEL:
                expected = "an angle of beams that are not parallel; expected a group a direction"
                faults.append(Fault(file_mesh.file, part.group, None, expected))
        sections.append(section)
        # A beam along the direction that its section is turned by has no frame.
        without = section.along_reference(along)
        if without.any():
            where = place(own[np.argmax(without)].mean(axis=0))
            faults.append(Fault(file_mesh.file, part.group, None, f"at {where}: {upright}"))
    if faults:
        raise InputError(faults)
    return Sections(tuple(ShellSection(entry.thickness) for entry in shells), tuple(sections))


def part_faults(structure: Structure, parts: Sequence[Part], path: Path) -> Iterator[Fault]:
    """What is wrong with the patterns of parts that have their own material or damping.

    `parts` are those of the structure's mesh; faults name the case file.
    """
    names = ", ".join(part.group for part in sorted(parts))
    # By their patterns alone, entries of both kinds are checked in one way.
    patterns = {
        f"{structure.key}.materials": [entry.parts for entry in structure.materials],
        f"{structure.key}.damping": [entry.parts for entry in structure.damping],
    }
    for key, entries in patterns.items():
        for index, of_entry in enumerate(entries):
            for k, pattern in enumerate(of_entry):
                if not any(fnmatchcase(part.group, pattern) for part in parts):
                    expected = f"expected a pattern of the parts of the mesh: {names}"
                    yield Fault(path, f"{key}[{index}].parts[{k}]", pattern, expected)
        for part in parts:
            first, *others = [k for k, e in enumerate(entries) if _matches(part, e)] or [0]
            if others:
                expected = f"also matched by {key}[{first}]; expected one entry for {part.group}"
                yield Fault(path, f"{key}[{others[0]}].parts", part.group, expected)


def read_parts(
    building: Building3D, path: Path, mesh: BuildingMesh | None = None
) -> tuple[BuildingParts, FloorMasses]:
    """Mesh, sections and masses of a building, from its mesh file. Not collective.

    The mesh is not read again where it is given.

    Raises:
        InputError: The mesh is not usable, or does not go with the case. Of a generated mesh, whose
            file is none of the user's, the case file is named.
    """
    structure, table, case_file = building.structure, building.entry.floors, building.case.path
    try:
        mesh = mesh or read_mesh(path)
        if list(mesh.floors) != [floor.floor for floor in table]:
            floors = ", ".join(map(str, mesh.floors))
            of_table = ", ".join(str(floor.floor) for floor in table)
            expected = f"expected the floors {of_table} of building {building.name}"
            raise InputError([Fault(path, "centre_<k>", f"floors {floors}", expected)])
        both = mesh.shell_parts, mesh.beam_parts
        faults = [
            *_height_faults(mesh, building.entry, path),
            *part_faults(structure, [part for some in both for part in some], case_file),
        ]
        if faults:
            raise InputError(faults)
        sections = sections_of(structure, mesh)
    except InputError as error:
        if not isinstance(structure.mesh, GeneratedMesh):
            raise
        faults = [
            Fault(case_file, f"{structure.key}.mesh, {fault.key}", fault.value, fault.expected)
            if fault.file == path
            else fault
            for fault in error.faults
        ]
        raise InputError(faults) from error
    materials = list[tuple[Material, ...]]()
    dampings = list[tuple[Rayleigh | None, ...]]()
    for some in both:
        of_parts = list[Material]()
        for part in some:
            given = structure.material_of(part.group)
            if given.density is None:
                raise ValueError("the materials of a structure have a density")
            of_parts.append(Material(given.young_modulus, given.poisson_ratio, given.density))
        materials.append(tuple(of_parts))
        entries = [
            next((e for e in structure.damping if _matches(part, e.parts)), None) for part in some
        ]
        dampings.append(tuple(one if one is None else one.rayleigh for one in entries))
    strips = {
        k: Strips("xy".index(one.across), one.edges, one.middle, one.strip)
        for one in structure.added_mass
        for k in one.floors
    }
    required = np.array([f.mass for f in table]) if structure.floor_masses else None
    try:
        masses = floor_masses(
            mesh, sections, Materials(*materials), required, structure.mass_eccentricity, strips
        )
    except FloorMassError as error:
        moved = f"{words_of(structure.mass_eccentricity)} m"
        faults = [
            Fault(case_file, f"{structure.key}.{key}", moved if "ecc" in key else None, expected)
            for expected, key in error.wrong
        ]
        raise InputError(faults) from error
    parts = BuildingParts(
        mesh=mesh,
        sections=sections,
        materials=Materials(*materials),
        added_mass=masses.on_triangles,
        drilling=structure.drilling,
        dampings=PartDamping(*dampings) if structure.damping else None,
    )
    return parts, masses


def _height_faults(mesh: BuildingMesh, building: Building, path: Path) -> Iterator[Fault]:
    """Storeys of another height than in the floor table: one of the two is of another building."""
    base = mesh.nodes[mesh.base, 2]
    # The lowest storey may stand on a base of several levels.
    below = (float(base.min()), float(base.max())) if base.size else (building.base, building.base)
    for floor in building.floors:
        level = mesh.elevations[floor.floor]
        lowest, highest = level - below[1], level - below[0]
        low, high = floor.storey_height_min, floor.storey_height_max
        if highest < low - HEIGHT or lowest > high + HEIGHT:
            in_mesh, in_table = (
                f"{a:.4g}" if a == b else f"{a:.4g} to {b:.4g}"
                for a, b in ((lowest, highest), (low, high))
            )
            expected = (
                f"the storey below floor {floor.floor} is {in_mesh} m high in the mesh and "
                f"{in_table} m in the floor table of building {building.name}; expected the same "
                f"to {HEIGHT:g} m"
            )
            yield Fault(path, f"centre_{floor.floor}", None, expected)
        below = (level, level)


def _matches(part: Part, patterns: Sequence[str]) -> bool:
    return any(fnmatchcase(part.group, pattern) for pattern in patterns)


def _geometry(mesh: GeneratedMesh, levels: Sequence[float]) -> Geometry:
    parapet = mesh.parapet
    walls, bays = mesh.built
    return Geometry(
        length=mesh.length,
        width=mesh.width,
        levels=tuple(levels),
        slab_thickness=mesh.slab_thickness,
        slabs={k: one.thickness for one in mesh.slabs for k in one.floors},
        walls=tuple(
            geometry.Wall(w.wall, storeys, (w.x1, w.y1), (w.x2, w.y2), thickness)
            for w in walls
            for thickness, storeys in _storeys_by_thickness(mesh, w)
        ),
        bays=tuple(
            geometry.Bay(b.bay, b.wall, b.storey, b.centre, b.sill, b.width, b.height) for b in bays
        ),
        beams=tuple(
            geometry.Beam(
                b.beam,
                b.floors,
                *b.ends,
                beam_section(
                    b.section,
                    (b.width, b.depth),
                    b.angle,
                    (b.x2 - b.x1, b.y2 - b.y1, 0.0),
                    b.offset,
                ),
            )
            for b in mesh.beams
        ),
        columns=tuple(
            geometry.Column(
                c.column,
                c.storeys,
                (c.x, c.y),
                column_section(c.section, (c.width_x, c.width_y), c.angle),
            )
            for c in mesh.columns
        ),
        parapet=(None if parapet is None else geometry.Parapet(parapet.height, parapet.thickness)),
        impact_edge=mesh.impact_edge,
        size=geometry.MeshSize(
            floor=mesh.floor_size or mesh.size,
            storey=mesh.storey_size or mesh.size,
            beam=mesh.beam_size or mesh.size,
            column=mesh.column_size or mesh.size,
        ),
    )


def beam_section(
    given: MemberSection | None, sides: Sides, angle: float, along: ArrayLike, offset: float
) -> BeamSection:
    """Return the section of a beam along a direction, given by its properties or a rectangle.

    Args:
        given: Its properties; None of a rectangle.
        sides: Width and depth of a rectangle [m].
        angle: Turn about its axis [rad].
        along: Direction of its axis, shape (3,).
        offset: Height of its axis above the line of nodes [m].
    """
    reference, away = beam_reference(along, angle), (0.0, 0.0, offset)
    if given is not None:
        return _of_properties(given, reference, away)
    return BeamSection.rectangle(*_rectangle(sides), reference=reference, offset=away)


def column_section(given: MemberSection | None, sides: Sides, angle: float) -> BeamSection:
    """Return the section of a column, given by its properties or by its sides along x and y [m].

    The angle turns it in plan [rad].
    """
    if given is not None:
        return _of_properties(given, column_reference(angle))
    return BeamSection.column(*_rectangle(sides), angle)


def _of_properties(
    given: MemberSection, reference: Vector, offset: Vector = (0.0, 0.0, 0.0)
) -> BeamSection:
    """A section whose local axes y and z are n1 and n2."""
    k1, k2 = (RIGID if Av is None else Av / given.A for Av in (given.Avy, given.Avz))
    return BeamSection(given.A, given.Iy, given.Iz, given.J, k1, k2, reference, offset)


def _rectangle(sides: Sides) -> tuple[float, float]:
    width, depth = sides
    if width is None or depth is None:
        raise ValueError("a member has a section or both sides of a rectangle")
    return width, depth


def _storeys_by_thickness(
    mesh: GeneratedMesh, wall: Wall
) -> Iterator[tuple[float, tuple[int, ...]]]:
    """The thicknesses of a wall, each with its storeys."""
    thickness = {k: mesh.wall_thickness(wall, k) for k in wall.storeys}
    for value in dict.fromkeys(thickness.values()):
        yield value, tuple(k for k, one in thickness.items() if one == value)


def _matched(
    file_mesh: FileMesh,
    key: str,
    entries: Sequence[Group],
    parts: Sequence[Part],
    faults: list[Fault],
) -> list[Group]:
    """The entry of each part; complete without a fault."""
    chosen, unmatched = [], []
    for part in parts:
        matching = [entry for entry in entries if fnmatchcase(part.group, entry.groups)]
        if len(matching) == 1:
            chosen.append(matching[0])
            continue
        if not matching:
            unmatched.append(part.group)
            continue
        patterns = ", ".join(f"'{entry.groups}'" for entry in matching)
        expected = f"matched by {patterns}; expected one of structure.mesh.{key} in the case"
        faults.append(Fault(file_mesh.file, part.group, None, expected))
    if unmatched:
        it = "it" if len(unmatched) == 1 else "them"
        expected = f"no pattern matches {it} of structure.mesh.{key} in the case"
        faults.append(Fault(file_mesh.file, ", ".join(unmatched), None, expected))
    groups = ", ".join(part.group for part in parts) or "none"
    for pattern in sorted(entry.groups for entry in entries):
        if not any(fnmatchcase(part.group, pattern) for part in parts):
            where = f"structure.mesh.{key} with the pattern '{pattern}'"
            expected = f"no group for {where}; the mesh has {groups}"
            faults.append(Fault(file_mesh.file, "", None, expected))
    return chosen
