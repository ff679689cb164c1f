"""Accelerograms in the CSMIP volume 2 format: the V2 files of CESMD."""

import math
import re
from dataclasses import replace

from impactfem.records.accelerogram import Accelerogram
from impactfem.records.file import (
    ACCELERATION_UNITS,
    Channel,
    Format,
    RecordFile,
    fixed_columns,
    plain_unit,
    read_channel,
    read_number,
)

HEADER_LINES = 45  # 25 of text, 7 of integers, 13 of real numbers
REAL_LINES = 13

_HEAD = re.compile(r"\s*Corrected\s+accelerogram", re.IGNORECASE)
_CHANNEL = re.compile(
    r"Chan\s+(\d+)\s*:\s*(.*?)\s*(?:(?:from\b|\(Sta\b|Location\b).*)?$", re.IGNORECASE
)
_OF_STATION = re.compile(r"\(\s*Sta\s+Chn:\s*(\d+)", re.IGNORECASE)
_LOCATION = re.compile(r"Location:\s*(.*?)\s*$", re.IGNORECASE)
_DATA = re.compile(
    r"\s*(\d{1,9})\s+points\s+of\s+(\w+)\s+data\s+equally\s+spaced\s+at\s+(\S+)\s*sec[.,]*\s*"
    r"(?:in\s+|\(units:\s*)([^()]*?)[.)]*\s*(?:\(\s*\d*\s*[EFG]([1-9]\d?)\.\d+\s*\))?\s*$",
    re.IGNORECASE,
)
_PEAK = re.compile(r"Peak\s+acceleration\s*=\s*(\S+)\s*cm/s", re.IGNORECASE)
_STEP = 61  # of the real header, from 1 [s]: with more digits than the line of the samples
_STOP = re.compile(r"\s*(\d+\s+points\s+of\s+\w+\s+data\s+equally\s+spaced|/&)", re.IGNORECASE)
_END = re.compile(r"\s*/&")


def read(file: RecordFile, component: str | None) -> Accelerogram:
    """Read an accelerogram from a CSMIP V2 file.

    A file holds one channel after another: 25 lines of text, 7 of integers, 13 of real numbers;
    then acceleration, velocity and displacement, each announced by a line with number of samples,
    time step, unit and columns, 8F10 where it names none, as before 1990; then a line that begins
    with "/&". Velocity and displacement are passed over. A peak that is not the header's is warned
    of. The layout was taken from files of CESMD among the test data of the USGS program gmprocess.

    The component is the number ("1") or orientation ("90 Deg") of a channel: the number at the
    station, where the header has it beside that of the recorder, and the place in the file where
    numbers repeat.
    """
    lines, channels, start = file.lines, list[Channel](), 0
    while start < len(lines):
        if not lines[start].strip():
            start += 1
            continue
        if not _HEAD.match(lines[start]):
            file.fail(start + 1, lines[start].strip(), f"expected {file.expected}")
        begin = start + HEADER_LINES
        match = _DATA.match(lines[begin]) if begin < len(lines) else None
        if match is None or not match[2].lower().startswith("acc"):
            if begin >= len(lines):
                file.fail(None, None, f"the file ends early; {file.expected}")
            file.fail(
                begin + 1, lines[begin].strip(), f"the header ends otherwise; {file.expected}"
            )
        step, factor = read_number(match[3]), ACCELERATION_UNITS.get(plain_unit(match[4]))
        if step is None or step <= 0.0:
            file.note(begin + 1, match[3], "expected a time step in seconds")
        elif (exact := _exact_step(lines[start:begin])) is not None:
            if abs(exact - step) > 1e-3:
                expected = f"the header has a time step of {exact:g} s; expected the same"
                file.note(begin + 1, match[3], expected)
            step = exact
        if factor is None:
            file.note(begin + 1, match[4], "expected a unit of acceleration, cm/sec2")
        # Velocities, or the end of the channel, stop the accelerations.
        behind = range(begin + 1, len(lines))
        stop = end = next((i for i in behind if _STOP.match(lines[i])), len(lines))
        while end < len(lines) and not (_END.match(lines[end]) or _HEAD.match(lines[end])):
            end += 1
        if end == len(lines) or not _END.match(lines[end]):
            expected = (
                f"the channel that begins on line {start + 1} does not end; expected '/& ...'"
            )
            file.note(end + 1 if end < len(lines) else None, None, expected)
        if file.faults or step is None or factor is None:
            raise file.error()
        named = next((m for m in map(_CHANNEL.search, (lines[start], lines[start + 7])) if m), None)
        of_station, peak = _OF_STATION.search(lines[start + 7]), _PEAK.search(lines[start + 17])
        number = of_station or named
        location = _LOCATION.search(lines[start + 7])
        title = f"{lines[start + 6]} {lines[start + 8]}"
        channels.append(
            Channel(
                number=number[1] if number else "1",
                orientation=named[2] if named else "",
                code="",
                title=" ".join((f"{location[1]}, {title}" if location else title).split()),
                announced=begin + 1,
                count=int(match[1]),
                time_step=step,
                factor=factor,
                width=int(match[5] or 10),
                stop=stop + 1,
                peak=(read_number(peak[1]) or math.nan) if peak else math.nan,
            )
        )
        start = end + 1
    if len({channel.number for channel in channels}) < len(channels):
        channels = [replace(one, number=str(k)) for k, one in enumerate(channels, start=1)]
    return read_channel(file, channels, component)


def _exact_step(header: list[str]) -> float | None:
    """The time step of the real header [s]; None where it has none."""
    reals = [cell for line in header[-REAL_LINES:] for cell in fixed_columns(line, 10)]
    value = read_number(reals[_STEP - 1]) if len(reals) >= _STEP else None
    return value if value is not None and value > 0.0 else None


FORMAT = Format(
    name="csmip",
    expected="a CSMIP V2 record: 'Corrected accelerogram', 45 lines of header, then 'n points of"
    " accel data equally spaced at .. sec, in cm/sec2. (8f10.6)' and the samples",
    endings=(),
    sign=_HEAD,
    read=read,
)
