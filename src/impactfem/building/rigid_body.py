"""Rigid-body motions of points with displacements and rotations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rigid_body(points: Array, origin: Array) -> Array:
    """The six unit motions u = a + b × (x − x0), θ = b of points.

    Args:
        points: Coordinates x, shape (n, 3) [m].
        origin: x0, shape (3,) [m].

    Returns:
        One column for each of ax, ay, az, bx, by, bz; rows (ux, uy, uz, rx, ry, rz) of each point;
        shape (6 n, 6).
    """
    arm = points - origin
    motions = np.zeros((len(points), 6, 6))
    motions[:, np.arange(6), np.arange(6)] = 1.0
    for axis in range(3):
        b = np.zeros(3)
        b[axis] = 1.0
        motions[:, :3, 3 + axis] = np.cross(b, arm)
    return motions.reshape(-1, 6)
