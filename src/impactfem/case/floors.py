"""The floor table of a building: one row a floor with the storey below it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationInfo, field_validator, model_validator

from impactfem.case.base import Section, present
from impactfem.case.leaf import (
    Area,
    Inertia,
    Mass,
    PositiveFactor,
    PositiveLength,
    Quantity,
    SecondMoment,
    Whole,
    refuse,
)
from impactfem.case.table import Table, column_key, read_table
from impactfem.case.unit import LENGTH
from impactfem.system.errors import Fault

MOST_FLOORS = 200


class Floor(Section):
    """A floor and the storey below it: one row of the floor table, bottom to top.

    The axes are those of the case: z is vertical and the stick's axis. Second moments of area and
    shear areas are those of the storey, as in the paper's Appendix A, where ``A_vy`` is the shear
    area along y and ``A_vz`` the one along x; ``I_z`` is close to I_x + I_y there and so polar.
    """

    floor: Annotated[int, Whole(1)] = Field(description="Number of the floor, increasing upwards.")
    mass: Mass = Field(description="Mass of the floor, lumped at its mass centre.")
    Jx: Inertia = Field(description="Moment of inertia of the floor's mass about x.")
    Jy: Inertia = Field(description="Moment of inertia of the floor's mass about y.")
    Jz: Inertia = Field(description="Moment of inertia of the floor's mass about z.")
    Ix: SecondMoment = Field(description="Second moment of area of the storey, bending about x.")
    Iy: SecondMoment = Field(description="Second moment of area of the storey, bending about y.")
    Iz: SecondMoment = Field(description="Torsion constant of the storey about z.")
    A: Area = Field(description="Area of the storey's cross-section.")
    Avy: Area = Field(description="Shear area of the storey along y.")
    Avz: Area = Field(description="Shear area of the storey along x.")
    storey_height: PositiveLength = Field(
        description="Height of the storey between mass centres; of the lowest one from the base."
    )
    storey_height_min: PositiveLength = Field(
        default=math.nan,
        description="Lower bound of the height in the calibration; default the height itself.",
    )
    storey_height_max: PositiveLength = Field(
        default=math.nan,
        description="Upper bound of the height in the calibration; default the height itself.",
    )
    storey_stiffness_factor: PositiveFactor = Field(
        default=1.0,
        description="Factor on all stiffnesses of this storey, besides the building's.",
    )
    length: Annotated[float | None, Quantity(LENGTH, above=0)] = Field(
        default=None, description="Length of this floor along x; default that of the building."
    )
    width: Annotated[float | None, Quantity(LENGTH, above=0)] = Field(
        default=None, description="Width of this floor along y; default that of the building."
    )

    @model_validator(mode="before")
    @classmethod
    def _fixed_height(cls, data: Any) -> Any:
        """A height without bounds is fixed: both bounds are the height."""
        if isinstance(data, dict) and "storey_height" in data:
            height = data["storey_height"]
            return {"storey_height_min": height, "storey_height_max": height} | data
        return data

    @field_validator("storey_height_max")
    @classmethod
    def _ordered_bounds(cls, value: float, info: ValidationInfo) -> float:
        if not present(info, ["storey_height", "storey_height_min"]):
            return value
        low, height = info.data["storey_height_min"], info.data["storey_height"]
        if low > value:
            raise refuse(f"expected bounds in order: storey_height_min is {low:g} m")
        if not low <= height <= value:
            raise refuse(f"expected bounds around storey_height, which is {height:g} m")
        return value


def read_floors(path: Path, faults: list[Fault]) -> Table[Floor] | None:
    """Read a floor table; what is wrong with it is appended to ``faults``.

    Args:
        path: A CSV file with the columns of ``Floor``.
        faults: Every fault of the table is appended here.

    Returns:
        The floors with the lines they stand on, or None when there were faults.
    """
    table = read_table(path, Floor, faults, MOST_FLOORS)
    if table is None:
        return None
    broken = list(_order_faults(path, table))
    faults.extend(broken)
    return None if broken else table


def _order_faults(path: Path, table: Table[Floor]) -> Iterator[Fault]:
    seen: dict[int, int] = {}
    highest = 0
    for line, row in zip(table.lines, table.rows, strict=True):
        key = column_key(line, table.headers["floor"])
        if row.floor in seen:
            first = seen[row.floor]
            yield Fault(path, key, row.floor, f"duplicate floor, the first is in line {first}")
        elif row.floor < highest:
            yield Fault(
                path, key, row.floor, f"expected floors from bottom to top, above {highest}"
            )
        seen.setdefault(row.floor, line)
        highest = max(highest, row.floor)
