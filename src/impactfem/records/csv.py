"""Accelerograms as CSV: a column of time and one or more of acceleration, units in the header."""

import csv
import math
import re
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from impactfem.records.accelerogram import Accelerogram
from impactfem.records.file import (
    ACCELERATION_UNITS,
    LONGEST,
    TIME_UNITS,
    Format,
    RecordFile,
    plain_unit,
    read_number,
    same_name,
)
from impactfem.records.recording import Recording, orientation, read_time
from impactfem.system.arrays import Array
from impactfem.system.files import wrong_separators

HEADER = "time [s],acceleration [m/s2]"

_CELL = re.compile(r"\s*([^\[\]]*?)\s*(?:\[\s*([^\[\]]*?)\s*\])?\s*")
_SEPARATOR = re.compile(r'"?sep=(.)"?,*', re.IGNORECASE)  # the first line, by a spreadsheet
_STATED = re.compile(r"\s*#\s*(start|event|station|sensor|component)\s*[:=]\s*(.*?)[\s,]*", re.I)
_PLAIN = re.compile(r"[-+.\deE,\s]*", re.ASCII)
_STEP_TOLERANCE = 0.01  # of the time step: what rounding of the printed times may do


def read(file: RecordFile, component: str | None) -> Accelerogram:
    """Read an accelerogram from a CSV file.

    Lines that begin with ``#`` and empty lines are skipped. The first other line is the header:
    ``time`` and one or more accelerations in any order, each with its unit in brackets
    (accelerations in m/s2, cm/s2, mm/s2, g, gal, ...; times in s, ms, min). A single acceleration
    may have any name, several have different ones: ``time [s],NS [g],EW [g]``. Then one sample a
    line, the first at time 0, at a uniform time step. A first line ``sep=,`` and empty cells at the
    end of lines, as of spreadsheets, are left out.

    Comments may state what other formats have in their headers, to be compared between components:
    ``# start: 2023-02-06T01:17:30.25`` (of the first sample, UTC), ``# event:``, ``# station:``,
    ``# sensor:`` and, of a file with one acceleration, ``# component:``.

    The component is the name of a column.
    """
    comments = (line[:LONGEST] for line in file.lines if line.lstrip().startswith("#"))
    stated = {m[1].lower(): m[2] for m in map(_STATED.fullmatch, comments) if m}
    lines = [
        (i, line)
        for i, line in enumerate(file.lines, start=1)
        if line.strip(" \t,") and not line.lstrip().startswith("#")
    ]
    if lines and _SEPARATOR.fullmatch(lines[0][1].strip()):
        lines = lines[1:]
    if not lines:
        file.fail(None, None, f"no header; expected {file.expected}")
    factors = _header(file, *lines[0])
    if len(lines) < 3:
        file.fail(None, None, "expected at least 2 samples below the header")
    values = _values(file, lines[1:], list(factors))
    if file.faults:
        raise file.error()
    columns = dict(zip(factors, values.T, strict=True))
    time = columns["time"] * factors["time"]
    # Samples whose time is not the one that a uniform step would give. The median: a sample left
    # out, or a wrong time, does not change what is usual.
    places, steps = [i for i, _ in lines[1:]], np.diff(time)
    forward = steps[steps > 0.0]
    usual = float(np.median(forward)) if forward.size else 0.0
    if usual > 0.0 and abs(time[0]) > _STEP_TOLERANCE * usual:
        expected = "expected the first sample at time 0: shift the times of the record"
        file.note(places[0], f"{time[0]:.9g} s", expected)
    uneven = (steps <= 0.0) | (np.abs(steps - usual) > _STEP_TOLERANCE * usual)
    for i in np.flatnonzero(uneven) + 1:
        step = float(steps[i - 1])
        if step <= 0.0:
            expected = f"expected times that ascend; the line before has {time[i - 1]:.9g} s"
        else:
            expected = (
                f"expected a uniform time step, {usual:.9g} s as between most samples (with"
                f" enough digits); this step is {step:.9g} s"
            )
        file.note(places[i], f"{time[i]:.9g} s", expected)
    if file.faults:
        raise file.error()
    h = float(time[-1] - time[0]) / (time.size - 1)
    names = [name for name in factors if name != "time"]
    known = ", ".join(f"'{name}'" for name in names)
    column = names[file.choose(component, [(name,) for name in names], known)]
    name, origin = file.path.stem, f"record {file.path.name}"
    if len(names) > 1:
        name, origin = f"{name}_{column}", f"{origin}, column {column}"
    named = column if len(names) > 1 or column != "acceleration" else ""
    named = stated.get("component", named) if len(names) == 1 else named
    recording = Recording(
        start=read_time(stated.get("start", "")),
        event=stated.get("event", ""),
        station=stated.get("station", ""),
        sensor=stated.get("sensor", ""),
        component=named,
        orientation=orientation(named),
    )
    return Accelerogram(h, columns[column] * factors[column], name, origin, recording=recording)


def write_csv(accelerogram: Accelerogram, path: Path | str) -> None:
    """Write an accelerogram as `read_record` reads it, with all digits, over an existing file."""
    pairs = zip(map(float, accelerogram.time), map(float, accelerogram.acceleration), strict=True)
    rows = [f"{time!r},{acceleration!r}" for time, acceleration in pairs]
    Path(path).write_text("\n".join([HEADER, *rows]) + "\n", encoding="utf-8")


def _header(file: RecordFile, line_number: int, line: str) -> dict[str, float]:
    """Read the columns' names, in order, and the factors of their units to SI."""
    separators = wrong_separators(line)
    if separators is not None:
        expected = f"the columns are separated by {separators}; expected commas: {file.expected}"
        file.fail(line_number, line.strip(), expected)
    headers = _cells(line)
    while len(headers) > 2 and not headers[-1]:
        headers.pop()
    lower = [cell.lower() for cell in headers]
    if all("[" not in cell and cell not in {"time", "acceleration"} for cell in lower):
        file.fail(line_number, line.strip(), f"this is no header; expected {file.expected}")
    factors: dict[str, float] = {}
    for cell in headers:
        match = _CELL.fullmatch(cell)
        name = match[1] if match else ""
        unit = plain_unit(match[2]) if match and match[2] else ""
        if name.lower() in {"time", "acceleration"}:
            name = name.lower()
        units = TIME_UNITS if name == "time" else ACCELERATION_UNITS
        factor = units.get(unit)
        # A column of another name is known as an acceleration by its unit alone.
        other = re.match(r"(?i)vel|disp", name)
        if not name or other or (factor is None and name not in {"time", "acceleration"}):
            what = "no such column"
            if other:
                what += ", as its name is not that of an acceleration"
            elif unit and unit not in TIME_UNITS and match:
                what += f", as '{match[2]}' is no unit of acceleration ({', '.join(units)})"
            file.note(line_number, cell.strip(), f"{what}; expected {file.expected}")
            continue
        if any(same_name(name, other) for other in factors):
            file.note(line_number, cell.strip(), f"a second column of {name}")
            continue
        if factor is None:
            expected = f"expected a unit of {name} in brackets, one of {', '.join(units)}"
            file.note(line_number, cell.strip(), expected)
        factors[name] = factor or math.nan
    if not file.faults and ("time" not in factors or len(factors) < 2):
        missing = "acceleration" if "time" in factors else "time"
        file.note(line_number, line.strip(), f"no column of {missing}; expected {file.expected}")
    if file.faults:
        raise file.error()
    return factors


def _cells(line: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line], skipinitialspace=True))]
    except csv.Error:  # a cell larger than any number
        return [line.strip()]


def _values(file: RecordFile, lines: Sequence[tuple[int, str]], names: Sequence[str]) -> Array:
    """The samples of all columns, one in a row; faults are noted."""
    plain = [line for _, line in lines]
    commas = len(names) - 1
    # Nearly all files: no cell that `_row` would refuse, converted at once.
    if all(line.count(",") == commas for line in plain) and _PLAIN.fullmatch("\n".join(plain)):
        with suppress(ValueError):
            values = np.loadtxt(plain, delimiter=",", ndmin=2)
            if np.isfinite(values).all():
                return values
    rows = (_row(file, i, line, names) for i, line in lines)
    return np.array([row for row in rows if row is not None])


def _row(file: RecordFile, line_number: int, line: str, names: Sequence[str]) -> list[float] | None:
    """Read one sample of each column; None, with the faults noted, when it is none."""
    cells = _cells(line)
    while len(cells) > len(names) and not cells[-1]:
        cells.pop()
    if len(cells) != len(names):
        expected = f"expected {len(names)} cells as in the header, got {len(cells)}"
        file.note(line_number, line.strip(), expected)
        return None
    values = []
    for name, cell in zip(names, cells, strict=True):
        value = read_number(cell)
        if value is None:
            expected = f"expected a finite number as the {name}, without unit"
            file.note(line_number, cell, expected)
        else:
            values.append(value)
    return values if len(values) == len(names) else None


FORMAT = Format(
    name="csv",
    expected=f"a CSV record with the header '{HEADER}'",
    endings=("csv",),
    sign=re.compile(r"[^#]*\[[^\]]*\]\s*,"),
    read=read,
)
