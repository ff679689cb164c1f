"""Calibration of the sticks, and its targets: modes of the buildings."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import StrictBool, ValidationInfo

from impactfem.case.base import Section, nearest, rule
from impactfem.case.floors import Floor, floors_of
from impactfem.case.leaf import Text, Whole
from impactfem.case.quantity import Frequency, Mass, PositiveFactor, PositiveLength, Weight
from impactfem.case.reading import TableFile
from impactfem.case.table import Table, read_table
from impactfem.system.errors import Fault


class Target(Section):
    """What the calibrated stick of a building shall reach in one mode of the bending family."""

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


def read_targets(
    path: Path, buildings: Collection[str] | None, faults: list[Fault]
) -> Table[Target] | None:
    """Read a target table, whose rows may be of some buildings; None where these are not known."""

    def unknown(table: Table[Target]) -> Iterator[Fault]:
        for line, row in table:
            if buildings is not None and row.building not in buildings:
                expected = f"unknown building; {nearest(row.building, list(buildings))}"
                yield table.fault(line, "building", row.building, expected)

    def twice(table: Table[Target]) -> Iterator[Fault]:
        return table.duplicates("mode", "building")

    return read_table(path, Target, faults, unknown, twice)


TARGETS = TableFile(
    "a target table (CSV)",
    lambda path, faults, info: read_targets(path, info.context.names("buildings"), faults),
    sited=True,
)


class Calibration(Section):
    """Fit of storey stiffness, storey heights and rigid zones to known modes.

    The fitted values are shared by all buildings named in the target table.
    """

    mode: Literal["fit", "given"] = "fit"
    """'fit' fits the sticks to the targets; 'given' takes the values of [[buildings]] and reports
    how far they are from the targets."""
    targets: Annotated[tuple[Target, ...], TARGETS]
    """Target table: a CSV file with frequencies and effective masses of modes."""
    direction: Literal["x", "y"]
    """Direction in which the bending family of the targets moves."""
    stiffness_factor: tuple[PositiveFactor, PositiveFactor]
    """Bounds of the stiffness factor that the buildings share."""
    rigid_depth: PositiveLength
    """Depth rigid_below + rigid_above, which is kept; its split is fitted."""
    height: PositiveLength
    """Height from the base to the highest mass centre, which is kept."""
    from_structure: StrictBool = False
    """Whether the bending modes of the 3D model take the place of the frequencies and masses in the
    target table's rows of its building; their weights stay."""
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
                yield f"mode {row.mode} of {row.building} is asked, which has {modes} in a family"
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
    """Floors of the buildings named in a target table, as far as they are known."""
    names = dict.fromkeys(target.building for target in targets)
    return {name: floors for name in names if (floors := floors_of(name, info))}
