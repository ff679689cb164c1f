"""Forces on floors in time, in addition to the ground motion: a blast, an impact, a test pulse."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationInfo, field_validator

from impactfem.case.base import Section, nearest
from impactfem.case.contacts import Vector, unit_vector
from impactfem.case.floors import floors_of
from impactfem.case.leaf import FileName
from impactfem.case.quantity import Number, read_number
from impactfem.case.reading import reading_of
from impactfem.case.table import column_key
from impactfem.case.unit import FORCE, TIME, Kind, UnitError, si_factor
from impactfem.system.errors import Fault
from impactfem.system.text_file import read_text, wrong_separators

Array = NDArray[np.float64]
TABLE = "a table of forces (CSV) with the header time [s],<building>.floor_<k> [N]"

_HEADER = re.compile(r"\s*([^\[\]]*?)\s*\[\s*([^\[\]]+?)\s*\]\s*")
_FLOOR = re.compile(r"(.+)\.floor_([1-9][0-9]*)")


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

    @field_validator("direction")
    @classmethod
    def _unit(cls, value: Vector) -> Vector:
        return unit_vector(value)


@dataclass(frozen=True, eq=False)
class ForceTable:
    """The forces of a file.

    Args:
        time: Increasing, shape (n,) [s].
        floors: Building and floor of each column.
        force: Shape (n, m) [N].
    """

    time: Array
    floors: tuple[tuple[str, int], ...]
    force: Array

    def at(self, time: Array) -> Array:
        """The forces at any times, zero outside of the table's, shape (n_t, m) [N]."""
        # A time that rounding puts behind the last one still is that one.
        end = self.time[-1]
        inside = np.where(np.abs(time - end) <= 1e-9 * max(end, 1.0), end, time)
        columns = [np.interp(inside, self.time, f, left=0.0, right=0.0) for f in self.force.T]
        return np.column_stack(columns)


def read_force_table(path: Path, faults: list[Fault]) -> ForceTable | None:
    """Read a table of forces; what is wrong with it is appended to ``faults``.

    Args:
        path: The file.
        faults: Every fault of the table is appended here.

    Returns:
        The table, or None when there were faults.
    """
    before = len(faults)
    text = read_text(path, TABLE)
    if isinstance(text, Fault):
        faults.append(text)
        return None
    numbered = enumerate(text.splitlines(), start=1)
    lines = [(k, line) for k, line in numbered if line.strip() and not line.startswith("#")]
    if not lines:
        faults.append(Fault(path, "", None, f"no header; expected {TABLE}"))
        return None
    separators = wrong_separators(lines[0][1])
    if separators is not None:
        expected = f"the columns are separated by {separators}; expected commas: {TABLE}"
        faults.append(Fault(path, f"line {lines[0][0]}", None, expected))
        return None
    try:
        headers, *table = [next(csv.reader([line])) for _, line in lines]
    except csv.Error as error:
        faults.append(Fault(path, "", None, f"not a CSV file ({error}); expected {TABLE}"))
        return None
    columns = [_column(path, lines[0][0], h, k == 0, faults) for k, h in enumerate(headers)]
    names = [name for name, _ in columns[1:]]
    if not names:
        expected = "expected a column '<building>.floor_<k> [N]' besides the time"
        faults.append(Fault(path, f"line {lines[0][0]}", None, expected))
    faults.extend(
        Fault(path, column_key(lines[0][0], headers[k + 1]), None, "duplicate column")
        for k, name in enumerate(names)
        if name in names[:k]
    )
    if len(lines) < 3:
        faults.append(Fault(path, "", None, "expected at least two lines of values"))
    numbers = [number for number, _ in lines[1:]]
    rows = [
        _row(path, number, cells, headers, faults)
        for number, cells in zip(numbers, table, strict=True)
    ]
    if len(faults) > before:
        return None
    values = np.array(rows) * np.array([factor for _, factor in columns])
    for k in np.flatnonzero(np.diff(values[:, 0], prepend=-1e-12) <= 0.0)[:1]:
        expected = "expected times that increase, from 0 s or later"
        key = column_key(lines[k + 1][0], headers[0])
        faults.append(Fault(path, key, float(values[k, 0]), expected))
        return None
    return ForceTable(values[:, 0], tuple(names), values[:, 1:])


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
    """A table that ends with a force, before the end of what is computed.

    Args:
        path: The file.
        table: The table.
        duration: Time that is computed [s].
    """
    if table.time[-1] < duration * (1.0 - 1e-9) and table.force[-1].any():
        expected = (
            f"expected forces up to {duration:g} s, which is computed, or a last line of zeros"
        )
        yield Fault(path, "time", f"up to {table.time[-1]:g} s", expected)


def _column(
    path: Path, line: int, header: str, first: bool, faults: list[Fault]
) -> tuple[tuple[str, int], float]:
    """Building and floor of a column, ("", 0) for the time, and its factor to SI."""
    match = _HEADER.fullmatch(header)
    name = match[1] if match else header.strip()
    kind: Kind = TIME if first else FORCE
    place = _FLOOR.fullmatch(name)
    key = column_key(line, header)
    wanted = "'time [s]'" if first else "'<building>.floor_<k> [N]'"
    if match is None:
        faults.append(Fault(path, key, None, f"no unit; expected {wanted}"))
    elif name != "time" if first else place is None:
        faults.append(Fault(path, key, None, f"expected {wanted}"))
    factor = 1.0
    if match is not None:
        try:
            factor = si_factor(match[2], kind)
        except UnitError as error:
            faults.append(Fault(path, key, None, f"{error}; expected {wanted}"))
    return (("", 0) if place is None else (place[1], int(place[2]))), factor


def _row(
    path: Path, number: int, cells: list[str], headers: list[str], faults: list[Fault]
) -> list[float]:
    if len(cells) != len(headers):
        expected = f"expected {len(headers)} cells as in the header, found {len(cells)}"
        faults.append(Fault(path, f"line {number}", None, expected))
        return []
    row = [read_number(cell.strip()) for cell in cells]
    faults.extend(
        Fault(path, column_key(number, header), cell, "expected a finite number")
        for cell, header, value in zip(cells, headers, row, strict=True)
        if value is None
    )
    return [value or 0.0 for value in row]
