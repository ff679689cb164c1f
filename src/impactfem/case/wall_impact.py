"""The impact of the 3D model on a rigid wall: as written in the case file, and resolved."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section
from impactfem.case.calibrated import CALIBRATED
from impactfem.case.contacts import ContactEntry, ContactLaw, FloorNumbers, KelvinVoigtLaw
from impactfem.case.leaf import Depth, Duration, Length, Ratio, Time, TimeStep, Whole, refuse
from impactfem.case.source import Source
from impactfem.case.time_step import half_of_duration
from impactfem.system.errors import Fault

TOP_FLOORS = 3
"""Number of floors that may hit the wall when the case file names none (paper, section 3.2.2)."""
Pull = Literal["whole_floor", "even_load", "mass_centre"]
"""How the displaced floor is drawn aside before its release."""


class _WallImpact(Section):
    """What the section has in common before and after its floors are known.

    The fields that differ stand here too, for the order of all fields.
    """

    floors: tuple[int, ...] | None
    displaced_floor: int | None
    gap: Depth = Field(description="Distance of the wall from the building at rest.")
    displacement: Length = Field(
        description="Displacement of displaced_floor before the release, towards the wall: "
        "negative away from it; with loads, see pull, that of its mass centre."
    )
    pull: Pull = Field(
        default="whole_floor",
        description="How displaced_floor is drawn aside: 'whole_floor' holds every node of its "
        "slab at the displacement; 'even_load' pulls with an even load over the slab, under which "
        "it arrives bowed; 'mass_centre' with one force at its mass centre. The floor of the "
        "stick is rigid: for it the three are the same.",
    )
    duration: Duration = Field(description="Time that is computed.")
    time_step: TimeStep = Field(description="Time step.")
    theta: Annotated[float, Ratio(at_least=0.5, at_most=1, percent=False)] = Field(
        default=0.5,
        description="θ of the θ-scheme: 0.5 keeps the energy of free motion, 1 is implicit Euler, "
        "which damps it.",
    )
    separation: Time = Field(
        default=5e-3, description="Shortest time without a force that parts two impacts."
    )

    @field_validator("displacement")
    @classmethod
    def _outside_the_wall(cls, value: float, info: ValidationInfo) -> float:
        if value == 0.0:
            raise refuse("expected a displacement that is not zero: the building would not move")
        gap = info.data.get("gap")
        if gap is not None and value >= gap:
            raise refuse(
                "the wall would start inside the building; expected less than the gap, "
                f"{gap:g} m, negative away from the wall"
            )
        return value

    _step_in_duration = field_validator("time_step")(half_of_duration)

    @field_validator("separation")
    @classmethod
    def _seen_to_be_over(cls, value: float, info: ValidationInfo) -> float:
        duration = info.data.get("duration")
        if duration is not None and value >= duration:
            raise refuse(f"expected less than the duration, {duration:g} s")
        return value


class WallImpactEntry(_WallImpact):
    """The impact of the building of [structure] on a rigid wall, which calibrates contact laws.

    One floor is drawn aside and let go; there is no ground motion. The wall stands on the side of
    the impact edges of the mesh.
    """

    floors: FloorNumbers | None = Field(
        default=None, description="Floors that may hit the wall; default the three top floors."
    )
    displaced_floor: Annotated[int, Whole(1)] | None = Field(
        default=None, description="Floor that is displaced; default the top floor."
    )

    @field_validator("floors")
    @classmethod
    def _each_once(cls, value: tuple[int, ...] | None) -> tuple[int, ...] | None:
        twice = sorted({k for k in value or () if value is not None and value.count(k) > 1})
        if twice:
            raise refuse(f"expected each floor once, found {', '.join(map(str, twice))} again")
        return value


class WallImpactSetup(_WallImpact):
    """The impact on a wall with its floors, bottom to top."""

    floors: tuple[int, ...]
    displaced_floor: int


def resolve_wall_impact(entry: WallImpactEntry, known: Sequence[int]) -> WallImpactSetup:
    """The section with the floors that it leaves to their default.

    Args:
        entry: The section as written.
        known: Numbers of the floors of the building, bottom to top.
    """
    shared = {name: getattr(entry, name) for name in WallImpactEntry.model_fields}
    return WallImpactSetup(
        **shared
        | {
            "floors": tuple(sorted(entry.floors or known[-TOP_FLOORS:])),
            "displaced_floor": entry.displaced_floor or known[-1],
        }
    )


def wall_impact_faults(
    source: Source, entry: WallImpactEntry, building: str, known: Sequence[int]
) -> Iterator[Fault]:
    """Floors of the section that the building does not have.

    Args:
        source: The case file.
        entry: The section as written.
        building: Name of the building of [structure].
        known: Numbers of its floors, bottom to top.
    """
    for key, asked in (("floors", entry.floors), ("displaced_floor", entry.displaced_floor)):
        numbers = asked if isinstance(asked, tuple) else (asked,)
        absent = [str(k) for k in numbers if k is not None and k not in known]
        if absent:
            expected = (
                f"{building} has no floor {', '.join(absent)}; "
                f"its floors are {', '.join(map(str, known))}"
            )
            value = list(numbers) if key == "floors" else asked
            yield source.fault(("wall_impact", key), value, expected)


def lacks_wall_impact(source: Source) -> Iterator[Fault]:
    """Laws that ask for calibrated values without the impact, from the file as it stands."""
    laws = source.raw.get("contact_laws")
    if "wall_impact" in source.raw or not isinstance(laws, Mapping):
        return
    for name, law in laws.items():
        if not isinstance(law, Mapping) or law.get("type") != "kelvin-voigt":
            continue
        for key in ("stiffness", "restitution"):
            if law.get(key) == CALIBRATED:
                expected = "expected a section [wall_impact] beside it: the impact that gives it"
                yield source.fault(("contact_laws", name, key), CALIBRATED, expected)


def calibrated_contact_faults(
    source: Source,
    laws: Mapping[str, ContactLaw],
    contacts: Sequence[ContactEntry],
    building: str,
) -> Iterator[Fault]:
    """Contacts with a law that is calibrated on a building they do not touch.

    Args:
        source: The case file.
        laws: Contact laws by name.
        contacts: The contacts as written.
        building: Name of the building of [structure].
    """
    for index, contact in enumerate(contacts):
        law = laws[contact.law]
        ends = (contact.a.building, contact.b.building)
        if isinstance(law, KelvinVoigtLaw) and law.calibrated and building not in ends:
            expected = (
                f"expected a law with values of its own: '{contact.law}' is calibrated on "
                f"{building}, the contact is of {' and '.join(ends)}"
            )
            yield source.fault(("contacts", index, "law"), contact.law, expected)
