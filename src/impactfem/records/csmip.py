"""Accelerograms in the CSMIP volume 2 format: the V2 files of CESMD."""

import re

from impactfem.records.accelerogram import Accelerogram
from impactfem.records.file import (
    ACCELERATION_UNITS,
    Channel,
    Format,
    RecordFile,
    plain_unit,
    read_channel,
    read_number,
)

HEADER_LINES = 45  # 25 of text, 7 of integers, 13 of real numbers

_HEAD = re.compile(r"\s*Corrected\s+accelerogram", re.IGNORECASE)
_CHANNEL = re.compile(r"Chan\s+(\d+)\s*:\s*(.*?)\s*(?:from\b.*)?$", re.IGNORECASE)
_DATA = re.compile(
    r"\s*(\d{1,9})\s+points\s+of\s+(\w+)\s+data\s+equally\s+spaced\s+at\s+(\S+)\s*sec,?\s*in\s+"
    r"([^()]*?)\.?\s*\(\s*\d*\s*[EFG]([1-9]\d?)\.\d+\s*\)",
    re.IGNORECASE,
)
_STOP = re.compile(r"\s*(\d+\s+points\s+of\s+\w+\s+data\s+equally\s+spaced|/&)", re.IGNORECASE)
_END = re.compile(r"\s*/&")


def read(file: RecordFile, component: str | None) -> Accelerogram:
    """Read an accelerogram from a CSMIP V2 file.

    A file holds one channel after another: 25 lines of text, 7 of integers, 13 of real numbers;
    then acceleration, velocity and displacement, each announced by a line with number of samples,
    time step, unit and columns; then a line that begins with "/&". Velocity and displacement are
    passed over. The layout was taken from files of CESMD among the test data of the USGS program
    gmprocess.

    The component is the number ("1") or orientation ("90 Deg") of a channel.
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
            line, text = (begin + 1, lines[begin].strip()) if begin < len(lines) else (None, None)
            file.fail(line, text, f"the header ends otherwise; {file.expected}")
        step, factor = read_number(match[3]), ACCELERATION_UNITS.get(plain_unit(match[4]))
        if step is None or step <= 0.0:
            file.note(begin + 1, match[3], "expected a time step in seconds")
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
        channels.append(
            Channel(
                number=named[1] if named else "1",
                orientation=named[2] if named else "",
                code="",
                title=" ".join(f"{lines[start + 6]} {lines[start + 8]}".split()),
                announced=begin + 1,
                count=int(match[1]),
                time_step=step,
                factor=factor,
                width=int(match[5]),
                stop=stop + 1,
            )
        )
        start = end + 1
    return read_channel(file, channels, component)


FORMAT = Format(
    name="csmip",
    expected="a CSMIP V2 record: 'Corrected accelerogram', 45 lines of header, then 'n points of"
    " accel data equally spaced at .. sec, in cm/sec2. (8f10.6)' and the samples",
    endings=(),
    sign=_HEAD,
    read=read,
)
