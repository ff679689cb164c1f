"""What the readers of records share: the text of a file, its units, its faults."""

from __future__ import annotations

import math
import re
from pathlib import Path

from impactfem.motion.measures import STANDARD_GRAVITY
from impactfem.system.errors import Fault, InputError

_MOST_FAULTS = 20

# The units accelerograms come in. A general unit parser would read "g" as the gram and "gal" as
# the gallon, and does not know the "cm/sec2" of the agencies' files.
ACCELERATION_UNITS = {
    "m/s2": 1.0,
    "cm/s2": 0.01,
    "mm/s2": 0.001,
    "in/s2": 0.0254,
    "ft/s2": 0.3048,
    "g": STANDARD_GRAVITY,
    "mg": 0.001 * STANDARD_GRAVITY,
    "%g": 0.01 * STANDARD_GRAVITY,
    "gal": 0.01,
}
TIME_UNITS = {"s": 1.0, "ms": 0.001, "min": 60.0}

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


def read_lines(path: Path, expected: str) -> list[str]:
    """Read a text file.

    Args:
        path: The file.
        expected: What it should be, for the message.

    Returns:
        Its lines, without their ends and without a byte order mark.

    Raises:
        InputError: The file cannot be read, is no text, or is empty.
    """
    try:
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        fault = Fault(path, "", None, f"cannot be read ({reason}); expected {expected}")
        raise InputError([fault]) from error
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        fault = Fault(path, "", None, f"this is not a text file; expected {expected}")
        raise InputError([fault]) from error
    if "\0" in text:
        raise InputError([Fault(path, "", None, f"this is not a text file; expected {expected}")])
    if not text.strip():
        raise InputError([Fault(path, "", None, f"the file is empty; expected {expected}")])
    return re.split(r"\r\n|\r|\n", text)


def plain_unit(text: str) -> str:
    """Bring the spellings of a unit to one: ``cm/sec^2``, ``CM/S/S`` and ``cm s-2`` are cm/s2."""
    unit = text.strip().lower().replace("²", "2").replace("**", "").replace("^", "")
    unit = re.sub(r"sec(onds?)?(?=\W|\d|$)", "s", unit)
    unit = re.sub(r"\s*/\s*", "/", unit)
    unit = re.sub(r"/\(?s[\s*/.·]?s\)?$", "/s2", unit)
    return re.sub(r"[\s.*·]s-2$", "/s2", unit)


def number(text: str) -> float | None:
    """Read a plain finite decimal number; None for all else (``nan``, ``1_000``, ``1e999``)."""
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    return value if math.isfinite(value) else None


def fixed_columns(line: str, width: int) -> list[str]:
    """Cut a line of fixed columns into its cells; a blank rest at the end is left out.

    Args:
        line: The line.
        width: Characters in a column.
    """
    text = line.rstrip()
    return [text[i : i + width].strip() for i in range(0, len(text), width)]


def check_component(path: Path, component: str | None, own: tuple[str, ...]) -> None:
    """See that the component asked for is the one that a file of one component holds.

    Args:
        path: The file.
        component: What was asked for; None asks for nothing.
        own: The names under which the file knows its component; empty when it names none.

    Raises:
        InputError: Another component was asked for, or the file does not say which it holds.
    """
    if component is None or any(same_name(component, name) for name in own):
        return
    expected = (
        f"the file holds one component, {own[0]}; leave component out or give that one"
        if own
        else "the file holds one component and does not name it; leave component out"
    )
    raise InputError([Fault(path, "component", component, expected)])


def same_name(one: str, other: str) -> bool:
    """Whether two names of a component agree, whatever their case and spaces."""
    return "".join(one.split()).casefold() == "".join(other.split()).casefold()


def input_error(path: Path, faults: list[Fault]) -> InputError:
    """Make the error that carries the faults of a file: the first 20, and the number of the rest.

    Args:
        path: The file.
        faults: In the order of the lines.
    """
    more = len(faults) - _MOST_FAULTS
    if more > 0:
        rest = Fault(path, "", None, f"and {more} more faults of this kind or another")
        faults = [*faults[:_MOST_FAULTS], rest]
    return InputError(faults)
