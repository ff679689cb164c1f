"""The file of a fit: the free keys of a case, and the targets."""

# The methods of the leaves are described once, in their base.
# ruff: noqa: D102

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from decimal import Decimal
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, ValidationError, ValidationInfo

from impactfem.building.floor_properties import UNITS
from impactfem.case.base import Leaf, Section, once, refuse, rule
from impactfem.case.device_tables import Direction
from impactfem.case.explain import explain
from impactfem.case.leaf import FloorNumbers, Text, Whole
from impactfem.case.place import Place, value_at
from impactfem.case.quantity import (
    QUANTITY,
    Acceleration,
    DampingRatio,
    Frequency,
    Length,
    Si,
)
from impactfem.case.reading import Reading, TableFile
from impactfem.case.source import EXTENDS, Source, parse
from impactfem.case.table import MOST_POINTS, Table, read_table
from impactfem.case.unit import UnitError, to_si
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import Fault, InputError
from impactfem.system.files import LARGEST_TOML, read_text

LEAST = 1e-9
"""Least standard deviation as a part of the value, and least change of a key by its step as a part
of the key: the case has values of twelve digits, and results are reproduced to about 1e-9."""
LARGEST = 1e60
"""Limit of all numbers in SI, as in the case file; squares of their ratios are finite."""
POSITIVE = ("Hz", "kg", "kg m2", "m2", "m4")
"""SI units of results that are never negative: frequencies, masses, inertia, sections."""


@dataclass(frozen=True)
class Given:
    """A number as it is written, in SI."""

    value: float
    unit: str  #: SI unit; "-" without one
    #: Standard deviation of what its last printed digit leaves open, in SI; nan of a bare number
    #: with a point, of which TOML keeps no zeros at the end.
    rounding: float


@dataclass(frozen=True)
class Quantity(Leaf):
    """A number, or a quantity with its unit; held as `Given`.

    With `part`, a number without a unit is a part of another value, as in the case file: 0.05 and
    "5 %" are the same. Its unit is "%" then.
    """

    part: bool = False

    @property
    def phrase(self) -> str:
        if self.part:
            return "a part of the value, 0.05 or '5 %', or a quantity with its unit, '0.1 Hz'"
        return "a number, or a quantity with its unit, for example '1.80 Hz'"

    def check(self, value: Any, info: ValidationInfo) -> Given:
        if isinstance(value, Given):
            return value
        number = isinstance(value, int | float) and not isinstance(value, bool)
        text = repr(value) if number else value if isinstance(value, str) else ""
        match = QUANTITY.fullmatch(text)
        if match is None:
            raise refuse(f"expected {self.phrase}")
        try:
            found, unit = to_si(float(match[1]), match[2])
            digit = 10.0 ** int(Decimal(match[1]).as_tuple().exponent)
            # Evenly spread over the width of the last digit.
            rounding = abs(to_si(digit, match[2])[0]) / math.sqrt(12.0)
            rounding = math.nan if isinstance(value, float) else rounding
        except UnitError as error:
            raise refuse(f"{error}; expected {self.phrase}") from error
        except OverflowError:
            found, unit, rounding = math.inf, "", 0.0
        if not math.isfinite(found) or rounding == 0.0:
            raise refuse(f"expected a finite value: {self.phrase}")
        if abs(found) > LARGEST:
            raise refuse(f"expected a value of at most {LARGEST:g} in SI units: {self.phrase}")
        return Given(found, "%" if self.part and unit == "-" else unit, rounding)

    def schema(self) -> dict[str, Any]:
        return {"anyOf": [{"type": "number"}, {"type": "string"}], "x-accepts": self.phrase}


Value = Annotated[Given, Quantity()]
Spread = Annotated[Given, Quantity(part=True)]
Part = Annotated[float, Si("-", ge=LEAST, le=LARGEST)]


def spread(deviation: Given, value: float) -> float:
    """Return a standard deviation in SI, of a value where it is a part of it."""
    return deviation.value * abs(value) if deviation.unit == "%" else deviation.value


class Prior(Section):
    """Prior of a key: a normal distribution, log-normal on a logarithmic scale."""

    mean: Value
    """Its mean."""
    deviation: Spread
    """Its standard deviation: a part of the mean, 0.05 or "5 %", or a quantity with its unit."""


class FreeKey(Section):
    """A key of the case that is fitted."""

    bounds: tuple[Value, Value]
    """Least and largest value."""
    scale: Literal["linear", "log"] = "linear"
    """Whether the key or its logarithm is fitted."""
    start: Value | None = None
    """First start; default the value of the case."""
    prior: Prior | None = None
    """Its prior distribution; default: only the bounds."""
    step: Annotated[float, Si("-", ge=1e-6, le=0.1)] = Field(default=1e-3, validate_default=True)
    """Step of differences, as part of the range between the bounds."""

    @rule("bounds")
    @staticmethod
    def _ordered(bounds: tuple[Given, Given]) -> Iterator[str]:
        if bounds[0].unit != bounds[1].unit:
            yield "expected one unit for both bounds"
        elif bounds[0].value >= bounds[1].value:
            yield "expected bounds in order, the lower one first"

    @rule("scale", "bounds")
    @staticmethod
    def _positive(scale: str, bounds: tuple[Given, Given]) -> Iterator[str]:
        if scale == "log" and bounds[0].value <= 0.0:
            yield "expected bounds above zero for a logarithmic scale"

    @rule("step", "bounds", "scale")
    @staticmethod
    def _apart(step: float, bounds: tuple[Given, Given], scale: str) -> Iterator[str]:
        low, high = (one.value for one in bounds)
        if not low < high or (scale == "log" and low <= 0.0):
            return  # another rule says so
        size = max(abs(low), abs(high))
        part = math.log(high / low) if scale == "log" else (high - low) / size
        if step * part < LEAST:
            yield (
                f"a step of {step:g} of the range between these bounds changes the key by "
                f"{step * part:.2g} of its value; expected at least {LEAST:g}: bounds farther apart"
            )

    @rule("start", "bounds")
    @staticmethod
    def _inside(start: Given | None, bounds: tuple[Given, Given]) -> Iterator[str]:
        low, high = bounds
        if start is not None and start.unit != low.unit:
            yield f"expected the unit of the bounds, {low.unit}"
        elif start is not None and not low.value <= start.value <= high.value:
            yield f"expected a start within the bounds, {low.value:g} to {high.value:g} {low.unit}"

    @rule("prior", "bounds", "scale")
    @staticmethod
    def _on_the_scale(
        prior: Prior | None, bounds: tuple[Given, Given], scale: str
    ) -> Iterator[str]:
        if prior is None:
            return
        if scale == "log" and prior.mean.value <= 0.0:
            yield "expected a mean above zero for a logarithmic scale"
        for one in (prior.mean, prior.deviation):
            if one.unit not in (bounds[0].unit, "%"):
                yield f"expected the unit of the bounds, {bounds[0].unit}"
        low, high = (one.value for one in bounds)
        width = spread(prior.deviation, prior.mean.value)
        if width <= 0.0 or width < LEAST * max(abs(prior.mean.value), high - low):
            yield f"expected a deviation of at least {LEAST:g} of the mean and of the bounds' range"

    def scaled(self, value: float) -> float:
        """Scale a value to 0 at the lower and 1 at the upper bound."""
        low, high, x = (
            self._on(one) for one in (self.bounds[0].value, self.bounds[1].value, value)
        )
        return (x - low) / (high - low)

    def value(self, u: float) -> float:
        """Return the value at a place u on that scale."""
        low, high = (self._on(one.value) for one in self.bounds)
        x = low + u * (high - low)
        return math.exp(x) if self.scale == "log" else x

    def slope(self, u: float) -> float:
        """∂value/∂u."""
        low, high = (self._on(one.value) for one in self.bounds)
        return (high - low) * (self.value(u) if self.scale == "log" else 1.0)

    def _on(self, value: float) -> float:
        return math.log(value) if self.scale == "log" else value

    @property
    def scaled_prior(self) -> tuple[float, float] | None:
        """Mean and standard deviation of the prior on the scale of the fit."""
        if self.prior is None:
            return None
        mean = self.prior.mean.value
        u = self.scaled(mean)
        return u, spread(self.prior.deviation, mean) / self.slope(u)


class ScalarTarget(Section):
    """A scalar result, by its name in summary.json."""

    type: Literal["scalar"] = "scalar"
    """A scalar result."""
    result: Text
    """Its name, for example building.frequency.1."""
    value: Value
    """Its value, as a text where its digits say how precise it is: "1.80" has two after the point,
    the bare number 1.80 one."""
    deviation: Spread | None = Field(default=None, validate_default=True)
    """Standard deviation: a part of the model's value, 0.05 or "5 %", or a quantity with its unit;
    default that of a value rounded to its printed digits, which a bare number with a point has
    not."""

    @rule("deviation", "value")
    @staticmethod
    def _of_the_value(deviation: Given | None, value: Given) -> Iterator[str]:
        yield from _wrong_deviation(deviation, value)

    @rule("value", "result")
    @staticmethod
    def _positive(value: Given, result: str) -> Iterator[str]:
        zero = value.value == 0.0 and "effective_mass" not in result
        if value.unit in POSITIVE and (value.value < 0.0 or zero):
            yield f"must be greater than 0: a result in {value.unit}"


def _wrong_deviation(deviation: Given | None, value: Given) -> Iterator[str]:
    if deviation is None and math.isnan(value.rounding):
        yield (
            'missing; expected a deviation, or the value as a text, as "1.80", whose digits say '
            "how precise it is"
        )
    elif deviation is not None and deviation.unit not in ("%", value.unit):
        yield f"expected a part of the value, as '5 %', or the unit of the value, {value.unit}"
    else:
        width = value.rounding if deviation is None else spread(deviation, value.value)
        yield from _too_small(width, value.value, value.unit)


def _too_small(width: float, value: float, unit: str) -> Iterator[str]:
    """Yield the fault of a deviation of zero or below what results are reproduced to."""
    least = LEAST * (abs(value) or LEAST)
    if width < least:
        yield (
            f"the standard deviation {width:.3g} {unit} is too small for a value of {value:g} "
            f"{unit}; expected at least {least:.3g} {unit}, for example deviation = '0.1 %'"
        )


class FloorTarget(Section):
    """Mass and inertia of floors of a 3D model, or the section of the storeys below them."""

    type: Literal["floor"]
    """Floors of a 3D model."""
    building: Text
    """Name of the building."""
    floors: FloorNumbers
    """Numbers of the floors."""
    quantity: Literal["mass", "Jx", "Jy", "Jz", "A", "Avy", "Avx", "Ix", "Iy"]
    """Their quantity, by the column of the floor table."""
    value: Value | None = None
    """Its value, of all of these floors; default that of the floor table of each."""
    deviation: Spread | None = Field(default=None, validate_default=True)
    """Standard deviation, as that of a scalar; without a value a part."""

    _each_once = once("floors", "floor")

    @rule("value", "quantity")
    @staticmethod
    def _of_the_quantity(value: Given | None, quantity: str) -> Iterator[str]:
        if value is not None and value.unit != UNITS[quantity]:
            yield f"expected a value in {UNITS[quantity]}, the unit of {quantity}"
        elif value is not None and value.value <= 0.0:
            yield f"must be greater than 0: a {quantity}"

    @rule("deviation", "value")
    @staticmethod
    def _of_the_value(deviation: Given | None, value: Given | None) -> Iterator[str]:
        if value is not None:
            yield from _wrong_deviation(deviation, value)
        elif deviation is not None and deviation.unit == "%" and deviation.value < LEAST:
            yield f"expected a deviation of at least {LEAST:g} of the value"


class MeasuredMode(Section):
    """A row of a table of measured modes."""

    MAY_BE_EMPTY: ClassVar[tuple[str, ...]] = ("damping",)
    mode: Annotated[int, Whole(1)]
    """Number of the mode, as in the table of its shape."""
    frequency: Frequency
    """Natural frequency."""
    damping: Annotated[float | None, Si("-", gt=0, lt=1)] = None
    """Damping ratio."""


class MeasuredShape(Section):
    """A row of a table of measured shapes: one sensor in one mode."""

    mode: Annotated[int, Whole(1)]
    """Number of the mode."""
    x: Length
    """Place of the sensor."""
    y: Length
    """Place of the sensor."""
    z: Length
    """Place of the sensor."""
    direction: Direction
    """Direction of the sensor."""
    amplitude: Annotated[float, Si("-", percent=False, ge=-LARGEST, le=LARGEST)]
    """Amplitude, of any scale, with its sign."""


def _measured_modes(path: Path, faults: list[Fault]) -> Table[MeasuredMode] | None:
    return read_table(path, MeasuredMode, faults, lambda table: table.duplicates("mode"))


def _measured_shapes(path: Path, faults: list[Fault]) -> Table[MeasuredShape] | None:
    def still(table: Table[MeasuredShape]) -> Iterator[Fault]:
        for number in dict.fromkeys(row.mode for row in table.rows):
            own = [(line, row.amplitude) for line, row in table if row.mode == number]
            if len(own) < 2 or not any(amplitude for _, amplitude in own):
                expected = "expected two sensors or more of each mode, not all at rest"
                yield table.fault(own[0][0], "mode", number, expected)

    return read_table(
        path,
        MeasuredShape,
        faults,
        lambda table: table.duplicates("mode", "x", "y", "z", "direction"),
        still,
        most=MOST_POINTS,
    )


class ModesTarget(Section):
    """Measured modes of a building: frequencies, damping ratios, shapes at sensors."""

    type: Literal["modes"]
    """Measured modes."""
    building: Text
    """Name of the building: of its 3D model where it has one, else of its stick."""
    modes: Annotated[tuple[MeasuredMode, ...], TableFile("a table of modes (CSV)", _measured_modes)]
    """Table of the modes: a CSV file."""
    shapes: Annotated[
        tuple[MeasuredShape, ...], TableFile("a table of shapes (CSV)", _measured_shapes)
    ]
    """Table of their shapes: a CSV file, one row a sensor and mode. A mode of the model is the
    measured one that its shape is most like, by the MAC."""
    frequency_deviation: Spread = Given(0.005, "%", 0.0)
    """Standard deviation of the frequencies: a part of the model's, 0.005 or "0.5 %", or a
    quantity in Hz."""
    damping_deviation: Spread = Given(0.2, "%", 0.0)
    """Standard deviation of the damping ratios, as a part of the model's."""
    shape_deviation: Part = 0.05
    """Standard deviation of the amplitudes, as part of the largest one of each mode."""

    @property
    def places(self) -> Array:
        """Places of the sensors, shape (n, 3) [m]."""
        return np.array([(one.x, one.y, one.z) for one in self.shapes])

    @property
    def along(self) -> Index:
        """Their directions: 0, 1 or 2, shape (n,)."""
        return np.array(["xyz".index(one.direction) for one in self.shapes])

    @rule("frequency_deviation", "modes")
    @staticmethod
    def _in_hertz(deviation: Given, modes: tuple[MeasuredMode, ...]) -> Iterator[str]:
        if deviation.unit not in ("%", "Hz") or deviation.value <= 0.0:
            yield "expected a part of the frequencies, as '0.5 %', or a frequency above zero"
        else:
            largest = max(one.frequency for one in modes)
            yield from _too_small(spread(deviation, largest), largest, "Hz")

    @rule("damping_deviation")
    @staticmethod
    def _of_a_ratio(deviation: Given) -> Iterator[str]:
        if deviation.unit != "%" or deviation.value < LEAST:
            yield f"expected a part of the damping ratios of at least {LEAST:g}, as '20 %'"

    @rule("shapes", "modes")
    @staticmethod
    def _of_each_mode(
        shapes: tuple[MeasuredShape, ...], modes: tuple[MeasuredMode, ...]
    ) -> Iterator[str]:
        listed, shown = {one.mode for one in modes}, {one.mode for one in shapes}
        if listed != shown:
            numbers = ", ".join(map(str, sorted(listed ^ shown)))
            yield f"expected the shapes of the listed modes; one table has no mode {numbers}"


class Ordinate(Section):
    """A row of a table of a measured spectrum."""

    frequency: Frequency
    """Frequency of the oscillator."""
    psa: Acceleration
    """Pseudo-acceleration."""


def _ordinates(path: Path, faults: list[Fault]) -> Table[Ordinate] | None:
    most = MOST_POINTS
    return read_table(path, Ordinate, faults, lambda t: t.duplicates("frequency"), most=most)


class SpectrumTarget(Section):
    """Ordinates of a floor response spectrum, of a stick or of a 3D model."""

    type: Literal["spectrum"]
    """A floor response spectrum."""
    building: Text
    """Name of the building."""
    floor: Annotated[int, Whole(1)] | None = None
    """Floor at whose mass centre it is, of the stick; or a probe."""
    probe: Text | None = None
    """Name of a probe of the 3D model, as in transient.nc."""
    direction: Literal["x", "y", "z"]
    """Direction in which the floor moves."""
    damping: DampingRatio
    """Damping ratio of the oscillators, one of [spectra]."""
    spectrum: Annotated[tuple[Ordinate, ...], TableFile("a spectrum (CSV)", _ordinates)]
    """Table of the spectrum: a CSV file."""
    deviation: Part = 0.1
    """Standard deviation of the ordinates, as part of each of the model's."""

    @rule("probe", "floor")
    @staticmethod
    def _one_place(probe: str | None, floor: int | None) -> Iterator[str]:
        if (probe is None) == (floor is None):
            yield "expected either floor or probe"


Target = ScalarTarget | FloorTarget | ModesTarget | SpectrumTarget


class FitFile(Section):
    """The free keys and the targets of a fit."""

    free: dict[str, FreeKey] = Field(min_length=1)
    """The free keys of the case."""
    targets: tuple[Annotated[Target, Field(discriminator="type")], ...] = Field(min_length=1)
    """The targets."""
    starts: Annotated[int, Whole(1, 1000)] = 3
    """Number of starts; those after the first are drawn inside the bounds."""
    seed: Annotated[int, Whole(0)] = 0
    """Seed of the starts."""
    coarse: dict[str, Any] = Field(default={})
    """Keys of the mesh and of the number of modes with values that make the case cheaper: the
    search is done with these, and corrected by the case itself."""

    @rule("targets")
    @staticmethod
    def _one_table(targets: tuple[Target, ...]) -> Iterator[str]:
        named = [one.building for one in targets if isinstance(one, ModesTarget)]
        if len(set(named)) < len(named):
            yield "expected one target of measured modes for each building at most"


def read_fit(path: Path, faults: list[Fault]) -> tuple[FitFile | None, Source]:
    """Read the file of a fit and the tables that it names; nothing of the case is read.

    Returns:
        What it says, None where it or one of its tables has faults, which are added; and the same
        as it is written, as far as that is TOML.
    """
    text = read_text(path, "a file of a fit (TOML)", LARGEST_TOML)
    try:
        if isinstance(text, Fault):
            raise InputError([text])
        source = Source(path, parse(path, text))
        if source.raw.keys() & {"buildings", EXTENDS} and not source.raw.keys() & {
            "free",
            "targets",
        }:
            expected = "this is a case; expected the file of a fit, with [free] and [[targets]]"
            raise InputError([Fault(path, "", None, expected)])
    except InputError as error:
        faults += error.faults
        return None, Source(path)
    targets = source.raw.get("targets")
    for target in targets if isinstance(targets, list) else ():
        if isinstance(target, dict):
            target.setdefault("type", "scalar")
    reading = Reading(source)
    own, found = list[Fault](), None
    try:
        found = FitFile.model_validate(source.raw, context=reading)
    except ValidationError as error:
        own = explain(error.errors(), source, FitFile)
    own += reading.faults
    faults += [_quoted(fault, source.raw) for fault in own]
    return None if own else found, source


def written(source: Source, place: Place, expected: str) -> Fault:
    """Return a fault at a place of the fit file, with the value that is written there if any."""
    value = value_at(place, source.raw)
    shown = None if isinstance(value, dict) else value
    return _quoted(source.fault(place, shown, expected), source.raw)


def _quoted(fault: Fault, raw: Mapping[str, Any]) -> Fault:
    """Put the name of a key of the case into quotes, as TOML requires for a name with points."""
    table = fault.key.partition(".")[0]
    keys = raw.get(table) if table in ("free", "coarse") else ()
    for name in sorted(keys, key=len, reverse=True) if isinstance(keys, dict) else ():
        rest = fault.key.removeprefix(f"{table}.{name}")
        if rest != fault.key and rest[:1] in ("", ".", "["):
            return replace(fault, key=f'{table}."{name}"{rest}')
    return fault


def measured_shape(target: ModesTarget, number: int) -> Array:
    """Amplitudes of a measured mode in the order of its table, the largest one 1, shape (n,)."""
    amplitude = np.array([row.amplitude for row in target.shapes if row.mode == number])
    return np.asarray(amplitude / np.abs(amplitude).max())
