"""Buildings as sticks: as written in the case file, and with their material and floors."""

from __future__ import annotations

from pathlib import Path

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, present
from impactfem.case.damping import Damping
from impactfem.case.floors import Floor
from impactfem.case.known import known_of
from impactfem.case.leaf import (
    Depth,
    File,
    Length,
    MaterialName,
    Name,
    PositiveFactor,
    PositiveLength,
    refuse,
)
from impactfem.case.materials import Material


class _Stick(Section):
    """What a building has in common before and after its names are resolved.

    The fields that differ stand here too, for the order of all fields.
    """

    name: Name = Field(description="Name of the building, unique in the file.")
    material: str | Material
    floors: Path | tuple[Floor, ...]
    axis: tuple[Length, Length] = Field(
        default=(0.0, 0.0), description="Position (x, y) of the stick's vertical axis in plan."
    )
    base: Length = Field(default=0.0, description="Elevation of the clamped base.")
    length: PositiveLength | None = Field(
        default=None,
        description="Length of the floors along x, with the axis in the middle. Only the search "
        "for facing floors that are in no pair uses it; left out, offsets of [[contacts]] and a "
        "generated mesh say how far the edges are.",
    )
    width: PositiveLength | None = Field(
        default=None, description="Width of the floors along y, as length."
    )
    setback: Depth = Field(
        default=0.0,
        description="How far columns and walls stand behind the edges of the floors: so much "
        "later a neighbour's floor meets a storey. Only the search for facing floors uses it.",
    )
    rigid_below: Depth = Field(
        description="Rigid zone from a floor's mass centre down to the lower edge of its beams."
    )
    rigid_above: Depth = Field(
        description="Rigid zone from a floor's mass centre up to the upper edge of its beams."
    )
    stiffness_factor: PositiveFactor = Field(
        default=1.0, description="Factor on all stiffnesses of the storeys."
    )
    second_moment_factor: PositiveFactor = Field(
        default=1.0, description="Factor on the second moments of area I_x and I_y of the storeys."
    )


class BuildingEntry(_Stick):
    """A building as a stick of storeys and rigid floors, clamped at its base."""

    material: MaterialName = Field(description="Name of the material of the storeys.")
    floors: File = Field(description="Floor table: a CSV file, one row a floor, bottom to top.")
    damping: Damping | None = Field(
        default=None, description="Damping of this building in place of [damping]."
    )

    @field_validator("rigid_above")
    @classmethod
    def _flexible_storeys(cls, value: float, info: ValidationInfo) -> float:
        """Each storey keeps a flexible part between the rigid zones of its two floors."""
        known = known_of(info)
        if known is None or not present(info, ["floors", "rigid_below"]):
            return value
        below: float = info.data["rigid_below"]
        for index, floor in enumerate(known.floors.get(info.data["floors"], ())):
            rigid = below + (value if index else 0.0)
            if floor.storey_height <= rigid:
                raise refuse(
                    f"the storey below floor {floor.floor} is {floor.storey_height:g} m high; "
                    f"expected less than that of its rigid zones together, not {rigid:g} m"
                )
        return value


class Building(_Stick):
    """A building with its material, floors and damping: what the sticks are made of."""

    material: Material
    floors: tuple[Floor, ...]
    damping: Damping

    @property
    def elevations(self) -> tuple[float, ...]:
        """Elevation of the mass centre of each floor [m], bottom to top."""
        elevations = []
        z = self.base
        for floor in self.floors:
            z += floor.storey_height
            elevations.append(z)
        return tuple(elevations)
