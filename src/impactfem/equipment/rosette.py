"""The nodes of a floor that a device is anchored to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.building.links import RigidLink
from impactfem.building.mesh import BuildingMesh
from impactfem.errors import SolutionError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LEVEL = 0.05
"""How far from a floor's level an anchor may be [m]."""


@dataclass(frozen=True, eq=False)
class Rosette:
    """A rigid plate between nodes of a slab, with the anchor of a device in it.

    Args:
        name: Name of the device.
        floor: Number of the floor.
        point: The anchor, shape (3,) [m].
        master: The node nearest to it.
        followers: The other nodes within the radius, shape (n,).
        offset: From the master to the anchor, shape (3,) [m].
    """

    name: str
    floor: int
    point: Array
    master: int
    followers: Index
    offset: Array

    @property
    def link(self) -> RigidLink:
        """The rigid link of the nodes."""
        return RigidLink(self.master, self.followers)

    @property
    def nodes(self) -> Index:
        """All of its nodes, shape (n + 1,)."""
        return np.append(self.followers, self.master)

    @property
    def carried(self) -> Array:
        """S of the anchor's motion by the master's: u + θ × offset and θ, shape (6, 6)."""
        x, y, z = self.offset
        S = np.eye(6)
        S[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
        return S


def find_rosette(
    mesh: BuildingMesh, name: str, point: tuple[float, float, float], radius: float
) -> Rosette:
    """Find the nodes that a device is anchored to.

    Args:
        mesh: The mesh.
        name: Name of the device.
        point: Its anchor [m].
        radius: Of the rosette [m].

    Raises:
        SolutionError: The anchor is on no floor, or no node of the floor is within the radius: it
            stands over a hole, or beside the slab, or the mesh is too coarse.
    """
    at = np.array(point, dtype=np.float64)
    floor = min(mesh.elevations, key=lambda k: abs(mesh.elevations[k] - at[2]))
    if abs(mesh.elevations[floor] - at[2]) > LEVEL:
        raise SolutionError(
            f"device {name}: its anchor at z = {at[2]:g} m is on no floor; the nearest one, floor "
            f"{floor}, is at {mesh.elevations[floor]:g} m"
        )
    slab = mesh.triangles[mesh.triangles_of("floor", floor)]
    flat = slab[np.ptp(mesh.nodes[slab[:, :3], 2], axis=1) < 1e-6]
    nodes = np.unique(flat)
    away = np.linalg.norm(mesh.nodes[nodes, :2] - at[:2], axis=1)
    within = nodes[away <= radius * (1.0 + 1e-9)]
    master = int(nodes[np.argmin(away)])
    if not within.size:
        x, y, z = mesh.nodes[master]
        raise SolutionError(
            f"device {name}: no node of floor {floor} is within {radius:g} m of its anchor at "
            f"({at[0]:g}, {at[1]:g}) m; the nearest one, at ({x:.4g}, {y:.4g}, {z:.4g}) m, is "
            f"{away.min():.3g} m away: the anchor stands over a hole or beside the slab, or the "
            "mesh is too coarse for the radius"
        )
    return Rosette(
        name=name,
        floor=floor,
        point=at,
        master=master,
        followers=np.asarray(within[within != master], dtype=np.int64),
        offset=at - mesh.nodes[master],
    )
