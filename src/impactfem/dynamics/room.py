"""Memory for vectors of a large model: what the machine has, and files for the rest."""

from __future__ import annotations

import mmap
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from impactfem.errors import SolutionError
from impactfem.log import LOGGER

Array = NDArray[np.float64]

LEFT = 4
"""Blocks of vectors that must have room beside the one that is set up: their copies and products
with a matrix."""
DISK = "/var/tmp"
"""Where files go without TMPDIR: /tmp is memory on many systems."""
_MEMORY = Path("/proc/meminfo")
_GROUP, _GROUPS = Path("/proc/self/cgroup"), Path("/sys/fs/cgroup")


@dataclass(frozen=True, eq=False)
class Room:
    """An array in memory, or in a file.

    Args:
        array: Shape (rows, columns), Fortran order.
        pages: The file's, None in memory.
    """

    array: Array
    pages: mmap.mmap | None

    def fetch(self) -> Array:
        """The array; that of a file is read as a whole, and not page by page when it is used."""
        if self.pages is not None:
            self.pages.madvise(mmap.MADV_WILLNEED)
        return self.array


def room(rows: int, columns: int, processes: int = 1) -> Room:
    """An array for columns, not yet filled: in memory, or in a file where memory runs short.

    The file is in the folder of the environment variable TMPDIR, else in /var/tmp; it has no name
    and goes with the array, also when the process is killed.

    Args:
        rows: Number of rows.
        columns: Number of columns.
        processes: Number of processes that set up as much on this machine at the same time.

    Raises:
        SolutionError: There is room neither in memory nor in the folder.
    """
    size = 8 * rows * columns
    if not size or (1 + LEFT) * size * processes <= available_memory():
        return Room(np.empty((rows, columns), order="F"), None)
    folder = os.environ.get("TMPDIR", DISK)
    try:
        with tempfile.TemporaryFile(dir=folder) as file:
            # A full disk would end the process when the pages are written.
            os.posix_fallocate(file.fileno(), 0, size)
            pages = mmap.mmap(file.fileno(), size)
    except OSError as error:
        raise SolutionError(
            f"the vectors of the reduced model need {1e-9 * size:.2g} GB beyond the memory, and no "
            f"file of this size can be made in {folder} ({error.strerror or error}): name another "
            "folder by TMPDIR"
        ) from error
    LOGGER.info(
        "memory runs short: %.2g GB of the vectors of a reduced model go to a file in %s",
        1e-9 * size,
        folder,
    )
    return Room(np.frombuffer(pages).reshape((rows, columns), order="F"), pages)


def available_memory() -> float:
    """Memory that this process and others of its job may still take [byte]; infinite if unknown."""
    return min(_of_machine(), _of_job())


def _of_machine() -> float:
    try:
        lines = _MEMORY.read_text(encoding="utf-8").splitlines()
    except OSError:
        return float("inf")
    found = [line.split()[1] for line in lines if line.startswith("MemAvailable:")]
    return 1024.0 * float(found[0]) if found else float("inf")


def _of_job() -> float:
    """What control groups (version 2) leave, as those of a batch system: the tightest of them."""
    left = float("inf")
    try:
        lines = _GROUP.read_text(encoding="utf-8").splitlines()
        own = next((line[3:] for line in lines if line.startswith("0::/")), "/").strip("/")
    except OSError:
        return left
    group = _GROUPS / own
    while group != _GROUPS.parent:
        try:
            most = (group / "memory.max").read_text(encoding="utf-8").strip()
            if most != "max":
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
