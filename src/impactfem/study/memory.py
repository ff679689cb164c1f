"""The largest memory that a stage needed."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def forget_peak() -> None:
    """Begin to measure anew; where the system does not allow it, the peak stays that of all."""
    with contextlib.suppress(OSError):
        RESET.write_text("5")


def peak_memory() -> float | None:
    """Largest resident memory of this process since `forget_peak` [byte]; None if not known."""
    try:
        found = re.search(r"^VmHWM:\s*(\d+) kB$", STATUS.read_text(), re.MULTILINE)
    except OSError:
        return None
    return None if found is None else 1024.0 * float(found[1])
