"""The target table of a calibration: frequency and effective mass of modes of the buildings."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Annotated

from pydantic import Field

from impactfem.case.base import Section
from impactfem.case.leaf import Frequency, Mass, Text, Weight, Whole, nearest
from impactfem.case.table import Table, column_key, read_table
from impactfem.system.errors import Fault


class Target(Section):
    """What the calibrated stick of a building shall reach in one mode of the bending family."""

    building: Text = Field(description="Name of the building.")
    mode: Annotated[int, Whole(1)] = Field(
        description="Number of the mode within the bending family, in the order of frequency."
    )
    frequency: Frequency = Field(description="Natural frequency to reach.")
    effective_mass: Mass = Field(description="Effective modal mass to reach.")
    frequency_weight: Weight = Field(
        default=1.0, description="Weight of the relative error of the frequency; 0 leaves it out."
    )
    mass_weight: Weight = Field(
        default=1.0, description="Weight of the relative error of the mass; 0 leaves it out."
    )


def read_targets(
    path: Path, buildings: Collection[str] | None, faults: list[Fault]
) -> Table[Target] | None:
    """Read a target table; what is wrong with it is appended to ``faults``.

    Args:
        path: A CSV file with the columns of ``Target``.
        buildings: The names a row may have; None when they are not known.
        faults: Every fault of the table is appended here.

    Returns:
        The targets with the lines they stand on, or None when there were faults.
    """
    table = read_table(path, Target, faults)
    if table is None:
        return None
    broken = list(_row_faults(path, table, buildings))
    faults.extend(broken)
    return None if broken else table


def _row_faults(
    path: Path, table: Table[Target], buildings: Collection[str] | None
) -> Iterator[Fault]:
    seen: dict[tuple[str, int], int] = {}
    for line, row in zip(table.lines, table.rows, strict=True):
        if buildings is not None and row.building not in buildings:
            key = column_key(line, table.headers["building"])
            hint = nearest(row.building, list(buildings))
            yield Fault(path, key, row.building, f"unknown building; {hint}")
        first = seen.setdefault((row.building, row.mode), line)
        if first != line:
            key = column_key(line, table.headers["mode"])
            yield Fault(path, key, row.mode, f"duplicate mode, the first is in line {first}")
