"""The direction in which the edge of a floor faces the other building."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh

Array = NDArray[np.float64]


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
