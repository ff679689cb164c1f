"""Calibration: sticks on modes of the buildings, contacts by an impact on a rigid wall."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, StrictBool, ValidationInfo, field_validator

from impactfem.case.base import Section, nearest, refuse, rule, step_within
from impactfem.case.contacts import check_floors
from impactfem.case.floors import Floor, floors_of
from impactfem.case.leaf import FloorNumbers, ModelledBuilding, Text, Whole
from impactfem.case.quantity import (
    Depth,
    Duration,
    Frequency,
    Length,
    Mass,
    PositiveFactor,
    PositiveLength,
    Si,
    Time,
    TimeStep,
    Weight,
)
from impactfem.case.reading import TableFile, reading_of
from impactfem.case.table import Table, read_table
from impactfem.system.errors import Fault


class Target(Section):
    """Target of a calibrated stick: one mode of the bending family of a building."""

    building: Text
    """Name of the building."""
    mode: Annotated[int, Whole(1)]
    """Number of the mode within the bending family, in the order of frequency."""
    frequency: Frequency
    """Natural frequency to reach."""
    effective_mass: Mass
    """Effective modal mass to reach."""
    frequency_weight: Weight = 1.0
    """Weight of the relative error of the frequency; 0 leaves it out."""
    mass_weight: Weight = 1.0
    """Weight of the relative error of the mass; 0 leaves it out."""


def read_targets(path: Path, faults: list[Fault], info: ValidationInfo) -> Table[Target] | None:
    """Read a target table; its buildings must be those of the case, where these are known."""
    buildings = reading_of(info).names("buildings")

    def unknown(table: Table[Target]) -> Iterator[Fault]:
        for line, row in table:
            if buildings is not None and row.building not in buildings:
                expected = f"unknown building; {nearest(row.building, list(buildings))}"
                yield table.fault(line, "building", row.building, expected)

    return read_table(path, Target, faults, unknown, once=("mode", "building"))


class Calibration(Section):
    """Fit of storey stiffness, storey heights and rigid zones to known modes.

    The fitted values are shared by all buildings named in the target table.
    """

    mode: Literal["fit", "given"] = "fit"
    """'fit' fits the sticks to the targets; 'given' keeps the values of [[buildings]] and reports
    the differences."""
    targets: Annotated[
        tuple[Target, ...], TableFile("a target table (CSV)", read_targets, sited=True)
    ]
    """Target table: a CSV file with frequencies and effective masses of modes."""
    direction: Literal["x", "y"]
    """Direction in which the bending family of the targets moves."""
    stiffness_factor: tuple[PositiveFactor, PositiveFactor]
    """Bounds of the stiffness factor that the buildings share."""
    rigid_depth: PositiveLength
    """Depth rigid_below + rigid_above, kept; the split is fitted."""
    height: PositiveLength
    """Height from the base to the highest mass centre, kept."""
    from_structure: StrictBool = False
    """Use the bending modes of the 3D model as targets of its building, with the weights of the
    target table."""
    starts: Annotated[int, Whole(1, 1000)] = 8
    """Number of starting points of the least-squares fit."""
    seed: Annotated[int, Whole(0)] = 0
    """Seed of the random starting points."""

    @rule("stiffness_factor")
    @staticmethod
    def _ordered(bounds: tuple[float, float]) -> Iterator[str]:
        if bounds[0] > bounds[1]:
            yield "expected bounds in order, the lower one first"

    @rule("targets", sited=True)
    @staticmethod
    def _same_floors(targets: tuple[Target, ...], info: ValidationInfo) -> Iterator[str]:
        """The buildings of the targets share their heights, so they have as many floors."""
        counts = {name: len(floors) for name, floors in _towers(targets, info).items()}
        for row in targets:
            modes = 2 * counts.get(row.building, row.mode)
            if row.mode > modes:
                words = f"mode {row.mode} of {row.building} is requested"
                yield f"{words}, which has {modes} in a family"
        if len(set(counts.values())) > 1:
            found = ", ".join(f"{name} {count}" for name, count in counts.items())
            yield (
                "the fitted heights are shared: expected buildings with the same number of "
                f"floors, found {found}"
            )

    @rule("rigid_depth", "targets", sited=True)
    @staticmethod
    def _within_storeys(
        depth: float, targets: tuple[Target, ...], info: ValidationInfo
    ) -> Iterator[str]:
        for name, floors in _towers(targets, info).items():
            for floor in floors[1:]:
                if floor.storey_height_min <= depth:
                    yield (
                        f"the storey below floor {floor.floor} of {name} may become "
                        f"{floor.storey_height_min:g} m high; expected less than that"
                    )

    @rule("height", "targets", sited=True)
    @staticmethod
    def _within_bounds(
        height: float, targets: tuple[Target, ...], info: ValidationInfo
    ) -> Iterator[str]:
        for name, floors in _towers(targets, info).items():
            low = sum(floor.storey_height_min for floor in floors)
            high = sum(floor.storey_height_max for floor in floors)
            # The bounds are sums of rounded numbers.
            if not low * (1.0 - 1e-9) <= height <= high * (1.0 + 1e-9):
                bounds = f"{low:g} m to {high:g} m"
                yield f"expected a height the storeys of {name} can sum up to, {bounds}"


def _towers(targets: Iterable[Target], info: ValidationInfo) -> dict[str, tuple[Floor, ...]]:
    """Floors of the buildings of a target table, without buildings whose floors are not known."""
    names = dict.fromkeys(target.building for target in targets)
    return {name: floors for name in names if (floors := floors_of(name, info))}


TOP_FLOORS = 3
"""Number of floors that may hit the wall when the case file names none (paper, section 3.2.2)."""
Pull = Literal["whole_floor", "even_load", "mass_centre"]
"""Shape of the displaced floor before its release."""


class WallImpactSetup(Section):
    """The impact of a building with a 3D model on a rigid wall, which calibrates contact laws.

    One floor is displaced and released; there is no ground motion. The wall is on the side of the
    impact edges of the mesh.
    """

    building: Annotated[str, ModelledBuilding(whose="the impact on the wall")] = Field(
        default=None, validate_default=True
    )
    """Name of the building; default the one with a 3D model."""
    floors: FloorNumbers = Field(default=None, validate_default=True)
    """Floors that may hit the wall; default the three top floors."""
    displaced_floor: Annotated[int, Whole(1)] = Field(default=None, validate_default=True)
    """Floor that is displaced; default the top floor."""
    gap: Depth
    """Distance of the wall from the building at rest."""
    displacement: Length
    """Displacement of displaced_floor before the release, positive towards the wall; with pull by
    loads, of its mass centre."""
    pull: Pull = "whole_floor"
    """Shape of the displaced floor. 'whole_floor' holds every node of the slab at the displacement;
    'even_load' applies a uniform load, which bows the slab; 'mass_centre' applies one force there.
    For the rigid floor of a stick the three are equal."""
    duration: Duration
    """Computed time."""
    time_step: TimeStep
    """Time step."""
    theta: Annotated[float, Si("-", ge=0.5, le=1, percent=False)] = 0.5
    """θ of the θ-scheme: 0.5 conserves the energy of free motion, 1 (implicit Euler) damps it."""
    unilateral_scheme: Literal["massless", "moreau"] = "moreau"
    """Scheme of contact. 'moreau', as in the paper: impulses on contact points with mass.
    'massless': contact points without mass and edges with a compliance, as in [pounding], whose
    contact_frequency counts; it needs theta = 0.5."""
    separation: Time = 5e-3
    """Shortest time without force between two impacts."""
    contact_spacing: PositiveLength | None = None
    """Least distance of two contact points along an edge; default every vertex. Each point adds a
    vector to the reduced building. On the paper's building, 1.93 m in place of 0.96 m change ε by
    -0.8 %, K_Ceq by 0.2 %, the impulse by -0.2 %, the peak force by -1.6 %."""

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
        floors = (value,) if isinstance(value, int) else value
        twice = sorted({k for k in floors if floors.count(k) > 1})
        if twice:
            words = ", ".join(map(str, twice))
            raise refuse(f"expected each floor once, found {words} again", kind="once")
        check_floors(floors, info)
        return value if isinstance(value, int) else tuple(sorted(value))

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

    @rule("unilateral_scheme", "theta")
    @staticmethod
    def _average_acceleration(scheme: str, theta: float) -> Iterator[str]:
        if scheme == "massless" and theta != 0.5:
            yield f"expected 'moreau' with theta = {theta:g}, or theta = 0.5"

    @rule("separation", "duration")
    @staticmethod
    def _seen_to_be_over(separation: float, duration: float) -> Iterator[str]:
        if separation >= duration:
            yield f"expected less than the duration, {duration:g} s"
