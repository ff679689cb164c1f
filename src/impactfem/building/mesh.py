"""The mesh of a building: parts by the names of their groups, nodes, cells and their shapes."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from impactfem.system.arrays import Array, Index

DOFS = 6
"""Degrees of freedom of a node: ux, uy, uz, rx, ry, rz."""
SHELLS = ("floor", "storey")
FLAT = 1e-6
"""A slab is flat: the part of a triangle's height in its size that counts as none."""

FOLD = np.radians(30.0)
"""Angle between facets above which they meet at a corner and not on a curved surface."""

NAME = re.compile(r"[a-z0-9]+(?:_[a-z0-9]+)*")
"""What can stand behind the number of a group."""
_GROUP = re.compile(rf"(floor|storey|beam|column)_([1-9][0-9]{{0,17}})(?:_({NAME.pattern}))?")
_MARK = re.compile(r"(edge|centre)_([1-9][0-9]{0,17})")
SCHEME = (
    "floor_<k>[_<part>], storey_<k>[_<part>], beam_<k>[_<part>], column_<k>[_<part>], "
    "edge_<k>, centre_<k> or base, with <k> from 1 and <part> of a-z, 0-9 and single _"
)


@dataclass(frozen=True, order=True)
class Part:
    """A set of shells or beams of one section: the physical group ``floor_8_parapet``."""

    family: str  #: ``floor`` (slabs), ``storey`` (walls), ``beam`` or ``column``.
    level: int  #: Number k of the floor, or of the storey below it; from 1 upwards.
    name: str = ""  #: What stands behind the number; empty when nothing does.

    @property
    def group(self) -> str:
        """Name of the physical group."""
        start = f"{self.family}_{self.level}"
        return f"{start}_{self.name}" if self.name else start

    @property
    def dimension(self) -> int:
        """2 for shells, 1 for beams."""
        return 2 if self.family in SHELLS else 1

    @property
    def scaled(self) -> bool:
        """Whether the storey stiffness factor acts on it: walls and columns."""
        return self.family in ("storey", "column")


@dataclass(frozen=True, order=True)
class Mark:
    """A set of nodes that carries no stiffness: ``edge_8``, ``centre_8`` or ``base``."""

    kind: str  #: ``edge``, ``centre`` or ``base``.
    level: int = 0  #: Number of the floor; 0 for the base.

    @property
    def group(self) -> str:
        """Name of the physical group."""
        return self.kind if self.kind == "base" else f"{self.kind}_{self.level}"


def parse_group(group: str) -> Part | Mark | None:
    """What the name of a physical group says; None when it is none of the scheme's."""
    if group == "base":
        return Mark("base")
    if match := _MARK.fullmatch(group):
        return Mark(match[1], int(match[2]))
    if match := _GROUP.fullmatch(group):
        return Part(match[1], int(match[2]), match[3] or "")
    return None


@dataclass(frozen=True, eq=False)
class BuildingMesh:
    """Six-node triangles and three-node lines that share their nodes.

    Facets are plane and edges straight. The nodes are those that shells and beams use, numbered
    from 0 in the order of gmsh's tags.
    """

    nodes: Array  #: Coordinates, shape (n, 3) [m].
    #: Nodes of each triangle, shape (m, 6): vertices 0 1 2, then the middles of the sides 01, 12
    #: and 20.
    triangles: Index
    triangle_part: NDArray[np.int32]  #: Index into `shell_parts` of each triangle, shape (m,).
    lines: Index  #: Nodes of each line, shape (l, 3): the ends, then the middle.
    line_part: NDArray[np.int32]  #: Index into `beam_parts` of each line, shape (l,).
    shell_parts: tuple[Part, ...]  #: Slabs and walls, sorted.
    beam_parts: tuple[Part, ...]  #: Beams and columns, sorted.
    #: Lines (ends, middle) of the edge that faces the other building, shape (k, 3), by floor.
    edges: dict[int, Index]
    centres: dict[int, int]  #: Node at the mass centre, by floor.
    base: Index  #: Nodes that are clamped, ascending, shape (b,).
    #: Coordinates of nodes of the file that no shell or beam uses, shape (d, 3) [m].
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
    def base_middle(self) -> Array:
        """Middle of the box around the clamped nodes, shape (3,) [m]."""
        base = self.nodes[self.base]
        return np.asarray(0.5 * (base.min(axis=0) + base.max(axis=0)))

    def triangles_of(self, family: str, level: int | None = None) -> Index:
        """Indices of the triangles of a family of parts, of one level or of all."""
        chosen = [p.family == family and level in (None, p.level) for p in self.shell_parts]
        return np.flatnonzero(np.array(chosen, dtype=bool)[self.triangle_part])

    def lines_of(self, family: str, level: int | None = None) -> Index:
        """Indices of the lines of a family of parts, of one level or of all."""
        chosen = [p.family == family and level in (None, p.level) for p in self.beam_parts]
        return np.flatnonzero(np.array(chosen, dtype=bool)[self.line_part])

    def slab(self, floor: int) -> Index:
        """Indices of the flat triangles of a floor: its slab, without what stands upright on it."""
        chosen = self.triangles_of("floor", floor)
        size = np.ptp(self.nodes[self.triangles[chosen, :3]], axis=1)
        flat: Index = chosen[size[:, 2] < FLAT * size.max(axis=1)]
        return flat

    def edge_axis(self, floor: int) -> int:
        """The axis along the edge of a floor: 0 for x, 1 for y."""
        return int(np.argmax(np.ptp(self.nodes[np.unique(self.edges[floor]), :2], axis=0)))


def outward_normal(mesh: BuildingMesh, floor: int) -> Array:
    """The horizontal unit vector at right angles to the edge of a floor, out of the building."""
    edge = mesh.nodes[np.unique(mesh.edges[floor]), :2]
    middle = 0.5 * (edge.min(axis=0) + edge.max(axis=0))
    along = np.linalg.svd(edge - edge.mean(axis=0), full_matrices=False)[2][0]
    # Rounded, so that an edge along an axis has a normal along the other one.
    normal = np.round([along[1], -along[0], 0.0], 12)
    slab = mesh.nodes[np.unique(mesh.triangles[mesh.triangles_of("floor", floor)]), :2]
    side = 1.0 if normal[:2] @ (middle - slab.mean(axis=0)) > 0.0 else -1.0
    return np.asarray(side * normal / np.linalg.norm(normal) + 0.0)


def sides(triangles: Index) -> Index:
    """The sides of six-node triangles: the ends, the smaller number first, then the middle.

    Of shape (3 m, 3): all sides 01, then all 12, then all 20.
    """
    ends_middle = ([0, 1, 3], [1, 2, 4], [2, 0, 5])
    every: Index = np.concatenate([triangles[:, columns] for columns in ends_middle])
    every[:, :2].sort(axis=1)
    return every


def shared_sides(triangles: Index) -> tuple[Index, Index, Index]:
    """Sides that exactly two triangles share: the index of each triangle, and the middle node."""
    middles, owner = sides(triangles)[:, 2], np.tile(np.arange(len(triangles)), 3)
    order = np.argsort(middles, kind="stable")
    found, first, counts = np.unique(middles[order], return_index=True, return_counts=True)
    pairs = first[counts == 2]
    return owner[order[pairs]], owner[order[pairs + 1]], found[counts == 2]


def rim(triangles: Index) -> tuple[Index, Index]:
    """The sides that one triangle alone has, as of `sides`, and its index; by ascending middles."""
    every = sides(triangles)
    _, first, count = np.unique(every[:, 2], return_index=True, return_counts=True)
    alone = first[count == 1]
    return every[alone], alone % len(triangles)


def joined_cells(cells: Sequence[Index], width: int) -> tuple[Index, Index]:
    """Cells of several parts, `width` nodes each, and the number of the part of each cell."""
    part = np.repeat(np.arange(len(cells)), [len(of_part) for of_part in cells])
    return np.concatenate([np.zeros((0, width), dtype=np.int64), *cells]), part


def area_shares(nodes: Array, triangles: Index) -> Array:
    """∫ N dA at each node, shape (n,) [m2].

    On six-node triangles it is zero at the vertices and a third of the area at each middle of a
    side.
    """
    shares = np.zeros(len(nodes))
    np.add.at(shares, triangles[:, 3:], areas(nodes, triangles)[:, None] / 3.0)
    return shares


def place(point: Array) -> str:
    """A point [m] in words, for messages."""
    return "({:.3f}, {:.3f}, {:.3f}) m".format(*(float(x) + 0.0 for x in point))


def radius_ratio(nodes: Array, triangles: Index) -> Array:
    """Twice the radius of the inscribed circle over that of the circumscribed one.

    q = 8 (s - a)(s - b)(s - c)/(a b c), with the sides a, b, c and s half their sum: 1 when they
    are equal, 0 when the triangle has collapsed. gmsh calls it gamma. The vertices are the first
    three columns of `triangles`.
    """
    a, b, c = side_lengths(nodes, triangles).T
    s = 0.5 * (a + b + c)
    product = a * b * c
    with np.errstate(invalid="ignore", divide="ignore"):
        q = 8.0 * (s - a) * (s - b) * (s - c) / product
    return np.where(product > 0.0, np.clip(q, 0.0, 1.0), 0.0)


def side_lengths(nodes: Array, triangles: Index) -> Array:
    """Lengths of the sides 01, 12 and 20, shape (m, 3)."""
    vertices = nodes[triangles[:, :3]]
    lengths: Array = np.linalg.norm(vertices - np.roll(vertices, -1, axis=1), axis=2)
    return lengths


def line_lengths(mesh: BuildingMesh) -> Array:
    """Length of each line, shape (l,) [m]."""
    ends = mesh.nodes[mesh.lines[:, :2]]
    return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))


def normals(nodes: Array, triangles: Index) -> Array:
    """Unit normals, shape (m, 3); zero for a triangle without an area."""
    p, q, r = np.moveaxis(nodes[triangles[:, :3]], 1, 0)
    normal: Array = np.cross(q - p, r - p)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    return normal


def areas(nodes: Array, triangles: Index) -> Array:
    """Areas, shape (m,)."""
    p, q, r = np.moveaxis(nodes[triangles[:, :3]], 1, 0)
    twice: Array = np.linalg.norm(np.cross(q - p, r - p), axis=1)
    return 0.5 * twice


def rigid_body(points: Array, origin: Array) -> Array:
    """The six unit motions u = a + b × (x − x0), θ = b of points x, shape (n, 3) [m].

    Shape (6 n, 6): one column for each of ax, ay, az, bx, by, bz; rows (ux, uy, uz, rx, ry, rz) of
    each point.
    """
    x, y, z = (points - origin).T
    motions = np.tile(np.eye(6), (len(points), 1, 1))
    motions[:, [1, 2], 3] = np.column_stack([-z, y])
    motions[:, [0, 2], 4] = np.column_stack([z, -x])
    motions[:, [0, 1], 5] = np.column_stack([-y, x])
    return motions.reshape(-1, 6)
