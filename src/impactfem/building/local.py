"""One rank's cells of one kind: their mesh, their space, and the global number of each node.

A distributed mesh of dolfinx 0.6 to 0.9 tears apart where three panels meet at an edge, so each
rank makes a mesh of its own cells only, and the numbers of the nodes come from the mesh file's
quadratic cells.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem._fenicsx import blocked_space, cell_nodes, local_mesh, node_coordinates
from impactfem.system.errors import SolutionError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

DOFS = 6
"""Degrees of freedom of a node: ux, uy, uz, rx, ry, rz."""

# The kinds of cells: vertices, and for each vertex of a triangle the place of the mid node of the
# opposite edge in the mesh file's cell, whose mid nodes are those of the edges 01, 12 and 20.
_SHAPES = {3: "interval", 6: "triangle"}
_OPPOSITE = np.array([4, 5, 3])


@dataclass(frozen=True)
class LocalCells:
    """A rank's cells of one kind.

    Args:
        space: P2 space with six components on them.
        cells: For each cell of the space's mesh its index in what was given, shape (n_cells,).
        nodes: For each node of the space its global number, shape (n_nodes,).
    """

    space: Any
    cells: Index
    nodes: Index

    @property
    def mesh(self) -> Any:
        """The mesh of the space."""
        return self.space.mesh


def local_cells(nodes: Array, cells: Index) -> LocalCells:
    """Make the mesh and the space of a rank's cells. Not collective.

    Args:
        nodes: Coordinates of all nodes, shape (n, 3) [m].
        cells: Global nodes of this rank's cells: shape (m, 6) triangles, vertices and mid nodes
            of the edges 01, 12, 20; or shape (m, 3) intervals, ends and mid node; m > 0.

    Raises:
        SolutionError: The nodes of dolfinx's space are not where the mesh file's are.
    """
    width = cells.shape[1]
    corners = {6: 3, 3: 2}[width]
    used, numbered = np.unique(cells[:, :corners], return_inverse=True)
    made = local_mesh(numbered.reshape(-1, corners), nodes[used], _SHAPES[width])
    space = blocked_space(made.mesh, DOFS, 2)
    vertices = used[made.corners]
    rows = cells[made.cells]
    if width == 6:
        # An edge of dolfinx's triangle is opposite to the vertex of its number.
        place = np.argmax(vertices[:, :, None] == rows[:, None, :3], axis=2)
        mids = np.take_along_axis(rows, _OPPOSITE[place], axis=1)
    else:
        mids = rows[:, 2:]
    numbers = np.full(len(node_coordinates(space)), -1, dtype=np.int64)
    numbers[cell_nodes(space)] = np.hstack([vertices, mids])
    local = LocalCells(space, made.cells, numbers)
    _check(local, nodes)
    return local


def _check(local: LocalCells, nodes: Array) -> None:
    where = node_coordinates(local.space)
    size = np.ptp(where, axis=0).max()
    away = np.linalg.norm(where - nodes[local.nodes], axis=1)
    if np.any(local.nodes < 0) or away.max() > 1e-6 * size:
        worst = int(np.argmax(away))
        place = ", ".join(f"{x:g}" for x in nodes[local.nodes[worst]])
        raise SolutionError(
            f"node {local.nodes[worst]} at ({place}) m lies {away[worst]:.3g} m from its edge's "
            "middle; expected straight edges with mid nodes in the middle"
        )
