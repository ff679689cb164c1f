"""Shells and beams: meshes and materials that benchmarks share, without a mesh generator."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh import sides
from impactfem.building.section import BeamSection, Material
from impactfem.building.shell_model import Beams
from impactfem.system.arrays import Array, Index

Vector = tuple[float, float, float]
Map = Callable[[Array, Array], tuple[Array, Array, Array]]

CONCRETE = Material(E=33e9, nu=0.2, rho=2500.0)
STEEL = Material(E=200e9, nu=0.3, rho=8000.0)
SHEAR = 5.0 / 6.0  # factor of the shear stiffness of plates and of rectangular sections
SAME = 1e-9  # points closer than this part of the mesh's size are one node
ROTATION = np.array([[2.0, -2.0, 1.0], [1.0, 2.0, 2.0], [-2.0, -1.0, 2.0]]) / 3.0
"""A rotation that leaves no axis where it was."""


def flat(along: Vector, across: Vector, corner: Vector = (0.0, 0.0, 0.0)) -> Map:
    """Return the parallelogram of two sides from a corner [m], as a place for `panel`."""

    def place(a: Array, b: Array) -> tuple[Array, Array, Array]:
        x, y, z = (o + a * p + b * q for o, p, q in zip(corner, along, across, strict=True))
        return x, y, z

    return place


def panel(columns: int, rows: int, place: Map, distortion: float = 0.0) -> tuple[Array, Index]:
    """Quadratic triangles on the image of the unit square: nodes (n, 3) [m], cells (m, 6).

    The cells of a regular grid are all cut along the same diagonal, on which elements lock more
    than on diagonals by turns. Facets are flat: the vertices lie on the surface and the mid nodes
    in the middle of the chords. `place` maps points (a, b) of the square to coordinates [m], and
    `distortion`, below 0.5, is how far inner vertices are shifted at most, in cells.
    """
    i, j = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1), indexing="ij")
    inner = (i > 0) & (i < columns) & (j > 0) & (j < rows)
    shift = distortion * np.random.default_rng(4).uniform(-1.0, 1.0, (2, *i.shape)) * inner
    a, b = (i + shift[0]) / columns, (j + shift[1]) / rows
    vertices = np.column_stack([x.ravel() for x in place(a, b)])
    number = i * (rows + 1) + j
    p, q = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
    r, s = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
    halves = np.concatenate([np.column_stack([p, q, r]), np.column_stack([p, r, s])])
    return quadratic(vertices, halves)


def rectangle(
    length: float, width: float, columns: int, rows: int, distortion: float = 0.0
) -> tuple[Array, Index]:
    """A panel from the origin along x and y."""
    return panel(columns, rows, flat((length, 0.0, 0.0), (0.0, width, 0.0)), distortion)


def mindlin(k2: Array, t: float, material: Material) -> Array:
    """Angular frequencies of waves k² in a plate of Mindlin [rad/s].

    With S = κ G t and I = ρ t³/12, ω² is the smaller root of
    (S k² − ρ t ω²) (D k² + S − I ω²) = S² k².
    """
    E, nu, mass = material.E, material.nu, material.rho * t
    D, S, rotary = E * t**3 / (12.0 * (1.0 - nu**2)), SHEAR * material.G * t, mass * t**2 / 12.0
    a, b, c = mass * rotary, mass * (D * k2 + S) + rotary * S * k2, S * D * k2**2
    # The smaller root, without the loss of digits of b − √(b² − 4 a c).
    return np.asarray(np.sqrt(2.0 * c / (b + np.sqrt(b**2 - 4.0 * a * c))))


def joined(panels: list[tuple[Array, Index]]) -> tuple[Array, Index, Index]:
    """Join panels to one mesh with common nodes; also return the panel of each triangle."""
    nodes = np.concatenate([panel[0] for panel in panels])
    starts = np.cumsum([0, *(len(panel[0]) for panel in panels)])
    triangles = np.concatenate(
        [panel[1] + start for panel, start in zip(panels, starts[:-1], strict=True)]
    )
    of = np.repeat(np.arange(len(panels)), [len(panel[1]) for panel in panels])
    key = np.round(nodes / (SAME * np.ptp(nodes, axis=0).max())).astype(np.int64)
    _, first, inverse = np.unique(key, axis=0, return_index=True, return_inverse=True)
    return nodes[first], inverse.ravel()[triangles], of


def straight_beam(
    length: float, elements: int, section: BeamSection, material: Material
) -> tuple[Array, Beams]:
    """A beam along x from the origin; its nodes are ordered along it."""
    nodes = np.zeros((2 * elements + 1, 3))
    nodes[:, 0] = np.linspace(0.0, length, len(nodes))
    first = 2 * np.arange(elements)
    return nodes, Beams(np.column_stack([first, first + 2, first + 1]), section, material)


def lines_at(triangles: Index, here: NDArray[np.bool_]) -> Index:
    """Sides of triangles (m, 6) with all three nodes `here` (n,): ends and middle, shape (k, 3)."""
    found = sides(triangles)
    return np.asarray(np.unique(found[here[found].all(axis=1)], axis=0), dtype=np.int64)


def quadratic(vertices: Array, triangles: Index) -> tuple[Array, Index]:
    """Add the mid nodes of the sides."""
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    edges, inverse = np.unique(ends, axis=0, return_inverse=True)
    nodes = np.concatenate([vertices, vertices[edges].mean(axis=1)])
    mids = len(vertices) + inverse.reshape(-1, 3)
    return nodes, np.hstack([triangles, mids])
