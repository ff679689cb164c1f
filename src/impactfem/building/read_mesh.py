"""Read a building's mesh from gmsh's file, generated or the user's own."""

from __future__ import annotations

from pathlib import Path

from impactfem.building.mesh import BuildingMesh
from impactfem.building.mesh_checks import check_mesh
from impactfem.building.mesh_groups import assemble
from impactfem.building.raw_mesh import EXPECTED, read_raw
from impactfem.system.own_process import read_in_own_process


def read_mesh(path: Path) -> BuildingMesh:
    """Read a mesh whose physical groups follow the scheme of docs/mesh-groups.md, and check it.

    gmsh runs in a process of its own. Not collective.

    Args:
        path: A file of gmsh, format 2 or 4, text or binary, of second order.

    Raises:
        InputError: The file is not such a mesh, a group is missing or unknown, or the mesh does
            not hold together; every fault names its group and a place.
    """
    mesh = assemble(read_in_own_process(read_raw, path, EXPECTED), path)
    check_mesh(mesh, path)
    return mesh
