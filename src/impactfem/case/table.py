"""Tables: CSV files whose header carries the units, ``mass [t]``, read into models row by row.

Every reader takes a list for faults, to which it appends all that is wrong, and gives None then.
"""

import csv
import itertools
import math
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from pydantic import ValidationError
from pydantic.fields import FieldInfo

from impactfem.case.base import Section, nearest
from impactfem.case.explain import expected_of
from impactfem.case.leaf import Levels, Whole, Words
from impactfem.case.place import one_line
from impactfem.case.quantity import Si
from impactfem.case.unit import KINDS, UnitError, si_factor
from impactfem.records.file import read_number
from impactfem.system.arrays import Array
from impactfem.system.errors import MOST_FAULTS, Fault
from impactfem.system.files import LARGEST, read_text, wrong_separators

Row = TypeVar("Row", bound=Section)
CellLeaf = Si | Whole | Words | Levels
Line = tuple[int, list[str]]
"""Number of a line, from 1, and its cells."""

MOST_ROWS = 10_000
"""Largest number of rows, where a table has no other."""
MOST_POINTS = 50_000
"""Largest number of points of spectra in a table."""

_PARENTHESES = re.compile(r"(.*?)\s*\(([^()]*)\)")
_SEPARATOR = re.compile(r'\s*"?sep=.?"?,*\s*', re.IGNORECASE)
"""The line by which spreadsheets say what separates the columns."""
_HEADER = re.compile(r"\s*([^\[\]]*?)\s*(?:\[\s*([^\[\]]*?)\s*\])?\s*")


@dataclass(frozen=True)
class Table(Generic[Row]):
    """The rows of a table."""

    path: Path  #: the file
    rows: tuple[Row, ...]  #: one model a row, SI
    lines: tuple[int, ...]  #: number of the line each row stands on, from 1
    headers: dict[str, str]  #: the header of each column as written, by the name of the field
    #: the values of each line that could be read, by the name of the field
    cells: tuple[tuple[int, dict[str, Any]], ...] = ()

    def __iter__(self) -> Iterator[tuple[int, Row]]:
        """The rows with their lines."""
        return zip(self.lines, self.rows, strict=True)

    def fault(self, line: int, column: str, value: Any, expected: str, kind: str = "") -> Fault:
        """A fault of a cell."""
        key = f"line {line}, column {self.headers.get(column, column)}"
        return Fault(self.path, key, value, expected, kind)

    def duplicates(self, column: str, *further: str) -> Iterator[Fault]:
        """Rows with a value, or a combination of those of columns, that stands above already."""
        first: dict[tuple[Any, ...], int] = {}
        for line, cells in self.cells:
            if cells.keys() >= {column, *further}:
                above = first.setdefault(tuple(cells[k] for k in (column, *further)), line)
                if above != line:
                    expected = f"duplicate {column}, the first is in line {above}"
                    yield self.fault(line, column, cells[column], expected, "duplicate")

    def curves(self, x: str, y: str, *by: str) -> dict[tuple[Any, ...], list[tuple[float, float]]]:
        """Points (x, y) of the curves that columns tell apart, as they stand."""
        found: dict[tuple[Any, ...], list[tuple[float, float]]] = defaultdict(list)
        for row in self.rows:
            key = tuple(getattr(row, column) for column in by)
            found[key].append((getattr(row, x), getattr(row, y)))
        return found

    def disorder(self, x: str, of_each: str, *by: str) -> Iterator[Fault]:
        """Curves with fewer than two points, or whose abscissae neither rise nor fall."""
        curves: dict[tuple[Any, ...], list[tuple[int, float]]] = defaultdict(list)
        for line, row in self:
            curves[tuple(getattr(row, k) for k in by)].append((line, getattr(row, x)))
        for points in curves.values():
            if len(points) < 2:
                expected = f"expected at least 2 points of each {of_each}"
                yield Fault(self.path, f"line {points[0][0]}", None, expected, "points")
                continue
            sign = math.copysign(1.0, points[1][1] - points[0][1])
            for (_, a), (line, b) in itertools.pairwise(points):
                if (b - a) * sign <= 0.0:
                    expected = f"expected values in order, each once; before: {a:g}"
                    yield self.fault(line, x, b, expected, "order")
                    break  # one says it of all that follow


@dataclass(frozen=True)
class _Column:
    header: str
    field: str
    leaf: CellLeaf
    unit: str | None  #: as written; None when it cannot be used: its cells are not read

    def value(self, cell: str) -> float | int | str | None:
        """The content of a cell as a case file would state it; None where it is no value."""
        if isinstance(self.leaf, Whole):
            return int(cell) if re.fullmatch(r"[+-]?\d{1,9}", cell) else None
        if not isinstance(self.leaf, Si):
            return cell or None
        number = read_number(cell)
        return f"{cell} {self.unit}" if number is not None and self.unit else number


@dataclass(frozen=True, eq=False)
class NumberTable:
    """The numbers of a CSV file, as written."""

    header: Line  #: number and cells of its first line
    lines: tuple[int, ...]  #: number of the line of each row, from 1
    values: Array  #: shape (rows, columns)


def read_lines(
    path: Path,
    what: str,
    header: str,
    faults: list[Fault],
    most: int = MOST_ROWS,
    largest: float = LARGEST,
) -> list[Line] | None:
    """Read the header of a CSV file and its rows, which have as many cells.

    Lines that begin with ``#`` and empty lines, of commas alone too, are skipped; so are what
    spreadsheets write: a line ``sep=,`` and empty cells behind the last column. A row with a
    fault is left out; every fault is appended to the list. What the file is to be, and the header
    that is expected, are for messages; `largest` is its size in bytes. None where there is no
    header, or there are too many rows.
    """
    lines = _filled_lines(path, what, header, faults, most, largest)
    return None if lines is None else _cells(path, lines, faults)


def read_numbers(
    path: Path,
    what: str,
    header: str,
    faults: list[Fault],
    most: int,
    largest: float = LARGEST,
) -> NumberTable | None:
    """Read a CSV file with numbers alone below its header; as `read_lines`, in much less time.

    None where it has faults; each cell that is no finite number is one.
    """
    lines = _filled_lines(path, what, header, faults, most, largest)
    if lines is None:
        return None
    before = len(faults)
    top = _cells(path, lines[:1], []) or []
    ends = ", \t" if lines[0][1].rstrip().endswith(",") else ""
    rows = [line.rstrip(ends) for _, line in lines[1:]]
    values = None
    with suppress(ValueError):
        values = np.loadtxt(rows, delimiter=",", comments=None, ndmin=2) if rows and top else None
    whole = values is not None and values.shape[1] == len(top[0][1]) and np.isfinite(values).all()
    if values is None or not whole:
        cells = _cells(path, lines, faults) or []
        values = np.empty((max(len(cells) - 1, 0), len(cells[0][1]) if cells else 0))
        for row, (number, texts) in zip(values, cells[1:], strict=True):
            for k, text in enumerate(texts):
                value = read_number(text)
                if value is None:
                    key = f"line {number}, column {cells[0][1][k]}"
                    expected = "expected a finite number (the unit is in the header)"
                    faults.append(Fault(path, key, text, expected, "cell"))
                row[k] = np.nan if value is None else value
            if len(faults) > before + MOST_FAULTS:
                break
    if len(faults) > before:
        return None
    return NumberTable(top[0], tuple(number for number, _ in lines[1:]), values)


def _filled_lines(
    path: Path, what: str, header: str, faults: list[Fault], most: int, largest: float
) -> list[tuple[int, str]] | None:
    """The lines of a CSV file that are not empty or a comment, with their numbers; as said."""
    text = read_text(path, what, largest)
    if isinstance(text, Fault):
        faults.append(text)
        return None
    lines = [
        (number, line)
        for number, line in enumerate(re.sub("\r\n?", "\n", text).split("\n"), start=1)
        if line.strip(" \t,") and not line.lstrip().startswith("#")
    ]
    if lines and _SEPARATOR.fullmatch(lines[0][1]):
        del lines[0]
    separators = wrong_separators(lines[0][1]) if lines else None
    key, expected = "", ""
    if not lines:
        expected = f"no header; expected {header}"
    elif separators is not None:
        key = f"line {lines[0][0]}"
        expected = f"the columns are separated by {separators}; expected commas: {header}"
    elif len(lines) - 1 > most:
        expected = f"{len(lines) - 1} rows below the header; expected at most {most}"
    if expected:
        faults.append(Fault(path, key, None, expected, "csv"))
    return None if expected else lines


def _cells(path: Path, lines: list[tuple[int, str]], faults: list[Fault]) -> list[Line] | None:
    """The cells of lines, of which the first one is the header; None where that has none."""
    found: list[Line] = []
    for number, line in lines:
        key = f"line {number}"
        try:
            cells = [cell.strip() for cell in next(csv.reader([line], skipinitialspace=True))]
        except csv.Error as error:
            faults.append(Fault(path, key, None, f"not a line of a CSV file ({error})", "csv"))
            if not found:
                return None
            continue
        columns = len(found[0][1]) if found else len(",".join(cells).rstrip(",").split(","))
        if not any(cells[columns:]):
            cells = cells[:columns]
        if len(cells) != columns:
            expected = f"expected {columns} cells as in the header, found {len(cells)}"
            faults.append(Fault(path, key, None, expected, "cells"))
            continue
        found.append((number, cells))
    if len(lines) == 1:
        faults.append(Fault(path, "", None, "the table has no row below its header", "no_row"))
    return found


def read_table(
    path: Path,
    row_model: type[Row],
    faults: list[Fault],
    *checks: Callable[[Table[Row]], Iterable[Fault]],
    once: tuple[str, ...] = (),
    most: int = MOST_ROWS,
    what: str = "",
    context: Any = None,
) -> Table[Row] | None:
    """Read a CSV file into models; None, with the faults appended to the list, where it has any.

    The header has names of the fields of ``row_model``, which carry a leaf each, in any order, each
    with its unit in brackets. A model that ignores what it does not know lets a table have further
    columns. The checks look at a table whose rows have no fault. A value of the first column of
    `once`, or a combination with its others, stands once in the table, whatever else is at fault.
    The context of a validation leads rows that name tables of the case file to these.
    """
    example = ",".join(_header_of(name, info) for name, info in row_model.model_fields.items())
    example, what = (what, what) if what else (example, f"a table (CSV) with the header {example}")
    found: list[Fault] = []
    table = None
    lines = read_lines(path, what, example, found, most)
    if lines is not None:
        columns = _columns(path, *lines[0], row_model, found)
        rows = [
            (n, *_row(path, n, cells, columns, row_model, found, context)) for n, cells in lines[1:]
        ]
        table = Table(
            path,
            tuple(row for _, row, _ in rows if row is not None),
            tuple(number for number, row, _ in rows if row is not None),
            {column.field: column.header for column in columns if column is not None},
            tuple((n, values if row is None else vars(row)) for n, row, values in rows),
        )
        sound = not found
        found.extend(table.duplicates(*once) if once else ())
        for check in checks if sound else ():
            kind = getattr(check, "__name__", "").strip("_")
            found.extend(replace(fault, kind=fault.kind or kind) for fault in check(table))
    faults.extend(found)
    return None if found else table


def leaf_of(info: FieldInfo) -> CellLeaf:
    """The leaf of a field of a row: what its cells must be."""
    return next(item for item in info.metadata if isinstance(item, CellLeaf))


def name_and_unit(header: str) -> tuple[str, str | None]:
    """The name and the unit of a header; all of it where it is no name with a unit in brackets."""
    match = _HEADER.fullmatch(header)
    return (match[1], match[2]) if match else (header, None)


def _name(header: str) -> str:
    return name_and_unit(header)[0]


def unit_of_column(header: str, unit: str) -> float | str:
    """Return the factor to an SI unit of a column by its header, or what is wrong with it."""
    name, written = name_and_unit(header)
    try:
        return si_factor(written or "", unit)
    except UnitError as error:
        said = f"{error if written else 'no unit'}; expected the unit of {KINDS[unit].name}"
        return f"{said} in brackets, '{name} [{unit}]'"


def _header_of(name: str, info: FieldInfo) -> str:
    leaf = leaf_of(info)
    return f"{name} [{leaf.unit}]" if isinstance(leaf, Si) and leaf.unit != "-" else name


def _columns(
    path: Path, number: int, headers: list[str], row_model: type[Row], faults: list[Fault]
) -> list[_Column | None]:
    """The columns of a header; one that cannot be used is None."""
    fields = row_model.model_fields
    if not any(name_and_unit(header)[0] in fields for header in headers):
        names = ",".join(_header_of(*one) for one in fields.items() if one[1].is_required())
        faults.append(Fault(path, f"line {number}", None, f"no header; expected {names}", "header"))
        return [None] * len(headers)
    columns: list[_Column | None] = []
    found: set[str] = set()
    for header in headers:
        name, unit = name_and_unit(header)
        column, wrong = None, ""
        if name not in fields:
            if row_model.model_config.get("extra") != "ignore":
                unused = [key for key in fields if key not in map(_name, headers)]
                known = nearest(name, unused)
                if (parts := _PARENTHESES.fullmatch(header)) and parts[1] in fields:
                    known = f"write the unit in square brackets: '{parts[1]} [{parts[2]}]'"
                wrong = f"unknown column; {known}" if header else "a column without a name"
        elif name in found:
            wrong = "duplicate column"
        else:
            found.add(name)
            leaf = leaf_of(fields[name])
            if isinstance(leaf, Si) and leaf.unit != "-":
                read = unit_of_column(header, leaf.unit)
                wrong = read if isinstance(read, str) else ""
            elif unit == "-" or (unit and not (isinstance(leaf, Si) and unit == "%")):
                wrong = "" if unit == "-" else f"this column has no unit; expected '{name}'"
                unit = ""
            column = _Column(header, name, leaf, None if wrong else unit or "")
        if wrong:
            at = f"line {number}, column {header}"
            faults.append(Fault(path, at, None, wrong, "column"))
        columns.append(column)
    incomplete = {name for group in row_model.TOGETHER if found & {*group} for name in group}
    for name, info in fields.items():
        if (info.is_required() or name in incomplete) and name not in found:
            expected = f"missing column; expected '{_header_of(name, info)}': {one_line(info)}"
            faults.append(Fault(path, f"line {number}", None, expected, "missing_column"))
    return columns


def _row(
    path: Path,
    line: int,
    cells: list[str],
    columns: list[_Column | None],
    row_model: type[Row],
    faults: list[Fault],
    context: Any,
) -> tuple[Row | None, dict[str, Any]]:
    """The model of a row, None where it has faults, and its values that could be read."""
    values: dict[str, Any] = {}
    written: dict[str, str] = {}
    key = f"line {line}, column "
    for cell, column in zip(cells, columns, strict=True):
        if column is None:
            continue
        written[column.field] = cell
        if not cell and column.field in row_model.MAY_BE_EMPTY:
            del written[column.field]  # as without the column
            continue
        if column.unit is None:
            continue
        value = column.value(cell)
        if value is None:
            expected = "a finite number (the unit is in the header)"
            if not isinstance(column.leaf, Si):
                text = isinstance(column.leaf, Words)
                expected = "a text, the cell is empty" if text else column.leaf.phrase
            at = key + column.header
            faults.append(Fault(path, at, cell, f"expected {expected}", "cell"))
        else:
            values[column.field] = value
    try:
        return row_model.model_validate(values, context=context), values
    except ValidationError as error:
        headers = {column.field: column.header for column in columns if column is not None}
        items = error.errors(include_url=False)
        fields = [str(item["loc"][0]) if item["loc"] else "" for item in items]
        said = [(i["msg"], i["input"]) for i, f in zip(items, fields, strict=True) if f in values]
        # Of a header with an unknown column a field without a column is a consequence.
        header_read = not any(fault.file == path and fault.kind == "column" for fault in faults)
        for item, field in zip(items, fields, strict=True):
            expected = expected_of(item, row_model.model_fields.get(field))
            if field in values:
                at, cell = key + headers[field], written[field]
                faults.append(Fault(path, at, cell, expected, item["type"]))
            # What is missing, or in a column but not read, was said of the header or the cell
            # already; and a field without a column may follow another one, whose fault it repeats.
            elif (
                item["type"] != "missing"
                and field not in written
                and (item["msg"], item["input"]) not in said
                and (header_read or field in headers or not field)
            ):
                without = "is empty" if field in headers else "has no column"
                expected = f"{field}, which {without}: {expected}" if field else expected
                faults.append(Fault(path, f"line {line}", None, expected, item["type"]))
        return None, values
