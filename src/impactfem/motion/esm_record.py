"""Accelerograms in the ASCII format of ESM and ITACA, the European and Italian databases."""

from __future__ import annotations

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
from impactfem.system.errors import Fault
from impactfem.system.log import LOGGER

HEADER_LINES = 64  # of the header format DYNA 1.2

_EXPECTED = (
    "an ESM or ITACA record: 64 lines 'KEY: value', from EVENT_NAME to USER5, then one sample"
    " a line"
)
_KEY = re.compile(r"([A-Z][A-Z0-9_/^]*):(.*)")
_PEAK_TOLERANCE = 0.01


def read_esm(path: Path | str, component: str | None = None) -> Accelerogram:
    """Read an accelerogram from an ASCII file of ESM or ITACA (header format DYNA 1.2).

    64 lines ``KEY: value`` come first. Of these, NDATA is the number of samples,
    SAMPLING_INTERVAL_S the step, UNITS their unit (cm/s^2), DATA_TYPE must be ACCELERATION, and
    STREAM names the component ("HNN"). Then one sample a line. A peak that is not the one the
    header has (PGA_CM/S^2) is warned of. The layout was taken from files of ESM among the test
    data of the USGS program gmprocess.

    Args:
        path: The file.
        component: The file holds one; another one than its STREAM is refused.

    Returns:
        The accelerogram in m/s2, named after the file; event, station and processing are in its
        origin.

    Raises:
        InputError: With every fault of the file (the first 20 and a count), each with its line.
    """
    path = Path(path)
    lines = read_lines(path, _EXPECTED)
    while lines and not lines[-1].strip():
        lines.pop()
    header: dict[str, tuple[int, str]] = {}
    for i, line in enumerate(lines[:HEADER_LINES], start=1):
        match = _KEY.fullmatch(line.strip())
        if match is None:
            expected = f"the header ends early; expected {_EXPECTED}"
            raise input_error(path, [Fault(path, f"line {i}", line.strip(), expected)])
        header[match[1]] = (i, match[2].strip())
    if len(lines) < HEADER_LINES:
        fault = Fault(
            path, "", None, f"the file ends after {len(lines)} lines; expected {_EXPECTED}"
        )
        raise input_error(path, [fault])
    faults: list[Fault] = []
    step = _positive(path, header, "SAMPLING_INTERVAL_S", "the time step in seconds", faults)
    count = _positive(path, header, "NDATA", "the number of samples", faults)
    factor = _factor(path, header, faults)
    samples = []
    for i, line in enumerate(lines[HEADER_LINES:], start=HEADER_LINES + 1):
        value = number(line.strip())
        if value is None:
            faults.append(Fault(path, f"line {i}", line.strip(), "expected one finite number"))
        else:
            samples.append(value)
    if count is not None and not faults and (len(samples) != count or count < 2):
        expected = f"the header announces {count:g} samples, the file has {len(samples)}"
        faults.append(Fault(path, f"line {header['NDATA'][0]}", f"NDATA: {count:g}", expected))
    if faults or step is None or factor is None:
        raise input_error(path, faults)
    stream = _text(header, "STREAM")
    check_component(path, component, (stream,) if stream else ())
    record = Accelerogram(step, np.array(samples) * factor, path.stem, _origin(path, header))
    _compare_peak(path, header, float(np.abs(record.acceleration).max()))
    return record


def _text(header: dict[str, tuple[int, str]], key: str) -> str:
    return header.get(key, (0, ""))[1]


def _positive(
    path: Path, header: dict[str, tuple[int, str]], key: str, what: str, faults: list[Fault]
) -> float | None:
    if key not in header:
        faults.append(Fault(path, "", None, f"the header has no {key}; expected {what}"))
        return None
    line, text = header[key]
    value = number(text)
    if value is None or value <= 0.0:
        faults.append(Fault(path, f"line {line}", text, f"expected {what} as {key}, positive"))
        return None
    return value


def _factor(path: Path, header: dict[str, tuple[int, str]], faults: list[Fault]) -> float | None:
    """Factor from the unit of the samples to m/s2."""
    kind_line, kind = header.get("DATA_TYPE", (0, "ACCELERATION"))
    if kind.upper() != "ACCELERATION":
        expected = "expected DATA_TYPE: ACCELERATION, not another quantity"
        faults.append(Fault(path, f"line {kind_line}", kind, expected))
    if "UNITS" not in header:
        faults.append(Fault(path, "", None, "the header has no UNITS; expected cm/s^2"))
        return None
    line, unit = header["UNITS"]
    factor = ACCELERATION_UNITS.get(plain_unit(unit))
    if factor is None:
        expected = "expected a unit of acceleration as UNITS, cm/s^2"
        faults.append(Fault(path, f"line {line}", unit, expected))
    return factor


def _origin(path: Path, header: dict[str, tuple[int, str]]) -> str:
    where = ".".join(_text(header, key) for key in ("NETWORK", "STATION_CODE", "STREAM"))
    what = f"{_text(header, 'EVENT_NAME')} {_text(header, 'EVENT_DATE_YYYYMMDD')}".strip()
    said = ", ".join(text for text in (what, _text(header, "BASELINE_CORRECTION").lower()) if text)
    return f"record {path.name}: {where}" + (f", {said}" if said else "")


def _compare_peak(path: Path, header: dict[str, tuple[int, str]], peak: float) -> None:
    """Warn of a peak that is not the header's: samples or units may have been changed."""
    announced = number(_text(header, "PGA_CM/S^2"))
    if announced and abs(peak - abs(announced) * 0.01) > _PEAK_TOLERANCE * peak:
        LOGGER.warning(
            "warning: %s: the largest sample is %.6g cm/s2, the header has %.6g cm/s2",
            path,
            100.0 * peak,
            announced,
        )
