"""Quantities with units and ratios, as annotations for the fields of pydantic models.

Inside the program every value is an SI float; a model made from Python takes such floats as they
are, a case file must state its units.
"""

# The methods of the leaves are described once, in their base.
# ruff: noqa: D102

import math
import re
from dataclasses import dataclass
from typing import Annotated, Any, Literal, get_args

from pydantic import ValidationInfo
from pydantic_core import PydanticCustomError

from impactfem.case import unit as units
from impactfem.case.base import Leaf, refuse
from impactfem.case.unit import Kind, UnitError
from impactfem.records.file import NUMBER as NUMBER

_BEYOND = 1e60  # no physical quantity in SI reaches it; a product of five of them is finite
QUANTITY = re.compile(rf"\s*({NUMBER})\s*(.*?)\s*", re.DOTALL)
_COMMA = re.compile(r"\s*([+-]?\d+),(\d+(?:[eE][+-]?\d+)?)((?:\s*[^\W\d].*?|\s*1\s*/.*?)?)\s*")
_PERCENT = re.compile(rf"\s*({NUMBER})\s*%\s*")


def _number(value: Any) -> float:
    """The float of a number; nan for what is none, inf for one that no float holds."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.inf


@dataclass(frozen=True, kw_only=True)
class _Bounded(Leaf):
    """A number, in SI, between bounds."""

    above: float | None = None  #: open lower bound, or None
    at_least: float | None = None  #: closed lower bound, or None
    below: float | None = None  #: open upper bound, or None
    at_most: float | None = None  #: closed upper bound, or None

    @property
    def _unit(self) -> str:
        return ""

    @property
    def bound(self) -> str:
        """The bounds in words, empty when there are none."""
        # Zero needs no unit.
        unit = self._unit if self.at_most is not None or self.at_least else ""
        lower = self.above is not None or self.at_least is not None
        words = (
            ("above", self.above, ""),
            ("of at least", self.at_least, unit),
            ("below", self.below, unit),
            ("at most" if lower else "of at most", self.at_most, unit),
        )
        return " and ".join(f"{word} {x:g}{unit}" for word, x, unit in words if x is not None)

    def _inside(self, number: float) -> bool:
        return (
            (self.above is None or number > self.above)
            and (self.at_least is None or number >= self.at_least)
            and (self.below is None or number < self.below)
            and (self.at_most is None or number <= self.at_most)
        )


@dataclass(frozen=True)
class Quantity(_Bounded):
    """A physical quantity, written with its unit, held as an SI float."""

    kind: Kind  #: the kind of quantity

    @property
    def _unit(self) -> str:
        return f" {self.kind.unit}"

    @property
    def phrase(self) -> str:
        return self.kind.phrase

    def check(self, value: Any, info: ValidationInfo) -> float:
        if isinstance(value, str):
            return self._bounded(self._from_text(value))
        number = _number(value)
        if math.isnan(number) and not isinstance(value, float):
            raise refuse(f"expected {self.phrase}")
        if info.context is not None:  # that of a case file; a model made from Python has none
            raise refuse(f"the unit is missing; expected {self.phrase}")
        return self._bounded(number)

    def _bounded(self, number: float) -> float:
        if not math.isfinite(number):
            raise refuse(f"expected a finite value: {self.phrase}")
        if abs(number) > _BEYOND:
            raise refuse(f"expected a value below {_BEYOND:g} in SI units: {self.phrase}")
        if not self._inside(number):
            example = f"for example '{self.kind.example}'"
            raise refuse(f"expected {self.kind.name} {self.bound}, {example}")
        return number

    def _from_text(self, text: str) -> float:
        comma = _COMMA.fullmatch(text)
        if comma is not None:
            point = f"{comma[1]}.{comma[2]}{comma[3]}"
            words = f"expected {self.kind.name} with a decimal point, not a comma"
            thousands = len(comma[2]) % 3 == 0 and comma[2].isdigit()
            whole = f", or '{comma[1]}{comma[2]}{comma[3]}'" if thousands else ""
            raise refuse(f"{words}: '{point}'{whole}")
        match = QUANTITY.fullmatch(text)
        if match is None:
            raise refuse(f"expected {self.phrase}")
        if not match[2]:
            raise refuse(f"the unit is missing; expected {self.phrase}")
        try:
            return units.scale(float(match[1]), units.si_factor(match[2], self.kind))
        except UnitError as error:
            raise refuse(f"{error}; expected {self.phrase}") from error

    def schema(self) -> dict[str, Any]:
        return {
            "type": "string",
            "pattern": rf"^\s*{NUMBER}(?:\s*[A-Za-zµμ]|\s+1\s*/).*$",
            "examples": [self.kind.example],
            "x-unit": self.kind.unit,
            "x-accepts": f"{self.kind.name} {self.bound}".strip(),
        }


@dataclass(frozen=True)
class Ratio(_Bounded):
    """A number without dimension, bare or in percent."""

    percent: bool = True  #: whether ``5 %`` may be written for 0.05

    @property
    def phrase(self) -> str:
        number = f"a number {self.bound}".strip()
        return f"{number}, bare or as a percentage: 0.05 or '5 %'" if self.percent else number

    def check(self, value: Any, info: ValidationInfo) -> float:
        percent = _PERCENT.fullmatch(value) if isinstance(value, str) and self.percent else None
        number = _number(value) if percent is None else float(percent[1]) / 100.0
        if not math.isfinite(number) or not self._inside(number):
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
        text = {"type": "string", "pattern": rf"^\s*{NUMBER}\s*%\s*$", "examples": ["5 %"]}
        return {"anyOf": [number, text]} | accepts


@dataclass(frozen=True)
class OrWord(Leaf):
    """What another leaf accepts, or a word, which is kept as it is."""

    value: Quantity | Ratio
    word: str

    @property
    def phrase(self) -> str:
        return f"{self.value.phrase}; or '{self.word}'"

    def check(self, value: Any, info: ValidationInfo) -> float | str:
        if value == self.word:
            return self.word
        try:
            return self.value.check(value, info)
        except PydanticCustomError as error:
            raise refuse(f"{error.message()}; or '{self.word}'") from error

    def schema(self) -> dict[str, Any]:
        value, about = _accepting(self.value, f', or `"{self.word}"`')
        return {"anyOf": [*value.get("anyOf", [value]), {"const": self.word}]} | about


@dataclass(frozen=True)
class OneOrTwo(Leaf):
    """One value for both, or a list of two; held as a tuple of two."""

    value: Quantity | OrWord

    @property
    def phrase(self) -> str:
        return f"{self.value.phrase}; or a list of two of them"

    def check(self, value: Any, info: ValidationInfo) -> tuple[Any, Any]:
        if isinstance(value, list | tuple):
            if len(value) != 2:
                raise refuse(f"expected {self.phrase}")
            return self.value.check(value[0], info), self.value.check(value[1], info)
        try:
            one = self.value.check(value, info)
        except PydanticCustomError as error:
            raise refuse(f"{error.message()}; or a list of two of them") from error
        return one, one

    def schema(self) -> dict[str, Any]:
        value, about = _accepting(self.value, ", or a list of two of them")
        one = value.get("anyOf", [value])
        both = {"type": "array", "items": value, "minItems": 2, "maxItems": 2}
        return {"anyOf": [*one, both]} | about


def _accepting(leaf: Leaf, more: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The schema of a leaf, and what stands beside it in words: its example, and what more."""
    value = leaf.schema()
    about = {key: value.pop(key) for key in ("x-unit", "x-accepts")}
    example = value.get("examples")
    if example:
        about["x-accepts"] += f', as `"{example[0]}"`'
    about["x-accepts"] += more
    return value, about


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
HertzStiffness = Annotated[float, Quantity(units.HERTZ_STIFFNESS, above=0)]
PositiveSpeed = Annotated[float, Quantity(units.VELOCITY, above=0)]
PositiveFactor = Annotated[float, Ratio(above=0)]
Weight = Annotated[float, Ratio(at_least=0)]
DampingRatio = Annotated[float, Ratio(at_least=0, below=1)]
Restitution = Annotated[float, Ratio(above=0, at_most=1)]
Number = Annotated[float, Ratio(percent=False)]
Calibrated = Literal["calibrated"]
(CALIBRATED,) = get_args(Calibrated)
"""Stands for the value that the stage `calibrate` finds."""
CalibratedStiffness = Annotated[
    float | Calibrated, OrWord(Quantity(units.STIFFNESS, above=0), CALIBRATED)
]
CalibratedRestitution = Annotated[float | Calibrated, OrWord(Ratio(above=0, at_most=1), CALIBRATED)]
