"""Memory of this process: its peak, what is left for it, and freed memory given back."""

import ctypes
import os
import re
from contextlib import suppress
from pathlib import Path

import psutil

STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")
GROUP, GROUPS = Path("/proc/self/cgroup"), Path("/sys/fs/cgroup")
FILE_CACHE = ("inactive_file ", "active_file ")
DISK = "/var/tmp"  # folder of temporary files without TMPDIR: /tmp is memory on many systems


def forget_peak() -> None:
    """Start a new peak; where the system does not allow it, the old one stays."""
    with suppress(OSError):
        RESET.write_text("5")


def peak_memory() -> float | None:
    """Largest resident memory of this process since `forget_peak` [byte]; None if not known."""
    with suppress(OSError):
        if found := re.search(r"^VmHWM:\s*(\d+) kB$", STATUS.read_text(), re.MULTILINE):
            return 1024.0 * float(found[1])
    return None


def give_back() -> None:
    """Return freed memory to the system: Open MPI makes the allocator keep all of it.

    Without it a second factor, a little larger, would not fit where the first one was.
    """
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


def disk_folder() -> str:
    """The folder for what memory cannot hold."""
    return os.environ.get("TMPDIR", DISK)


def available_memory(*, whole: bool = False) -> float:
    """Memory that this process and others of its job may still take, or all of it (`whole`) [byte].

    psutil knows the machine only; a batch system limits the group of a job: the tightest of the
    control groups (version 2) counts.
    """
    machine = psutil.virtual_memory()
    left = float(machine.total if whole else machine.available)
    with suppress(OSError):
        lines = GROUP.read_text(encoding="utf-8").splitlines()
        own = next((line[3:] for line in lines if line.startswith("0::/")), "/").strip("/")
        groups = (GROUPS / own, *(GROUPS / own).parents)
        for group in [path for path in groups if path.is_relative_to(GROUPS)]:
            # A group without such a limit, or not for this user to read, limits nothing.
            with suppress(OSError, ValueError, IndexError):
                limit = float((group / "memory.max").read_text().replace("max", "inf"))
                if not whole:
                    limit -= float((group / "memory.current").read_text())
                    # The kernel gives up pages of files where memory is short.
                    stat = (group / "memory.stat").read_text().splitlines()
                    cached = [line for line in stat if line.startswith(FILE_CACHE)]
                    limit += sum(float(line.split()[1]) for line in cached)
                left = min(left, limit)
    return left
