"""How many threads a process may use."""

from __future__ import annotations

import os


def threads() -> int:
    """OMP_NUM_THREADS where it is set to a number, else the processors of this process."""
    asked = os.environ.get("OMP_NUM_THREADS", "")
    return max(1, int(asked)) if asked.isdigit() else len(os.sched_getaffinity(0))
