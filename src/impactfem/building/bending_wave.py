"""The frequency up to which the mesh of the slabs resolves bending waves."""

import numpy as np

from impactfem.building.mesh import side_lengths
from impactfem.building.parts import BuildingParts

ELEMENTS = 3.0
"""Least number of elements in a bending wave. Elements of second order then have an error of
(k h)⁴ / 720 in ω², 2.7 %, k the wave number: 1.3 % in the frequency."""


def mesh_limit(parts: BuildingParts) -> float:
    """Return the frequency at which a bending wave of a slab has `ELEMENTS` elements [Hz].

    Of a thin plate with all of its mass, ω = k² √(D / m'); with the median over the slab of each
    floor, of the floor with the lowest. Infinite without floors.
    """
    mesh, thickness = parts.mesh, parts.thickness()
    size = side_lengths(mesh.nodes, mesh.triangles).mean(axis=1)
    limits = [np.inf]
    for floor in mesh.floors:
        slab, material = mesh.slab(floor), parts.slab_material(floor)
        D = material.E * thickness[slab] ** 3 / (12.0 * (1.0 - material.nu**2))
        mass = material.rho * thickness[slab] + parts.added_mass[slab]
        k = 2.0 * np.pi / (ELEMENTS * size[slab])
        limits.append(float(np.median(k**2 * np.sqrt(D / mass) / (2.0 * np.pi))))
    return min(limits)
