"""The mesh of a building as arrays: shells, beams, and the nodes that the study asks about."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from impactfem.building.part import Part

Array = NDArray[np.float64]


Ints = NDArray[np.int64]
FLAT = 1e-6
"""A slab is flat: the part of a triangle's height in its size that counts as none."""


def outward_normal(mesh: BuildingMesh, floor: int) -> Array:
    """The horizontal unit vector at right angles to the edge of a floor, out of the building.

    Args:
        mesh: The mesh.
        floor: Number of the floor, which has an edge.

    Returns:
        The vector, shape (3,).
    """
    edge = mesh.nodes[np.unique(mesh.edges[floor]), :2]
    middle = 0.5 * (edge.min(axis=0) + edge.max(axis=0))
    along = np.linalg.svd(edge - edge.mean(axis=0), full_matrices=False)[2][0]
    # Rounded, so that an edge along an axis has a normal along the other one.
    normal = np.round([along[1], -along[0], 0.0], 12)
    slab = mesh.nodes[np.unique(mesh.triangles[mesh.triangles_of("floor", floor)]), :2]
    side = 1.0 if normal[:2] @ (middle - slab.mean(axis=0)) > 0.0 else -1.0
    return np.asarray(side * normal / np.linalg.norm(normal) + 0.0)


@dataclass(frozen=True, eq=False)
class BuildingMesh:
    """Six-node triangles and three-node lines that share their nodes.

    Facets are plane and edges straight. The nodes are those that shells and beams use, numbered
    from 0 in the order of gmsh's tags.

    Args:
        nodes: Coordinates, shape (n, 3) [m].
        triangles: Nodes of each triangle, shape (m, 6): vertices 0 1 2, then the middles of the
            sides 01, 12 and 20.
        triangle_part: Index into `shell_parts` of each triangle, shape (m,).
        lines: Nodes of each line, shape (l, 3): the ends, then the middle.
        line_part: Index into `beam_parts` of each line, shape (l,).
        shell_parts: Slabs and walls, sorted.
        beam_parts: Beams and columns, sorted.
        edges: Lines (ends, middle) of the edge that faces the other building, shape (k, 3), by
            floor.
        centres: Node at the mass centre, by floor.
        base: Nodes that are clamped, ascending, shape (b,).
        dropped: Coordinates of nodes of the file that no shell or beam uses, shape (d, 3) [m].
    """

    nodes: Array
    triangles: Ints
    triangle_part: NDArray[np.int32]
    lines: Ints
    line_part: NDArray[np.int32]
    shell_parts: tuple[Part, ...]
    beam_parts: tuple[Part, ...]
    edges: dict[int, Ints]
    centres: dict[int, int]
    base: Ints
    dropped: Array = field(default_factory=lambda: np.zeros((0, 3)))

    @property
    def floors(self) -> tuple[int, ...]:
        """Numbers of the floors, bottom to top."""
        return tuple(sorted(self.centres))

    @property
    def elevations(self) -> dict[int, float]:
        """Elevation of each floor, at its mass centre [m]."""
        return {k: float(self.nodes[self.centres[k], 2]) for k in self.floors}

    @property
    def elements(self) -> int:
        """Number of shell and beam elements."""
        return len(self.triangles) + len(self.lines)

    def triangles_of(self, family: str, level: int | None = None) -> Ints:
        """Indices of the triangles of a family of parts, of one level or of all."""
        return np.flatnonzero(_chosen(self.shell_parts, family, level)[self.triangle_part])

    def slab(self, floor: int) -> Ints:
        """Indices of the flat triangles of a floor: its slab, without what stands upright on it."""
        chosen = self.triangles_of("floor", floor)
        size = np.ptp(self.nodes[self.triangles[chosen, :3]], axis=1)
        flat: Ints = chosen[size[:, 2] < FLAT * size.max(axis=1)]
        return flat

    def lines_of(self, family: str, level: int | None = None) -> Ints:
        """Indices of the lines of a family of parts, of one level or of all."""
        return np.flatnonzero(_chosen(self.beam_parts, family, level)[self.line_part])


def sides(triangles: Ints) -> Ints:
    """The sides of six-node triangles: the ends, the smaller number first, then the middle.

    Args:
        triangles: Shape (m, 6).

    Returns:
        Shape (3 m, 3): all sides 01, then all 12, then all 20.
    """
    found: Ints = np.concatenate(
        [triangles[:, [0, 1, 3]], triangles[:, [1, 2, 4]], triangles[:, [2, 0, 5]]]
    )
    found[:, :2].sort(axis=1)
    return found


def place(point: Array) -> str:
    """A point [m] in words, for messages."""
    return "({:.3f}, {:.3f}, {:.3f}) m".format(*(float(x) + 0.0 for x in point))


def _chosen(parts: tuple[Part, ...], family: str, level: int | None) -> NDArray[np.bool_]:
    return np.array(
        [part.family == family and level in (None, part.level) for part in parts], dtype=bool
    )
