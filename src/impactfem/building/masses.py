"""Masses of the floors: what the parts weigh, and what is added to reach given masses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh
from impactfem.building.part import Part
from impactfem.building.quality import areas as triangle_areas
from impactfem.building.section import Materials, Sections
from impactfem.system.errors import SolutionError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FloorMasses:
    """How the mass of a building belongs to its floors.

    A floor has its slab and beams, and of each wall and column the share by the lever rule: at
    the height z between floors k − 1 and k, the part (z − z_{k−1}) / (z_k − z_{k−1}) goes to
    floor k and the rest to floor k − 1. So half of a storey without bays goes to each.

    Args:
        parts: Mass of the parts by floor, shape (n_floors,) [kg].
        added: Mass added on the slab of each floor, shape (n_floors,) [kg].
        base: Mass that belongs to the base and does not move [kg].
        on_triangles: Added mass on each triangle, shape (m,) [kg/m2].
    """

    parts: Array
    added: Array
    base: float
    on_triangles: Array

    @property
    def floors(self) -> Array:
        """Mass of each floor, shape (n_floors,) [kg]."""
        return self.parts + self.added


def floor_masses(
    mesh: BuildingMesh, sections: Sections, materials: Materials, asked: Array | None = None
) -> FloorMasses:
    """Masses of the floors; with given masses, what must be added evenly on the slabs.

    Args:
        mesh: The mesh; its floors are 1 to n_floors.
        sections: Sections of its parts.
        materials: Their materials.
        asked: Masses of the floors, bottom to top, shape (n_floors,) [kg]; None adds nothing.

    Raises:
        SolutionError: A floor's parts weigh more than is asked, or it has no slab to add mass on.
    """
    areas = triangle_areas(mesh.nodes, mesh.triangles)
    on_area = [m.rho * s.thickness for m, s in zip(materials.shells, sections.shells, strict=True)]
    shells = areas * np.array(on_area)[mesh.triangle_part]
    shares = _shares(mesh, mesh.shell_parts, mesh.triangle_part, mesh.triangles[:, :3], shells)
    if len(mesh.lines):
        on_line = [m.rho * s.A for m, s in zip(materials.beams, sections.beams, strict=True)]
        beams = line_lengths(mesh) * np.array(on_line)[mesh.line_part]
        shares += _shares(mesh, mesh.beam_parts, mesh.line_part, mesh.lines[:, :2], beams)
    parts = shares[1:]
    on_triangles = np.zeros(len(areas))
    if asked is None:
        return FloorMasses(parts, np.zeros_like(parts), float(shares[0]), on_triangles)
    added = np.asarray(asked, dtype=np.float64) - parts
    for k, missing in zip(mesh.floors, added, strict=True):
        slab = mesh.slab(k)
        if slab.size == 0:
            raise SolutionError(f"floor {k} has no flat slab that could carry an added mass")
        if missing < 0.0:
            raise SolutionError(
                f"floor {k} weighs {parts[k - 1] / 1e3:.1f} t by its parts alone, more than the "
                f"{(parts[k - 1] + missing) / 1e3:.1f} t that the floors table gives it"
            )
        on_triangles[slab] = missing / areas[slab].sum()
    return FloorMasses(parts, added, float(shares[0]), on_triangles)


def line_lengths(mesh: BuildingMesh) -> Array:
    """Length of each line, shape (l,) [m]."""
    ends = mesh.nodes[mesh.lines[:, :2]]
    return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), dtype=np.float64)


def lever_rule(
    mesh: BuildingMesh,
    parts: tuple[Part, ...],
    part: NDArray[np.int32],
    corners: NDArray[np.int64],
) -> tuple[NDArray[np.int64], Array]:
    """The floor of each cell, and the share of its mass that belongs to it.

    The rest of a wall or a column belongs to the floor below, or to the base.

    Args:
        mesh: The mesh.
        parts: Parts that the cells are of.
        part: Index into them of each cell, shape (m,).
        corners: Vertices of the cells, shape (m, 2) or (m, 3).

    Returns:
        Numbers of floors and shares, each of shape (m,).
    """
    level = np.array([p.level for p in parts], dtype=np.int64)[part]
    standing = np.array([p.scaled for p in parts], dtype=bool)[part]
    elevation = np.array([mesh.nodes[mesh.base, 2].min(), *mesh.elevations.values()])
    z = mesh.nodes[corners, 2].mean(axis=1)
    below, above = elevation[level - 1], elevation[level]
    return level, np.where(standing, np.clip((z - below) / (above - below), 0.0, 1.0), 1.0)


def _shares(
    mesh: BuildingMesh,
    parts: tuple[Part, ...],
    part: NDArray[np.int32],
    corners: NDArray[np.int64],
    mass: Array,
) -> Array:
    """Mass of cells by level: the base, then the floors."""
    level, upper = lever_rule(mesh, parts, part, corners)
    count = 1 + len(mesh.floors)
    lower = np.bincount(level - 1, mass * (1.0 - upper), count)
    return np.asarray(np.bincount(level, mass * upper, count) + lower)
