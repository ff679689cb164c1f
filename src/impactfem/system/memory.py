"""Memory of this process: its peak, what is left for it, and freed memory given back."""

import ctypes
import os
import re
from contextlib import suppress
from pathlib import Path

import psutil

STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")
GROUP, GROUPS = Path("/proc/self/cgroup"), Path("/sys/fs/cgroup")
FILES = {
    1: ("memory", "memory.limit_in_bytes", "memory.usage_in_bytes", "total_"),
    2: ("", "memory.max", "memory.current", ""),
}
"""Of either version of control groups: the folder in GROUPS, the files of the limit and of what is
used, and what the names of statistics of a group with all below it begin with."""
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

    psutil knows the machine only; a batch system or a container limits the group of a job: the
    tightest of the control groups (version 1 or 2) counts.
    """
    machine = psutil.virtual_memory()
    left = float(machine.total if whole else machine.available)
    with suppress(OSError):
        for line in GROUP.read_text(encoding="utf-8").splitlines():
            _, controllers, own = line.split(":", 2)
            if controllers and "memory" not in controllers.split(","):
                continue
            folder, *files = FILES[1 if controllers else 2]
            # A group above limits this one, too. In a container the top is its own group.
            top = GROUPS / folder
            group = top / own.strip("/")
            for one in (group, *group.parents):
                # A group without such a limit, or not for this user to read, limits nothing.
                with suppress(OSError, ValueError, IndexError):
                    if one.is_relative_to(top):
                        left = min(left, _left(one, *files, whole=whole))
    return left


def _left(group: Path, limit: str, used: str, total: str, *, whole: bool) -> float:
    """Memory that a control group may still take, or its limit (`whole`) [byte]."""
    most = float((group / limit).read_text().replace("max", "inf"))
    if whole:
        return most
    # The kernel gives up pages of files where memory is short.
    cached = (f"{total}inactive_file ", f"{total}active_file ")
    stat = (group / "memory.stat").read_text().splitlines()
    freed = sum(float(line.split()[1]) for line in stat if line.startswith(cached))
    return most - float((group / used).read_text()) + freed
