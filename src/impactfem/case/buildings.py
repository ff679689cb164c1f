"""Buildings: sticks of storeys and rigid floors, with a 3D model where they have one."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import Field, ValidationInfo, ValidatorFunctionWrapHandler, field_validator

from impactfem.case.base import Section, refuse, rule
from impactfem.case.damping import Damping
from impactfem.case.floors import FLOORS, UNKNOWN_DAMPING, Floor, Material, MaterialOf, read_floors
from impactfem.case.leaf import Name
from impactfem.case.quantity import Depth, Length, PositiveFactor, PositiveLength
from impactfem.case.reading import TableFile
from impactfem.case.structure import Structure


class Building(Section):
    """A building as a stick of storeys and rigid floors, clamped at its base."""

    name: Name
    """Name of the building, unique in the file."""
    material: Annotated[Material, MaterialOf()]
    """Name of the material of the storeys."""
    floors: Annotated[tuple[Floor, ...], TableFile(FLOORS, read_floors)]
    """Floor table: a CSV file, one row a floor, bottom to top."""
    axis: tuple[Length, Length] = (0.0, 0.0)
    """Position (x, y) of the stick's vertical axis in plan."""
    base: Length = 0.0
    """Elevation of the clamped base."""
    length: PositiveLength | None = None
    """Length of the floors along x, with the axis in the middle. Only the search for facing floors
    that are in no pair uses it; left out, offsets of [[contacts]] and a generated mesh say how far
    the edges are."""
    width: PositiveLength | None = None
    """Width of the floors along y, as length."""
    setback: Depth = 0.0
    """How far columns and walls stand behind the edges of the floors: so much later a neighbour's
    floor meets a storey. Only the search for facing floors uses it."""
    rigid_below: Depth
    """Rigid zone from a floor's mass centre down to the lower edge of its beams."""
    rigid_above: Depth
    """Rigid zone from a floor's mass centre up to the upper edge of its beams."""
    stiffness_factor: PositiveFactor = 1.0
    """Factor on all stiffnesses of the storeys."""
    second_moment_factor: PositiveFactor = 1.0
    """Factor on the second moments of area I_x and I_y of the storeys."""
    damping: Damping = Field(default=None, validate_default=True)
    """Damping of this building in place of [damping]."""
    # Not in the hash of the buildings: what depends on them alone is reused with another 3D model.
    structure: Structure | None = Field(default=None, exclude=True)
    """The 3D model of the building; left out, there is none."""

    @rule("rigid_above", "floors", "rigid_below", sited=True)
    @staticmethod
    def _flexible_storeys(
        above: float, floors: tuple[Floor, ...], below: float, info: ValidationInfo
    ) -> Iterator[str]:
        """Each storey keeps a flexible part between the rigid zones of its two floors."""
        for index, floor in enumerate(floors if info.context is not None else ()):
            rigid = below + (above if index else 0.0)
            if floor.storey_height <= rigid:
                yield (
                    f"the storey below floor {floor.floor} is {floor.storey_height:g} m high; "
                    f"expected less than that of its rigid zones together, not {rigid:g} m"
                )

    @field_validator("damping", mode="before")
    @classmethod
    def _own_or_that_of_all(cls, value: Any, info: ValidationInfo) -> Any:
        if value is None and info.context is not None:
            return info.context.valid(Damping, info.context.value("damping")) or UNKNOWN_DAMPING
        return value

    @field_validator("structure", mode="wrap")
    @classmethod
    def _named(
        cls, value: Any, handler: ValidatorFunctionWrapHandler, info: ValidationInfo
    ) -> Structure | None:
        if not isinstance(value, dict) or info.context is None:
            return handler(value)  # type: ignore[no-any-return]
        if "building" in value:
            raise refuse("expected no key building: the 3D model is that of its [[buildings]]")
        name = info.data.get("name", "")
        with info.context.model_of(name):
            return handler(value | {"building": name})  # type: ignore[no-any-return]

    @property
    def elevations(self) -> tuple[float, ...]:
        """Elevation of the mass centre of each floor [m], bottom to top."""
        heights = itertools.accumulate((f.storey_height for f in self.floors), initial=self.base)
        return tuple(heights)[1:]

    @property
    def levels(self) -> dict[int, float]:
        """The same by the number of the floor."""
        numbers = [floor.floor for floor in self.floors]
        return dict(zip(numbers, self.elevations, strict=True))
