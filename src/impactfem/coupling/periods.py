"""First periods of buildings before a run: those of sticks, and an estimate for generated meshes.

A period far from the usual ones is a sign of missing supports, of a wrong unit, or of sections
that are not those of the storeys.
"""

import math
from collections.abc import Iterator

import numpy as np
import scipy.linalg

from impactfem.case.buildings import Building, GeneratedMesh
from impactfem.case.model import Case
from impactfem.case.place import Place
from impactfem.case.plausibility import MODULUS, PERIOD_PER_STOREY
from impactfem.coupling.from_case import stick_of
from impactfem.system.arrays import Array

SHEAR = 5.0 / 6.0
"""Shear area of a rectangular section over its area."""

Bending = tuple[float, float | None]
"""Second moment of area and shear area of a member, None without shear deformation [m4, m2]."""


def unusual_periods(case: Case) -> Iterator[tuple[Place, str]]:
    """Find first periods of sticks and of 3D models that are not those of a building."""
    low, high = PERIOD_PER_STOREY
    for k, building in enumerate(case.buildings):
        storeys, young = len(building.floors), building.material.young_modulus
        if not MODULUS.low <= young <= MODULUS.high:
            continue  # has a warning of its own
        own = building.name not in case.sticks_on_models
        period = stick_period(building) if own else math.nan
        if own and not low * storeys <= period <= high * storeys:
            text = (
                f"the first period of the stick of {building.name} is {period:.3g} s, "
                f"{period / storeys:.2g} s a storey; expected {low:g} to {high:g} s a storey: "
                "correct units and stiffness of the floor table, young_modulus or "
                f'stiffness_factor, or type periods = {{ x = "{0.1 * storeys:.2g} s", y = '
                f'"{0.1 * storeys:.2g} s" }} with the periods of the building'
            )
            yield ("buildings", k, "floors"), text
        structure = building.structure
        if structure is None or not isinstance(structure.mesh, GeneratedMesh):
            continue
        if structure.calibration is not None:
            continue  # fitted to a frequency
        for axis, stiffness in zip("xy", storey_stiffness(building), strict=True):
            period = shear_period(building, stiffness)
            if period > high * storeys:
                text = (
                    f"the first period of the 3D model of {building.name} along {axis} is at least "
                    f"{period:.3g} s, {period / storeys:.2g} s a storey; expected at most "
                    f"{high:g} s a storey, by the stiffness of walls and columns between rigid "
                    "slabs: add rows to walls or columns, or correct their units"
                )
                yield ("buildings", k, "structure", "mesh", "columns"), text


def stick_period(building: Building) -> float:
    """Compute the first period of the stick of a building, on a clamped base [s]."""
    stick = stick_of(building)
    lowest = scipy.linalg.eigh(stick.K, stick.M, eigvals_only=True, subset_by_index=[0, 0])[0]
    return 2.0 * math.pi / math.sqrt(lowest) if lowest > 0.0 else math.inf


def storey_stiffness(building: Building) -> tuple[Array, Array]:
    """Estimate the lateral stiffness of the storeys of a generated mesh along x and y [N/m].

    Walls and columns are clamped between rigid slabs, 1 / (h³ / (12 E I) + h / (G A_s)), which is
    an upper bound. Openings in walls are left out.
    """
    structure = building.structure
    assert structure is not None and isinstance(structure.mesh, GeneratedMesh)
    mesh, factor = structure.mesh, structure.storey_stiffness_factor
    found = np.zeros((2, len(building.floors)))
    for k, floor in enumerate(building.floors):
        h = floor.storey_height - (mesh.slab(floor.floor) if k else 0.0)

        members = list[tuple[str, tuple[float, float], Bending, Bending]]()
        for column in mesh.columns:
            if floor.floor in column.levels:
                axis = math.cos(column.angle), math.sin(column.angle)
                a, b = column.width_x or 0.0, column.width_y or 0.0
                bendings = rectangle(a, b), rectangle(b, a)
                if (own := column.section) is not None:
                    bendings = (own.Iy, own.Avz), (own.Iz, own.Avy)
                members.append((f"column_{floor.floor}_{column.column}", axis, *bendings))
        for wall in mesh.walls:
            if floor.floor in wall.levels:
                axis = (wall.x2 - wall.x1) / wall.length, (wall.y2 - wall.y1) / wall.length
                a, b = wall.length, mesh.wall_thickness(wall, floor.floor)
                bendings = rectangle(a, b), rectangle(b, a)
                members.append((f"storey_{floor.floor}_{wall.wall}", axis, *bendings))
        for group, axis, *both in members:
            E = structure.material_of(group).young_modulus
            G = E / (2.0 * (1.0 + structure.material_of(group).poisson_ratio))
            along, across = (
                1.0 / (h**3 / (12.0 * E * moment) + (h / (G * area) if area else 0.0))
                for moment, area in both
            )
            x, y = np.square(axis)
            found[:, k] += x * along + y * across, y * along + x * across
    return factor * found[0], factor * found[1]


def rectangle(depth: float, width: float) -> Bending:
    """Return second moment of area and shear area of a rectangle along its depth [m4, m2]."""
    return width * depth**3 / 12.0, SHEAR * depth * width


def shear_period(building: Building, stiffness: Array) -> float:
    """Compute the first period of rigid floors on storeys that shear [s]."""
    masses = np.array([floor.mass for floor in building.floors])
    K = np.diag(stiffness) + np.diag(np.append(stiffness[1:], 0.0))
    K -= np.diag(stiffness[1:], 1) + np.diag(stiffness[1:], -1)
    lowest = scipy.linalg.eigh(K, np.diag(masses), eigvals_only=True, subset_by_index=[0, 0])[0]
    return 2.0 * math.pi / math.sqrt(lowest) if lowest > 0.0 else math.inf
