"""Rayleigh damping of the parts of a building: which have their own, and what it is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from impactfem.building.mesh import BuildingMesh
from impactfem.building.part import Part
from impactfem.case.part_damping import PartDamping as Entry
from impactfem.case.structure import Structure
from impactfem.errors import Fault, InputError

Coefficients = tuple[float, float]
"""α [1/s] and β [s]."""
KEY = "structure.damping"


@dataclass(frozen=True)
class PartDamping:
    """Coefficients of the parts of a mesh; None where a part has the damping of the building.

    Args:
        shells: Of each of the mesh's `shell_parts`, in their order.
        beams: Of each of the mesh's `beam_parts`, in their order.
    """

    shells: tuple[Coefficients | None, ...]
    beams: tuple[Coefficients | None, ...]

    @property
    def distinct(self) -> list[Coefficients]:
        """The coefficients that occur, each once, ascending."""
        return sorted({one for one in (*self.shells, *self.beams) if one is not None})


def part_damping(structure: Structure, mesh: BuildingMesh, path: Path) -> PartDamping | None:
    """The damping of the parts of a structure's mesh; None without damping by part.

    Args:
        structure: The structure.
        mesh: Its mesh.
        path: The case file, for messages.

    Raises:
        InputError: A pattern matches no part, or a part matches two entries.
    """
    if not structure.damping:
        return None
    every = (*mesh.shell_parts, *mesh.beam_parts)
    faults = [
        *_patterns_without_part(structure.damping, every, path),
        *_parts_of_two(structure.damping, every, path),
    ]
    if faults:
        raise InputError(faults)
    return PartDamping(
        shells=tuple(_of(part, structure.damping) for part in mesh.shell_parts),
        beams=tuple(_of(part, structure.damping) for part in mesh.beam_parts),
    )


def _matches(part: Part, entry: Entry) -> bool:
    return any(fnmatchcase(part.group, pattern) for pattern in entry.parts)


def _of(part: Part, entries: tuple[Entry, ...]) -> Coefficients | None:
    return next((entry.coefficients for entry in entries if _matches(part, entry)), None)


def _patterns_without_part(
    entries: tuple[Entry, ...], parts: tuple[Part, ...], path: Path
) -> Iterator[Fault]:
    names = ", ".join(part.group for part in parts)
    for index, entry in enumerate(entries):
        for k, pattern in enumerate(entry.parts):
            if not any(fnmatchcase(part.group, pattern) for part in parts):
                expected = f"expected a pattern of the parts of the mesh: {names}"
                yield Fault(path, f"{KEY}[{index}].parts[{k}]", pattern, expected)


def _parts_of_two(
    entries: tuple[Entry, ...], parts: tuple[Part, ...], path: Path
) -> Iterator[Fault]:
    for part in parts:
        own = [index for index, entry in enumerate(entries) if _matches(part, entry)]
        if len(own) > 1:
            expected = f"also matched by {KEY}[{own[0]}]; expected one damping for {part.group}"
            yield Fault(path, f"{KEY}[{own[1]}].parts", part.group, expected)
