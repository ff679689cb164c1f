"""A floor as a bar across the building: what a wave between its edges meets, by hand.

A load normal to an edge, even along it, stretches and presses a wide slab across itself and hardly
along itself. Across the building the floor is then a bar of the length L, the distance of its
edges, with

    EA' = (1/L) (∫ E t/(1 − ν²) dA + Σ E A_b cos⁴φ ℓ_b),    m' = (1/L) Σ m,    c = √(EA'/m'),

where dA is the slab's area, A_b, ℓ_b and φ the section, the length and the angle to the bar of its
beams, and m the masses of slab and beams and what is added on the slab. Half a storey of the walls
and columns next to the floor moves with it, too: what stands in the edges themselves is a mass at
an end of the bar, the rest is spread along it. Eccentricity of the beams, upstands and the bending
of slab and walls are not in the bar.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.building.masses import lever_rule, line_lengths
from impactfem.building.mesh import BuildingMesh
from impactfem.building.parts import BuildingParts
from impactfem.building.quality import areas

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

IN_EDGE = 1e-6
"""How far from an edge a cell may be that stands in it, over the length of the bar."""


@dataclass(frozen=True)
class FloorBar:
    """A floor as a bar.

    Args:
        length: L [m].
        stiffness: EA' [N].
        slab_mass: Of slab, beams and what is added on the slab [kg].
        standing_mass: Of what stands on the floor and below it by the lever rule, outside of the
            bar's ends [kg].
        end_mass: Of what stands in the edges at the lower and the upper end [kg].
    """

    length: float
    stiffness: float
    slab_mass: float
    standing_mass: float
    end_mass: tuple[float, float]

    @property
    def speed(self) -> float:
        """Speed c = √(EA'/m') of the slab with its beams and what is added on it [m/s]."""
        return math.sqrt(self.stiffness * self.length / self.slab_mass)

    @property
    def crossing(self) -> float:
        """L/c [s]."""
        return self.length / self.speed


def floor_bar(parts: BuildingParts, floor: int, axis: int) -> FloorBar:
    """The bar of a floor.

    Args:
        parts: The building.
        floor: Number of the floor.
        axis: 0 for a bar along x, 1 for one along y.

    Raises:
        KeyError: The floor has no slab.
    """
    mesh, shells_of, beams_of = parts.mesh, parts.materials.shells, parts.materials.beams
    slab = mesh.slab(floor)
    if not len(slab):
        raise KeyError(f"floor {floor} has no slab")
    along = mesh.nodes[mesh.triangles[slab, :3], axis]
    ends = float(along.min()), float(along.max())
    L = ends[1] - ends[0]
    dA, t = areas(mesh.nodes, mesh.triangles), parts.thickness()
    rho = np.array([m.rho for m in shells_of])[mesh.triangle_part]
    shells = rho * t * dA  # without the added mass, which lies on slabs alone
    plane = np.array([m.E / (1.0 - m.nu**2) for m in shells_of])[mesh.triangle_part]
    EA = float((plane * t * dA)[slab].sum()) / L
    in_slab = float((shells + parts.added_mass * dA)[slab].sum())
    beams = mesh.lines_of("beam", floor)
    A, ell, rods = np.zeros(0), np.zeros(0), np.zeros(0)
    if len(mesh.lines):
        A = np.array([section.A for section in parts.sections.beams])[mesh.line_part]
        E = np.array([m.E for m in beams_of])[mesh.line_part]
        ell = line_lengths(mesh)
        rods = np.array([m.rho for m in beams_of])[mesh.line_part] * A * ell
        tangent = mesh.nodes[mesh.lines[beams, 1], axis] - mesh.nodes[mesh.lines[beams, 0], axis]
        EA += float(((E * A)[beams] * (tangent / ell[beams]) ** 4 * ell[beams]).sum()) / L
        in_slab += float(rods[beams].sum())
    upright = np.ones(len(shells), dtype=bool)
    upright[slab] = False
    columns = np.ones(len(rods), dtype=bool)
    columns[beams] = False
    standing, at_ends = 0.0, np.zeros(2)
    for cells, part, of, mass, chosen in (
        (mesh.triangles[:, :3], mesh.triangle_part, mesh.shell_parts, shells, upright),
        (mesh.lines[:, :2], mesh.line_part, mesh.beam_parts, rods, columns),
    ):
        if not len(cells):
            continue
        level, upper = lever_rule(mesh, of, part, cells)
        mine = mass * (upper * (level == floor) + (1.0 - upper) * (level == floor + 1)) * chosen
        for end, place in enumerate(ends):
            here = np.abs(mesh.nodes[cells, axis] - place).max(axis=1) < IN_EDGE * L
            at_ends[end] += mine[here].sum()
            mine[here] = 0.0
        standing += float(mine.sum())
    return FloorBar(L, EA, in_slab, standing, (float(at_ends[0]), float(at_ends[1])))


def bar_axis(mesh: BuildingMesh, floor: int) -> int:
    """The axis across the edge of a floor: 0 for x, 1 for y.

    Raises:
        KeyError: The floor has no edge.
    """
    spread: Array = np.ptp(mesh.nodes[np.unique(mesh.edges[floor]), :2], axis=0)
    return 1 - int(np.argmax(spread))
