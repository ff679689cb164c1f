"""Accelerograms in the AT2 format of the PEER ground motion database, and in its older layouts."""

import math
import re

import numpy as np

from impactfem.records.accelerogram import Accelerogram
from impactfem.records.file import (
    ACCELERATION_UNITS,
    LONGEST,
    NUMBER,
    Format,
    RecordFile,
    plain_unit,
)
from impactfem.records.recording import Orientation, Recording, orientation

HEADER_LINES = 4
_MOST_HEADER = 20

# A unit ends where the next statement begins: "UNITS OF G; PGA = ...", "G. FILTER POINTS: ...".
_UNITS = re.compile(
    r"(?:units?\s+of|acceleration\s+in(?!\s+unit))\s+(.*?)[\s.,;:]*"
    r"(?:[;,(]\s*\S.*|\b(?:filter|pg[avd]|peak)\b.*)?$",
    re.IGNORECASE,
)
_IN_BRACKETS = re.compile(
    r"\bacc[a-z]*\b[^(]*\(\s*(?:in\s+|units?\s*(?:of|:)\s*)*([^()]*?)\s*\)", re.I
)
_TIMES_UNIT = re.compile(rf"({NUMBER})\s*\*?\s*([a-z].*)", re.IGNORECASE)
_DT = rf"dt\s*[=:]\s*({NUMBER})\s*(?![\s\d.e]|ms|mil)"
_SIZES = (
    re.compile(rf"npts\s*[=:]\s*(\d{{1,9}})\s*,?\s*{_DT}", re.IGNORECASE),
    re.compile(rf"\s*(\d{{1,9}})\s+({NUMBER})\s*,?\s*npts\s*,\s*dt\b", re.IGNORECASE),
    re.compile(
        rf"npts\s*,\s*dt\s*[=:]\s*(\d{{1,9}})\s*,?\s*({NUMBER})(?![\d.e]|\s*m)", re.IGNORECASE
    ),
)
_NPTS = re.compile(r"npts\s*[=:]\s*(\d{1,9})(?![\d.])", re.IGNORECASE)
_STEP = re.compile(rf"\b{_DT}", re.IGNORECASE)
_SAMPLE = re.compile(NUMBER)
_TOUCHING = re.compile(r"([\d.])([+-])")
# "Nowhere-01, 1/2/2003, Made Up Station, 090", "NOWHERE 10/15/79 2319, MADE UP, 230 (USGS 1)".
_TITLE = re.compile(
    r"\s*(?P<event>.+?),?\s+(?P<date>\d{1,2}/\d{1,2}/\d{2,4})(?:\s+[\d:]+)?\s*,\s*"
    r"(?P<station>.+?)\s*(?:,\s*(?P<component>[^,(]*?)\s*(?:\(.*)?)?$"
)
# How names of files end; those of horizontal components with their azimuth.
_UPRIGHT = re.compile(r"(up|ud|dwn|ver|vrt|[-_.][vz]|[bcehls][ghln]z)$", re.IGNORECASE)
_DIGITS = re.compile(r"\d{3}$")


def read(file: RecordFile, component: str | None) -> Accelerogram:
    """Read an accelerogram from a PEER AT2 file.

    Four lines of header: the third names the unit ("UNITS OF G" or "ACCELERATION IN G", in older
    files with the corners of a filter or peaks behind it: "FILTER POINTS: HP=0.1 Hz LP=46.0 Hz",
    "PGA= .2 G"), the fourth the number of samples and the step ("NPTS=  4000, DT=   .0050 SEC", or
    in older files "4000 0.0050 NPTS, DT"). Older files have up to 20 lines, with the unit in
    brackets ("(G'S)", "(9.81 M/S2)") and the number and the step on lines of their own; the last
    ones before the samples count. Then the samples, any number a line. In a full column of 15
    characters a negative sample touches the one before it ("-.1234E-02-.5678E-03"): a sign begins
    a new sample, too.

    The file holds one component; its second line, or the name of the file, says which.
    """
    lines = file.lines
    if len(lines) < HEADER_LINES + 1:
        file.fail(None, None, f"the file ends early; expected {file.expected}")
    head = [line[:LONGEST] for line in lines[:_MOST_HEADER]]
    count, step, at = _announced(head)
    # Words may follow, as the end of an old header.
    rest = range(at, len(lines))
    n_header = next((i for i in rest if any(map(_SAMPLE.match, lines[i].split()))), at)
    factor = _factor(file, head[:n_header])
    if not (count and step):
        expected = "expected the number of samples and the step, 'NPTS=  4000, DT=  .0050 SEC'"
        file.note(at, lines[at - 1].strip(), expected)
    elif not (0.0 < float(step) < math.inf and int(count) >= 2):
        file.note(at, lines[at - 1].strip(), "expected at least 2 samples and a positive time step")
    samples = file.samples(
        range(n_header, len(lines)),
        lambda line: _TOUCHING.sub(r"\1 \2", line).split(),
        "expected finite numbers only",
    )
    # A broken line hides samples: their number says nothing then.
    if not file.faults and len(samples) != int(count):
        expected = f"the header announces {int(count)} samples, the file has {len(samples)}"
        file.note(at, lines[at - 1].strip(), expected)
    if file.faults or factor is None:
        raise file.error()
    title = " ".join(f"{lines[0]} {lines[1]}".split())
    origin = f"record {file.path.name}: {title}" if title else f"record {file.path.name}"
    recording = _recording(file.path.stem, head[:n_header])
    file.check_component(component, tuple(filter(None, (recording.component,))))
    a = np.array(samples) * factor
    return Accelerogram(float(step), a, file.path.stem, origin, recording=recording)


def _announced(lines: list[str]) -> tuple[str, str, int]:
    """The number of samples and the step, as text, empty where missing; lines up to the last."""
    count, step = "", ""
    at = HEADER_LINES
    for i, line in enumerate(lines, start=1):
        both = next((m for m in (one.search(line) for one in _SIZES) if m), None)
        npts, dt = (both, both) if both else (_NPTS.search(line), _STEP.search(line))
        count = npts[1] if npts else count
        step = dt[2 if both else 1] if dt else step
        at = i if npts or dt else at
    return count, step, at


def _factor(file: RecordFile, header: list[str]) -> float | None:
    """Read the unit of the samples, as a factor to m/s2; None with a fault."""
    units: dict[int, str] = {}
    for i, line in enumerate(header):
        unit = _UNITS.search(line) or _IN_BRACKETS.search(line)
        if unit:
            units[i] = plain_unit(unit[1]).replace("'", "")
    factors: dict[int, float] = {}
    for i, name in units.items():
        times = _TIMES_UNIT.fullmatch(name)  # "9.81 m/s2" is g
        unit_name = times[2] if times else name
        factor = ACCELERATION_UNITS.get("g" if unit_name == "gs" else unit_name)
        if factor is not None:
            factors[i] = factor * (float(times[1]) if times else 1.0)
    if len(set(factors.values())) == 1:
        return next(iter(factors.values()))
    last = max(factors or units, default=2)
    expected = "expected 'ACCELERATION TIME SERIES IN UNITS OF G' (or another unit of acceleration)"
    if factors:
        expected = "another line of the header has another unit; expected one unit of acceleration"
    file.note(last + 1, file.lines[last].strip(), expected)
    return None


def _recording(name: str, header: list[str]) -> Recording:
    """The event, station and component, by the title and by the name of the file."""
    title = next((m for m in map(_TITLE.match, header[1:3]) if m), None)
    last = title["component"] or "" if title else header[1].rpartition(",")[2].strip()
    direction, digits = orientation(last), _DIGITS.search(name)
    if _UPRIGHT.search(name):
        last, direction = name, Orientation(vertical=True)
    elif direction is None and digits:
        # They are an azimuth where PEER gave the name.
        of_peer = name.lower().startswith("rsn")
        last, direction = name, orientation(digits[0]) if of_peer else Orientation(vertical=False)
    return Recording(
        event=f"{title['event']} {title['date']}" if title else "",
        station=title["station"] if title else "",
        component=last if direction else "",
        orientation=direction,
    )


FORMAT = Format(
    name="at2",
    expected="a PEER AT2 record: two lines of title, 'ACCELERATION TIME SERIES IN UNITS OF G',"
    " 'NPTS= ..., DT= ... SEC', then the samples",
    endings=("at2",),
    sign=re.compile(r".*units?\s+of\s+|\s*npts\s*=", re.IGNORECASE),
    read=read,
)
