"""Tables: CSV files whose header carries the units, ``mass [t]``, read into models row by row."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from impactfem.case.base import Section, nearest
from impactfem.case.leaf import Levels, Whole, Words
from impactfem.case.place import one_line
from impactfem.case.quantity import Quantity, Ratio, read_number
from impactfem.case.unit import UnitError, scale, si_factor
from impactfem.system.errors import Fault
from impactfem.system.text_file import read_text, wrong_separators

Row = TypeVar("Row", bound=Section)
CellLeaf = Quantity | Ratio | Whole | Words | Levels

MOST_ROWS = 10_000
"""Largest number of rows, where a table has no other."""
MOST_POINTS = 50_000
"""Largest number of points of spectra in a table."""

_NEWLINE = re.compile(r"\r\n|\r|\n")
_HEADER = re.compile(r"\s*([^\[\]]*?)\s*(?:\[\s*([^\[\]]*?)\s*\])?\s*")


@dataclass(frozen=True)
class Table(Generic[Row]):
    """The rows of a table.

    Args:
        rows: One model a row, SI.
        lines: Number of the line each row stands on, from 1.
        headers: The header of each column as written, by the name of the field.
    """

    rows: tuple[Row, ...]
    lines: tuple[int, ...]
    headers: dict[str, str]


@dataclass(frozen=True)
class _Column:
    header: str
    field: str
    leaf: CellLeaf
    factor: float | None  # None when the unit could not be used: its cells are not read


def column_key(line: int, header: str) -> str:
    """Where a cell is, for a message."""
    return f"line {line}, column {header}"


def read_table(
    path: Path, row_model: type[Row], faults: list[Fault], most: int = MOST_ROWS
) -> Table[Row] | None:
    """Read a CSV file into models.

    Lines that begin with ``#`` and empty lines are skipped. The first line left is the header:
    names of the fields of ``row_model``, in any order, each with its unit in brackets.

    Args:
        path: The file.
        row_model: The model of a row; its fields carry a leaf each.
        faults: Every fault of the table is appended here.
        most: Largest number of rows.

    Returns:
        The table, or None when there were faults.
    """
    before = len(faults)
    example = ",".join(_header_of(name, info) for name, info in row_model.model_fields.items())
    text = read_text(path, f"a table (CSV) with the header {example}")
    if isinstance(text, Fault):
        faults.append(text)
        return None
    lines = [
        (number, line)
        for number, line in enumerate(_NEWLINE.split(text), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        faults.append(Fault(path, "", None, f"no header; expected {example}"))
        return None
    separators = wrong_separators(lines[0][1])
    if separators is not None:
        expected = f"the columns are separated by {separators}; expected commas: {example}"
        faults.append(Fault(path, f"line {lines[0][0]}", None, expected))
        return None
    if len(lines) - 1 > most:
        expected = f"{len(lines) - 1} rows below the header; expected at most {most}"
        faults.append(Fault(path, "", None, expected))
        return None
    try:
        columns = _columns(path, *lines[0], row_model, faults)
    except csv.Error as error:
        faults.append(Fault(path, f"line {lines[0][0]}", None, f"no header of a table ({error})"))
        return None
    if len(lines) == 1:
        faults.append(Fault(path, "", None, "the table has no row below its header"))
    rows = []
    for number, line in lines[1:]:
        row = _row(path, number, line, columns, row_model, faults)
        if row is not None:
            rows.append((number, row))
    if len(faults) > before:
        return None
    headers = {column.field: column.header for column in columns if column is not None}
    return Table(tuple(row for _, row in rows), tuple(number for number, _ in rows), headers)


def leaf_of(info: FieldInfo) -> CellLeaf:
    """The leaf of a field of a row: what its cells must be."""
    for item in info.metadata:
        if isinstance(item, CellLeaf):
            return item
    raise TypeError(f"the field {info} of a table has no leaf")


def _header_of(name: str, info: FieldInfo) -> str:
    leaf = leaf_of(info)
    return f"{name} [{leaf.kind.unit}]" if isinstance(leaf, Quantity) else name


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in next(csv.reader([line], skipinitialspace=True))]


def _columns(
    path: Path, number: int, line: str, row_model: type[Row], faults: list[Fault]
) -> list[_Column | None]:
    """Read the header; a column that cannot be used is None."""
    fields = row_model.model_fields
    columns: list[_Column | None] = []
    found: set[str] = set()
    for header in _cells(line):
        match = _HEADER.fullmatch(header)
        name, unit = (match[1], match[2]) if match else (header, None)
        key = column_key(number, header)
        if name not in fields:
            hint = nearest(name, list(fields))
            faults.append(Fault(path, key, None, f"unknown column; {hint}"))
            columns.append(None)
        elif name in found:
            faults.append(Fault(path, key, None, "duplicate column"))
            columns.append(None)
        else:
            found.add(name)
            leaf = leaf_of(fields[name])
            factor = _unit_factor(path, key, leaf, name, unit, faults)
            columns.append(_Column(header, name, leaf, factor))
    for name, info in fields.items():
        if info.is_required() and name not in found:
            expected = f"missing column; expected '{_header_of(name, info)}': {one_line(info)}"
            faults.append(Fault(path, f"line {number}", None, expected))
    return columns


def _unit_factor(
    path: Path, key: str, leaf: object, name: str, unit: str | None, faults: list[Fault]
) -> float | None:
    """Factor from the unit of a header to SI; None, with a fault, when it is of no use."""
    if isinstance(leaf, Quantity):
        example = f"expected the unit of {leaf.kind.name} in brackets, '{name} [{leaf.kind.unit}]'"
        if not unit:
            faults.append(Fault(path, key, None, f"no unit; {example}"))
            return None
        try:
            return si_factor(unit, leaf.kind)
        except UnitError as error:
            faults.append(Fault(path, key, None, f"{error}; {example}"))
            return None
    if isinstance(leaf, Ratio) and unit == "%":
        return 0.01
    if unit in {None, "", "-"}:
        return 1.0
    faults.append(Fault(path, key, None, f"this column has no unit; expected '{name}'"))
    return None


def _row(
    path: Path,
    number: int,
    line: str,
    columns: list[_Column | None],
    row_model: type[Row],
    faults: list[Fault],
) -> Row | None:
    try:
        cells = _cells(line)
    except csv.Error as error:
        faults.append(Fault(path, f"line {number}", None, f"not a line of a CSV file ({error})"))
        return None
    if len(cells) != len(columns):
        expected = f"expected {len(columns)} cells as in the header, found {len(cells)}"
        faults.append(Fault(path, f"line {number}", None, expected))
        return None
    values: dict[str, Any] = {}
    for cell, column in zip(cells, columns, strict=True):
        if column is None or column.factor is None:
            continue
        value = _value(cell, column.leaf, column.factor)
        if value is None:
            key = column_key(number, column.header)
            faults.append(Fault(path, key, cell, f"expected {_cell_words(column.leaf)}"))
        else:
            values[column.field] = value
    try:
        return row_model.model_validate(values)
    except ValidationError as error:
        faults.extend(_faults_of(error, path, number, cells, columns, values))
        return None


def _faults_of(
    error: ValidationError,
    path: Path,
    number: int,
    cells: list[str],
    columns: list[_Column | None],
    values: dict[str, Any],
) -> list[Fault]:
    """What a model refused of a row and was not said before."""
    written = {
        column.field: (column.header, cell)
        for cell, column in zip(cells, columns, strict=True)
        if column is not None
    }
    found: list[Fault] = []
    said: list[tuple[str, Any]] = []
    further: list[tuple[str, str, Any]] = []
    for item in error.errors(include_url=False):
        field = str(item["loc"][0]) if item["loc"] else ""
        if field in values:
            header, cell = written[field]
            found.append(Fault(path, column_key(number, header), cell, item["msg"]))
            said.append((item["msg"], item["input"]))
        # What is missing, or in a column but not read, was said of the header or the cell already.
        elif item["type"] != "missing" and field not in written:
            further.append((field, item["msg"], item["input"]))
    for field, message, value in further:
        # A field without a column may follow another one, whose fault it repeats.
        if (message, value) not in said:
            expected = f"{field}, which has no column: {message}" if field else message
            found.append(Fault(path, f"line {number}", None, expected))
    return found


def _value(cell: str, leaf: object, factor: float) -> float | int | str | None:
    """The value of a cell; None when it cannot be read as what the column holds."""
    if isinstance(leaf, Words | Levels):
        return cell or None
    if isinstance(leaf, Whole):
        return int(cell) if re.fullmatch(r"[+-]?\d{1,9}", cell) else None
    number = read_number(cell)
    return None if number is None else scale(number, factor)


def _cell_words(leaf: object) -> str:
    if isinstance(leaf, Words):
        return "a text, the cell is empty"
    if isinstance(leaf, Levels):
        return leaf.phrase
    if isinstance(leaf, Whole):
        return leaf.phrase
    return "a finite number (the unit is in the header)"
