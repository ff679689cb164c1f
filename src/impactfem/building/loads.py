"""Loads of a building: forces on its nodes, even ones on the edge of a floor or on its slab."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.building.local import DOFS
from impactfem.building.mesh import BuildingMesh
from impactfem.building.model import BuildingModel
from impactfem.building.quality import areas

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class NodalLoad:
    """Parallel forces on nodes with the resultant 1 N.

    Args:
        nodes: The nodes, shape (n,).
        forces: Force on each of them for the unit resultant, shape (n,) [N/N].
    """

    nodes: Index
    forces: Array

    def vector(self, model: BuildingModel, direction: tuple[float, float, float]) -> Array:
        """The load at this rank's rows, shape (n_local,).

        Args:
            model: The building.
            direction: Direction of the resultant, a unit vector.
        """
        load = np.zeros(DOFS * len(model.nodes))
        rows = model.rows(self.nodes)
        here = rows >= 0
        for axis, part in enumerate(direction):
            load[rows[here] + axis] = part * self.forces[here]
        return load


def edge_load(mesh: BuildingMesh, floor: int, eccentricity: float = 0.0) -> NodalLoad:
    """Consistent nodal forces of a line load with the resultant 1 N on the edge of a floor.

    With the middle s0 of an edge of the length L, the line load is
    q(s) = (1 + 12 e (s − s0) / L²) / L: uniform, or linear with its resultant at the distance e
    from the middle. Its nodal forces on quadratic edges are ∫ N q ds.

    Args:
        mesh: The mesh.
        floor: Number of the floor.
        eccentricity: e, from the middle of the edge along its longer axis [m].

    Raises:
        KeyError: The floor has no edge.
    """
    lines = mesh.edges[floor]
    ends = mesh.nodes[lines[:, :2]]
    axis = int(np.argmax(np.ptp(ends.reshape(-1, 3), axis=0)))
    s = ends[:, :, axis]
    length = np.ptp(s)
    middle = 0.5 * (s.min() + s.max())
    q = (1.0 + 12.0 * eccentricity * (s - middle) / length**2) / length
    # ∫ N q ds over a quadratic edge with q linear from q0 to q1: h (q0, q1, 2 (q0 + q1)) / 6.
    h = np.abs(s[:, 1] - s[:, 0])
    forces = np.zeros(len(mesh.nodes))
    np.add.at(forces, lines[:, 0], h * q[:, 0] / 6.0)
    np.add.at(forces, lines[:, 1], h * q[:, 1] / 6.0)
    np.add.at(forces, lines[:, 2], h * q.sum(axis=1) / 3.0)
    nodes = np.unique(lines)
    return NodalLoad(nodes, forces[nodes])


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
