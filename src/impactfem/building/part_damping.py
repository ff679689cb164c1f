"""Rayleigh damping of the parts of a building: which have their own, and what it is."""

from __future__ import annotations

from dataclasses import dataclass

from impactfem.building.mesh import BuildingMesh
from impactfem.building.part import Part, entry_of
from impactfem.case.structure import Structure
from impactfem.dynamics.damping import Rayleigh

"""α [1/s] and β [s]."""


@dataclass(frozen=True)
class PartDamping:
    """Coefficients of the parts of a mesh; None where a part has the damping of the building.

    Args:
        shells: Of each of the mesh's `shell_parts`, in their order.
        beams: Of each of the mesh's `beam_parts`, in their order.
    """

    shells: tuple[Rayleigh | None, ...]
    beams: tuple[Rayleigh | None, ...]

    @property
    def distinct(self) -> list[Rayleigh]:
        """The coefficients that occur, each once, ascending."""
        return sorted({one for one in (*self.shells, *self.beams) if one is not None})


def part_damping(structure: Structure, mesh: BuildingMesh) -> PartDamping | None:
    """The damping of the parts of a structure's mesh; None without damping by part.

    Args:
        structure: The structure, whose patterns match (`from_case.part_faults`).
        mesh: Its mesh.
    """
    if not structure.damping:
        return None

    def of(part: Part) -> Rayleigh | None:
        entry = entry_of(part, structure.damping)
        return None if entry is None else entry.rayleigh

    return PartDamping(
        shells=tuple(of(part) for part in mesh.shell_parts),
        beams=tuple(of(part) for part in mesh.beam_parts),
    )
