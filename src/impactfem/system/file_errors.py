"""Errors of files and memory: what the system refuses, as a message for the user."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from impactfem.system.errors import ImpactfemError
from impactfem.system.log import LOGGER

# What NumPy says of an array that no machine holds, in place of MemoryError.
_TOO_LARGE = ("Maximum allowed size exceeded", "Maximum allowed dimension", "array is too big")
_PETSC_MEMORY = 55  # PETSC_ERR_MEM


@contextmanager
def file_errors() -> Iterator[None]:
    """What the system refuses in the block becomes a message that says what and why.

    For work that touches many files, its own and those of libraries, or takes much memory. Not
    collective.

    Raises:
        ImpactfemError: A file or folder cannot be read or written, as on a full disk; or there is
            not enough memory.
    """
    try:
        yield
    except OSError as error:
        if error.strerror is None:  # no answer of the system, but a fault that a library found
            raise
        LOGGER.debug("refused by the system", exc_info=True)
        where = "a file" if error.filename is None else error.filename
        raise ImpactfemError(f"cannot read or write {where}: {error.strerror}") from error
    except (MemoryError, ValueError, RuntimeError) as error:
        if not _wants_memory(error):
            raise
        LOGGER.debug("out of memory", exc_info=True)
        reason = str(error).partition("\n")[0]
        raise ImpactfemError(
            f"not enough memory{f' ({reason})' if reason else ''}: 'impactfem check' prints what a "
            "case needs; longer time steps, larger elements or fewer vectors need less"
        ) from error


def _wants_memory(error: Exception) -> bool:
    if isinstance(error, MemoryError):
        return True
    if isinstance(error, ValueError):
        return str(error).startswith(_TOO_LARGE)
    return getattr(error, "ierr", None) == _PETSC_MEMORY
