"""Reading an accelerogram from a file of any format known."""

from __future__ import annotations

from pathlib import Path

from impactfem.errors import Fault, InputError
from impactfem.motion.accelerogram import Accelerogram
from impactfem.motion.at2_record import read_at2
from impactfem.motion.csv_record import read_csv

_READERS = {"csv": read_csv, "at2": read_at2}


def read_record(path: Path | str, fmt: str | None = None) -> Accelerogram:
    """Read an accelerogram.

    Args:
        path: The file.
        fmt: "csv" (:func:`impactfem.motion.csv_record.read_csv`) or "at2"
            (:func:`impactfem.motion.at2_record.read_at2`); None goes by the file's ending,
            whatever its case.

    Returns:
        The accelerogram in m/s2.

    Raises:
        InputError: The format is not known, or the file is at fault.
    """
    path = Path(path)
    name = path.suffix.lower().lstrip(".") if fmt is None else fmt
    reader = _READERS.get(name)
    if reader is None:
        found = f"the ending '{path.suffix}'" if fmt is None else f"the format '{fmt}'"
        known = " or ".join(f"'{known}'" for known in _READERS)
        raise InputError([Fault(path, "", None, f"{found} is not known; expected {known}")])
    return reader(path)
