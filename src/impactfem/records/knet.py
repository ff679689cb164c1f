"""Accelerograms in the ASCII format of K-NET and KiK-net, the Japanese networks of NIED."""

import math
import re
from datetime import timedelta

import numpy as np

from impactfem.records.accelerogram import Accelerogram
from impactfem.records.file import Format, RecordFile, read_number
from impactfem.records.recording import Recording, orientation, read_time
from impactfem.system.log import LOGGER

HEADER_LINES = 17
TRIGGER_DELAY = 15.0  # s, that the recorders add to the Record Time

_KEY_WIDTH = 18
_KEYS = (
    "Origin Time",
    "Lat.",
    "Lon",
    "Depth",
    "Mag.",
    "Station Code",
    "Station Lat.",
    "Station Lon",
    "Station Height",
    "Record Time",
    "Sampling Freq",
    "Duration Time",
    "Dir.",
    "Scale Factor",
    "Max",
    "Last Correction",
    "Memo.",
)
_FREQUENCY = re.compile(r"(\d+(?:\.\d*)?)\s*Hz", re.IGNORECASE)
_SCALE = re.compile(r"(\d+(?:\.\d*)?)\s*\(gal\)\s*/\s*(\d+(?:\.\d*)?)", re.IGNORECASE)
_SAMPLE = re.compile(r"[+-]?\d{1,10}")
# Channels of a KiK-net station: 1 to 3 in the borehole, 4 to 6 at the surface.
_CHANNELS = {"1": "NS1", "2": "EW1", "3": "UD1", "4": "NS2", "5": "EW2", "6": "UD2"}


def read(file: RecordFile, component: str | None) -> Accelerogram:
    """Read an accelerogram from a K-NET or KiK-net ASCII file.

    17 lines of header, each with its key in the first 18 columns; then eight whole numbers a
    line. A number times the Scale Factor, "3920(gal)/6182761", is the acceleration in gal. The
    number of samples must be Sampling Freq times Duration Time.

    The numbers have the offset of the instrument, of some gal. The mean of the whole record is
    taken out here, as NIED does for the Max. Acc. of the header; the origin says so, and a peak
    that is not that Max. Acc. is warned of. The recorder delays its Record Time by 15 s, so that
    the first sample is 15 s earlier; the origin has that time (JST).

    Source: NIED, "About K-NET ASCII format" (kyoshin.bosai.go.jp/kyoshin/man/knetform_en.html).
    """
    lines = file.lines
    if len(lines) < HEADER_LINES:
        file.fail(None, None, f"the file ends after {len(lines)} lines; expected {file.expected}")
    for i, (line, key) in enumerate(zip(lines, _KEYS, strict=False), start=1):
        if not line.lower().startswith(key.lower()):
            expected = f"expected the line '{key} ...'; this should be {file.expected}"
            file.fail(i, line.strip(), expected)
    value = [line[_KEY_WIDTH:].strip() for line in lines[:HEADER_LINES]]
    frequency = _FREQUENCY.fullmatch(value[10])
    if frequency is None or not 0.0 < float(frequency[1]) < math.inf:
        file.note(11, value[10], "expected the sampling frequency with its unit, '100Hz'")
    scale = _SCALE.fullmatch(value[13])
    if scale is None or not all(0.0 < float(scale[k]) < math.inf for k in (1, 2)):
        file.note(14, value[13], "expected the scale factor in gal, '3920(gal)/6182761'")
    duration = read_number(value[11])
    if duration is None or duration <= 0.0:
        file.note(12, value[11], "expected the duration in seconds")
    samples = file.samples(
        range(HEADER_LINES, len(lines)),
        str.split,
        "expected whole numbers only",
        lambda cell: float(cell) if _SAMPLE.fullmatch(cell) else None,
    )
    counts = np.array(samples)
    if frequency and duration and not file.faults:
        announced = duration * float(frequency[1])
        if abs(counts.size - announced) >= 0.5 or counts.size < 2:
            expected = (
                f"{duration:g} s at {frequency[1]} Hz are {announced:g} samples, the file has"
                f" {counts.size}"
            )
            file.note(12, value[11], expected)
    if file.faults or frequency is None or scale is None:
        raise file.error()
    direction = value[12]
    # "N-S" may be requested as "NS", too; "4" of a KiK-net station as "NS2".
    names = (_CHANNELS.get(direction, direction), direction, direction.replace("-", ""))
    file.check_component(component, names)
    gal = counts * (float(scale[1]) / float(scale[2]))
    offset = float(gal.mean())
    acceleration = gal - offset
    file.compare_peak(float(np.abs(acceleration).max()), value[14], "gal", rounding=5e-4)
    origin = f"record {file.path.name}: {value[5]} {names[0]}"
    local, start = read_time(value[9]), read_time(f"{value[9]} JST")  # where the header has it
    if local is not None and start is not None:
        delay = timedelta(seconds=TRIGGER_DELAY)
        start -= delay
        origin += f", first sample {local - delay} JST"
    origin += f"; mean of {offset:.4g} gal taken out"
    LOGGER.info("%s: mean of %.4g gal taken out, the offset of the instrument", file.path, offset)
    sensors = {"1": "in the borehole", "2": "at the surface"}
    recording = Recording(
        start=start,
        event=value[0],
        station=value[5],
        sensor=sensors.get(names[0][-1:], ""),
        component=names[0],
        orientation=orientation(names[0]),
    )
    step = 1.0 / float(frequency[1])
    return Accelerogram(step, 0.01 * acceleration, file.path.stem, origin, recording=recording)


FORMAT = Format(
    name="knet",
    expected="a K-NET record: 17 lines from 'Origin Time' to 'Memo.', then the samples as whole"
    " numbers",
    endings=tuple(f"{way}{sensor}" for way in ("ns", "ew", "ud") for sensor in ("", "1", "2")),
    sign=re.compile(r"Origin Time\s"),
    read=read,
)
