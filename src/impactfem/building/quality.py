"""Shape of triangles: how far they are from collapsing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def radius_ratio(nodes: Array, triangles: NDArray[np.int64]) -> Array:
    """Twice the radius of the inscribed circle over that of the circumscribed one.

    q = 8 (s - a)(s - b)(s - c)/(a b c), with the sides a, b, c and s half their sum: 1 when they
    are equal, 0 when the triangle has collapsed. gmsh calls it gamma.

    Args:
        nodes: Coordinates, shape (n, 3).
        triangles: Vertices in the first three columns, shape (m, >= 3).

    Returns:
        Shape (m,).
    """
    a, b, c = side_lengths(nodes, triangles).T
    s = 0.5 * (a + b + c)
    product = a * b * c
    with np.errstate(invalid="ignore", divide="ignore"):
        q = 8.0 * (s - a) * (s - b) * (s - c) / product
    return np.where(product > 0.0, np.clip(q, 0.0, 1.0), 0.0)


def side_lengths(nodes: Array, triangles: NDArray[np.int64]) -> Array:
    """Lengths of the sides 01, 12 and 20, shape (m, 3)."""
    vertices = nodes[triangles[:, :3]]
    lengths: Array = np.linalg.norm(vertices - np.roll(vertices, -1, axis=1), axis=2)
    return lengths


def areas(nodes: Array, triangles: NDArray[np.int64]) -> Array:
    """Areas, shape (m,)."""
    p, q, r = np.moveaxis(nodes[triangles[:, :3]], 1, 0)
    twice: Array = np.linalg.norm(np.cross(q - p, r - p), axis=1)
    return 0.5 * twice
