"""The memory of this process: what it took at most, what is left for it, what it gives back."""

from __future__ import annotations

import contextlib
import ctypes
import os
import re
from pathlib import Path

import psutil

STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")
GROUP, GROUPS = Path("/proc/self/cgroup"), Path("/sys/fs/cgroup")
FILE_CACHE = ("inactive_file ", "active_file ")
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
    """Memory that this process and others of its job may still take [byte]."""
    return min(float(psutil.virtual_memory().available), _of_job())


def total_memory() -> float:
    """Memory that this process could take if nothing else ran [byte]."""
    return min(float(psutil.virtual_memory().total), _of_job(whole=True))


def disk_folder() -> str:
    """The folder for files of what memory cannot hold."""
    return os.environ.get("TMPDIR", DISK)


def _of_job(*, whole: bool = False) -> float:
    """What control groups (version 2) leave, as those of a batch system: the tightest of them.

    Args:
        whole: Whether what they have is requested, used or not.
    """
    left = float("inf")
    try:
        lines = GROUP.read_text(encoding="utf-8").splitlines()
    except OSError:
        return left
    group = GROUPS / next((line[3:] for line in lines if line.startswith("0::/")), "/").strip("/")
    for folder in (group, *group.parents):
        if not folder.is_relative_to(GROUPS):
            break
        # A group without such a limit, or not for us to read, leaves all.
        with contextlib.suppress(OSError, ValueError, IndexError):
            most = float((folder / "memory.max").read_text(encoding="utf-8").replace("max", "inf"))
            if not whole:
                most -= float((folder / "memory.current").read_text(encoding="utf-8"))
                stat = (folder / "memory.stat").read_text(encoding="utf-8").splitlines()
                # Pages of files are given up where memory is short.
                cached = [line for line in stat if line.startswith(FILE_CACHE)]
                most += sum(float(line.split()[1]) for line in cached)
            left = min(left, most)
    return left
