"""Loads along the edge of a floor that faces the other building."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.building.local import DOFS
from impactfem.building.mesh import BuildingMesh
from impactfem.building.model import BuildingModel

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class EdgeLoad:
    """Consistent nodal forces of a line load with the resultant 1 N on an edge.

    With the middle s0 of an edge of the length L, the line load is
    q(s) = (1 + 12 e (s − s0) / L²) / L: uniform, or linear with its resultant at the distance e
    from the middle. Its nodal forces on quadratic edges are ∫ N q ds.

    Args:
        nodes: Nodes of the edge, shape (n,).
        forces: Force on each node for the unit resultant, shape (n,) [N/N].
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


def edge_load(mesh: BuildingMesh, floor: int, eccentricity: float = 0.0) -> EdgeLoad:
    """The line load on the edge of a floor.

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
    return EdgeLoad(nodes, forces[nodes])
