"""The impact of the 3D model on a rigid wall."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, refuse, rule, step_within
from impactfem.case.contacts import floors_of_building
from impactfem.case.floors import floors_of
from impactfem.case.leaf import FloorNumbers, ModelledBuilding, Whole
from impactfem.case.quantity import Depth, Duration, Length, Ratio, Time, TimeStep

TOP_FLOORS = 3
"""Number of floors that may hit the wall when the case file names none (paper, section 3.2.2)."""
Pull = Literal["whole_floor", "even_load", "mass_centre"]
"""How the displaced floor is drawn aside before its release."""


class WallImpactSetup(Section):
    """The impact of a building with a 3D model on a rigid wall, which calibrates contact laws.

    One floor is drawn aside and let go; there is no ground motion. The wall stands on the side of
    the impact edges of the mesh.
    """

    building: Annotated[str, ModelledBuilding(whose="the impact on the wall")] = Field(
        default=None, validate_default=True
    )
    """Name of the building; left out, the one that has a 3D model."""
    floors: FloorNumbers = Field(default=None, validate_default=True)
    """Floors that may hit the wall; default the three top floors."""
    displaced_floor: Annotated[int, Whole(1)] = Field(default=None, validate_default=True)
    """Floor that is displaced; default the top floor."""
    gap: Depth
    """Distance of the wall from the building at rest."""
    displacement: Length
    """Displacement of displaced_floor before the release, towards the wall: negative away from it;
    with loads, see pull, that of its mass centre."""
    pull: Pull = "whole_floor"
    """How displaced_floor is drawn aside: 'whole_floor' holds every node of its slab at the
    displacement; 'even_load' pulls with an even load over the slab, under which it arrives bowed;
    'mass_centre' with one force at its mass centre. The floor of the stick is rigid: for it the
    three are the same."""
    duration: Duration
    """Time that is computed."""
    time_step: TimeStep
    """Time step."""
    theta: Annotated[float, Ratio(at_least=0.5, at_most=1, percent=False)] = 0.5
    """θ of the θ-scheme: 0.5 keeps the energy of free motion, 1 is implicit Euler, which damps
    it."""
    separation: Time = 5e-3
    """Shortest time without a force that parts two impacts."""

    @field_validator("floors", "displaced_floor", mode="before")
    @classmethod
    def _top_floors(cls, value: Any, info: ValidationInfo) -> Any:
        if value is not None or info.context is None:
            return value
        floors = [floor.floor for floor in floors_of(info.data.get("building"), info)] or [1]
        return floors[-TOP_FLOORS:] if info.field_name == "floors" else floors[-1]

    @field_validator("floors", "displaced_floor")
    @classmethod
    def _existing(cls, value: Any, info: ValidationInfo) -> Any:
        if isinstance(value, int):
            floors_of_building((value,), info.data.get("building", ""), info)
            return value
        twice = sorted({k for k in value if value.count(k) > 1})
        if twice:
            raise refuse(f"expected each floor once, found {', '.join(map(str, twice))} again")
        floors_of_building(value, info.data.get("building", ""), info)
        return tuple(sorted(value))

    @rule("displacement")
    @staticmethod
    def _moved(displacement: float) -> Iterator[str]:
        if displacement == 0.0:
            yield "expected a displacement that is not zero: the building would not move"

    @rule("displacement", "gap")
    @staticmethod
    def _outside_the_wall(displacement: float, gap: float) -> Iterator[str]:
        if displacement >= gap:
            yield (
                "the wall would start inside the building; expected less than the gap, "
                f"{gap:g} m, negative away from the wall"
            )

    _step_in_duration = step_within("duration", 0.5)

    @rule("separation", "duration")
    @staticmethod
    def _seen_to_be_over(separation: float, duration: float) -> Iterator[str]:
        if separation >= duration:
            yield f"expected less than the duration, {duration:g} s"
