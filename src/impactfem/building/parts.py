"""What is assembled: the mesh with its sections, its material and the added mass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh
from impactfem.building.part import Part
from impactfem.building.part_damping import PartDamping
from impactfem.building.section import BeamSection, Sections

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ShellCells:
    """Shells of one kind: slabs, or walls.

    Args:
        storey: Whether the storey factor acts on them.
        cells: Nodes of the triangles, shape (m, 6).
        thickness: Of each triangle, shape (m,) [m].
        added_mass: On each triangle, shape (m,) [kg/m2].
        part: Index into the mesh's `shell_parts` of each triangle, shape (m,).
    """

    storey: bool
    cells: Index
    thickness: Array
    added_mass: Array
    part: Index


@dataclass(frozen=True, eq=False)
class BeamCells:
    """Beams of one kind: beams, or columns.

    Args:
        storey: Whether the storey factor acts on them.
        cells: Nodes of the lines, shape (m, 3).
        sections: Sections of the mesh's `beam_parts`, in their order.
        part: Index into them of each line, shape (m,).
    """

    storey: bool
    cells: Index
    sections: tuple[BeamSection, ...]
    part: Index


Kind = ShellCells | BeamCells


@dataclass(frozen=True, eq=False)
class BuildingParts:
    """A building ready for assembly.

    Args:
        mesh: Its mesh.
        sections: Sections of the mesh's parts, in their order.
        young_modulus: E [Pa].
        poisson_ratio: ν.
        density: ρ [kg/m3].
        added_mass: Mass on the area of each triangle that is not the shells' own, shape (m,)
            [kg/m2].
        drilling: Factor of the drilling stiffness μ t.
        dampings: Dampings of its parts; None where all have that of the building.
    """

    mesh: BuildingMesh
    sections: Sections
    young_modulus: float
    poisson_ratio: float
    density: float
    added_mass: Array
    drilling: float = 1.0
    dampings: PartDamping | None = None

    def thickness(self) -> Array:
        """Thickness of each triangle, shape (m,) [m]."""
        by_part = np.array([section.thickness for section in self.sections.shells])
        return by_part[self.mesh.triangle_part]

    def kinds(self) -> list[Kind]:
        """The cells that are there, as slabs, walls, beams and columns."""
        mesh = self.mesh
        thickness = self.thickness()
        found: list[Kind] = []
        for scaled in (False, True):
            chosen = np.flatnonzero(_scaled(mesh.shell_parts, scaled)[mesh.triangle_part])
            if chosen.size:
                found.append(
                    ShellCells(
                        scaled,
                        mesh.triangles[chosen],
                        thickness[chosen],
                        self.added_mass[chosen],
                        mesh.triangle_part[chosen].astype(np.int64),
                    )
                )
        for scaled in (False, True):
            chosen = np.flatnonzero(_scaled(mesh.beam_parts, scaled)[mesh.line_part])
            if chosen.size:
                part = mesh.line_part[chosen].astype(np.int64)
                found.append(BeamCells(scaled, mesh.lines[chosen], self.sections.beams, part))
        return found


def _scaled(parts: tuple[Part, ...], scaled: bool) -> NDArray[np.bool_]:
    return np.array([part.scaled == scaled for part in parts], dtype=bool)
