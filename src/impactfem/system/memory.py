"""The memory of this process: what it took at most, what is left for it, what it gives back."""

from __future__ import annotations

import contextlib
import ctypes
import os
import re
from pathlib import Path

STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")
MACHINE = Path("/proc/meminfo")
GROUP, GROUPS = Path("/proc/self/cgroup"), Path("/sys/fs/cgroup")
DISK = "/var/tmp"
"""Where what memory cannot hold goes without TMPDIR: /tmp is memory on many systems."""


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


def give_back() -> None:
    """Return freed memory to the system: Open MPI tells the allocator to keep all of it.

    Elsewhere a second factor, a little larger, would not fit where the first one was.
    """
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


def available_memory() -> float:
    """Memory that this process and others of its job may still take [byte]; infinite if unknown."""
    return min(_of_machine(), _of_job())


def total_memory() -> float:
    """Memory that this process could take if nothing else ran [byte]; infinite if unknown."""
    return min(_of_machine("MemTotal:"), _of_job(whole=True))


def disk_folder() -> str:
    """The folder for files of what memory cannot hold."""
    return os.environ.get("TMPDIR", DISK)


def _of_machine(entry: str = "MemAvailable:") -> float:
    try:
        lines = MACHINE.read_text(encoding="utf-8").splitlines()
    except OSError:
        return float("inf")
    found = [line.split()[1] for line in lines if line.startswith(entry)]
    return 1024.0 * float(found[0]) if found else float("inf")


def _of_job(*, whole: bool = False) -> float:
    """What control groups (version 2) leave, as those of a batch system: the tightest of them.

    Args:
        whole: Whether what they have is asked for, used or not.
    """
    left = float("inf")
    try:
        lines = GROUP.read_text(encoding="utf-8").splitlines()
        own = next((line[3:] for line in lines if line.startswith("0::/")), "/").strip("/")
    except OSError:
        return left
    group = GROUPS / own
    while group != GROUPS.parent:
        try:
            most = (group / "memory.max").read_text(encoding="utf-8").strip()
            if most != "max" and whole:
                left = min(left, float(most))
            elif most != "max":
                used = float((group / "memory.current").read_text(encoding="utf-8"))
                stat = (group / "memory.stat").read_text(encoding="utf-8").splitlines()
                cached = sum(float(line.split()[1]) for line in stat if _is_file_cache(line))
                left = min(left, float(most) - used + cached)
        except (OSError, ValueError, IndexError):
            pass  # a group without such a limit, or not for us to read
        group = group.parent
    return left


def _is_file_cache(line: str) -> bool:
    return line.startswith(("inactive_file ", "active_file "))
