"""From the case to the geometry of its structure, and to sections and materials of its mesh."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np

from impactfem.building import geometry
from impactfem.building.geometry import Geometry
from impactfem.building.mesh import BuildingMesh, place
from impactfem.building.part import Part, entry_of, pattern_faults
from impactfem.building.section import (
    BeamSection,
    Material,
    Materials,
    Sections,
    ShellSection,
)
from impactfem.case import Case
from impactfem.case.file_mesh import BeamGroup, FileMesh
from impactfem.case.generated_mesh import GeneratedMesh
from impactfem.case.materials import Material as CaseMaterial
from impactfem.case.structure import Structure
from impactfem.system.errors import Fault, InputError


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
    yield from pattern_faults(structure.materials, parts, path, "structure.materials")
    yield from pattern_faults(structure.damping, parts, path, "structure.damping")


def materials_of(structure: Structure, mesh: BuildingMesh) -> Materials:
    """The materials of the parts of a structure's mesh.

    Args:
        structure: The structure, whose patterns match (`part_faults`).
        mesh: Its mesh.
    """

    def of(part: Part) -> Material:
        entry = entry_of(part, structure.materials)
        return _material(structure.material if entry is None else entry.material)

    return Materials(tuple(map(of, mesh.shell_parts)), tuple(map(of, mesh.beam_parts)))


def _material(material: CaseMaterial) -> Material:
    if material.density is None:
        raise ValueError("the materials of a structure have a density")
    return Material(material.young_modulus, material.poisson_ratio, material.density)


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


class _Group(Protocol):
    @property
    def groups(self) -> str: ...


Entry = TypeVar("Entry", bound=_Group)


def _file_sections(asked: FileMesh, mesh: BuildingMesh) -> Sections:
    faults: list[Fault] = []
    shells = _matched(asked, "shells", asked.shells, mesh.shell_parts, faults)
    beams = _matched(asked, "beams", asked.beams, mesh.beam_parts, faults)
    if faults:
        raise InputError(faults)
    chosen = list(zip(mesh.beam_parts, beams, strict=True))
    sections = tuple(_beam_section(part, entry) for part, entry in chosen)
    faults = [
        Fault(asked.file, part.group, entry.offset, "an offset; expected none for columns")
        for part, entry in chosen
        if part.family == "column" and entry.offset != 0.0
    ]
    faults += _direction_faults(asked, mesh, sections)
    if faults:
        raise InputError(faults)
    return Sections(tuple(ShellSection(entry.thickness) for entry in shells), sections)


def _matched(
    asked: FileMesh,
    key: str,
    entries: tuple[Entry, ...],
    parts: tuple[Part, ...],
    faults: list[Fault],
) -> list[Entry]:
    """The entry of each part; complete when no fault was found."""
    found = []
    unused = {entry.groups for entry in entries}
    for part in parts:
        own = [entry for entry in entries if fnmatchcase(part.group, entry.groups)]
        unused -= {entry.groups for entry in own}
        if len(own) == 1:
            found.append(own[0])
            continue
        patterns = ", ".join(f"'{entry.groups}'" for entry in own)
        expected = f"matched by {patterns}; expected one" if own else "no pattern matches it"
        faults.append(
            Fault(asked.file, part.group, None, f"{expected} of structure.mesh.{key} in the case")
        )
    groups = ", ".join(part.group for part in parts) or "none"
    for pattern in sorted(unused):
        where = f"structure.mesh.{key} with the pattern '{pattern}'"
        faults.append(Fault(asked.file, "", None, f"no group for {where}; the mesh has {groups}"))
    return found


def _beam_section(part: Part, entry: BeamGroup) -> BeamSection:
    if part.family == "column":
        return BeamSection.column(entry.width, entry.depth)
    return BeamSection.beam(entry.width, entry.depth, entry.offset)


def _direction_faults(
    asked: FileMesh, mesh: BuildingMesh, sections: tuple[BeamSection, ...]
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
                yield Fault(asked.file, part.group, None, f"at {where}: {expected}")
                break
