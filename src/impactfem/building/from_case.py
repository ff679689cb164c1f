"""From the case to a building's geometry, and from its mesh file to what is assembled."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np

from impactfem.building import geometry
from impactfem.building.geometry import Geometry
from impactfem.building.mesh import BuildingMesh, Part, place
from impactfem.building.mesh_report import MeshReport, mesh_report
from impactfem.building.parts import BuildingParts, FloorMasses, PartDamping, floor_masses
from impactfem.building.read_mesh import read_mesh
from impactfem.building.section import BeamSection, Material, Materials, Sections, ShellSection
from impactfem.case import Case
from impactfem.case.buildings import Building
from impactfem.case.structure import FileMesh, GeneratedMesh, Structure
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import Fault, InputError, SolutionError

HEIGHT = 0.1
"""Largest difference of a storey's height in the mesh from that in the floor table [m].

A level may be that of the mass centre or of the middle of the slab.
"""


def geometry_of(case: Case) -> Geometry:
    """The geometry that the generator builds for the structure of a case.

    The floors are at the elevations of the building's floor table.

    Args:
        case: A case with a structure whose mesh is generated.

    Raises:
        ValueError: It has none.
    """
    structure = case.structure
    if structure is None or not isinstance(structure.mesh, GeneratedMesh):
        raise ValueError("the case has no structure with a generated mesh")
    building = case.building(structure.building)
    return _geometry(structure.mesh, (building.base, *building.elevations))


def sections_of(structure: Structure, mesh: BuildingMesh) -> Sections:
    """The sections of the parts of a structure's mesh.

    Args:
        structure: The structure.
        mesh: Its mesh, generated or read from the user's file.

    Raises:
        InputError: A group of the user's mesh matches no entry of the case file, or two; an entry
            matches no group; a beam stands along the reference direction of its section.
    """
    if isinstance(structure.mesh, GeneratedMesh):
        base = float(mesh.nodes[mesh.base, 2].min())
        built = _geometry(structure.mesh, (base, *mesh.elevations.values()))
        return built.sections(mesh.shell_parts, mesh.beam_parts)
    return _file_sections(structure.mesh, mesh)


def part_faults(structure: Structure, parts: Sequence[Part], path: Path) -> Iterator[Fault]:
    """What is wrong with the patterns of parts that have their own material or damping.

    Args:
        structure: The structure.
        parts: The parts of its mesh.
        path: The case file, for messages.
    """
    names = ", ".join(part.group for part in parts)
    entries: Sequence[_OfParts]
    for key, entries in (("materials", structure.materials), ("damping", structure.damping)):
        for index, entry in enumerate(entries):
            for k, pattern in enumerate(entry.parts):
                if not any(fnmatchcase(part.group, pattern) for part in parts):
                    key_path = f"{structure.key}.{key}[{index}].parts[{k}]"
                    expected = f"expected a pattern of the parts of the mesh: {names}"
                    yield Fault(path, key_path, pattern, expected)
        for part in parts:
            matching = [index for index, entry in enumerate(entries) if _matches(part, entry)]
            if len(matching) > 1:
                key_path = f"{structure.key}.{key}[{matching[1]}].parts"
                other = f"{structure.key}.{key}[{matching[0]}]"
                expected = f"also matched by {other}; expected one entry for {part.group}"
                yield Fault(path, key_path, part.group, expected)


def materials_of(structure: Structure, mesh: BuildingMesh) -> Materials:
    """The materials of the parts of a structure's mesh.

    Args:
        structure: The structure, whose patterns match its parts.
        mesh: Its mesh.
    """

    def of(part: Part) -> Material:
        entry = _entry_of(part, structure.materials)
        material = structure.material if entry is None else entry.material
        if material.density is None:
            raise ValueError("the materials of a structure have a density")
        return Material(material.young_modulus, material.poisson_ratio, material.density)

    return Materials(tuple(map(of, mesh.shell_parts)), tuple(map(of, mesh.beam_parts)))


def part_damping(structure: Structure, mesh: BuildingMesh) -> PartDamping | None:
    """The damping of the parts of a structure's mesh; None without damping by part.

    Args:
        structure: The structure, whose patterns match its parts.
        mesh: Its mesh.
    """
    if not structure.damping:
        return None

    def of(part: Part) -> Rayleigh | None:
        entry = _entry_of(part, structure.damping)
        return None if entry is None else entry.rayleigh

    return PartDamping(tuple(map(of, mesh.shell_parts)), tuple(map(of, mesh.beam_parts)))


def read_parts(case: Case, path: Path) -> tuple[BuildingParts, FloorMasses, MeshReport]:
    """Mesh, sections and masses of the structure of a case. Not collective.

    Args:
        case: The case; it has a structure.
        path: The mesh file.

    Raises:
        InputError: The mesh is not usable, or does not go with the case. Of a generated mesh, whose
            file is none of the user's, the case file is named.
    """
    try:
        return _read_parts(case, path)
    except InputError as error:
        if case.structure is None or not isinstance(case.structure.mesh, GeneratedMesh):
            raise
        faults = [
            Fault(case.path, f"{case.structure.key}.mesh, {fault.key}", fault.value, fault.expected)
            if fault.file == path
            else fault
            for fault in error.faults
        ]
        raise InputError(faults) from error


def _read_parts(case: Case, path: Path) -> tuple[BuildingParts, FloorMasses, MeshReport]:
    structure = case.structure
    if structure is None:
        raise ValueError("the case has no structure")
    building = case.building(structure.building)
    mesh = read_mesh(path)
    if list(mesh.floors) != [floor.floor for floor in building.floors]:
        floors = ", ".join(map(str, mesh.floors))
        expected = f"the floors 1 to {len(building.floors)} of building {building.name}"
        raise InputError([Fault(path, "centre_<k>", f"floors {floors}", expected)])
    every = (*mesh.shell_parts, *mesh.beam_parts)
    faults = [
        *_height_faults(mesh, building, path),
        *part_faults(structure, every, case.path),
    ]
    if faults:
        raise InputError(faults)
    sections = sections_of(structure, mesh)
    materials = materials_of(structure, mesh)
    required = np.array([f.mass for f in building.floors]) if structure.floor_masses else None
    try:
        masses = floor_masses(mesh, sections, materials, required)
    except SolutionError as error:
        raise InputError(
            [Fault(case.path, f"{structure.key}.floor_masses", None, str(error))]
        ) from error
    parts = BuildingParts(
        mesh=mesh,
        sections=sections,
        materials=materials,
        added_mass=masses.on_triangles,
        drilling=structure.drilling,
        dampings=part_damping(structure, mesh),
    )
    return parts, masses, mesh_report(mesh, sections)


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


class _OfParts(Protocol):
    """An entry of the case file for some parts, by patterns of the names of their groups."""

    @property
    def parts(self) -> tuple[str, ...]: ...


Entry = TypeVar("Entry", bound=_OfParts)


def _entry_of(part: Part, entries: Sequence[Entry]) -> Entry | None:
    """The first entry with a pattern that matches the part's group; None without one."""
    return next((entry for entry in entries if _matches(part, entry)), None)


def _matches(part: Part, entry: _OfParts) -> bool:
    return any(fnmatchcase(part.group, pattern) for pattern in entry.parts)


def _geometry(mesh: GeneratedMesh, levels: Sequence[float]) -> Geometry:
    acroterion = mesh.acroterion
    return Geometry(
        length=mesh.length,
        width=mesh.width,
        levels=tuple(levels),
        slab_thickness=mesh.slab_thickness,
        walls=tuple(
            geometry.Wall(w.wall, w.storeys, (w.x1, w.y1), (w.x2, w.y2), w.thickness)
            for w in mesh.walls
        ),
        bays=tuple(
            geometry.Bay(b.bay, b.wall, b.storey, b.centre, b.sill, b.width, b.height)
            for b in mesh.bays
        ),
        beams=tuple(
            geometry.Beam(b.beam, b.floors, (b.x1, b.y1), (b.x2, b.y2), b.width, b.depth, b.offset)
            for b in mesh.beams
        ),
        columns=tuple(
            geometry.Column(c.column, c.storeys, (c.x, c.y), c.width_x, c.width_y)
            for c in mesh.columns
        ),
        acroterion=(
            None
            if acroterion is None
            else geometry.Acroterion(acroterion.height, acroterion.thickness)
        ),
        impact_edge=mesh.impact_edge,
        size=geometry.MeshSize(
            floor=mesh.floor_size or mesh.size,
            storey=mesh.storey_size or mesh.size,
            beam=mesh.beam_size or mesh.size,
            column=mesh.column_size or mesh.size,
        ),
    )


class _OfGroups(Protocol):
    @property
    def groups(self) -> str: ...


Group = TypeVar("Group", bound=_OfGroups)


def _file_sections(file_mesh: FileMesh, mesh: BuildingMesh) -> Sections:
    faults: list[Fault] = []
    shells = _matched(file_mesh, "shells", file_mesh.shells, mesh.shell_parts, faults)
    beams = _matched(file_mesh, "beams", file_mesh.beams, mesh.beam_parts, faults)
    if faults:
        raise InputError(faults)
    chosen = list(zip(mesh.beam_parts, beams, strict=True))
    sections = tuple(
        BeamSection.column(entry.width, entry.depth)
        if part.family == "column"
        else BeamSection.beam(entry.width, entry.depth, entry.offset)
        for part, entry in chosen
    )
    faults = [
        Fault(file_mesh.file, part.group, entry.offset, "an offset; expected none for columns")
        for part, entry in chosen
        if part.family == "column" and entry.offset != 0.0
    ]
    faults += _direction_faults(file_mesh, mesh, sections)
    if faults:
        raise InputError(faults)
    return Sections(tuple(ShellSection(entry.thickness) for entry in shells), sections)


def _matched(
    file_mesh: FileMesh,
    key: str,
    entries: tuple[Group, ...],
    parts: tuple[Part, ...],
    faults: list[Fault],
) -> list[Group]:
    """The entry of each part; complete without a fault."""
    chosen = []
    unused = {entry.groups for entry in entries}
    for part in parts:
        matching = [entry for entry in entries if fnmatchcase(part.group, entry.groups)]
        unused -= {entry.groups for entry in matching}
        if len(matching) == 1:
            chosen.append(matching[0])
            continue
        patterns = ", ".join(f"'{entry.groups}'" for entry in matching)
        expected = f"matched by {patterns}; expected one" if matching else "no pattern matches it"
        expected = f"{expected} of structure.mesh.{key} in the case"
        faults.append(Fault(file_mesh.file, part.group, None, expected))
    groups = ", ".join(part.group for part in parts) or "none"
    for pattern in sorted(unused):
        where = f"structure.mesh.{key} with the pattern '{pattern}'"
        expected = f"no group for {where}; the mesh has {groups}"
        faults.append(Fault(file_mesh.file, "", None, expected))
    return chosen


def _direction_faults(
    file_mesh: FileMesh, mesh: BuildingMesh, sections: tuple[BeamSection, ...]
) -> Iterable[Fault]:
    """Beams that stand along the direction that their section is turned by."""
    ends = mesh.nodes[mesh.lines[:, :2]]
    along = ends[:, 1] - ends[:, 0]
    tangents = along / np.linalg.norm(along, axis=1)[:, None]
    for i, (part, section) in enumerate(zip(mesh.beam_parts, sections, strict=True)):
        for line in np.flatnonzero(mesh.line_part == i):
            try:
                section.frame(tangents[line])
            except ValueError:
                where = place(ends[line].mean(axis=0))
                expected = (
                    "a vertical beam; expected a group column_<k>"
                    if part.family == "beam"
                    else "a column along y; expected a group beam_<k>"
                )
                yield Fault(file_mesh.file, part.group, None, f"at {where}: {expected}")
                break
