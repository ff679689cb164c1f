"""What a field of a case can learn of the rest of the file."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from pydantic import ValidationInfo

from impactfem.case.floors import Floor
from impactfem.case.targets import Target


@dataclass(frozen=True)
class Known:
    """What the loader knows before the models are made: the names and the tables of the file.

    Names are taken from the file as it stands, so that a reference to a table that has a fault of
    its own is no second fault. None means that the names are not known, and nothing is checked.

    Args:
        groups: Names by group (``materials``, ``buildings``, ``contact_laws``).
        floors: Rows of the floor tables that could be read, by the file name in the case file.
        floors_of: The file name of the floor table of each building, by the building's name.
        targets: Rows of the target tables that could be read, by the file name.
        material_of: The name of the material of each building, by the building's name.
        without_density: Names of the materials that say no density.
    """

    groups: dict[str, tuple[str, ...] | None] = field(default_factory=dict)
    floors: dict[Path, tuple[Floor, ...]] = field(default_factory=dict)
    floors_of: dict[str, Path] = field(default_factory=dict)
    targets: dict[Path, tuple[Target, ...]] = field(default_factory=dict)
    material_of: dict[str, str] = field(default_factory=dict)
    without_density: frozenset[str] = frozenset()

    def names(self, group: str) -> tuple[str, ...] | None:
        """The names of a group, or None when they are not known."""
        return self.groups.get(group)

    def building_floors(self, building: str) -> tuple[Floor, ...] | None:
        """The floors of a building, or None when its table could not be read."""
        name = self.floors_of.get(building)
        return None if name is None else self.floors.get(name)


def known_of(info: ValidationInfo) -> Known | None:
    """What is known of the rest of the file; None when a model is made from Python."""
    return info.context if isinstance(info.context, Known) else None
