"""Accelerograms in the AT2 format of the PEER ground motion database."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from impactfem.motion.accelerogram import Accelerogram
from impactfem.motion.record_text import (
    ACCELERATION_UNITS,
    check_component,
    input_error,
    number,
    plain_unit,
    read_lines,
)
from impactfem.system.errors import Fault, InputError

_EXPECTED = (
    "a PEER AT2 record: two lines of title, 'ACCELERATION TIME SERIES IN UNITS OF G',"
    " 'NPTS= ..., DT= ... SEC', then the samples"
)
_FLOAT = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_UNITS = re.compile(r"units?\s+of\s+(.*?)[\s.,;]*(?:filter\s+points?\b.*)?$", re.IGNORECASE)
_NAMED = re.compile(r"npts\s*=\s*(\d{1,9})\s*,?\s*dt\s*=\s*" + f"({_FLOAT})", re.IGNORECASE)
_BARE = re.compile(r"\s*(\d{1,9})\s+" + rf"({_FLOAT})\s*,?\s*npts\s*,\s*dt\b", re.IGNORECASE)
_SAMPLE = re.compile(rf"\s*({_FLOAT})(?=\s|[+-]|$)")


def read_at2(path: Path | str, component: str | None = None) -> Accelerogram:
    """Read an accelerogram from a PEER AT2 file.

    Four lines of header: the third names the unit ("UNITS OF G", in older files with the corners
    of a filter behind it: "FILTER POINTS: HP=0.1 Hz LP=46.0 Hz"), the fourth the number of samples
    and the step ("NPTS=  4000, DT=   .0050 SEC", or in older files "4000 0.0050 NPTS, DT"). Then
    the samples, any number a line. In a full column of 15 characters a negative sample touches the
    one before it ("-.1234E-02-.5678E-03"): a sign begins a new sample, too.

    Args:
        path: The file.
        component: The file holds one and does not name it: must be None.

    Returns:
        The accelerogram in m/s2, named after the file; the title is in its origin.

    Raises:
        InputError: With every fault of the file (the first 20 and a count), each with its line.
    """
    path = Path(path)
    lines = read_lines(path, _EXPECTED)
    if len(lines) < 5:
        raise InputError([Fault(path, "", None, f"the file ends early; expected {_EXPECTED}")])
    faults: list[Fault] = []
    unit = _UNITS.search(lines[2])
    factor = ACCELERATION_UNITS.get(plain_unit(unit[1])) if unit else None
    if factor is None:
        expected = (
            "expected 'ACCELERATION TIME SERIES IN UNITS OF G' (or another unit of acceleration)"
        )
        faults.append(Fault(path, "line 3", lines[2].strip(), expected))
    size = _NAMED.search(lines[3]) or _BARE.match(lines[3])
    if size is None:
        expected = "expected the number of samples and the step, 'NPTS=  4000, DT=  .0050 SEC'"
        faults.append(Fault(path, "line 4", lines[3].strip(), expected))
    elif not (float(size[2]) > 0.0 and math.isfinite(float(size[2])) and int(size[1]) >= 2):
        expected = "expected at least 2 samples and a positive time step"
        faults.append(Fault(path, "line 4", lines[3].strip(), expected))
        size = None
    samples: list[float] = []
    broken = False
    for i, line in enumerate(lines[4:], start=5):
        broken = not _samples(path, i, line, samples, faults) or broken
    if size is not None and not broken and len(samples) != int(size[1]):
        expected = f"the header announces {size[1]} samples, the file has {len(samples)}"
        faults.append(Fault(path, "line 4", lines[3].strip(), expected))
    if faults or size is None or factor is None:
        raise input_error(path, faults)
    check_component(path, component, ())
    title = " ".join(f"{lines[0]} {lines[1]}".split())
    origin = f"record {path.name}: {title}" if title else f"record {path.name}"
    acceleration = np.array(samples) * factor
    return Accelerogram(float(size[2]), acceleration, path.stem, origin)


def _samples(
    path: Path, line_number: int, line: str, samples: list[float], faults: list[Fault]
) -> bool:
    """Append the samples of a line; False, with a fault noted, when the line is broken."""
    position = 0
    text = line.rstrip()
    while position < len(text):
        match = _SAMPLE.match(text, position)
        value = number(match[1]) if match else None
        if match is None or value is None:
            rest = text[position:].split()
            expected = "expected finite numbers only"
            faults.append(Fault(path, f"line {line_number}", rest[0], expected))
            return False
        samples.append(value)
        position = match.end()
    return True
