"""Accelerograms in the ASCII format of ESM and ITACA, the European and Italian databases."""

import math
import re

import numpy as np

from impactfem.records.accelerogram import Accelerogram
from impactfem.records.file import ACCELERATION_UNITS, Format, RecordFile, plain_unit, read_number
from impactfem.records.recording import Recording, orientation, read_time

_KEY = re.compile(r"([A-Z][A-Z0-9_/^]*):(.*)")
_FIRST = "EVENT_NAME:"
_MOST_BEFORE = 20  # lines before the first key


def read(file: RecordFile, component: str | None) -> Accelerogram:
    """Read an accelerogram from an ASCII file of ESM or ITACA (header format DYNA 1.0 or 1.2).

    Lines ``KEY: value`` come first, 55 or 64. Of these, NDATA is the number of samples,
    SAMPLING_INTERVAL_S the step, UNITS their unit (cm/s^2), DATA_TYPE must be ACCELERATION, and
    STREAM names the component ("HNN"). Then one sample a line. A peak or duration that is not the
    one the header has (PGA_CM/S^2, DURATION_S) is warned of. The layout was taken from files of ESM
    among the test data of the USGS program gmprocess. Lines before EVENT_NAME are left out: files
    of AFAD of 2023 have six there that begin with "AAD_".

    Event, station and processing are in the origin.
    """
    lines = file.lines
    while lines and not lines[-1].strip():
        lines.pop()
    header: dict[str, tuple[int, str]] = {}
    before = (i for i, line in enumerate(lines[:_MOST_BEFORE]) if line.startswith(_FIRST))
    begin = next(before, 0)
    for i, line in enumerate(lines[begin:], start=begin + 1):
        match = _KEY.fullmatch(line.strip())
        if match is None and read_number(line) is not None:
            break
        if match is None:
            file.fail(i, line.strip(), f"the header ends early; expected {file.expected}")
        header[match[1]] = (i, match[2].strip())
    if begin + len(header) == len(lines):
        file.fail(None, None, f"the file ends after {len(lines)} lines; expected {file.expected}")
    text = {key: value for key, (_, value) in header.items()}
    step = _positive(file, header, "SAMPLING_INTERVAL_S", "the time step in seconds")
    count = _positive(file, header, "NDATA", "the number of samples")
    kind_line, kind = header.get("DATA_TYPE", (0, "ACCELERATION"))
    if kind.upper() != "ACCELERATION":
        file.note(kind_line, kind, "expected DATA_TYPE: ACCELERATION, not another quantity")
    unit_line, unit = header.get("UNITS", (None, None))
    factor = None if unit is None else ACCELERATION_UNITS.get(plain_unit(unit))
    if unit is None:
        file.note(None, None, "the header has no UNITS; expected cm/s^2")
    elif factor is None:
        file.note(unit_line, unit, "expected a unit of acceleration as UNITS, cm/s^2")
    behind = range(max((i for i, _ in header.values()), default=0), len(lines))
    samples = file.samples(behind, lambda line: [line.strip()], "expected one finite number")
    if count is not None and not file.faults and (len(samples) != count or count < 2):
        expected = f"the header announces {count:g} samples, the file has {len(samples)}"
        file.note(header["NDATA"][0], f"NDATA: {count:g}", expected)
    if file.faults or step is None or factor is None:
        raise file.error()
    file.check_component(component, (text["STREAM"],) if text.get("STREAM") else ())
    acceleration = np.array(samples) * factor
    peak = 100.0 * float(np.abs(acceleration).max())
    file.compare_peak(peak, text.get("PGA_CM/S^2", ""), "cm/s2")
    said = read_number(text.get("DURATION_S", ""))
    file.compare_duration(step, len(samples), math.nan if said is None else said)
    where = ".".join(text.get(key, "") for key in ("NETWORK", "STATION_CODE", "STREAM"))
    event = f"{text.get('EVENT_NAME', '')} {text.get('EVENT_DATE_YYYYMMDD', '')}".strip()
    details = [event, text.get("BASELINE_CORRECTION", "").lower()]
    origin = ", ".join([f"record {file.path.name}: {where}", *filter(None, details)])
    return Accelerogram(step, acceleration, file.path.stem, origin, recording=_recording(text))


def _recording(text: dict[str, str]) -> Recording:
    """The header's event, station, sensor and component."""
    date, time = (text.get(f"EVENT_{key}", "") for key in ("DATE_YYYYMMDD", "TIME_HHMMSS"))
    origin = read_time(f"{date} {time}")  # in files of AFAD in several spellings
    event = (text.get("EVENT_NAME", ""), f"{origin:%Y-%m-%d %H:%M:%S}" if origin else date)
    # At a station, instruments have codes ("HN"), places and depths.
    stream = text.get("STREAM", "")
    places = (stream[:-1], text.get("LOCATION", ""), text.get("SENSOR_DEPTH_M", ""))
    station = (text.get("NETWORK", ""), text.get("STATION_CODE", ""))
    return Recording(
        start=read_time(text.get("DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS", "")),
        event=" ".join(filter(None, event)),
        station=".".join(filter(None, station)),
        sensor=" ".join(filter(None, places)),
        component=stream,
        orientation=orientation(stream),
    )


def _positive(
    file: RecordFile, header: dict[str, tuple[int, str]], key: str, what: str
) -> float | None:
    if key not in header:
        file.note(None, None, f"the header has no {key}; expected {what}")
        return None
    line, text = header[key]
    value = read_number(text)
    if value is None or value <= 0.0:
        file.note(line, text, f"expected {what} as {key}, positive")
        return None
    return value


FORMAT = Format(
    name="esm",
    expected="an ESM or ITACA record: lines 'KEY: value', from EVENT_NAME to USER5, then one"
    " sample a line",
    endings=(),
    sign=re.compile(rf"{_FIRST}|AAD_"),
    read=read,
)
