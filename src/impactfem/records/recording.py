"""What the header of a record says of it: start, event, station, sensor and component."""

import re
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime, timedelta

_DATE = re.compile(r"(\d{4})[-/.]?(\d\d)[-/.]?(\d\d)|(\d{1,2})/\s?(\d{1,2})/\s?(\d{4}|\d\d)(?!\d)")
_NAMED_DATE = re.compile(r"([A-Z][a-z]{2})[a-z]*\.?\s+(\d{1,2}),?\s+(\d{4})")
_MONTHS = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"]
_TIME = re.compile(
    r"(\d{1,2}):(\d\d)(?::\s*(\d{0,2}(?:\.\d*)?))?|(?<!\d)(\d\d)(\d\d)(\d\d(?:\.\d*)?)"
)
_ZONE = re.compile(r"\s*(?:([A-Z]{3,4})\b|Z\b)")
# Hours ahead of UTC.
_ZONES = {"": 0, "UTC": 0, "GMT": 0, "JST": 9, "HST": -10, "AKST": -9, "AKDT": -8}
_ZONES |= {"PST": -8, "PDT": -7, "MST": -7, "MDT": -6, "CST": -6, "CDT": -5, "EST": -5, "EDT": -4}

_VERTICAL = re.compile(
    r"ud[12]?|du|updo?|updown|up|u|down|dn|dwn|v|z|ver|vrt|vert|vertical|[bcehls][ghln]z"
)
_AZIMUTHS = {"n": 0.0, "ns": 0.0, "north": 0.0, "northsouth": 0.0, "s": 180.0, "sn": 0.0}
_AZIMUTHS |= {"south": 180.0, "e": 90.0, "ew": 90.0, "we": 90.0, "east": 90.0, "eastwest": 90.0}
_AZIMUTHS |= {"w": 270.0, "west": 270.0}
_SEED = re.compile(r"[bcehls][ghln]([ne])")
_HORIZONTAL = re.compile(
    r"h[12]|[bcehls][ghln][12]|long|longitudinal|tran|transverse|radial|radl|tang|tangential"
)
_DEGREES = re.compile(r"\+?(\d{1,3})(?:\.0*)?\s*(?:deg\w*|°)?")
_QUADRANT = re.compile(r"([ns])\s*(\d{1,2})\s*([ew])")
_OF_KIKNET = re.compile(r"(ns|ew)[12]")


@dataclass(frozen=True)
class Orientation:
    """Direction of a component: vertical, or horizontal with an azimuth that may be unknown."""

    vertical: bool
    azimuth: float | None = None  #: of a horizontal one, from north through east [degree]


def orientation(name: str) -> Orientation | None:
    """Read a direction from the name of a component; None where it is none.

    Words for up and down, compass points, azimuths in degrees ("90 Deg", "N45E") and SEED codes
    ("HNZ") are known; of several words, the last one may be one of these, but no bare number.
    """
    words = re.findall(r"[a-z0-9.+°]+", name.lower())
    if not words:
        return None
    if words in (["l"], ["t"], ["r"]):  # longitudinal, transverse, radial
        return Orientation(False)
    degrees = _DEGREES.fullmatch(" ".join(words))
    if degrees and int(degrees[1]) <= 360:
        return Orientation(False, float(degrees[1]) % 360.0)
    for word in ("".join(words), words[-1]):
        quadrant, seed = _QUADRANT.fullmatch(word), _SEED.fullmatch(word)
        borehole = _OF_KIKNET.fullmatch(word)
        if _VERTICAL.fullmatch(word):
            return Orientation(True)
        if quadrant:
            angle = float(quadrant[2])
            angle = angle if quadrant[3] == "e" else -angle
            return Orientation(False, (angle if quadrant[1] == "n" else 180.0 - angle) % 360.0)
        azimuth = _AZIMUTHS.get(seed[1] if seed else borehole[1] if borehole else word)
        if azimuth is not None or _HORIZONTAL.fullmatch(word):
            return Orientation(False, azimuth)
    return None


def read_time(text: str) -> datetime | None:
    """Read a date with a time from a header, in UTC; None where it holds none, or another zone.

    As "20230206_011730.250", "2003/01/02 03:04:10.25 UTC", "2/13/12, 21:06:45.0 PST" and
    "Thu Jan  2, 2003 03:04:05.0 UTC"; without a zone it is UTC.
    """
    date, named = _DATE.search(text), _NAMED_DATE.search(text)
    found = date or named
    time = _TIME.search(text, found.end()) if found else None
    zone = _ZONE.match(text, time.end()) if time else None
    ahead = _ZONES.get((zone[1] or "") if zone else "")
    if found is None or time is None or ahead is None:
        return None
    with suppress(ValueError, OverflowError):  # no such day or time
        if date and date[1]:
            year, month, day = (int(date[k]) for k in (1, 2, 3))
        elif date:
            month, day, year = (int(date[k]) for k in (4, 5, 6))
            year += 0 if year > 99 else 1900 if year > 50 else 2000
        else:
            year, day = int(found[3]), int(found[2])
            month = _MONTHS.index(found[1]) + 1
        hour, minute, second = (time[k] or time[k + 3] or "0" for k in (1, 2, 3))
        moment = datetime(year, month, day, int(hour), int(minute))
        return moment + timedelta(seconds=float(f"0{second}"), hours=-ahead)
    return None


@dataclass(frozen=True)
class Recording:
    """Header of a record; what the file does not state is empty or None."""

    start: datetime | None = None  #: of the first sample, UTC
    event: str = ""  #: name or origin time
    station: str = ""
    sensor: str = ""  #: where it is at the station: "borehole", a code or a place
    component: str = ""  #: its name in the file
    orientation: Orientation | None = None
