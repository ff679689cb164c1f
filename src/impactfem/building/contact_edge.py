"""The edge of a floor as the place of unilateral contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from impactfem.building.local import DOFS
from impactfem.building.mesh import BuildingMesh
from impactfem.building.model import BuildingModel

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ContactEdge:
    """Contact along an edge with a pressure that is straight between its vertices.

    With the hat function N_i of vertex i along the edge, w_i = ∫ N_i ds and the displacement u_n
    towards the wall, constraint i is

        g_i = ∫ N_i u_n ds / w_i ≤ gap,

    a weighted mean over the sides next to the vertex. Its force P_i is the resultant of the line
    load P_i N_i / w_i; the resultant of the edge is Σ P_i. On quadratic sides nodal forces would
    alternate between vertices and middles; these do not.

    Args:
        floor: Number of the floor.
        position: Distance of each vertex from the first end of the edge, ascending, shape (m,) [m].
        weight: w_i, shape (m,) [m].
        nodes: Nodes of the edge, ascending, shape (n,).
        means: Share of each node in each constraint, shape (n, m), sparse; columns add up to 1.
    """

    floor: int
    position: Array
    weight: Array
    nodes: Index
    means: scipy.sparse.csr_matrix

    def columns(self, model: BuildingModel, normal: Array) -> scipy.sparse.csr_matrix:
        """G at this rank's rows, with g = Gᵀ u, shape (n_local, m).

        Args:
            model: The building.
            normal: Unit vector towards the wall, shape (3,).
        """
        rows = model.rows(self.nodes)
        here = np.flatnonzero(rows >= 0)
        shape = (DOFS * len(model.nodes), len(self.nodes))
        spread = scipy.sparse.csr_matrix(shape)
        for axis in range(3):
            entries = (np.full(len(here), normal[axis]), (rows[here] + axis, here))
            spread = spread + scipy.sparse.csr_matrix(entries, shape=shape)
        return scipy.sparse.csr_matrix(spread @ self.means)


def contact_edge(mesh: BuildingMesh, floor: int) -> ContactEdge:
    """Contact along the edge of a floor.

    Args:
        mesh: The mesh.
        floor: Number of the floor.

    Raises:
        KeyError: The floor has no edge.
    """
    lines = mesh.edges[floor]
    ends = mesh.nodes[lines[:, :2]]
    axis = int(np.argmax(np.ptp(ends.reshape(-1, 3), axis=0)))
    h = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    vertices = np.unique(lines[:, :2])
    vertices = vertices[np.argsort(mesh.nodes[vertices, axis])]
    position = np.linalg.norm(mesh.nodes[vertices] - mesh.nodes[vertices[0]], axis=1)
    nodes = np.unique(lines)
    column = np.zeros(len(mesh.nodes), dtype=np.int64)
    column[vertices] = np.arange(len(vertices), dtype=np.int64)
    row = np.zeros(len(mesh.nodes), dtype=np.int64)
    row[nodes] = np.arange(len(nodes), dtype=np.int64)
    # With the hat λ_i of an end of a quadratic side: ∫ λ_i (N_i, N_j, N_mid) ds = h (1, 0, 2) / 6.
    first, second, middle = lines.T
    weight = np.zeros(len(vertices))
    entries = []
    for end in (first, second):
        np.add.at(weight, column[end], h / 2.0)
        entries.append((h / 6.0, row[end], column[end]))
        entries.append((h / 3.0, row[middle], column[end]))
    values, rows, columns = (np.concatenate(parts) for parts in zip(*entries, strict=True))
    shares = scipy.sparse.csr_matrix(
        (values / weight[columns], (rows, columns)), shape=(len(nodes), len(vertices))
    )
    return ContactEdge(floor, position, weight, nodes, shares)
