"""Accelerograms as CSV: a column of time and one or more of acceleration, units in the header."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from impactfem.motion.accelerogram import Accelerogram
from impactfem.motion.record_text import (
    ACCELERATION_UNITS,
    TIME_UNITS,
    input_error,
    number,
    plain_unit,
    read_lines,
    same_name,
)
from impactfem.system.errors import Fault, InputError
from impactfem.system.text_file import wrong_separators

FloatArray = npt.NDArray[np.float64]

HEADER = "time [s],acceleration [m/s2]"

_EXPECTED = f"a CSV record with the header '{HEADER}'"
_CELL = re.compile(r"\s*([^\[\]]*?)\s*(?:\[\s*([^\[\]]*?)\s*\])?\s*")
_STEP_TOLERANCE = 0.01  # of the time step: what rounding of the printed times may do


def read_csv(path: Path | str, component: str | None = None) -> Accelerogram:
    """Read an accelerogram from a CSV file.

    Lines that begin with ``#`` and empty lines are skipped. The first other line is the header:
    ``time`` and one or more accelerations in any order, each with its unit in brackets
    (accelerations in m/s2, cm/s2, mm/s2, g, gal, ...; times in s, ms, min). A single acceleration
    may have any name, several have different ones: ``time [s],NS [g],EW [g]``. Then one sample a
    line, the first at time 0, at a uniform time step.

    Args:
        path: The file.
        component: Name of the column; None when there is only one acceleration.

    Returns:
        The accelerogram in m/s2, named after the file, and after the column where there are
        several.

    Raises:
        InputError: With every fault of the file (the first 20 and a count), each with its line.
    """
    path = Path(path)
    lines = [
        (i, line)
        for i, line in enumerate(read_lines(path, _EXPECTED), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise InputError([Fault(path, "", None, f"no header; expected {_EXPECTED}")])
    factors = _header(path, *lines[0])
    numbers: list[int] = []
    samples: list[list[float]] = []
    faults: list[Fault] = []
    for i, line in lines[1:]:
        values = _row(path, i, line, list(factors), faults)
        if values is not None:
            numbers.append(i)
            samples.append(values)
    if len(lines) < 3:
        faults.append(Fault(path, "", None, "expected at least 2 samples below the header"))
    if faults:
        raise input_error(path, faults)
    columns = dict(zip(factors, np.array(samples).T, strict=True))
    time = columns["time"] * factors["time"]
    faults = _time_faults(path, numbers, time)
    if faults:
        raise input_error(path, faults)
    step = float(time[-1] - time[0]) / (time.size - 1)
    names = [name for name in factors if name != "time"]
    chosen = _chosen(path, names, component)
    single = len(names) == 1
    return Accelerogram(
        step,
        columns[chosen] * factors[chosen],
        path.stem if single else f"{path.stem}_{chosen}",
        f"record {path.name}" if single else f"record {path.name}, column {chosen}",
    )


def write_csv(accelerogram: Accelerogram, path: Path | str) -> None:
    """Write an accelerogram as :func:`read_csv` reads it, with all digits.

    Args:
        accelerogram: The motion.
        path: The file; an existing one is overwritten.

    Raises:
        OSError: The file cannot be written.
    """
    pairs = zip(map(float, accelerogram.time), map(float, accelerogram.acceleration), strict=True)
    rows = [f"{time!r},{acceleration!r}" for time, acceleration in pairs]
    Path(path).write_text("\n".join([HEADER, *rows]) + "\n", encoding="utf-8")


def _header(path: Path, line_number: int, line: str) -> dict[str, float]:
    """Read the columns' names, in order, and the factors of their units to SI."""
    faults: list[Fault] = []
    factors: dict[str, float] = {}
    key = f"line {line_number}"
    fault = _layout_fault(path, key, line)
    if fault is not None:
        raise InputError([fault])
    for cell in line.split(","):
        match = _CELL.fullmatch(cell)
        name = match[1] if match else ""
        unit = plain_unit(match[2]) if match and match[2] else ""
        if name.lower() in {"time", "acceleration"}:
            name = name.lower()
        units = TIME_UNITS if name == "time" else ACCELERATION_UNITS
        factor = units.get(unit)
        # A column of another name is an acceleration by its unit, or none of ours.
        if not name or (factor is None and name not in {"time", "acceleration"}):
            what = "no such column"
            if unit and unit not in TIME_UNITS and match:
                what += f", as '{match[2]}' is no unit of acceleration ({', '.join(units)})"
            faults.append(Fault(path, key, cell.strip(), f"{what}; expected {_EXPECTED}"))
            continue
        if any(same_name(name, other) for other in factors):
            faults.append(Fault(path, key, cell.strip(), f"a second column of {name}"))
            continue
        if factor is None:
            expected = f"expected a unit of {name} in brackets, one of {', '.join(units)}"
            faults.append(Fault(path, key, cell.strip(), expected))
        factors[name] = factor or math.nan
    if not faults and "time" not in factors:
        expected = f"no column of time; expected {_EXPECTED}"
        faults.append(Fault(path, key, line.strip(), expected))
    elif not faults and len(factors) < 2:
        expected = f"no column of acceleration; expected {_EXPECTED}"
        faults.append(Fault(path, key, line.strip(), expected))
    if faults:
        raise input_error(path, faults)
    return factors


def _layout_fault(path: Path, key: str, line: str) -> Fault | None:
    """What is wrong with the header as a whole; None where its columns can be looked at."""
    separators = wrong_separators(line)
    if separators is not None:
        expected = f"the columns are separated by {separators}; expected commas: {_EXPECTED}"
        return Fault(path, key, line.strip(), expected)
    names = (cell.strip().lower() for cell in line.split(","))
    if all("[" not in name and name not in {"time", "acceleration"} for name in names):
        return Fault(path, key, line.strip(), f"this is no header; expected {_EXPECTED}")
    return None


def _chosen(path: Path, names: Sequence[str], component: str | None) -> str:
    """The column asked for."""
    known = ", ".join(f"'{name}'" for name in names)
    if component is None:
        if len(names) == 1:
            return names[0]
        expected = f"the file holds {len(names)} components, choose one by component: {known}"
        raise InputError([Fault(path, "component", None, expected)])
    for name in names:
        if same_name(name, component):
            return name
    expected = f"no such component; the file holds {known}"
    raise InputError([Fault(path, "component", component, expected)])


def _row(
    path: Path, line_number: int, line: str, names: Sequence[str], faults: list[Fault]
) -> list[float] | None:
    """Read one sample; None, with the faults noted, when it is none."""
    key = f"line {line_number}"
    cells = [cell.strip() for cell in line.split(",")]
    if len(cells) != len(names):
        expected = f"expected {len(names)} cells as in the header, got {len(cells)}"
        faults.append(Fault(path, key, line.strip(), expected))
        return None
    values = []
    for name, cell in zip(names, cells, strict=True):
        value = number(cell)
        if value is None:
            expected = f"expected a finite number as the {name}, without unit"
            faults.append(Fault(path, key, cell, expected))
        else:
            values.append(value)
    return values if len(values) == len(names) else None


def _time_faults(path: Path, lines: list[int], time: FloatArray) -> list[Fault]:
    """Find the samples whose time is not the one that a uniform step would give."""
    faults = []
    steps = np.diff(time)
    forward = steps[steps > 0.0]
    usual = float(np.median(forward)) if forward.size else 0.0
    if usual > 0.0 and abs(time[0]) > _STEP_TOLERANCE * usual:
        expected = "expected the first sample at time 0: shift the times of the record"
        faults.append(Fault(path, f"line {lines[0]}", f"{time[0]:.9g} s", expected))
    for i, step in enumerate(steps.tolist(), start=1):
        key, value = f"line {lines[i]}", f"{time[i]:.9g} s"
        if step <= 0.0:
            expected = f"expected times that ascend; the line before has {time[i - 1]:.9g} s"
            faults.append(Fault(path, key, value, expected))
        elif abs(step - usual) > _STEP_TOLERANCE * usual:
            expected = (
                f"expected a uniform time step, {usual:.9g} s as between most samples (with"
                f" enough digits); this step is {step:.9g} s"
            )
            faults.append(Fault(path, key, value, expected))
    return faults
