"""Units as people write them (``m/s2``, ``kg m2``, ``N/m``, ``1/s``) and the kinds of quantity."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pint


class UnitError(ValueError):
    """A unit that cannot be used here; the message says why, for the user."""


@dataclass(frozen=True)
class Kind:
    """A kind of physical quantity."""

    name: str  #: what it is called in a message, with its article: ``a length``
    unit: str  #: its SI unit, which all values have inside the program
    example: str  #: a value as it may be written in a case file
    #: The only units it may be built of, by pint's names; None when the dimension alone decides. A
    #: frequency in rad/s has the dimension of one in Hz and is 2π off, so frequencies are asked for
    #: in hertz.
    symbols: frozenset[str] | None = None
    #: Units of which it must have one, by pint's names: a moment per angle has the dimension of an
    #: energy.
    one_of: frozenset[str] = frozenset()

    @property
    def phrase(self) -> str:
        """What is expected of a value, in words."""
        return f"{self.name} with its unit, for example '{self.example}'"


LENGTH = Kind("a length", "m", "1 cm")
AREA = Kind("an area", "m2", "13.86 m2")
SECOND_MOMENT = Kind("a second moment of area", "m4", "6.4e3 m4")
MASS = Kind("a mass", "kg", "2502 t")
INERTIA = Kind("a moment of inertia", "kg m2", "6.3e7 kg m2")
DENSITY = Kind("a density", "kg/m3", "2400 kg/m3")
TIME = Kind("a time", "s", "5 ms")
FREQUENCY = Kind("a frequency", "Hz", "20 Hz", frozenset({"hertz"}))
RATE = Kind("a rate", "1/s", "0.838 1/s", frozenset({"second", "minute", "hour"}))
VELOCITY = Kind("a velocity", "m/s", "0.36 m/s")
ACCELERATION = Kind("an acceleration", "m/s2", "2.3 m/s2")
FORCE = Kind("a force", "N", "121 MN")
STRESS = Kind("a stress", "Pa", "33 GPa")
STIFFNESS = Kind("a stiffness", "N/m", "1e11 N/m")
ROTATIONAL_STIFFNESS = Kind(
    "a rotational stiffness", "N m/rad", "3e7 N m/rad", one_of=frozenset({"radian", "degree"})
)
BENDING_STIFFNESS = Kind("a bending or twisting stiffness", "N m2", "8e7 N m2")
SECTION_STIFFNESS = Kind("a shear or stretching stiffness", "N", "1.2e9 N")
HERTZ_STIFFNESS = Kind("a stiffness of Hertz contact", "N/m^1.5", "2.75e9 N/m^1.5")
FLEXIBILITY = Kind("a flexibility", "m/N", "1e-11 m/N")
IMPULSE = Kind("an impulse", "N s", "829 kN s")
ENERGY = Kind("an energy", "J", "4 kJ")
ACCELERANCE = Kind("an acceleration per force", "1/kg", "1.5e-6 1/kg")

# A shear or stretching stiffness is not among them: without its name it is a force.
KINDS = (
    *(LENGTH, AREA, SECOND_MOMENT, MASS, INERTIA, DENSITY, TIME, FREQUENCY, RATE, VELOCITY),
    *(ACCELERATION, FORCE, STRESS, STIFFNESS, ROTATIONAL_STIFFNESS, BENDING_STIFFNESS),
    *(HERTZ_STIFFNESS, FLEXIBILITY, IMPULSE, ENERGY, ACCELERANCE),
)

SPELLED = (
    *("Pa", "kPa", "MPa", "GPa", "N", "kN", "MN", "GN", "m", "mm", "cm", "dm", "km", "s", "ms"),
    *("Hz", "kHz", "MHz", "kg", "g", "t", "kt", "J", "kJ", "MJ", "rad", "deg", "min", "h"),
)
"""Units as they are spelled, of which another spelling may be meant: ``Gpa``, ``KN``."""

_UNCLEAR = {"ton": "'t' (1000 kg) or 'short_ton'", "force_ton": "'tf' (1000 kg times gravity)"}
"""Units of two sizes that go by one name, and what to write."""

_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_FACTOR = r"([^\W\d_]+(?:_[^\W\d_]+)*)(?:(?:\^|\*\*)?([+-]?\d{1,2}(?:\.5)?))?"
_OPERATOR = r"(\s*[*·⋅./]\s*|\s+)"
_FIRST = re.compile(rf"(1\s*/\s*)?{_FACTOR}")
_NEXT = re.compile(rf"{_OPERATOR}{_FACTOR}")


@dataclass(frozen=True)
class _Measured:
    """A unit taken apart: factor to SI base units, exponents of the dimensions, names in it."""

    factor: float
    dimension: tuple[tuple[str, str], ...]
    symbols: frozenset[str]

    def is_of(self, kind: Kind) -> bool:
        only = kind.symbols is None or self.symbols <= kind.symbols
        one = not kind.one_of or bool(self.symbols & kind.one_of)
        return self.dimension == _measure(kind.unit).dimension and only and one


@cache
def _registry() -> pint.UnitRegistry[float]:
    """The registry of units, made on first use: importing pint takes longer than all the rest."""
    import pint

    return pint.UnitRegistry()


@lru_cache(maxsize=512)
def _measure(text: str) -> _Measured:
    import pint

    plain = text.translate(_SUPERSCRIPTS).strip()
    symbols = set()
    total = _registry().Quantity(1.0)
    position, match = 0, _FIRST.match(plain)
    try:
        while match is not None:
            operator, name, exponent = match.groups()
            parsed = _registry().parse_unit_name(name)
            if not parsed:
                raise UnitError(f"'{name}' is not a unit known here{_meant(name)}")
            symbol = parsed[0][1]
            if symbol in _UNCLEAR and "short" not in name:
                raise UnitError(f"'{name}' may be of 907 or 1000 kg; write {_UNCLEAR[symbol]}")
            symbols.add(symbol)
            # A sign of division holds for the factor behind it alone.
            sign = -1 if operator and "/" in operator else 1
            total = total * _registry().Quantity(1.0, name) ** (sign * float(exponent or 1))
            position = match.end()
            match = _NEXT.match(plain, position)
        if not position or position < len(plain):
            raise UnitError(f"'{text}' cannot be read as a unit")
        base = total.to_base_units()
    except (pint.PintError, OverflowError) as error:
        raise UnitError(f"'{text}' cannot be used as a unit here") from error
    dimension = tuple(sorted((str(k), f"{v:g}") for k, v in base.dimensionality.items()))
    return _Measured(base.magnitude, dimension, frozenset(symbols))


def _kind_of(measured: _Measured) -> Kind | None:
    return next((kind for kind in KINDS if measured.is_of(kind)), None)


def si_factor(text: str, kind: Kind) -> float:
    """Factor from a unit to the SI unit of a kind of quantity, which it must measure.

    Units are written ``cm``, ``m/s2``, ``m/s^2`` or ``kg·m²``. Where an acceleration is expected
    ``g`` is the standard gravity, elsewhere the gram; ``t`` is the tonne. UnitError where the text
    is not a unit, or measures something else.
    """
    if kind is ACCELERATION and text.strip() == "g":
        text = "standard_gravity"
    measured, si = _measure(text), _measure(kind.unit)
    if not measured.is_of(kind):
        other = _kind_of(measured)
        if other is not None:
            given = other.name
        elif measured.dimension == si.dimension:
            given = f"no unit for {kind.name}"  # rad/s where hertz is asked for
        elif measured.dimension:
            given = "a quantity of another dimension"
        else:
            given = "a number without dimension"
        raise UnitError(f"'{text}' is {given}{_meant(text, kind)}")
    return measured.factor / si.factor


def _meant(text: str, kind: Kind | None = None) -> str:
    """A question for the unit that is spelled with other capitals, of the kind if one is given."""
    for unit in SPELLED:
        alike = unit.lower() == text.strip().lower() and unit != text.strip()
        if alike and (kind is None or _measure(unit).is_of(kind)):
            return f"; did you mean '{unit}'?"
    return ""


def scale(value: float, factor: float) -> float:
    """Product of a value and a unit's factor, correctly rounded for decimal submultiples.

    1 cm becomes the float nearest to 0.01 although 0.01 itself is no float: the division by the
    inverse, a whole number, rounds only once.
    """
    inverse = round(1.0 / factor) if 0.0 < factor < 1.0 else 0
    if inverse and abs(inverse * factor - 1.0) < 4e-16:
        return value / inverse
    return value * factor


def to_si(value: float, text: str) -> tuple[float, str]:
    """Convert a value to SI and name the SI unit, whatever the kind of quantity.

    The unit is empty, ``-`` or ``%`` for a number without dimension. UnitError where the text is
    not a unit, or no kind of quantity known here has it.
    """
    if text.strip() in {"", "-"}:
        return value, "-"
    if text.strip() == "%":
        return value / 100.0, "-"
    kind = _kind_of(_measure(text))
    if kind is None:
        raise UnitError(f"'{text}' measures no kind of quantity known here")
    return scale(value, si_factor(text, kind)), kind.unit
