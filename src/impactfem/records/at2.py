"""Accelerograms in the AT2 format of the PEER ground motion database."""

import math
import re

import numpy as np

from impactfem.records.accelerogram import Accelerogram
from impactfem.records.file import ACCELERATION_UNITS, NUMBER, Format, RecordFile, plain_unit

_UNITS = re.compile(
    r"(?:units?\s+of|acceleration\s+in(?!\s+unit))\s+(.*?)[\s.,;]*(?:filter\s+points?\b.*)?$",
    re.IGNORECASE,
)
_NAMED = re.compile(
    rf"npts\s*=\s*(\d{{1,9}})\s*,?\s*dt\s*=\s*({NUMBER})\s*(?![\s\d.e]|ms|mil)", re.IGNORECASE
)
_BARE = re.compile(r"\s*(\d{1,9})\s+" + rf"({NUMBER})\s*,?\s*npts\s*,\s*dt\b", re.IGNORECASE)
_TOUCHING = re.compile(r"([\d.])([+-])")


def read(file: RecordFile, component: str | None) -> Accelerogram:
    """Read an accelerogram from a PEER AT2 file.

    Four lines of header: the third names the unit ("UNITS OF G" or "ACCELERATION IN G", in older
    files with the corners of a filter behind it: "FILTER POINTS: HP=0.1 Hz LP=46.0 Hz"), the fourth
    the number of samples and the step ("NPTS=  4000, DT=   .0050 SEC", or in older files
    "4000 0.0050 NPTS, DT"). Then the samples, any number a line. In a full column of 15 characters
    a negative sample touches the one before it ("-.1234E-02-.5678E-03"): a sign begins a new
    sample, too.

    The file holds one component and does not name it; its title is in the origin.
    """
    lines = file.lines
    if len(lines) < 5:
        file.fail(None, None, f"the file ends early; expected {file.expected}")
    unit = _UNITS.search(lines[2])
    factor = ACCELERATION_UNITS.get(plain_unit(unit[1])) if unit else None
    if factor is None:
        expected = (
            "expected 'ACCELERATION TIME SERIES IN UNITS OF G' (or another unit of acceleration)"
        )
        file.note(3, lines[2].strip(), expected)
    size = _NAMED.search(lines[3]) or _BARE.match(lines[3])
    if size is None:
        expected = "expected the number of samples and the step, 'NPTS=  4000, DT=  .0050 SEC'"
        file.note(4, lines[3].strip(), expected)
    elif not (float(size[2]) > 0.0 and math.isfinite(float(size[2])) and int(size[1]) >= 2):
        file.note(4, lines[3].strip(), "expected at least 2 samples and a positive time step")
        size = None
    n_header = len(file.faults)
    samples = file.samples(
        range(4, len(lines)),
        lambda line: _TOUCHING.sub(r"\1 \2", line).split(),
        "expected finite numbers only",
    )
    # A broken line hides samples: their number says nothing then.
    if size is not None and len(file.faults) == n_header and len(samples) != int(size[1]):
        expected = f"the header announces {size[1]} samples, the file has {len(samples)}"
        file.note(4, lines[3].strip(), expected)
    if file.faults or size is None or factor is None:
        raise file.error()
    file.check_component(component, ())
    title = " ".join(f"{lines[0]} {lines[1]}".split())
    origin = f"record {file.path.name}: {title}" if title else f"record {file.path.name}"
    return Accelerogram(float(size[2]), np.array(samples) * factor, file.path.stem, origin)


FORMAT = Format(
    name="at2",
    expected="a PEER AT2 record: two lines of title, 'ACCELERATION TIME SERIES IN UNITS OF G',"
    " 'NPTS= ..., DT= ... SEC', then the samples",
    endings=("at2",),
    sign=re.compile(r".*units?\s+of\s+|\s*npts\s*=", re.IGNORECASE),
    read=read,
)
