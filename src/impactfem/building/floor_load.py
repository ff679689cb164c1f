"""A load on the slab of a floor, in its plane."""

from __future__ import annotations

import numpy as np

from impactfem.building.mesh import BuildingMesh
from impactfem.building.nodal_load import NodalLoad
from impactfem.building.quality import areas


def floor_load(mesh: BuildingMesh, floor: int) -> NodalLoad:
    """Consistent nodal forces of an even load with the resultant 1 N over the slab of a floor.

    On six-node triangles ∫ N dA is zero at the vertices and a third of the area at each middle of
    a side.

    Args:
        mesh: The mesh.
        floor: Number of the floor; what stands upright on its slab takes no load.

    Raises:
        KeyError: The floor has no slab.
    """
    flat = mesh.triangles[mesh.slab(floor)]
    if not len(flat):
        raise KeyError(f"floor {floor} has no slab")
    area = areas(mesh.nodes, flat)
    forces = np.zeros(len(mesh.nodes))
    np.add.at(forces, flat[:, 3:], area[:, None] / 3.0)
    nodes = np.unique(flat[:, 3:])
    return NodalLoad(nodes, forces[nodes] / area.sum())
