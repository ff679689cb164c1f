"""Errors of files: what the system refuses, as a message for the user."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from impactfem.errors import ImpactfemError
from impactfem.log import LOGGER


@contextmanager
def file_errors() -> Iterator[None]:
    """What the system refuses in the block becomes a message that names the file and the reason.

    For work that touches many files, its own and those of libraries. Not collective.

    Raises:
        ImpactfemError: A file or folder cannot be read or written, as on a full disk.
    """
    try:
        yield
    except OSError as error:
        if error.strerror is None:  # no answer of the system, but a fault that a library found
            raise
        LOGGER.debug("refused by the system", exc_info=True)
        where = "a file" if error.filename is None else error.filename
        raise ImpactfemError(f"cannot read or write {where}: {error.strerror}") from error
