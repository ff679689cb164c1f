"""Accelerograms, and the formats of the files that they come in.

A further format is a file in this folder with its `FORMAT`, and its line in `FORMATS`; the case
file takes the names from here.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from impactfem.records import at2, cosmos, csmip, csv, esm, knet
from impactfem.records.accelerogram import Accelerogram
from impactfem.records.file import Format, RecordFile
from impactfem.system.errors import Fault, ImpactfemError, InputError

FORMATS: dict[str, Format] = {
    module.FORMAT.name: module.FORMAT for module in (csv, at2, esm, cosmos, csmip, knet)
}
# Endings of several formats: the content decides. CESMD gives V2 to two formats.
AMBIGUOUS_ENDINGS = ("asc", "txt", "v2")
FORMAT_OF_ENDING = {
    ending: name for name, record_format in FORMATS.items() for ending in record_format.endings
}
if TYPE_CHECKING:
    RecordFormat = str
else:
    RecordFormat = Literal[tuple(FORMATS)]

_SIGN_LINES = 4


def read_record(
    path: Path | str, fmt: str | None = None, component: str | None = None
) -> Accelerogram:
    """Read an accelerogram in m/s2, named after the file.

    Args:
        path: The file.
        fmt: Name of the format, one of `FORMATS`. None goes by the file's ending, whatever its
            case, and by its first lines where the ending has several formats.
        component: Which component of a file that holds several: the name of a column, the number,
            orientation or code of a channel.

    Raises:
        InputError: The format is not known, or the file is at fault: the first 20 faults and the
            number of the others, each with its line.
    """
    path = Path(path)
    ending = path.suffix.lower().lstrip(".")
    what = f"the format '{fmt}'"
    if fmt is None and ending in AMBIGUOUS_ENDINGS:
        what = f"the record format of the ending '{path.suffix}'"
        lines = [line for line in RecordFile(path, "a record").lines if not line.startswith("#")]
        # CSV is last: a title in brackets looks like the header of a column.
        for name, one in reversed(FORMATS.items()):
            if fmt is None and any(one.sign.match(line) for line in lines[:_SIGN_LINES]):
                fmt = name
    elif fmt is None:
        fmt, what = FORMAT_OF_ENDING.get(ending), f"the ending '{path.suffix}'"
    if fmt not in FORMATS:
        known = " or ".join(f"'{name}'" for name in FORMATS)
        expected = (
            f'{what} is not known; type format = {known}; for "csv" the first line is a header, '
            "time [s],acceleration [g]"
        )
        raise InputError([Fault(path, "", None, expected)])
    record_format = FORMATS[fmt]
    try:
        # A sample near the largest float overflows when its unit is converted: a fault, below.
        with np.errstate(over="ignore", invalid="ignore"):
            return record_format.read(RecordFile(path, record_format.expected), component)
    except InputError:
        raise
    except ImpactfemError as error:
        raise InputError([Fault(path, "", None, str(error))]) from error
