"""Loads along the edge of a floor that faces the other building."""

from __future__ import annotations

import numpy as np

from impactfem.building.mesh import BuildingMesh
from impactfem.building.nodal_load import NodalLoad


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
