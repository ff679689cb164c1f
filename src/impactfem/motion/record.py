"""Reading an accelerogram from a file of any format known."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from impactfem.case.record_format import AMBIGUOUS_ENDINGS, FORMAT_OF_ENDING
from impactfem.motion.accelerogram import Accelerogram
from impactfem.motion.at2_record import read_at2
from impactfem.motion.cosmos_record import read_cosmos
from impactfem.motion.csmip_record import read_csmip
from impactfem.motion.csv_record import read_csv
from impactfem.motion.esm_record import read_esm
from impactfem.motion.knet_record import read_knet
from impactfem.motion.record_text import read_lines
from impactfem.system.errors import Fault, ImpactfemError, InputError

_READERS: dict[str, Callable[[Path, str | None], Accelerogram]] = {
    "csv": read_csv,
    "at2": read_at2,
    "esm": read_esm,
    "cosmos": read_cosmos,
    "csmip": read_csmip,
    "knet": read_knet,
}
# What a file of each format has on one of its first lines, and on no line of the others.
_SIGNS = {
    "esm": re.compile(r"EVENT_NAME:"),
    "knet": re.compile(r"Origin Time\s"),
    "cosmos": re.compile(r"\w+\s+\w+.*\(Format\s+v", re.IGNORECASE),
    "csmip": re.compile(r"\s*Corrected\s+accelerogram", re.IGNORECASE),
    "at2": re.compile(r".*units?\s+of\s+|\s*npts\s*=", re.IGNORECASE),
    "csv": re.compile(r"[^#]*\[[^\]]*\]\s*,"),
}
_SIGN_LINES = 4


def read_record(
    path: Path | str, fmt: str | None = None, component: str | None = None
) -> Accelerogram:
    """Read an accelerogram.

    Args:
        path: The file.
        fmt: "csv" (:func:`impactfem.motion.csv_record.read_csv`), "at2"
            (:func:`impactfem.motion.at2_record.read_at2`), "esm"
            (:func:`impactfem.motion.esm_record.read_esm`), "cosmos"
            (:func:`impactfem.motion.cosmos_record.read_cosmos`), "csmip"
            (:func:`impactfem.motion.csmip_record.read_csmip`) or "knet"
            (:func:`impactfem.motion.knet_record.read_knet`). None goes by the file's ending,
            whatever its case, and by its first lines where the ending has several formats.
        component: Which component of a file that holds several: the name of a column, the number,
            orientation or code of a channel.

    Returns:
        The accelerogram in m/s2.

    Raises:
        InputError: The format is not known, or the file is at fault.
    """
    path = Path(path)
    name = _format_of(path) if fmt is None else fmt
    reader = _READERS.get(name)
    if reader is None:
        raise _unknown(path, f"the format '{name}'")
    try:
        # A sample near the largest float overflows when its unit is converted: a fault, below.
        with np.errstate(over="ignore", invalid="ignore"):
            return reader(path, component)
    except InputError:
        raise
    except ImpactfemError as error:
        raise InputError([Fault(path, "", None, str(error))]) from error


def _format_of(path: Path) -> str:
    """The format of a file, by its ending and, where that leaves a choice, by its content."""
    ending = path.suffix.lower().lstrip(".")
    if ending in FORMAT_OF_ENDING:
        return FORMAT_OF_ENDING[ending]
    if ending not in AMBIGUOUS_ENDINGS:
        raise _unknown(path, f"the ending '{path.suffix}'")
    lines = [line for line in read_lines(path, "a record") if not line.startswith("#")]
    for name, sign in _SIGNS.items():
        if any(sign.match(line) for line in lines[:_SIGN_LINES]):
            return name
    raise _unknown(path, f"what the file with the ending '{path.suffix}' holds")


def _unknown(path: Path, found: str) -> InputError:
    known = " or ".join(f"'{known}'" for known in _READERS)
    expected = f"{found} is not known; expected the format {known}"
    return InputError([Fault(path, "", None, expected)])
