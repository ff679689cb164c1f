"""Forces on floors in time, in addition to the ground motion: a blast, an impact, a test pulse."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field, ValidationInfo, create_model, field_validator

from impactfem.case.base import Section, nearest
from impactfem.case.contacts import unit_vector
from impactfem.case.floors import floors_of
from impactfem.case.leaf import FileName
from impactfem.case.quantity import Number, Quantity
from impactfem.case.reading import reading_of
from impactfem.case.table import Table, name_and_unit, read_lines, read_table
from impactfem.case.unit import FORCE, TIME
from impactfem.system.errors import Fault

Array = NDArray[np.float64]
TABLE = "a table of forces (CSV) with the header time [s],<building>.floor_<k> [N]"

MOST_TIMES = 1_000_000
"""Largest number of times in a table."""

_FLOOR = re.compile(r"([A-Za-z].*)\.floor_([1-9][0-9]*)")


class FloorForces(Section):
    """Forces on floors in time, in addition to the ground motion.

    In the sticks they act on the mass centres. In the 3D model they act as line loads on the edges
    of the floors that face the other building, at right angles to these, with the eccentricity of
    [transient].
    """

    file: Annotated[Path, FileName("a table of forces (CSV)")]
    """Table of the forces (CSV): `time [s]`, then a column `<building>.floor_<k> [MN]` for each
    floor; straight between its times, zero outside of them."""
    direction: tuple[Number, Number, Number]
    """Direction (x, y, z) of positive forces, of any length."""

    @field_validator("file", mode="wrap")
    @classmethod
    def _of_floors(cls, value: Any, check: Any, info: ValidationInfo) -> Path:
        file: Path = check(value)
        if info.context is not None:
            info.context.table(value, "a table of forces (CSV)", _read_for_case, info)
        return file

    _unit = field_validator("direction")(unit_vector)


class _Time(Section):
    """The column that each table of forces has; the others are those of its floors."""

    model_config = ConfigDict(extra="ignore", protected_namespaces=())

    time: Annotated[float, Quantity(TIME)]
    """Time."""


_Force = Annotated[float, Quantity(FORCE)]


@dataclass(frozen=True, eq=False)
class ForceTable:
    """The forces of a file."""

    time: Array  #: increasing, shape (n,) [s]
    floors: tuple[tuple[str, int], ...]  #: building and floor of each column
    force: Array  #: shape (n, m) [N]

    def at(self, time: Array) -> Array:
        """The forces at any times, zero outside of the table's, shape (n_t, m) [N]."""
        # A time that rounding puts behind the last one still is that one.
        end = self.time[-1]
        inside = np.where(np.abs(time - end) <= 1e-9 * max(end, 1.0), end, time)
        columns = [np.interp(inside, self.time, f, left=0.0, right=0.0) for f in self.force.T]
        return np.column_stack(columns)


def read_force_table(path: Path, faults: list[Fault]) -> ForceTable | None:
    """Read a table of forces; None, and what is wrong with it, when there are faults."""
    header = read_lines(path, TABLE, TABLE, [], MOST_TIMES)
    names = [name_and_unit(one)[0] for one in header[0][1]] if header else []
    floors = {name: place for name in names if (place := _FLOOR.fullmatch(name))}
    fields: dict[str, Any] = {name: (_Force, Field(description="Force.")) for name in floors}
    model = create_model("Forces", __base__=_Time, **fields)
    found: list[Fault] = []
    table = read_table(path, model, found, _increasing, most=MOST_TIMES, what=TABLE)
    for number, headers in (header or ())[:1]:
        for name, written in zip(names, headers, strict=True):
            if name != "time" and name not in floors:
                expected = "expected '<building>.floor_<k> [N]', or 'time [s]'"
                found.append(Fault(path, f"line {number}, column {written}", None, expected))
        if not floors:
            expected = "expected a column '<building>.floor_<k> [N]' besides the time"
            found.append(Fault(path, f"line {number}", None, expected))
    faults += found
    if table is None or found:
        return None
    time = np.array([row.time for row in table.rows])
    force = np.array([[getattr(row, name) for name in floors] for row in table.rows])
    return ForceTable(time, tuple((p[1], int(p[2])) for p in floors.values()), force)


def _increasing(table: Table[_Time]) -> Iterator[Fault]:
    if len(table.rows) < 2:
        yield Fault(table.path, "", None, "expected at least two lines of values")
    before = -1e-12
    for line, row in table:
        if row.time <= before:
            expected = "expected times that increase, from 0 s or later"
            yield table.fault(line, "time", row.time, expected)
            return
        before = row.time


def _read_for_case(path: Path, faults: list[Fault], info: ValidationInfo) -> ForceTable | None:
    """Read a table whose columns are floors of the buildings of the case file."""
    table = read_force_table(path, faults)
    names = reading_of(info).names("buildings")
    if table is None or names is None:
        return table
    before = len(faults)
    for building, floor in table.floors:
        column = f"column {building}.floor_{floor}"
        known = [one.floor for one in floors_of(building, info)]
        if building not in names:
            expected = f"expected a building of the case; {nearest(building, list(names))}"
            faults.append(Fault(path, column, building, expected))
        elif known and floor not in known:
            numbers = ", ".join(map(str, known))
            expected = f"{building} has no floor {floor}; its floors are {numbers}"
            faults.append(Fault(path, column, floor, expected))
    return table if len(faults) == before else None


def early_ends(path: Path, table: ForceTable, duration: float) -> Iterator[Fault]:
    """A table that ends with a force, before the end of what is computed [s]."""
    if table.time[-1] < duration * (1.0 - 1e-9) and table.force[-1].any():
        expected = (
            f"expected forces up to {duration:g} s, which is computed, or a last line of zeros"
        )
        yield Fault(path, "time", f"up to {table.time[-1]:g} s", expected)
