"""What a case's building is made of: its mesh file, read, with sections, materials, masses."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from impactfem.building.from_case import materials_of, part_faults, sections_of
from impactfem.building.masses import FloorMasses, floor_masses
from impactfem.building.mesh import BuildingMesh
from impactfem.building.mesh_report import MeshReport, mesh_report
from impactfem.building.part_damping import part_damping
from impactfem.building.parts import BuildingParts
from impactfem.building.read_mesh import read_mesh
from impactfem.case import Case
from impactfem.case.buildings import Building
from impactfem.case.generated_mesh import GeneratedMesh
from impactfem.system.errors import Fault, InputError, SolutionError

HEIGHT = 0.1
"""Largest difference of a storey's height in the mesh from that in the floor table [m].

A level may be that of the mass centre or of the middle of the slab.
"""


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
            Fault(case.path, f"structure.mesh, {one.key}", one.value, one.expected)
            if one.file == path
            else one
            for one in error.faults
        ]
        raise InputError(faults) from error


def _read_parts(case: Case, path: Path) -> tuple[BuildingParts, FloorMasses, MeshReport]:
    structure = case.structure
    if structure is None:
        raise ValueError("the case has no structure")
    building = case.building(structure.building)
    mesh = read_mesh(path)
    if list(mesh.floors) != [floor.floor for floor in building.floors]:
        found = ", ".join(map(str, mesh.floors))
        expected = f"the floors 1 to {len(building.floors)} of building {building.name}"
        raise InputError([Fault(path, "centre_<k>", f"floors {found}", expected)])
    every = (*mesh.shell_parts, *mesh.beam_parts)
    faults = [
        *_height_faults(mesh, building, path),
        *part_faults(structure, every, case.path),
    ]
    if faults:
        raise InputError(faults)
    sections = sections_of(structure, mesh)
    materials = materials_of(structure, mesh)
    asked = np.array([f.mass for f in building.floors]) if structure.floor_masses else None
    try:
        masses = floor_masses(mesh, sections, materials, asked)
    except SolutionError as error:
        raise InputError([Fault(case.path, "structure.floor_masses", None, str(error))]) from error
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
            found = f"{lowest:.4g}" if lowest == highest else f"{lowest:.4g} to {highest:.4g}"
            wanted = f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
            expected = (
                f"the storey below floor {floor.floor} is {found} m high in the mesh and {wanted} "
                f"m in the floor table of building {building.name}; expected the same to "
                f"{HEIGHT:g} m"
            )
            yield Fault(path, f"centre_{floor.floor}", None, expected)
        below = (level, level)
