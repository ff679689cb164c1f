"""Slender triangles in thin plates: upper estimate of the error of the bending stiffness.

The reduced shear of `impactfem.building.shell` keeps the mean of γ over each triangle. In a thin
plate this demands a constant rot β in the triangle. The bubble of the rotations relaxes the demand
by the flexibility τ ~ w²/D_b of the width w of the triangle, but a plate that twists along the
length l of the triangle violates it in proportion to l³. The parasitic energy therefore grows with
(l/w)² (l/L)⁴ for a plate of span L, as long as the thickness t is small compared with w. Upper
bounds of computed plates are

    error = x / (1 + x),   x = 0.6 (a^1.5 (l/L)^3.5 + a^0.75 l/L),   a = l / √(w² + 8 t²)

The second term is for triangles at a re-entrant corner alone, where moments are singular. l and w
are √2 times the singular values of the vertices' positions about their centroid: both are the side
of an equilateral triangle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from impactfem.building.mesh import FOLD, BuildingMesh, normals, shared_sides, sides
from impactfem.system.arrays import Array, Index

SLENDER, THIN = 2.0, 1.5
"""Ratios l/w and a above which a triangle counts: right triangles 1:1 have l/w = 1.7, 2:1 2.5."""
RE_ENTRANT = np.radians(190.0)
"""Angle of a panel at a corner above which the corner is re-entrant."""
_ON_SIDE = np.linspace(0.0, 1.0, 9)  # where distances to a side are taken
_SCALES = 2.0 ** (-0.25 * np.arange(64))


@dataclass(frozen=True, eq=False)
class SlenderTriangles:
    """The slender triangles of a mesh and their panels, each array of the shape (k,)."""

    cells: Index  #: Index of the triangle in the mesh.
    length: Array  #: l [m].
    width: Array  #: w [m].
    thickness: Array  #: t [m].
    span: Array  #: Span L of its panel [m].
    at_corner: Array  #: 1 at a re-entrant corner of the panel, else 0.

    @classmethod
    def of(cls, mesh: BuildingMesh, thickness: Array) -> SlenderTriangles:
        """Find those of a mesh, by the thickness of each triangle, shape (m,) [m]."""
        vertices = mesh.nodes[mesh.triangles[:, :3]]
        about = vertices - vertices.mean(axis=1, keepdims=True)
        length, width = np.sqrt(2.0) * np.linalg.svd(about, compute_uv=False)[:, :2].T
        cells = np.flatnonzero(_counts(length, width, thickness))
        return cls(cells, length[cells], width[cells], thickness[cells], *_panels(mesh, cells))

    @property
    def error(self) -> Array:
        """Upper estimate of how much too small deflections of the panel are [-].

        It adds to the error of well-shaped triangles of the same length.
        """
        error: Array = self._error(np.ones(1))[0]
        return error

    def allowed_scale(self, allowed: float) -> Array:
        """Factor of the length that gives at most an allowed error at the same width [-]."""
        scale: Array = _SCALES[np.argmax(self._error(_SCALES) <= allowed, axis=0)]
        return scale

    def _error(self, scales: Array) -> Array:
        """Of lengths times each scale, shape (n_scales, k)."""
        length = scales[:, None] * self.length
        a = length / np.sqrt(self.width**2 + 8.0 * self.thickness**2)
        r = length / self.span
        x = 0.6 * (a**1.5 * r**3.5 + a**0.75 * r * self.at_corner)
        return np.where(_counts(length, self.width, self.thickness), x / (1.0 + x), 0.0)


def _counts(length: Array, width: Array, thickness: Array) -> NDArray[np.bool_]:
    thin = length > THIN * np.sqrt(width**2 + 8.0 * thickness**2)
    return np.asarray((length > SLENDER * width) & thin)


def _panels(mesh: BuildingMesh, chosen: Index) -> tuple[Array, Array]:
    """Span of the panel of each chosen triangle [m], and 1 for one at a re-entrant corner, else 0.

    A panel ends at free edges, at other shells and at beams. D is the diameter of its largest
    circle without a column or a clamped node inside. With such nodes the span is D. Without them it
    is D (H/D)^0.75 for a panel of the length H > D along the triangle, because long panels bend
    along themselves near their ends alone.
    """
    nodes, triangles, count = mesh.nodes, mesh.triangles, len(mesh.triangles)
    a, b, middle = shared_sides(triangles)
    normal = normals(nodes, triangles)
    smooth = np.abs(np.einsum("ij,ij->i", normal[a], normal[b])) > np.cos(FOLD)
    smooth &= ~np.isin(middle, mesh.lines[:, 2])
    joints = coo_array((np.ones(smooth.sum()), (a[smooth], b[smooth])), shape=(count, count))
    _, panel = connected_components(joints, directed=False)
    every, owner = sides(triangles), np.tile(np.arange(count), 3)
    outer = ~np.isin(every[:, 2], middle[smooth])
    held = np.union1d(mesh.lines, mesh.base)
    vertices = nodes[triangles[:, :3]]
    centres = vertices.mean(axis=1)
    span, at_corner = np.zeros(count), np.zeros(count)
    for k in np.unique(panel[chosen]).tolist():
        cells, some = np.flatnonzero(panel == k), chosen[panel[chosen] == k]
        border = every[outer & (panel[owner] == k)]
        start, end = nodes[border[:, :2]].transpose(1, 0, 2)
        on_border = (start + _ON_SIDE[:, None, None] * (end - start)).reshape(-1, 3)
        used = np.unique(triangles[cells])
        inner = np.setdiff1d(np.intersect1d(used, held), border)
        inside = np.vstack([nodes[used], centres[cells]])
        distance, _ = cKDTree(np.vstack([on_border, nodes[inner]])).query(inside)
        span[some] = 2.0 * distance.max()
        if not len(inner):
            lengths = [_length_along(vertices[cell], start, end) for cell in some]
            span[some] *= np.maximum(np.array(lengths) / span[some], 1.0) ** 0.75
        to_next = np.roll(vertices[cells], -1, axis=1) - vertices[cells]
        to_last = np.roll(vertices[cells], 1, axis=1) - vertices[cells]
        opposite = np.linalg.norm(np.cross(to_next, to_last), axis=2)
        angle = np.arctan2(opposite, np.einsum("ijk,ijk->ij", to_next, to_last))
        total = np.bincount(triangles[cells, :3].ravel(), angle.ravel(), minlength=len(nodes))
        corners = np.intersect1d(border[:, :2], np.flatnonzero(total > RE_ENTRANT))
        at_corner[some] = np.isin(triangles[some, :3], corners).any(axis=1)
    return span[chosen], at_corner[chosen]


def _length_along(vertices: Array, start: Array, end: Array) -> float:
    """Length H of a panel along a long side of a triangle, between the sides of its border [m].

    The larger one of the lines through the centroid parallel to the two longer sides. 0 where a
    line leaves a curved panel.
    """
    centre = vertices.mean(axis=0)
    vectors = np.roll(vertices, -1, axis=0) - vertices
    vectors = vectors[np.argsort(np.linalg.norm(vectors, axis=1))]
    normal = np.cross(vectors[0], vectors[1])
    largest = 0.0
    for side in vectors[1:]:
        along, across = side / np.linalg.norm(side), np.cross(normal, side)
        y0, y1 = (start - centre) @ across, (end - centre) @ across
        crossed = (y0 > 0.0) != (y1 > 0.0)
        part = y0[crossed] / (y0 - y1)[crossed]
        x = (start[crossed] + part[:, None] * (end - start)[crossed] - centre) @ along
        length = x[x > 0.0].min(initial=np.inf) - x[x <= 0.0].max(initial=-np.inf)
        if np.isfinite(length):
            largest = max(largest, float(length))
    return largest
