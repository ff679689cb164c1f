"""Quantities with units and numbers without, as annotations for the fields of pydantic models.

Inside the program every value is an SI float; a model made from Python takes such floats as they
are, a case file must state its units.
"""

import re
from dataclasses import KW_ONLY, dataclass
from types import NoneType
from typing import Annotated, Any, Literal, get_args

from pydantic import GetCoreSchemaHandler, ValidationInfo, ValidatorFunctionWrapHandler
from pydantic_core import CoreSchema, core_schema

from impactfem.case.base import Leaf, refuse
from impactfem.case.unit import KINDS, UnitError, scale, si_factor
from impactfem.records.file import NUMBER as NUMBER

BEYOND = 1e60  # no physical quantity in SI reaches it; a product of five of them is finite
QUANTITY = re.compile(rf"\s*({NUMBER})\s*(.*?)\s*", re.DOTALL)
_COMMA = re.compile(r"\s*([+-]?\d+),(\d+(?:[eE][+-]?\d+)?)((?:\s*[^\W\d].*?|\s*1\s*/.*?)?)\s*")
_PERCENT = re.compile(rf"\s*({NUMBER})\s*%\s*")


@dataclass(frozen=True)
class Si(Leaf):
    """A quantity, written with its unit, or a number without dimension; held as an SI float."""

    unit: str  #: SI unit, a key of `KINDS`; "-" without dimension
    _: KW_ONLY
    gt: float | None = None  #: open lower bound
    ge: float | None = None  #: closed lower bound
    lt: float | None = None  #: open upper bound
    le: float | None = None  #: closed upper bound
    percent: bool = True  #: whether a number without dimension may be a percentage
    word: str = ""  #: a word in place of a value, kept unchanged
    kind: str = ""  #: kind of quantity in words; default that of the unit

    @property
    def accepts(self) -> str:
        """The kind of quantity with its bounds."""
        lower = self.gt is not None or self.ge is not None
        bounds = (
            ("greater than", self.gt),
            ("of at least", self.ge),
            ("less than", self.lt),
            ("at most" if lower else "of at most", self.le),
        )
        unit = "" if self.unit == "-" else f" {self.unit}"
        words = [f"{word} {x:g}{unit if x else ''}" for word, x in bounds if x is not None]
        kind = "a number" if self.unit == "-" else self.kind or KINDS[self.unit].name
        return f"{kind} {' and '.join(words)}".rstrip()

    @property
    def phrase(self) -> str:
        """Expectation: kind, bounds, and an example."""
        if self.unit != "-":
            words = f"{self.accepts} with its unit, for example '{KINDS[self.unit].example}'"
        else:
            example = ", bare or as a percentage: 0.05 or '5 %'" if self.percent else ""
            words = self.accepts + example
        return f"{words}; or '{self.word}'" if self.word else words

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        limit = None if self.unit == "-" else BEYOND
        low = None if limit is None or self.gt is not None or self.ge is not None else -limit
        number = core_schema.float_schema(
            strict=True,
            allow_inf_nan=False,
            gt=self.gt,
            ge=self.ge if low is None else low,
            lt=self.lt,
            le=self.le if self.le is not None or self.lt is not None else limit,
        )
        # A word is serialised unchanged.
        whatever = core_schema.plain_serializer_function_ser_schema(lambda value: value)
        schema = core_schema.with_info_wrap_validator_function(
            self._read, number, serialization=whatever if self.word else None
        )
        return core_schema.nullable_schema(schema) if NoneType in get_args(source) else schema

    def _read(self, value: Any, number: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Any:
        if self.word and value == self.word:
            return value
        if isinstance(value, str):
            return number(self._from_text(value))
        given = isinstance(value, int | float) and not isinstance(value, bool)
        if not given or (isinstance(value, int) and abs(value) > BEYOND):
            raise refuse(f"expected {self.phrase}", kind="quantity")
        if self.unit != "-" and info.context is not None:  # that of a case file
            raise refuse(f"the unit is missing; expected {self.phrase}", kind="unit_missing")
        return number(value)

    def _from_text(self, text: str) -> float:
        if self.unit == "-":
            percent = _PERCENT.fullmatch(text) if self.percent else None
            if percent is None:
                raise refuse(f"expected {self.phrase}", kind="quantity")
            return float(percent[1]) / 100.0
        if comma := _COMMA.fullmatch(text):
            point = f"'{comma[1]}.{comma[2]}{comma[3]}'"
            expected = f"expected a decimal point, not a comma: {point}"
            raise refuse(expected, kind="decimal_comma")
        match = QUANTITY.fullmatch(text)
        if match is None:
            raise refuse(f"expected {self.phrase}", kind="quantity")
        if not match[2]:
            raise refuse(f"the unit is missing; expected {self.phrase}", kind="unit_missing")
        try:
            return scale(float(match[1]), si_factor(match[2], self.unit))
        except UnitError as error:
            raise refuse(f"{error}; expected {self.phrase}", kind="unit") from error

    def schema(self) -> dict[str, Any]:
        """The JSON schema of a text with a unit, or of a number."""
        about: dict[str, Any] = {"x-unit": self.unit, "x-accepts": self.accepts}
        text: dict[str, Any] = {
            "type": "string",
            "pattern": rf"^\s*{NUMBER}(?:\s*[A-Za-zµμ]|\s+1\s*/).*$",
        }
        if self.unit != "-":
            written = [text | {"examples": [KINDS[self.unit].example]}]
        else:
            keys = ("exclusiveMinimum", "minimum", "exclusiveMaximum", "maximum")
            bounds = zip(keys, (self.gt, self.ge, self.lt, self.le), strict=True)
            written = [{"type": "number"} | {key: x for key, x in bounds if x is not None}]
            if self.percent:
                percent = {"pattern": rf"^\s*{NUMBER}\s*%\s*$", "examples": ["5 %"]}
                written.append(text | percent)
        if self.word:
            written.append({"const": self.word})
            example = f', as `"{written[0]["examples"][0]}"`' if self.unit != "-" else ""
            about["x-accepts"] += f'{example}, or `"{self.word}"`'
        return (written[0] if len(written) == 1 else {"anyOf": written}) | about


Length = Annotated[float, Si("m")]
PositiveLength = Annotated[float, Si("m", gt=0)]
Depth = Annotated[float, Si("m", ge=0)]
Area = Annotated[float, Si("m2", gt=0)]
SecondMoment = Annotated[float, Si("m4", gt=0)]
Mass = Annotated[float, Si("kg", gt=0)]
Inertia = Annotated[float, Si("kg m2", gt=0)]
Density = Annotated[float, Si("kg/m3", gt=0)]
Time = Annotated[float, Si("s", ge=0)]
PositiveTime = Annotated[float, Si("s", gt=0)]
Duration = Annotated[float, Si("s", gt=0, le=1e5)]
TimeStep = Annotated[float, Si("s", ge=1e-9)]
Extent = Annotated[float, Si("m", gt=0, le=2000)]
ElementSize = Annotated[float, Si("m", ge=1e-2)]
Frequency = Annotated[float, Si("Hz", gt=0)]
Rate = Annotated[float, Si("1/s", ge=0)]
Acceleration = Annotated[float, Si("m/s2", gt=0)]
Stress = Annotated[float, Si("Pa", gt=0)]
HertzStiffness = Annotated[float, Si("N/m^1.5", gt=0)]
Rigid = Literal["rigid"]
(RIGID,) = get_args(Rigid)
"""Word for edges without compliance."""
EdgeStiffness = Annotated[
    float | Rigid, Si("Pa", gt=0, kind="a stiffness per length, N/m2,", word=RIGID)
]
PositiveSpeed = Annotated[float, Si("m/s", gt=0)]
PositiveFactor = Annotated[float, Si("-", gt=0)]
Weight = Annotated[float, Si("-", ge=0)]
DampingRatio = Annotated[float, Si("-", ge=0, lt=1)]
Restitution = Annotated[float, Si("-", gt=0, le=1)]
Number = Annotated[float, Si("-", percent=False)]
Calibrated = Literal["calibrated"]
(CALIBRATED,) = get_args(Calibrated)
"""Word for the value that the stage `calibrate` finds."""
CalibratedStiffness = Annotated[float | Calibrated, Si("N/m", gt=0, word=CALIBRATED)]
CalibratedRestitution = Annotated[float | Calibrated, Si("-", gt=0, le=1, word=CALIBRATED)]
