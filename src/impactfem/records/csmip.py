"""Accelerograms in the CSMIP volume 2 format: the V2 files of CESMD."""

import math
import re

from impactfem.records.accelerogram import Accelerogram
from impactfem.records.file import (
    ACCELERATION_UNITS,
    LONGEST,
    Channel,
    Format,
    RecordFile,
    plain_unit,
    read_channel,
    read_number,
)
from impactfem.records.recording import Orientation, Recording, orientation, read_time
from impactfem.system.log import LOGGER

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
    r"(?:in\s+|\(units:\s*)([^()]*?)[.)]*\s*(?:\(\s*\d*\s*[EFG]([1-9]\d?)\.\d+\s*\).*)?$",
    re.IGNORECASE,
)
_PEAK = re.compile(r"Peak\s+acceleration\s*=\s*(\S+)\s*cm/s", re.IGNORECASE)
_STEP = 61  # of the real header, from 1 [s]: with more digits than the line of the samples
_AZIMUTH, _UPRIGHT = 27, (500, 600)  # of the integer header, from 1 [degree]; its up and down
_INTEGER_LINE, _INTEGER_WIDTH, _INTEGERS = 25, 5, 16  # from 0; columns of a number, numbers a line
_STATION = re.compile(r"Station No\.?\s*(\S+)", re.IGNORECASE)
_START = re.compile(r"(?:Start time:|Rcrd of|Record of)(.*)", re.IGNORECASE)
_ORIGIN = re.compile(r"Origin:\s*(\d[^)]*?)\s*(?:\)|$)", re.IGNORECASE)
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
        # The step of the real header has eight columns of 10 a line; 0 where it is not given.
        row, column = divmod(_STEP - 1, 8)
        exact = read_number(lines[begin - REAL_LINES + row][10 * column : 10 * (column + 1)])
        if step is None or step <= 0.0:
            file.note(begin + 1, match[3], "expected a time step in seconds")
        elif exact is not None and exact > 0.0:
            digits = len(match[3].rstrip(".").partition(".")[2])
            if abs(exact - step) <= 0.5001 * 10.0**-digits:
                step = exact
            else:
                text = "warning: %s: the samples have a time step of %s s, the header has %g s"
                LOGGER.warning(text, file.path, match[3], exact)
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
                recording=_recording(lines[start:begin], named[2] if named else ""),
                peak=(read_number(peak[1]) or math.nan) if peak else math.nan,
            )
        )
        start = end + 1
    return read_channel(file, channels, component)


def _recording(header: list[str], name: str) -> Recording:
    """The event, station, sensor and component of a channel."""
    text = [line[:LONGEST] for line in header[:_INTEGER_LINE]]
    station, event, location = (
        next((m[1] for m in map(pattern.search, text) if m), "")
        for pattern in (_STATION, _ORIGIN, _LOCATION)
    )
    times = (m[1] for m in map(_START.search, (text[4], text[2], text[8])) if m)
    row, column = divmod(_AZIMUTH - 1, _INTEGERS)
    place = slice(_INTEGER_WIDTH * column, _INTEGER_WIDTH * (column + 1))
    azimuth = read_number(header[_INTEGER_LINE + row][place])
    of_code = Orientation(True) if azimuth in _UPRIGHT else None
    if of_code is None and azimuth is not None and azimuth > 0.0:
        of_code = orientation(f"{azimuth:g}")
    return Recording(
        start=next(filter(None, map(read_time, times)), None),
        event=event,
        station=station or text[6][:40].strip(),
        sensor=location,
        component=name,
        orientation=orientation(name) or of_code,
    )


FORMAT = Format(
    name="csmip",
    expected="a CSMIP V2 record: 'Corrected accelerogram', 45 lines of header, then 'n points of"
    " accel data equally spaced at .. sec, in cm/sec2. (8f10.6)' and the samples",
    endings=(),
    sign=_HEAD,
    read=read,
)
