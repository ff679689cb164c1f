"""Memory for vectors of a large model: what the machine has, and files for the rest."""

from __future__ import annotations

import mmap
import os
import tempfile
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.system.errors import SolutionError
from impactfem.system.log import LOGGER
from impactfem.system.memory import available_memory, disk_folder

Array = NDArray[np.float64]

LEFT = 4
"""Blocks of vectors that must have room beside the one that is set up: their copies and products
with a matrix."""


@dataclass(frozen=True, eq=False)
class Room:
    """An array in memory, or in a file."""

    array: Array  #: Shape (rows, columns), Fortran order.
    pages: mmap.mmap | None  #: The file's, None in memory.

    def fetch(self) -> Array:
        """The array; that of a file is read as a whole, and not page by page when it is used."""
        if self.pages is not None:
            self.pages.madvise(mmap.MADV_WILLNEED)
        return self.array


def room(rows: int, columns: int, processes: int = 1) -> Room:
    """An array for columns, not yet filled: in memory, or in a file where memory runs short.

    The file is in the folder of the environment variable TMPDIR, else in /var/tmp; it has no name
    and goes with the array, also when the process is killed. So many processes set up as much on
    this machine at the same time.

    Raises:
        SolutionError: There is room neither in memory nor in the folder.
    """
    size = 8 * rows * columns
    if not size or (1 + LEFT) * size * processes <= available_memory():
        return Room(np.empty((rows, columns), order="F"), None)
    folder = disk_folder()
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
