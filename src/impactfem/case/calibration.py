"""Calibration of the sticks: as written in the case file, and with its targets."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StrictBool, ValidationInfo, field_validator

from impactfem.case.base import Section
from impactfem.case.floors import Floor
from impactfem.case.known import known_of
from impactfem.case.leaf import File, PositiveFactor, PositiveLength, Whole, refuse
from impactfem.case.targets import Target


class _Calibration(Section):
    """What a calibration has in common before and after its table is read.

    The field that differs stands here too, for the order of all fields.
    """

    mode: Literal["fit", "given"] = Field(
        default="fit",
        description="'fit' fits the sticks to the targets; 'given' takes the values of "
        "[[buildings]] and reports how far they are from the targets.",
    )
    targets: Path | tuple[Target, ...]
    direction: Literal["x", "y"] = Field(
        description="Direction in which the bending family of the targets moves."
    )
    stiffness_factor: tuple[PositiveFactor, PositiveFactor] = Field(
        description="Bounds of the stiffness factor that the buildings share."
    )
    rigid_depth: PositiveLength = Field(
        description="Depth rigid_below + rigid_above, which is kept; its split is fitted."
    )
    height: PositiveLength = Field(
        description="Height from the base to the highest mass centre, which is kept."
    )
    from_structure: StrictBool = Field(
        default=False,
        description="Whether the bending modes of the 3D model take the place of the frequencies "
        "and masses in the target table's rows of its building; their weights stay.",
    )
    starts: Annotated[int, Whole(1, 1000)] = Field(
        default=8, description="Number of starting points of the least-squares fit."
    )
    seed: Annotated[int, Whole(0)] = Field(
        default=0, description="Seed of the random starting points."
    )

    @field_validator("stiffness_factor")
    @classmethod
    def _ordered(cls, value: tuple[float, float]) -> tuple[float, float]:
        if value[0] > value[1]:
            raise refuse("expected bounds in order, the lower one first")
        return value


class CalibrationEntry(_Calibration):
    """Fit of storey stiffness, storey heights and rigid zones to known modes.

    The fitted values are shared by all buildings named in the target table.
    """

    targets: File = Field(
        description="Target table: a CSV file with frequencies and effective masses of modes."
    )

    @field_validator("targets")
    @classmethod
    def _same_floors(cls, value: Path, info: ValidationInfo) -> Path:
        """The buildings of the targets share their heights, so they have as many floors."""
        counts = {name: len(floors) for name, floors in _towers(info, value).items()}
        known = known_of(info)
        for row in known.targets.get(value, ()) if known is not None else ():
            modes = 2 * counts.get(row.building, row.mode)
            if row.mode > modes:
                raise refuse(
                    f"mode {row.mode} of {row.building} is asked, which has {modes} in a family"
                )
        if len(set(counts.values())) > 1:
            found = ", ".join(f"{name} {count}" for name, count in counts.items())
            raise refuse(
                "the fitted heights are shared: expected buildings with the same number of "
                f"floors, found {found}"
            )
        return value

    @field_validator("rigid_depth")
    @classmethod
    def _within_storeys(cls, value: float, info: ValidationInfo) -> float:
        for name, floors in _towers(info, info.data.get("targets")).items():
            for floor in floors[1:]:
                if floor.storey_height_min <= value:
                    raise refuse(
                        f"the storey below floor {floor.floor} of {name} may become "
                        f"{floor.storey_height_min:g} m high; expected less than that"
                    )
        return value

    @field_validator("height")
    @classmethod
    def _within_bounds(cls, value: float, info: ValidationInfo) -> float:
        for name, floors in _towers(info, info.data.get("targets")).items():
            low = sum(floor.storey_height_min for floor in floors)
            high = sum(floor.storey_height_max for floor in floors)
            # The bounds are sums of rounded numbers.
            if not low * (1.0 - 1e-9) <= value <= high * (1.0 + 1e-9):
                raise refuse(
                    f"expected a height the storeys of {name} can sum up to, "
                    f"{low:g} m to {high:g} m"
                )
        return value


class Calibration(_Calibration):
    """A calibration with its targets."""

    targets: tuple[Target, ...]


def _towers(info: ValidationInfo, targets: Path | None) -> dict[str, tuple[Floor, ...]]:
    """Floors of the buildings named in a target table, as far as all of it could be read."""
    known = known_of(info)
    if known is None or targets is None:
        return {}
    names = dict.fromkeys(target.building for target in known.targets.get(targets, ()))
    floors = {name: known.building_floors(name) for name in names}
    return {name: rows for name, rows in floors.items() if rows is not None}
