"""What is assembled: the mesh with its sections, its materials and the added mass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh
from impactfem.building.part import Part
from impactfem.building.part_damping import PartDamping
from impactfem.building.section import BeamSection, Material, Materials, Sections

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class ShellCells:
    """Shells of one kind: slabs or walls of one material.

    Args:
        storey: Whether the storey factor acts on them.
        material: Their material.
        cells: Nodes of the triangles, shape (m, 6).
        thickness: Of each triangle, shape (m,) [m].
        added_mass: On each triangle, shape (m,) [kg/m2].
        part: Index into the mesh's `shell_parts` of each triangle, shape (m,).
    """

    storey: bool
    material: Material
    cells: Index
    thickness: Array
    added_mass: Array
    part: Index


@dataclass(frozen=True, eq=False)
class BeamCells:
    """Beams of one kind: beams or columns of one material.

    Args:
        storey: Whether the storey factor acts on them.
        material: Their material.
        cells: Nodes of the lines, shape (m, 3).
        sections: Sections of the mesh's `beam_parts`, in their order.
        part: Index into them of each line, shape (m,).
    """

    storey: bool
    material: Material
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
        materials: Materials of the mesh's parts, in their order.
        added_mass: Mass on the area of each triangle that is not the shells' own, shape (m,)
            [kg/m2].
        drilling: Factor of the drilling stiffness μ t.
        dampings: Dampings of its parts; None where all have that of the building.
    """

    mesh: BuildingMesh
    sections: Sections
    materials: Materials
    added_mass: Array
    drilling: float = 1.0
    dampings: PartDamping | None = None

    def thickness(self) -> Array:
        """Thickness of each triangle, shape (m,) [m]."""
        by_part = np.array([section.thickness for section in self.sections.shells])
        return by_part[self.mesh.triangle_part]

    def slab_material(self, floor: int) -> Material:
        """The material of the slab of a floor: of its first part.

        Raises:
            KeyError: The floor has no slab.
        """
        for part, material in zip(self.mesh.shell_parts, self.materials.shells, strict=True):
            if (part.family, part.level) == ("floor", floor):
                return material
        raise KeyError(f"floor {floor} has no slab")

    def kinds(self) -> list[Kind]:
        """The cells that are there: slabs, walls, beams and columns, of each material apart."""
        mesh = self.mesh
        thickness = self.thickness()
        found: list[Kind] = []
        for scaled in (False, True):
            for material in dict.fromkeys(self.materials.shells):
                chosen = _cells(
                    mesh.shell_parts, self.materials.shells, mesh.triangle_part, scaled, material
                )
                if chosen.size:
                    found.append(
                        ShellCells(
                            scaled,
                            material,
                            mesh.triangles[chosen],
                            thickness[chosen],
                            self.added_mass[chosen],
                            mesh.triangle_part[chosen].astype(np.int64),
                        )
                    )
        for scaled in (False, True):
            for material in dict.fromkeys(self.materials.beams):
                chosen = _cells(
                    mesh.beam_parts, self.materials.beams, mesh.line_part, scaled, material
                )
                if chosen.size:
                    part = mesh.line_part[chosen].astype(np.int64)
                    lines = mesh.lines[chosen]
                    found.append(BeamCells(scaled, material, lines, self.sections.beams, part))
        return found


def _cells(
    parts: tuple[Part, ...],
    materials: tuple[Material, ...],
    part: NDArray[np.int32],
    scaled: bool,
    material: Material,
) -> Index:
    """The cells of the parts of a material that the storey factor acts on, or not."""
    own = [p.scaled == scaled and m == material for p, m in zip(parts, materials, strict=True)]
    return np.flatnonzero(np.array(own, dtype=bool)[part])
