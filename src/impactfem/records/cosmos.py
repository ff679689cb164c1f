"""Accelerograms in the COSMOS strong-motion format, version 1.20: the V2c files of CESMD."""

import math
import re
from dataclasses import replace
from typing import NoReturn

from impactfem.records.accelerogram import Accelerogram
from impactfem.records.file import (
    ACCELERATION_UNITS,
    LONGEST,
    Channel,
    Format,
    RecordFile,
    fixed_columns,
    plain_unit,
    read_channel,
    read_number,
)
from impactfem.records.recording import Orientation, Recording, orientation, read_time

_HEAD = re.compile(
    r"(\w+)\s+\w+.*\(Format\s+v\S+\s+with\s+(\d{1,4})\s+text\s+lines\)", re.IGNORECASE
)
_FORMAT = r"Format\s*=\s*\(\s*(?:\d*P,?)?(\d*)[A-Z]([1-9]\d?)(?:\.\d+)?[A-Z]?\s*\)"
_VALUES = re.compile(
    r"\s*(\d{1,9})\s+(Integer|Real)-header\s+values\s+follow\s+on\s+(\d{1,6})\s+lines?,?\s*"
    + _FORMAT,
    re.IGNORECASE,
)
_COMMENTS = re.compile(r"\s*(\d{1,6})\s+Comment\s+line\(?s?\)?\s+follow", re.IGNORECASE)
_DATA = re.compile(
    r"\s*(\d{1,9})\s+([A-Za-z][\w. ]*?)\s+(?:pts|points)\b.*?units\s*=\s*([^,(]*?)[\s.]*"
    r"(?:\(\s*(\d{1,4})\s*\))?\s*,?\s*" + _FORMAT,
    re.IGNORECASE,
)
_SECONDS = re.compile(r"approx\s*(\d+\.?\d*)\s*sec", re.IGNORECASE)
_END = re.compile(r"\s*(?:End[- ]of[- ]data(?:\s+for)?(?:\s+chan)?\s*(\S*)|/&)", re.IGNORECASE)
_STATION_CHANNEL = re.compile(r"Sta\s+Cha\w*:?\s*([\w?]+)\s*:\s*(.*?)\s*(?:\(|Location|$)")
_CODE = re.compile(r"<?SCNL[>:]\s*[^.\s]*\.(\w+)\.")

# Of the real header, from 1: of the samples the interval [ms], the duration [s] and the peak in
# their unit. The interval of the raw record [s] is theirs only where it was not changed.
_INTERVAL, _DURATION, _PEAK, _RAW_INTERVAL = 62, 63, 64, 34
_DATA_UNITS = 3  # of the integer header, from 1
_AZIMUTH = 54  # of the integer header, from 1: degrees to 360, codes above
_YEAR, _MONTH, _DAY, _HOUR, _MINUTE = 40, 42, 43, 44, 45  # of the first sample, integer header
_SECOND = 30  # of the real header
# COSMOS table of orientations: up, down, vertical; radial, transverse, along a structure, H1, H2.
_UPRIGHT, _LEVEL = (400, 401, 402), (500, 501, 600, 601, 700, 701)
_STATION = re.compile(r"Statn No:\s*(\S+)(?:\s+Code:\s*(\S+))?")
_START, _ORIGIN = re.compile(r"Rcrd start time:(.*)"), re.compile(r"Origin:\s*(\d.*?)\s*$")
_LOCATION = re.compile(r"Location:\s*(?!\(see)(.*?)\s*$", re.IGNORECASE)
_UNSPECIFIED = -999
# COSMOS table 2, as far as they are accelerations; to m/s2 by the unit's name.
_UNIT_CODES = {2: "g", 4: "cm/s2", 7: "in/s2", 10: "gal", 11: "mg"}


def read(file: RecordFile, component: str | None) -> Accelerogram:
    """Read an accelerogram from a COSMOS file.

    A file holds one channel after another. Each begins with lines of text, the first of which
    gives their number; then come blocks of integers, of real numbers (the 62nd is the interval of
    the samples in ms; where it is unspecified, the 34th is that of the raw record in s) and of
    comments, each announced by a line with its size and columns. Then

        42000 acceleration pts, approx  210 secs, units=cm/sec2(04),Format=(1E15.6)

    announces the samples, and "End-of-data" (or "/&") ends them. Velocities and displacements,
    with a header of their own or following their acceleration, are passed over. An uncorrected
    acceleration in a unit of acceleration is read, too, and named so in the origin; counts are
    refused. Source: COSMOS strong motion data format 1.20 (strongmotioncenter.org), seen in files
    of CESMD among the test data of the USGS program gmprocess.

    The component is the number ("1"), orientation ("90 deg") or code ("HNE") of a channel.
    """
    lines = file.lines
    channels: list[Channel] = []
    header: tuple[Channel, int] | None = None
    i = 0
    while i < len(lines):
        if not lines[i].strip():
            i += 1
            continue
        if _HEAD.match(lines[i]):
            channel, unit, i = _header(file, i)
            header = channel, unit
        if header is None:
            _fail(file, i, f"expected {file.expected}")
        channel, quantity, i = _block(file, i, *header)
        if _is_acceleration(quantity):
            channels.append(channel)
    return read_channel(file, channels, component)


def _is_acceleration(quantity: str) -> bool:
    """Whether a quantity, as "acceleration" or "raw accel.", is one."""
    return "acc" in quantity.lower()


def _fail(file: RecordFile, i: int, expected: str) -> NoReturn:
    """Raise the fault of a line, counted from 0."""
    if not any(line.strip() for line in file.lines[i:]):
        file.fail(None, None, f"the file ends early; {expected}")
    file.fail(i + 1, file.lines[i].strip(), expected)


def _header(file: RecordFile, start: int) -> tuple[Channel, int, int]:
    """Read the header blocks of a channel, which begin at a line."""
    # Gives the channel without its samples, the code of its unit, and the line behind.
    lines = file.lines
    head = _HEAD.match(lines[start])
    n_text = int(head[2]) if head else 0
    text = lines[start : start + n_text]
    integers, i = _values(file, start + n_text, "Integer")
    reals, i = _values(file, i, "Real")
    comments = _COMMENTS.match(lines[i]) if i < len(lines) else None
    if comments is None:
        _fail(file, i, "expected '  n Comment line(s) follow'")
    following = lines[i + 1 : i + 1 + int(comments[1])]
    station = next((m for m in map(_STATION_CHANNEL.search, text) if m), None)
    code = next((m for m in map(_CODE.search, following) if m), None)
    interval, duration, peak, raw = (
        next(iter(reals[k - 1 :]), float(_UNSPECIFIED))
        for k in (_INTERVAL, _DURATION, _PEAK, _RAW_INTERVAL)
    )
    step = 1e-3 * interval if interval > 0.0 else raw
    if not step > 0.0:
        expected = "expected the interval of the samples [ms] as real-header value 62"
        _fail(file, start + n_text, f"{expected}; where that is unspecified, [s] as value 34")
    status = (head[1] if head else "").lower()
    # The record of which event, and the station.
    title = ", ".join(" ".join(text[k].split()) for k in (1, 4) if k < n_text)
    channel = Channel(
        number=station[1] if station else "?",
        orientation=station[2] if station else "",
        code=code[1] if code else "",
        title=f"{status} acceleration, {title}".strip(", "),
        time_step=step,
        recording=_recording(
            [line[:LONGEST] for line in text],
            integers,
            reals,
            (station[2] if station else "", code[1] if code else ""),
        ),
        duration=duration if duration > 0.0 else math.nan,
        peak=math.nan if peak == _UNSPECIFIED else peak,
    )
    unit = round(next(iter(integers[_DATA_UNITS - 1 :]), _UNSPECIFIED))
    return channel, unit, i + 1 + int(comments[1])


def _recording(
    text: list[str], integers: list[float], reals: list[float], names: tuple[str, str]
) -> Recording:
    """The event, station, sensor and component of a channel, by its words and its code."""
    found = {
        name: next((m for m in map(pattern.search, text) if m), None)
        for name, pattern in (
            ("station", _STATION),
            ("start", _START),
            ("event", _ORIGIN),
            ("sensor", _LOCATION),
        )
    }
    of_header = [
        next(iter(integers[k - 1 :]), float(_UNSPECIFIED))
        for k in (_YEAR, _MONTH, _DAY, _HOUR, _MINUTE, _AZIMUTH)
    ]
    *date, azimuth = [int(value) for value in of_header]
    second = next(iter(reals[_SECOND - 1 :]), float(_UNSPECIFIED))
    # The numbers have more digits than the words.
    start = (
        read_time("{:04d}{:02d}{:02d} {:02d}:{:02d}:".format(*date) + f"{second:f}")
        if min(date) >= 0 and second >= 0.0
        else None
    )
    if start is None and found["start"]:
        start = read_time(found["start"][1])
    of_code = (
        Orientation(azimuth in _UPRIGHT)
        if azimuth in (*_UPRIGHT, *_LEVEL)
        else orientation(str(azimuth))
        if azimuth > 0
        else None
    )
    station = found["station"]
    return Recording(
        start=start,
        event=found["event"][1] if found["event"] else "",
        station=(station[2] or station[1]) if station else "",
        sensor=found["sensor"][1] if found["sensor"] else "",
        component=next(filter(None, names), ""),
        orientation=next(filter(None, map(orientation, names)), of_code),
    )


def _values(file: RecordFile, i: int, kind: str) -> tuple[list[float], int]:
    """Read a block of integers or real numbers; gives the line behind it."""
    lines = file.lines
    match = _VALUES.match(lines[i]) if i < len(lines) else None
    if match is None or match[2].lower() != kind.lower():
        expected = f"expected ' 100 {kind}-header values follow on  .. lines, Format= (..)'"
        _fail(file, i, expected)
    count, n_lines, width = int(match[1]), int(match[3]), int(match[5])
    values: list[float] = []
    for j in range(i + 1, i + 1 + n_lines):
        cells = fixed_columns(lines[j], width) if j < len(lines) else []
        numbers = [value for value in map(read_number, cells) if value is not None]
        if not cells or len(numbers) < len(cells):
            expected = f"expected {count} numbers of the {kind.lower()} header on {n_lines} lines"
            _fail(file, j, expected)
        values += numbers
    if len(values) != count:
        _fail(file, i, f"{count} numbers are announced, {len(values)} follow")
    return values, i + 1 + n_lines


def _block(file: RecordFile, i: int, header: Channel, unit: int) -> tuple[Channel, str, int]:
    """Find a block of samples; gives its channel, its quantity and the line behind its end."""
    lines = file.lines
    match = _DATA.match(lines[i]) if i < len(lines) else None
    if match is None:
        expected = "expected '  n acceleration pts, approx .. secs, units=cm/sec2,Format=(..)'"
        _fail(file, i, expected)
    stop = i + 1
    while stop < len(lines) and not (_END.match(lines[stop]) or _HEAD.match(lines[stop])):
        stop += 1
    end = _END.match(lines[stop]) if stop < len(lines) else None
    if end is None:
        announced = f"{match[1]} samples are announced on line {i + 1}"
        _fail(file, stop, f"{announced}; expected 'End-of-data' behind them")
    quantity, factor = match[2], None
    # Factor from the unit of the samples to m/s2; its name and codes must agree.
    codes = [int(match[4])] if match[4] else []
    codes += [unit] if unit != _UNSPECIFIED else []
    names = [plain_unit(match[3])] if match[3] else []
    names += [_UNIT_CODES.get(k, f"unit {k} of COSMOS table 2") for k in codes]
    factors = {ACCELERATION_UNITS.get(name) for name in names}
    if len(factors) == 1:
        factor = factors.pop()
    if factor is None and _is_acceleration(quantity):
        given = " and ".join(dict.fromkeys(names)) or "no unit"
        if "counts" in names:
            given += ": a raw record; take its V1c or V2c file"
        _fail(file, i, f"expected one unit of acceleration, got {given}")
    said = _SECONDS.search(lines[i])
    duration = header.duration if header.duration > 0.0 or not said else float(said[1])
    code = end[1] if end[1] and not end[1].isdigit() and end[1].isalnum() else ""
    channel = replace(
        header,
        code=header.code or ("" if code.lower().startswith(("acc", "vel", "dis")) else code),
        announced=i + 1,
        count=int(match[1]),
        factor=math.nan if factor is None else factor,
        duration=duration,
        width=int(match[6]),
        stop=stop + 1,
    )
    return channel, quantity, stop + 1


FORMAT = Format(
    name="cosmos",
    expected="a COSMOS record: 'Corrected acceleration (Format v01.20 with 13 text lines)', its"
    " header blocks, then the samples",
    endings=("v2c", "v1c"),
    sign=re.compile(r"\w+\s+\w+.*\(Format\s+v", re.IGNORECASE),
    read=read,
)
