"""The whole model as cells for a viewer: shells and beams at their vertices, or at all nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class MotionGrid:
    """Triangles and lines with their own numbering of nodes."""

    nodes: Index  #: Their nodes in the mesh, ascending, shape (n,).
    points: Array  #: Coordinates, shape (n, 3) [m].
    #: Indices of `nodes`, shape (m, 3), or (m, 6) with the mid nodes 01, 12 and 20.
    triangles: Index
    lines: Index  #: The same, shape (l, 2), or (l, 3) with the mid node last.

    @property
    def cells(self) -> int:
        """Number of triangles and lines."""
        return len(self.triangles) + len(self.lines)


def motion_grid(mesh: BuildingMesh, which: str) -> MotionGrid:
    """Shells and beams of a mesh.

    Args:
        mesh: The mesh.
        which: "vertices", or "all" nodes.
    """
    corners, ends = (6, 3) if which == "all" else (3, 2)
    triangles, lines = mesh.triangles[:, :corners], mesh.lines[:, :ends]
    nodes: Index = np.union1d(triangles, lines)
    return MotionGrid(
        nodes=nodes,
        points=mesh.nodes[nodes],
        triangles=np.searchsorted(nodes, triangles),
        lines=np.searchsorted(nodes, lines),
    )


def floor_vertices(mesh: BuildingMesh) -> Index:
    """Vertices of all floors, acroterion included, ascending."""
    return np.asarray(np.unique(mesh.triangles[mesh.triangles_of("floor"), :3]), dtype=np.int64)


def wave_slab(mesh: BuildingMesh, floor: int | None = None) -> tuple[Index, Index]:
    """Triangles of a floor's slab, and all of its nodes; of the top floor when None."""
    flat = mesh.slab(mesh.floors[-1] if floor is None else floor)
    return flat, np.unique(mesh.triangles[flat])


def recorded_nodes(mesh: BuildingMesh, probes: Index, floor: int | None = None) -> Index:
    """All nodes whose motion is recorded: probes, floors, and those of the waves.

    Args:
        mesh: The mesh.
        probes: Nodes of the probes, shape (n,).
        floor: Number of the floor with the waves; the top floor when None.
    """
    every = np.concatenate([probes, floor_vertices(mesh), wave_slab(mesh, floor)[1]])
    return np.asarray(np.unique(every), dtype=np.int64)
