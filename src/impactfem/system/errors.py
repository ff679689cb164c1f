"""The errors of impactfem: one base, the faults of an input, and what the system refuses."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""Characters that end a line, command a terminal, turn the direction of writing, or are none."""
MOST_FAULTS = 200
"""Largest number of faults that are listed; so many have one cause."""
# What NumPy says of an array that no machine holds, in place of MemoryError.
_TOO_LARGE = ("Maximum allowed size exceeded", "Maximum allowed dimension", "array is too big")
_LOGGER = logging.getLogger("impactfem")  # as in `impactfem.system.log`
_PETSC_MEMORY = 55  # PETSC_ERR_MEM


def printable(text: str) -> str:
    """The text on one line: what is in `CONTROL` stands there as its escape sequence."""
    return CONTROL.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


class ImpactfemError(Exception):
    """Base of every error that impactfem raises on purpose. The message is for the user."""


@dataclass(frozen=True)
class Fault:
    """One fault of an input.

    Args:
        file: The file that holds the fault.
        key: Where in the file: a dotted key (``buildings[0].floors``) or ``line 12``; may be empty
            when the fault is the file's as a whole.
        value: What stands there, as written; None when nothing does.
        expected: What was expected, in words that say how to mend it.
    """

    file: Path | str
    key: str
    value: object | None
    expected: str

    def __str__(self) -> str:
        where = f"{self.file}: {_cut(self.key, 160)}" if self.key else f"{self.file}"
        found = "" if self.value is None else f" = {_short(self.value)}"
        return printable(f"{where}{found}: {self.expected}")


class InputError(ImpactfemError):
    """The input is not usable; carries every fault that was found, up to `MOST_FAULTS` of them."""

    def __init__(self, faults: Iterable[Fault]) -> None:
        found = tuple(faults)
        if len(found) > MOST_FAULTS:
            rest = len(found) - MOST_FAULTS + 1
            last = Fault(found[-1].file, "", None, f"{rest} further faults, here and before")
            found = (*found[: MOST_FAULTS - 1], last)
        self.faults = found
        super().__init__("\n".join(str(fault) for fault in self.faults))

    def __reduce__(self) -> tuple[type[InputError], tuple[tuple[Fault, ...]]]:
        # An exception is pickled with its message; this one is made from its faults.
        return type(self), (self.faults,)


class SolutionError(ImpactfemError):
    """A computation did not reach a result that may be used; says which and why."""


def _short(value: object) -> str:
    return _cut(repr(value), 80)


def _cut(text: str, limit: int) -> str:
    return text if len(text) <= limit else f"{text[: limit - 3]}..."


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
        _LOGGER.debug("refused by the system", exc_info=True)
        where = "a file" if error.filename is None else error.filename
        raise ImpactfemError(f"cannot read or write {where}: {error.strerror}") from error
    except (MemoryError, ValueError, RuntimeError) as error:
        if not _wants_memory(error):
            raise
        _LOGGER.debug("out of memory", exc_info=True)
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
