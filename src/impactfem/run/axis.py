"""An axis of a sweep: a key of the case file and the values that it takes."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from impactfem.case.key import key_fault, read_key
from impactfem.case.model import CaseFile
from impactfem.case.overlay import as_toml
from impactfem.case.place import Place
from impactfem.case.source import EXTENDS, Source
from impactfem.case.unit import UnitError, to_si
from impactfem.system.errors import Fault

COMMAND_LINE = "command line"
_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*(.*?)\s*", re.DOTALL)
_RANGE = "expected a range start:stop:count or start:stop:count:log, for example '25 cm:35 cm:3'"
MOST = 10_000  # values of an axis and variants of a sweep: more is a slip of the pen


@dataclass(frozen=True)
class Axis:
    """An axis of a sweep.

    Args:
        key: The key as it was written.
        place: Its place in the case.
        values: Its values as in a case file: texts with units, numbers, truth values, lists.
    """

    key: str
    place: Place
    values: tuple[Any, ...]

    @property
    def unit(self) -> str:
        """SI unit of the values; "-" for numbers; "" when they are words."""
        units = {unit for _, unit in map(in_si, self.values)}
        return units.pop() if len(units) == 1 else ""

    def cell(self, value: Any) -> float | str:
        """A value for a table: in SI where all values of the axis have one unit, else as words."""
        return in_si(value)[0] if self.unit else words(value)


def words(value: Any) -> str:
    """A value as a person writes it on the command line."""
    return value if isinstance(value, str) else as_toml(value)


def in_si(value: Any) -> tuple[float | str, str]:
    """A value in SI with its unit; a value that is no quantity as words, with the unit ""."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value), "-"
    match = _QUANTITY.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return words(value), ""
    try:
        return to_si(float(match[1]), match[2])
    except UnitError:
        return words(value), ""


def read_axes(
    settings: Mapping[str, str | Sequence[Any]] | Sequence[str], source: Source
) -> tuple[list[Axis], list[Fault]]:
    """The axes that are asked for, and every fault of them.

    Args:
        settings: Texts `KEY=VALUES`; or by key a text of values, or a list of them. In a text,
            values are separated by commas, and one may be a range.
        source: The case.

    Returns:
        The axes that are free of faults, and the faults.
    """
    if isinstance(settings, Mapping):
        pairs = [(key, values) for key, values in settings.items()]
    else:
        parts = [text.partition("=") for text in settings]
        pairs = [(key.strip(), values) for key, _, values in parts]
    axes: list[Axis] = []
    faults: list[Fault] = []
    if not pairs:
        expected = "expected one key or more with its values, for example 'damping.ratio=3 %,5 %'"
        faults.append(Fault(COMMAND_LINE, "--set", None, expected))
    for key, given in pairs:
        found = _read_axis(key, given, source, axes)
        if isinstance(found, Axis):
            axes.append(found)
        else:
            faults += found
    return axes, faults


def _read_axis(
    key: str, given: str | Sequence[Any], source: Source, before: list[Axis]
) -> Axis | list[Fault]:
    where = f"--set {key}".strip()
    place = read_key(key)
    if place is None or place == (EXTENDS,):
        expected = "expected KEY=VALUES with a key of the case file, for example 'damping.ratio'"
        return [Fault(COMMAND_LINE, where, None, expected)]
    faults = []
    fault = key_fault(place, source.raw, CaseFile)
    if fault is not None:
        faults.append(Fault(COMMAND_LINE, where, None, fault))
    for other in before:
        shorter = min(len(place), len(other.place))
        if place[:shorter] == other.place[:shorter]:
            expected = f"expected keys that do not hold one another; {other.key} is swept as well"
            faults.append(Fault(COMMAND_LINE, where, None, expected))
    values: list[Any] = []
    if isinstance(given, str):
        for item in _items(given):
            try:
                values += _values(item)
            except ValueError as error:
                faults.append(Fault(COMMAND_LINE, where, item, str(error)))
    else:
        values += given
    if not values and not faults:
        faults.append(Fault(COMMAND_LINE, where, None, "expected one value or more after '='"))
    written = [words(value) for value in values]
    for twice in dict.fromkeys(word for word in written if written.count(word) > 1):
        faults.append(Fault(COMMAND_LINE, where, twice, "expected each value once"))
    return faults or Axis(key, place, tuple(values))


def _items(text: str) -> Iterator[str]:
    """What stands between the commas that are in no quotes and no brackets."""
    depth, quote, item = 0, "", ""
    for letter in text:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        depth += 0 if quote else (letter in "[{") - (letter in "]}")
        if letter == "," and not quote and depth == 0:
            yield item.strip()
            item = ""
        else:
            item += letter
    if item.strip() or text.strip():
        yield item.strip()


def _values(item: str) -> list[Any]:
    """The values of an item: those of a range, or the item itself.

    Raises:
        ValueError: It is empty or a range with a fault; says what was expected.
    """
    if not item:
        raise ValueError("expected a value between two commas")
    try:
        content = tomllib.loads(f"value = {item}")
    except tomllib.TOMLDecodeError:
        content = {}
    if list(content) == ["value"] and isinstance(
        content["value"], bool | int | float | str | list | dict
    ):
        return [content["value"]]
    return _range(item) if ":" in item else [item]


def _range(text: str) -> list[Any]:
    """The values of a range, evenly spaced or in equal ratios, in the unit of its ends.

    Raises:
        ValueError: It is none; says what was expected.
    """
    parts = [part.strip() for part in text.split(":")]
    if len(parts) not in {3, 4} or parts[3:] not in ([], ["log"]):
        raise ValueError(_RANGE)
    ends = [_QUANTITY.fullmatch(part) for part in parts[:2]]
    if ends[0] is None or ends[1] is None or not parts[2].isdecimal():
        raise ValueError(_RANGE)
    count = int(parts[2])
    if not 2 <= count <= MOST:
        raise ValueError(f"expected a range of 2 to {MOST} values")
    units = {end[2] for end in ends if end is not None and end[2]}
    if len(units) > 1:
        raise ValueError("expected one unit for both ends of a range")
    start, stop = (float(end[1]) for end in ends if end is not None)
    if not (math.isfinite(start) and math.isfinite(stop)) or start == stop:
        raise ValueError("expected a range between two different finite numbers")
    if len(parts) == 3:
        spaced = np.linspace(start, stop, count)
    elif min(start, stop) > 0.0:
        spaced = np.geomspace(start, stop, count)
    else:
        raise ValueError("expected a range above zero: its values have equal ratios")
    # Twelve digits: 0.1:0.3:3 is 0.1, 0.2, 0.3 and not 0.30000000000000004.
    rounded = [float(f"{value:.12g}") for value in spaced]
    if units:
        unit = units.pop()
        return [f"{value:.12g} {unit}" for value in rounded]
    whole = all(re.fullmatch(r"[+-]?\d+", part) for part in parts[:2])
    if whole and all(value.is_integer() for value in rounded):
        return [int(value) for value in rounded]
    return list(rounded)
