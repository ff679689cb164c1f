"""The table of modes of a device: frequencies, effective masses and heights."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, present
from impactfem.case.leaf import Frequency, Length, Quantity, Ratio, Words, refuse
from impactfem.case.table import Table, read_table
from impactfem.case.unit import INERTIA, MASS
from impactfem.system.errors import Fault


class DeviceMode(Section):
    """One mode of a device, in one direction: one row of the table of modes.

    A mode that moves along two axes, or along one and about another, has a row for each.
    """

    frequency: Frequency = Field(description="Natural frequency.")
    effective_mass: Annotated[float, Quantity(MASS, at_least=0)] = Field(
        default=0.0, description="Effective mass along the axis; 0 for a mode about one."
    )
    effective_inertia: Annotated[float, Quantity(INERTIA, at_least=0)] = Field(
        default=0.0, description="Effective moment of inertia about the axis; 0 along one."
    )
    height: Length = Field(
        default=0.0,
        description="Of x and y: where it acts above the anchor, overturning moment over force.",
    )
    direction: Annotated[
        str, Words("'x', 'y', 'z', 'rx', 'ry' or 'rz': along or about an axis", "r?[xyz]")
    ] = Field(description="How it moves: along an axis, or about one.")
    damping: Annotated[float | None, Ratio(at_least=0, below=1)] = Field(
        default=None, description="Damping ratio; without this column, by damping of the device."
    )

    # Checked at the only one of these columns that each table has.
    @field_validator("direction")
    @classmethod
    def _carries_something(cls, value: str, info: ValidationInfo) -> str:
        if present(info, ["effective_mass", "effective_inertia"]):
            mass, inertia = info.data["effective_mass"], info.data["effective_inertia"]
            if value.startswith("r") and not (inertia > 0.0 and mass == 0.0):
                raise refuse(
                    "expected effective_inertia above 0 and effective_mass 0 about an axis"
                )
            if not value.startswith("r") and not (mass > 0.0 and inertia == 0.0):
                raise refuse(
                    "expected effective_mass above 0 and effective_inertia 0 along an axis"
                )
        if value not in ("x", "y") and info.data.get("height", 0.0) != 0.0:
            raise refuse("expected height 0: only a mode along x or y acts above the anchor")
        return value


def read_device_modes(path: Path, faults: list[Fault]) -> Table[DeviceMode] | None:
    """Read a table of modes; what is wrong with it is appended to ``faults``.

    Args:
        path: A CSV file with the columns of ``DeviceMode``.
        faults: Every fault of the table is appended here.

    Returns:
        The modes with the lines they stand on, or None when there were faults.
    """
    return read_table(path, DeviceMode, faults)
