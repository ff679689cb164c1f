"""The errors of impactfem: one base, the faults of an input, and what the system refuses."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import date, time
from pathlib import Path

CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""Ends of lines, commands to a terminal, changes of direction, surrogates."""
MOST_FAULTS = 200
"""Largest number of faults that are listed."""
# Messages of NumPy's ValueError for an array that is too large for any machine.
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
    """One fault of an input."""

    file: Path | str  #: the file that holds the fault
    key: str  #: dotted key (``buildings[0].floors``) or ``line 12``; "" for the file as a whole
    value: object | None  #: the value as written; None where there is none
    expected: str  #: what was expected, in words that say how to mend it
    kind: str = ""  #: kind of the fault, for tests and programs: ``missing``, ``unit``

    def __str__(self) -> str:
        where = f"{self.file}: {_cut(self.key, 160)}" if self.key else f"{self.file}"
        # As TOML writes it.
        toml = isinstance(self.value, bool | date | time)
        value = str(self.value).lower() if toml else repr(self.value)
        found = "" if self.value is None else f" = {_cut(value, 80)}"
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


def _cut(text: str, limit: int) -> str:
    return text if len(text) <= limit else f"{text[: limit - 3]}..."


@contextmanager
def file_errors() -> Iterator[None]:
    """Report as an `ImpactfemError` a file or memory that the system refuses. Not collective."""
    try:
        yield
    except OSError as error:
        if error.strerror is None:  # raised by a library, not by the system
            raise
        _LOGGER.debug("refused by the system", exc_info=True)
        where = "a file" if error.filename is None else error.filename
        raise ImpactfemError(f"cannot read or write {where}: {error.strerror}") from error
    except (MemoryError, ValueError, RuntimeError) as error:
        array = isinstance(error, ValueError) and str(error).startswith(_TOO_LARGE)
        petsc = getattr(error, "ierr", None) == _PETSC_MEMORY
        if not (array or petsc or isinstance(error, MemoryError)):
            raise
        _LOGGER.debug("out of memory", exc_info=True)
        reason = str(error).partition("\n")[0]
        raise ImpactfemError(
            f"not enough memory{f' ({reason})' if reason else ''}: 'impactfem check' prints what a "
            "case needs; longer time steps, larger elements or fewer vectors need less"
        ) from error
