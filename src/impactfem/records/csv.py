"""Accelerograms as CSV: a column of time and one or more of acceleration, units in the header."""

import csv
import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from impactfem.records.accelerogram import Accelerogram
from impactfem.records.file import (
    ACCELERATION_UNITS,
    TIME_UNITS,
    Format,
    RecordFile,
    plain_unit,
    read_number,
    same_name,
)
from impactfem.system.files import wrong_separators

HEADER = "time [s],acceleration [m/s2]"

_CELL = re.compile(r"\s*([^\[\]]*?)\s*(?:\[\s*([^\[\]]*?)\s*\])?\s*")
_STEP_TOLERANCE = 0.01  # of the time step: what rounding of the printed times may do


def read(file: RecordFile, component: str | None) -> Accelerogram:
    """Read an accelerogram from a CSV file.

    Lines that begin with ``#`` and empty lines are skipped. The first other line is the header:
    ``time`` and one or more accelerations in any order, each with its unit in brackets
    (accelerations in m/s2, cm/s2, mm/s2, g, gal, ...; times in s, ms, min). A single acceleration
    may have any name, several have different ones: ``time [s],NS [g],EW [g]``. Then one sample a
    line, the first at time 0, at a uniform time step.

    The component is the name of a column.
    """
    lines = [
        (i, line)
        for i, line in enumerate(file.lines, start=1)
        if line.strip(" \t,") and not line.lstrip().startswith("#")
    ]
    if not lines:
        file.fail(None, None, f"no header; expected {file.expected}")
    factors = _header(file, *lines[0])
    rows = {i: _row(file, i, line, list(factors)) for i, line in lines[1:]}
    samples = {i: values for i, values in rows.items() if values is not None}
    if len(lines) < 3:
        file.note(None, None, "expected at least 2 samples below the header")
    if file.faults:
        raise file.error()
    columns = dict(zip(factors, np.array(list(samples.values())).T, strict=True))
    time = columns["time"] * factors["time"]
    # Samples whose time is not the one that a uniform step would give. The median: a sample left
    # out, or a wrong time, does not change what is usual.
    places, steps = list(samples), np.diff(time)
    forward = steps[steps > 0.0]
    usual = float(np.median(forward)) if forward.size else 0.0
    if usual > 0.0 and abs(time[0]) > _STEP_TOLERANCE * usual:
        expected = "expected the first sample at time 0: shift the times of the record"
        file.note(places[0], f"{time[0]:.9g} s", expected)
    for i, step in enumerate(steps.tolist(), start=1):
        if step <= 0.0:
            expected = f"expected times that ascend; the line before has {time[i - 1]:.9g} s"
        elif abs(step - usual) > _STEP_TOLERANCE * usual:
            expected = (
                f"expected a uniform time step, {usual:.9g} s as between most samples (with"
                f" enough digits); this step is {step:.9g} s"
            )
        else:
            continue
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
    return Accelerogram(h, columns[column] * factors[column], name, origin)


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


def _row(file: RecordFile, line_number: int, line: str, names: Sequence[str]) -> list[float] | None:
    """Read one sample of each column; None, with the faults noted, when it is none."""
    cells = _cells(line)
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
