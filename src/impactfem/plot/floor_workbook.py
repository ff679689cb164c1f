"""The workbook of floor response spectra: a sheet for each building, direction and damping."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from openpyxl import Workbook
from openpyxl.cell import WriteOnlyCell
from openpyxl.cell.cell import ILLEGAL_CHARACTERS_RE
from openpyxl.styles import Alignment, Font
from openpyxl.utils import get_column_letter

from impactfem.plot.table import Cell, cell
from impactfem.spectra.design import ZPA_TOLERANCE
from impactfem.spectra.product import DesignFloorSpectra
from impactfem.system.files import atomic

LONGEST_NAME = 31  # of a sheet, by the file format
LABEL_WIDTH, COLUMN_WIDTH = 26, 13  # characters


def write_workbook(path: Path, design: DesignFloorSpectra) -> None:
    """Write the workbook; the first sheet lists the others.

    Args:
        path: The file.
        design: The spectra.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    book = Workbook(write_only=True)
    source = design.source
    buildings = list(dict.fromkeys(station.building for station in source.stations))
    contents = book.create_sheet("contents")
    contents.column_dimensions["A"].width = LABEL_WIDTH
    _append(contents, ["case", source.title])
    for line in _method_lines(design):
        _append(contents, line)
    _append(contents, [])
    _append(contents, ["sheet", "building", "direction", "damping [-]"], bold=True)
    names: set[str] = {"contents"}
    for building in buildings:
        for x, direction in enumerate(source.directions):
            for d, damping in enumerate(source.damping):
                name = _sheet_name(f"{building} {direction} {100.0 * damping:g} %", names)
                names.add(name.lower())
                _append(contents, [name, building, direction, float(damping)])
                _sheet(book, name, design, building, x, d)
    with atomic(path) as temporary:
        book.save(temporary)


def _method_lines(design: DesignFloorSpectra) -> list[list[Cell]]:
    return [
        ["quantity", "pseudo-acceleration of floor response spectra"],
        ["units", "accelerations in m/s2, frequencies in Hz, elevations in m"],
        ["method", design.source.method],
        ["motions", design.motions_text],
        ["design", design.broadening_text],
        ["between frequencies", "straight lines on doubly logarithmic axes"],
        ["empty cells", "frequencies added for the corners of broadened peaks: not computed"],
    ]


def _sheet(book: Any, name: str, design: DesignFloorSpectra, building: str, x: int, d: int) -> None:
    source = design.source
    numbers = [s for s, station in enumerate(source.stations) if station.building == building]
    stations = [source.stations[s] for s in numbers]
    sheet = book.create_sheet(name)
    sheet.column_dimensions["A"].width = LABEL_WIDTH
    for column in range(2, 2 + 2 * len(numbers)):
        sheet.column_dimensions[get_column_letter(column)].width = COLUMN_WIDTH
    head: list[list[Cell]] = [
        ["case", source.title],
        ["building", building],
        ["direction", source.directions[x]],
        ["damping [-]", float(source.damping[d])],
        *_method_lines(design),
        [],
        ["floor", *_twice(station.label for station in stations)],
        ["points", *_twice("; ".join(station.points) for station in stations)],
        ["elevation [m]", *_twice(cell(station.elevation) for station in stations)],
        ["zero-period acceleration [m/s2]", *_twice(cell(design.zpa[s, x]) for s in numbers)],
        [
            f"within {100 * ZPA_TOLERANCE:g} % of it from [Hz]",
            *_twice(cell(design.rigid[d, s, x]) for s in numbers),
        ],
    ]
    for line in head:
        _append(sheet, line)
    titles = [title for _ in numbers for title in ("raw [m/s2]", "broadened [m/s2]")]
    _append(sheet, ["frequency [Hz]", *titles], bold=True)
    # Frozen below the titles and right of the frequencies.
    sheet.freeze_panes = f"B{len(head) + 2}"
    raw, psa = design.computed[d, :, x], design.psa[d, :, x]
    for k, frequency in enumerate(design.frequency):
        pairs = [value for s in numbers for value in (raw[s, k], psa[s, k])]
        sheet.append([cell(frequency), *(cell(value) for value in pairs)])


def _append(sheet: Any, cells: Sequence[Cell], bold: bool = False) -> None:
    row = []
    for value in cells:
        entry = WriteOnlyCell(sheet, value=None)
        if isinstance(value, str):
            # As text whatever it begins with: a title such as "=1+1" is no formula.
            entry.value = ILLEGAL_CHARACTERS_RE.sub(" ", value)
            entry.data_type = "s"
        else:
            entry.value = value
        entry.alignment = Alignment(horizontal="left")
        entry.font = Font(bold=bold)
        row.append(entry)
    sheet.append(row)


def _twice(values: Iterable[Cell]) -> list[Cell]:
    """One entry over both columns of a floor, for filters and copies."""
    return [value for value in values for _ in range(2)]


def _sheet_name(wanted: str, names: set[str]) -> str:
    """A name that the format allows and that no sheet has; case does not tell names apart."""
    clean = re.sub(r"[\[\]:*?/\\']", "_", wanted)
    name, count = clean[:LONGEST_NAME], 1
    while name.lower() in names:
        count += 1
        name = f"{clean[: LONGEST_NAME - len(str(count)) - 1]}~{count}"
    return name
