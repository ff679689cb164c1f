"""Texts of record files in the layouts of the agencies, for tests of the readers.

The layouts are those of files that ESM, CESMD and NIED publish, seen among the test data of the
USGS program gmprocess and on NIED's page on the K-NET format; the content is made up.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

_UNSPECIFIED = -999


def at2_text(samples: npt.ArrayLike, step: float) -> str:
    """A PEER AT2 file of samples in g: 5 a line in columns of 15 characters."""
    g = np.asarray(samples, dtype=np.float64)
    header = f"""\
PEER NGA STRONG MOTION DATABASE RECORD
Nowhere-01, 1/2/2003, Made Up Station, 090
ACCELERATION TIME SERIES IN UNITS OF G
NPTS= {g.size:6d}, DT= {step:8.5f} SEC"""
    return "\n".join([header, *_columns([f"{value:15.7E}" for value in g], 5), ""])


_ESM_KEYS = """\
EVENT_NAME EVENT_ID EVENT_DATE_YYYYMMDD EVENT_TIME_HHMMSS EVENT_LATITUDE_DEGREE
EVENT_LONGITUDE_DEGREE EVENT_DEPTH_KM HYPOCENTER_REFERENCE MAGNITUDE_W MAGNITUDE_W_REFERENCE
MAGNITUDE_L MAGNITUDE_L_REFERENCE FOCAL_MECHANISM NETWORK STATION_CODE STATION_NAME
STATION_LATITUDE_DEGREE STATION_LONGITUDE_DEGREE STATION_ELEVATION_M LOCATION SENSOR_DEPTH_M
VS30_M/S SITE_CLASSIFICATION_EC8 MORPHOLOGIC_CLASSIFICATION EPICENTRAL_DISTANCE_KM
EARTHQUAKE_BACKAZIMUTH_DEGREE DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS
DATE_TIME_FIRST_SAMPLE_PRECISION SAMPLING_INTERVAL_S NDATA DURATION_S STREAM UNITS INSTRUMENT
INSTRUMENT_ANALOG/DIGITAL INSTRUMENTAL_FREQUENCY_HZ INSTRUMENTAL_DAMPING FULL_SCALE_G
N_BIT_DIGITAL_CONVERTER PGA_CM/S^2 TIME_PGA_S BASELINE_CORRECTION FILTER_TYPE FILTER_ORDER
LOW_CUT_FREQUENCY_HZ HIGH_CUT_FREQUENCY_HZ LATE/NORMAL_TRIGGERED DATABASE_VERSION HEADER_FORMAT
DATA_TYPE PROCESSING DATA_TIMESTAMP_YYYYMMDD_HHMMSS DATA_LICENSE DATA_CITATION DATA_CREATOR
ORIGINAL_DATA_MEDIATOR_CITATION ORIGINAL_DATA_MEDIATOR ORIGINAL_DATA_CREATOR_CITATION
ORIGINAL_DATA_CREATOR USER1 USER2 USER3 USER4 USER5
"""


def esm_text(samples: npt.ArrayLike, step: float, stream: str = "HNN") -> str:
    """An ESM file of samples in cm/s2: 64 lines of header, then one sample a line."""
    a = np.asarray(samples, dtype=np.float64)
    peak = int(np.argmax(np.abs(a)))
    given = f"""\
EVENT_NAME: NOWHERE
EVENT_DATE_YYYYMMDD: 20030102
EVENT_TIME_HHMMSS: 030405
NETWORK: XX
STATION_CODE: MADE
STATION_NAME: Made Up, Nowhere
DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS: 20030102_030410.250
SAMPLING_INTERVAL_S: {step:.6f}
NDATA: {a.size}
DURATION_S: {a.size * step:.3f}
STREAM: {stream}
UNITS: cm/s^2
INSTRUMENT: sensor = Unknown [Unknown] | digitizer = Unknown [Unknown]
PGA_CM/S^2: {a[peak]:.6f}
TIME_PGA_S: {peak * step:.6f}
BASELINE_CORRECTION: BASELINE REMOVED
DATABASE_VERSION: DYNA 1.0
HEADER_FORMAT: DYNA 1.2
DATA_TYPE: ACCELERATION"""
    known = dict(line.split(": ", 1) for line in given.splitlines())
    header = [f"{key}: {known.get(key, '')}" for key in _ESM_KEYS.split()]
    return "\n".join([*header, *(f"{value:.6f}" for value in a), ""])


def cosmos_text(
    channels: Sequence[tuple[str, str, npt.ArrayLike]],
    step: float,
    *,
    unit: str = "cm/sec2",
    unit_code: int = 4,
    columns: str = "(8F10.5)",
    integrals: bool = True,
) -> str:
    """A COSMOS 1.20 file.

    Args:
        channels: Orientation, code and samples of each channel.
        step: Time step [s].
        unit: Of the samples.
        unit_code: Its number in COSMOS table 2.
        columns: "(8F10.5)" or "(1E15.6)".
        integrals: Whether a velocity and a displacement follow each acceleration, the first with a
            header of its own, the second without.
    """
    lines: list[str] = []
    kinds = [("acceleration", 1.0, f"{unit}({unit_code:02d})", unit_code)]
    if integrals:
        kinds += [("velocity", 3.0, "cm/sec(05)", 5), ("displacement", 2.0, "cm(06)", 0)]
    for number, (orientation, code, samples) in enumerate(channels, start=1):
        a = np.asarray(samples, dtype=np.float64)
        for kind, factor, units, code_of_unit in kinds:
            if code_of_unit:
                lines += _cosmos_header(kind, number, orientation, code, step, code_of_unit)
            seconds = f"approx {a.size * step:4.0f} secs"
            lines.append(f"{a.size:8d} {kind} pts, {seconds}, units={units},Format={columns}")
            if columns == "(8F10.5)":
                lines += _columns([_fixed(factor * value) for value in a], 8)
            else:
                lines += [f"{factor * value:15.6e}" for value in a]
            lines.append(f"End-of-data for Chan{number:3d} {kind}")
    return "\n".join([*lines, ""])


def _cosmos_header(
    what: str, number: int, orientation: str, code: str, step: float, unit_code: int
) -> list[str]:
    integers = [_UNSPECIFIED] * 100
    integers[:4] = [2, 1, unit_code, 120]
    integers[49] = number
    reals = [float(_UNSPECIFIED)] * 100
    reals[33] = step
    return [
        f"""\
Corrected {what}    (Format v01.20 with 13 text lines) Src: made up
Record of Nowhere Earthquake of Thu Jan  2, 2003 03:04 UTC
Hypocenter: 61.34640 -149.95520 H= 46km Mw=7.0
Origin: 2003/01/02 03:04:05    UTC
Statn No: 37-000011 Code:XX-MADE     Made Up Station
Coords: 60.9677 -144.6051  Site geology:
Recorder: (see cmnt)      ( 3 Chns of   3 at Sta) Sensor: (see comment)
Rcrd start time: 2003/01/02 03:04:10.250 UTC (Q=5) RcrdId: (see comment)
Sta Chan {number:3d}: {orientation} (Rcrdr Chan {number:2d}) Location:
Raw record length = 210.000 sec, Uncor max =    101730, at  82.680 sec.
Processed:2003-03-03 05:46:55 GMT, UNKN, Max =   -6.852 cm/sec2 at   76.215 sec
Record filtered below  0.03 Hz (periods over 33.33 secs), and above 20.0 Hz
Values used when parameter or data value is unknown/unspecified:   -999, -999.00
 100 Integer-header values follow on  10 lines, Format= (10I8)""",
        *_columns([f"{value:8d}" for value in integers], 10),
        " 100 Real-header values follow on  20 lines, Format= (5F15.6)",
        *_columns([f"{value:15.6f}" for value in reals], 5),
        '   2 Comment line(s) follow, each starting with a "|":',
        f"|<SCNL>MADE.{code}.XX.--    <AUTH> 2003/02/01 21:38:15.000",
        "|<PROCESS> MANUAL",
    ]


def csmip_text(channels: Sequence[tuple[str, npt.ArrayLike]], step: float) -> str:
    """A CSMIP V2 file of samples in cm/s2.

    Args:
        channels: Orientation and samples of each channel.
        step: Time step [s].
    """
    lines = []
    seconds = f"{step:.4f}".rstrip("0").removeprefix("0")
    for number, (orientation, samples) in enumerate(channels, start=1):
        a = np.asarray(samples, dtype=np.float64)
        where = f"Chan {number:2d}: {orientation}"
        blank = "\n"
        lines += [
            f"""\
Corrected accelerogram   00000.XX.MADE.--.HN   {where}     {"from":<7}
Uncorrected Accelerogram Data             Processed: 01/03/03, XX
Rcrd of Thu Jan  2, 2003 03:04:05.0 UTC{3 * blank}
Made Up Station
{where}
Rcrd of Thu Jan  2, 2003 03:04:05.0 UTC{6 * blank}
 {a.size:5d} points of instrument- and baseline-corrected accel, veloc and displ
At equally-spaced intervals of    {seconds}  sec.{8 * blank}""",
            *_columns([f"{_UNSPECIFIED:5d}"] * 100, 16),
            *_columns(["-999.00000"] * 100, 8),
        ]
        for kind, unit, factor in (
            ("accel", "cm/sec2", 1.0),
            ("veloc", "cm/sec", 3.0),
            ("displ", "cm", 2.0),
        ):
            layout = f"equally spaced at  {seconds} sec, in {unit}. (8f10.5)"
            lines.append(f" {a.size:5d} points of {kind} data {layout}")
            lines += _columns([_fixed(factor * value) for value in a], 8)
        lines.append(f"/&  ----------  End of data for channel {number:2d}  ----------")
    return "\n".join([*lines, ""])


def knet_text(
    counts: Sequence[int],
    frequency: int,
    *,
    direction: str = "N-S",
    scale: str = "3920(gal)/6182761",
) -> str:
    """A K-NET file: 17 lines of header, then eight whole numbers a line in columns of 9.

    Args:
        counts: The samples, whole seconds of them.
        frequency: Sampling frequency [Hz].
        direction: Of the component.
        scale: Gal over counts.
    """
    numerator, denominator = scale.replace("(gal)", "").split("/")
    a = np.asarray(counts, dtype=np.float64)
    peak = np.abs(a - a.mean()).max() * float(numerator) / float(denominator)
    header = f"""\
Origin Time       2003/01/02 03:04:05
Lat.              37.798
Long.             142.200
Depth. (km)       36
Mag.              5.7
Station Code      MADE01
Station Lat.      38.7262
Station Long.     141.5109
Station Height(m) 79
Record Time       2003/01/02 03:04:45
Sampling Freq(Hz) {frequency}Hz
Duration Time(s)  {len(counts) // frequency}
Dir.              {direction}
Scale Factor      {scale}
Max. Acc. (gal)   {peak:.3f}
Last Correction   2003/01/02 03:04:30
"""
    samples = [f"{row} " for row in _columns([f"{c:9d}" for c in counts], 8)]
    return "\n".join([f"{header}{'Memo.':<18}", *samples, ""])


def _columns(cells: Sequence[str], per_line: int) -> list[str]:
    return ["".join(cells[i : i + per_line]) for i in range(0, len(cells), per_line)]


def _fixed(value: float) -> str:
    """A number as the agencies print it in F10.5: without the zero before the point."""
    text = f"{abs(value):.5f}".removeprefix("0")
    return (f"-{text}" if f"{value:.5f}".startswith("-") else text).rjust(10)
