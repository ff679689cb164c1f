"""The smallest parts of a case file: quantities, ratios, whole numbers, names, file names.

Each is an annotation for a field of a pydantic model. A leaf knows what it accepts, says so in
plain words (``phrase``) for messages and the reference page, and gives its part of the JSON schema.
Inside the program every value is an SI float; a model made from Python takes such floats as they
are, a case file must state its units.
"""

# The methods of the leaves are described once, in their base.
# ruff: noqa: D102

from __future__ import annotations

import itertools
import math
import re
from abc import ABC, abstractmethod
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from impactfem.case import unit as units
from impactfem.case.unit import Kind, UnitError
from impactfem.system.errors import CONTROL

_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_LARGEST = 2**31 - 1  # what every library that counts steps or takes a seed can hold
_BEYOND = 1e60  # no physical quantity in SI reaches it; a product of five of them is finite
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*(.*?)\s*", re.DOTALL)
LONGEST_NAME = 64  # letters; file names are made of names, two at a time
LISTED = 300  # letters of the names that a message lists
_RESERVED = re.compile("con|prn|aux|nul|com[0-9]|lpt[0-9]", re.IGNORECASE)  # by Windows, for files
_COMMA = re.compile(r"\s*([+-]?\d+),(\d+(?:[eE][+-]?\d+)?)((?:\s*[^\W\d].*?|\s*1\s*/.*?)?)\s*")
_PERCENT = re.compile(rf"\s*({_NUMBER})\s*%\s*")


def refuse(expected: str) -> PydanticCustomError:
    """The error a validator raises: it carries the expectation in words and nothing else."""
    return PydanticCustomError("fault", "{expected}", {"expected": expected})


def nearest(name: str, known: list[str]) -> str:
    """Words that name the nearest known name, or some known ones when none is near."""
    close = get_close_matches(name, known, n=1, cutoff=0.6)
    folded = {other.lower(): other for other in known}
    if not close:
        close = [folded[c] for c in get_close_matches(name.lower(), list(folded), 1, cutoff=0.6)]
    if close:
        return f"did you mean '{close[0]}'?"
    # As many as a line can hold.
    ends = itertools.accumulate(len(one) + 2 for one in known)
    listed = [one for one, end in zip(known, ends, strict=True) if end <= LISTED]
    more = f" and {len(known) - len(listed)} others" if len(listed) < len(known) else ""
    return f"known: {', '.join(listed)}{more}" if known else "none is defined"


def read_number(text: str) -> float | None:
    """A finite float from its decimal text; None when the text is no such number."""
    if re.fullmatch(_NUMBER, text.strip()) is None:
        return None
    value = float(text)
    return value if math.isfinite(value) else None


class Leaf(ABC):
    """Base of the annotations: checks a value and describes what it accepts."""

    @property
    @abstractmethod
    def phrase(self) -> str:
        """What is expected, in words that complete 'expected ...'."""

    @abstractmethod
    def check(self, value: Any, info: ValidationInfo) -> Any:
        """Give the value as the program uses it, or raise the error of ``refuse``."""

    @abstractmethod
    def schema(self) -> dict[str, Any]:
        """The JSON schema of what a case file may say."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(self.check)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return self.schema()


@dataclass(frozen=True)
class Quantity(Leaf):
    """A physical quantity, written with its unit, held as an SI float.

    Args:
        kind: The kind of quantity.
        above: Open lower bound in SI, or None.
        at_least: Closed lower bound in SI, or None.
        at_most: Closed upper bound in SI, or None.
    """

    kind: Kind
    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None

    @property
    def bound(self) -> str:
        """The bounds in words, empty when there are none."""
        words = (
            ("above", self.above, ""),
            ("of at least", self.at_least, self._unit),
            ("at most" if self.bounded_below else "of at most", self.at_most, self._unit),
        )
        return " and ".join(f"{word} {x:g}{unit}" for word, x, unit in words if x is not None)

    @property
    def bounded_below(self) -> bool:
        """Whether it has a lower bound."""
        return self.above is not None or self.at_least is not None

    @property
    def _unit(self) -> str:
        """The unit of a bound, which zero needs none for."""
        return f" {self.kind.unit}" if self.at_most is not None or self.at_least else ""

    @property
    def phrase(self) -> str:
        return self.kind.phrase

    def check(self, value: Any, info: ValidationInfo) -> float:
        if isinstance(value, str):
            number = self._from_text(value)
        elif _is_number(value) and not _from_case_file(info):
            number = _to_float(value)
        elif _is_number(value):
            raise refuse(f"the unit is missing; expected {self.phrase}")
        else:
            raise refuse(f"expected {self.phrase}")
        return self.check_bound(number)

    def check_bound(self, number: float) -> float:
        """Refuse a value that is not finite or beyond the bound."""
        if not math.isfinite(number):
            raise refuse(f"expected a finite value: {self.phrase}")
        if abs(number) > _BEYOND:
            raise refuse(f"expected a value below {_BEYOND:g} in SI units: {self.phrase}")
        outside = (
            (self.above is not None and number <= self.above)
            or (self.at_least is not None and number < self.at_least)
            or (self.at_most is not None and number > self.at_most)
        )
        if outside:
            example = f"for example '{self.kind.example}'"
            raise refuse(f"expected {self.kind.name} {self.bound}, {example}")
        return number

    def _from_text(self, text: str) -> float:
        comma = _COMMA.fullmatch(text)
        if comma is not None:
            point = f"{comma[1]}.{comma[2]}{comma[3]}"
            words = f"expected {self.kind.name} with a decimal point, not a comma"
            raise refuse(f"{words}: '{point}'")
        match = _QUANTITY.fullmatch(text)
        if match is None:
            raise refuse(f"expected {self.phrase}")
        number, unit = float(match[1]), match[2]
        if not unit:
            raise refuse(f"the unit is missing; expected {self.phrase}")
        try:
            return units.scale(number, units.si_factor(unit, self.kind))
        except UnitError as error:
            raise refuse(f"{error}; expected {self.phrase}") from error

    def schema(self) -> dict[str, Any]:
        return {
            "type": "string",
            "pattern": rf"^\s*{_NUMBER}(?:\s*[A-Za-zµμ]|\s+1\s*/).*$",
            "examples": [self.kind.example],
            "x-unit": self.kind.unit,
            "x-accepts": f"{self.kind.name} {self.bound}".strip(),
        }


@dataclass(frozen=True)
class Ratio(Leaf):
    """A number without dimension, bare or in percent.

    Args:
        above: Open lower bound, or None.
        at_least: Closed lower bound, or None.
        below: Open upper bound, or None.
        at_most: Closed upper bound, or None.
        percent: Whether ``5 %`` may be written for 0.05.
    """

    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    percent: bool = True

    @property
    def bound(self) -> str:
        """The bounds in words, empty when there are none."""
        words = (
            ("above", self.above),
            ("of at least", self.at_least),
            ("below", self.below),
            ("at most", self.at_most),
        )
        return " and ".join(f"{word} {value:g}" for word, value in words if value is not None)

    @property
    def phrase(self) -> str:
        number = f"a number {self.bound}".strip()
        return f"{number}, bare or as a percentage: 0.05 or '5 %'" if self.percent else number

    def check(self, value: Any, info: ValidationInfo) -> float:
        percent = _PERCENT.fullmatch(value) if isinstance(value, str) and self.percent else None
        if percent is not None:
            number = float(percent[1]) / 100.0
        elif _is_number(value):
            number = _to_float(value)
        else:
            raise refuse(f"expected {self.phrase}")
        return self.check_bound(number)

    def check_bound(self, number: float) -> float:
        """Refuse a value that is not finite or beyond the bounds."""
        outside = (
            not math.isfinite(number)
            or (self.above is not None and number <= self.above)
            or (self.at_least is not None and number < self.at_least)
            or (self.below is not None and number >= self.below)
            or (self.at_most is not None and number > self.at_most)
        )
        if outside:
            raise refuse(f"expected {self.phrase}")
        return number

    def schema(self) -> dict[str, Any]:
        bounds = {
            "exclusiveMinimum": self.above,
            "minimum": self.at_least,
            "exclusiveMaximum": self.below,
            "maximum": self.at_most,
        }
        number = {"type": "number"} | {k: v for k, v in bounds.items() if v is not None}
        accepts = {"x-unit": "-", "x-accepts": f"a number {self.bound}".strip()}
        if not self.percent:
            return number | accepts
        text = {"type": "string", "pattern": rf"^\s*{_NUMBER}\s*%\s*$", "examples": ["5 %"]}
        return {"anyOf": [number, text]} | accepts


@dataclass(frozen=True)
class Whole(Leaf):
    """A whole number, from ``at_least`` to ``at_most``."""

    at_least: int
    at_most: int = _LARGEST

    @property
    def phrase(self) -> str:
        words = f"a whole number of at least {self.at_least}"
        return words if self.at_most == _LARGEST else f"{words} and at most {self.at_most}"

    def check(self, value: Any, info: ValidationInfo) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or value < self.at_least:
            raise refuse(f"expected {self.phrase}")
        if value > self.at_most:
            also = "" if self.at_most < _LARGEST else f" and at most {_LARGEST}"
            raise refuse(f"expected {self.phrase}{also}")
        return value

    def schema(self) -> dict[str, Any]:
        bounds = {"minimum": self.at_least, "maximum": self.at_most}
        return {"type": "integer", "x-accepts": self.phrase} | bounds


@dataclass(frozen=True)
class Wholes(Leaf):
    """One whole number of at least 1, or a list of them; held as a tuple."""

    @property
    def phrase(self) -> str:
        return "a whole number of at least 1, or a list of such numbers"

    def check(self, value: Any, info: ValidationInfo) -> tuple[int, ...]:
        numbers = tuple(value) if isinstance(value, list | tuple) else (value,)
        for number in numbers:
            if isinstance(number, bool) or not isinstance(number, int) or number < 1:
                raise refuse(f"expected {self.phrase}")
        if not numbers:
            raise refuse(f"expected {self.phrase}; the list is empty")
        return numbers

    def schema(self) -> dict[str, Any]:
        one = {"type": "integer", "minimum": 1}
        many = {"type": "array", "items": one, "minItems": 1}
        return {"anyOf": [one, many], "x-accepts": self.phrase}


@dataclass(frozen=True)
class Words(Leaf):
    """A text that is not empty and shows as it is; with ``pattern`` it must match.

    Args:
        words: What is expected, in words.
        pattern: A regular expression for all of it, or None.
        longest: Largest number of characters.
        lines: Whether it may have several lines.
        file: Whether files are named by it: what some systems reserve is refused.
    """

    words: str = "a text in quotes"
    pattern: str | None = None
    longest: int = 1000
    lines: bool = False
    file: bool = False

    @property
    def phrase(self) -> str:
        return self.words

    def check(self, value: Any, info: ValidationInfo) -> str:
        matches = isinstance(value, str) and value.strip() != ""
        if not matches or (self.pattern and re.fullmatch(self.pattern, value) is None):
            raise refuse(f"expected {self.phrase}")
        if len(value) > self.longest:
            raise refuse(f"expected at most {self.longest} characters, not {len(value)}")
        if CONTROL.search(re.sub(r"[\r\n\t]", "", value) if self.lines else value):
            one = "" if self.lines else "one line "
            raise refuse(f"expected {one}without control characters: {self.phrase}")
        if self.file and _RESERVED.fullmatch(value):
            raise refuse("expected another name: files are named by it, and Windows reserves it")
        return str(value)

    def schema(self) -> dict[str, Any]:
        pattern = {"pattern": f"^(?:{self.pattern})$"} if self.pattern else {"minLength": 1}
        return {"type": "string", "x-accepts": self.phrase, "maxLength": self.longest} | pattern


@dataclass(frozen=True)
class Reference(Leaf):
    """The name of a table defined elsewhere in the case file.

    Args:
        group: Where the names are: ``materials``, ``buildings`` or ``contact_laws``.
        word: What one of them is called in a message.
    """

    group: str
    word: str

    @property
    def phrase(self) -> str:
        return f"the name of a {self.word} of this file"

    def check(self, value: Any, info: ValidationInfo) -> str:
        if not isinstance(value, str):
            raise refuse(f"expected {self.phrase}")
        known = info.context.names(self.group) if info.context is not None else None
        if known is not None and value not in known:
            raise refuse(f"unknown {self.word}; {nearest(value, list(known))}")
        return value

    def schema(self) -> dict[str, Any]:
        return {"type": "string", "minLength": 1, "x-accepts": self.phrase}


@dataclass(frozen=True)
class FileName(Leaf):
    """A file, relative to the folder of the case file unless absolute."""

    @property
    def phrase(self) -> str:
        return "a file name in quotes, relative to the folder of the case file"

    def check(self, value: Any, info: ValidationInfo) -> Path:
        if isinstance(value, Path):
            return value
        if not isinstance(value, str) or not value.strip() or CONTROL.search(value):
            raise refuse(f"expected {self.phrase}")
        return Path(value)

    def schema(self) -> dict[str, Any]:
        return {"type": "string", "minLength": 1, "x-accepts": self.phrase}


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _to_float(value: int | float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _from_case_file(info: ValidationInfo) -> bool:
    """A case file brings its context with it; a model made from Python has none."""
    return info.context is not None


Length = Annotated[float, Quantity(units.LENGTH)]
PositiveLength = Annotated[float, Quantity(units.LENGTH, above=0)]
Depth = Annotated[float, Quantity(units.LENGTH, at_least=0)]
Area = Annotated[float, Quantity(units.AREA, above=0)]
SecondMoment = Annotated[float, Quantity(units.SECOND_MOMENT, above=0)]
Mass = Annotated[float, Quantity(units.MASS, above=0)]
Inertia = Annotated[float, Quantity(units.INERTIA, above=0)]
Density = Annotated[float, Quantity(units.DENSITY, above=0)]
Time = Annotated[float, Quantity(units.TIME, at_least=0)]
PositiveTime = Annotated[float, Quantity(units.TIME, above=0)]
Duration = Annotated[float, Quantity(units.TIME, above=0, at_most=1e5)]
TimeStep = Annotated[float, Quantity(units.TIME, at_least=1e-9)]
Extent = Annotated[float, Quantity(units.LENGTH, above=0, at_most=2000)]
ElementSize = Annotated[float, Quantity(units.LENGTH, at_least=1e-2)]
Frequency = Annotated[float, Quantity(units.FREQUENCY, above=0)]
Rate = Annotated[float, Quantity(units.RATE, at_least=0)]
Acceleration = Annotated[float, Quantity(units.ACCELERATION, above=0)]
Stress = Annotated[float, Quantity(units.STRESS, above=0)]
Stiffness = Annotated[float, Quantity(units.STIFFNESS, above=0)]
HertzStiffness = Annotated[float, Quantity(units.HERTZ_STIFFNESS, above=0)]
PositiveSpeed = Annotated[float, Quantity(units.VELOCITY, above=0)]
PositiveFactor = Annotated[float, Ratio(above=0)]
Weight = Annotated[float, Ratio(at_least=0)]
DampingRatio = Annotated[float, Ratio(at_least=0, below=1)]
Number = Annotated[float, Ratio(percent=False)]
Text = Annotated[str, Words()]
Prose = Annotated[str, Words(longest=10_000, lines=True)]
Key = Annotated[str, Words("a name of visible characters", longest=LONGEST_NAME)]
Name = Annotated[
    str,
    Words(
        "a name of letters, digits, '_' and '-' that begins with a letter, for example 'B1'",
        "[A-Za-z][A-Za-z0-9_-]*",
        longest=LONGEST_NAME,
        file=True,
    ),
]
MaterialName = Annotated[str, Reference("materials", "material")]
BuildingName = Annotated[str, Reference("buildings", "building")]
LawName = Annotated[str, Reference("contact_laws", "contact law")]
File = Annotated[Path, FileName()]
