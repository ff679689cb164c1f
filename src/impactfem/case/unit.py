"""Units as people write them (``m/s2``, ``kg m2``, ``N/m``, ``1/s``) and the kinds of quantity."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import TYPE_CHECKING

from impactfem.records.file import ACCELERATION_UNITS, plain_unit

if TYPE_CHECKING:
    import pint


class UnitError(ValueError):
    """A unit that cannot be used here; the message says why, for the user."""


@dataclass(frozen=True)
class Kind:
    """A kind of physical quantity."""

    name: str  #: what it is called in a message, with its article: ``a length``
    example: str  #: a value as it may be written in a case file
    #: The only units it may be built of, by pint's names; None when the dimension alone decides. A
    #: frequency in rad/s has the dimension of one in Hz and is 2π off, so frequencies are given
    #: in hertz.
    symbols: frozenset[str] | None = None
    #: Units of which it must have one, by pint's names: a moment per angle has the dimension of an
    #: energy.
    one_of: frozenset[str] = frozenset()


KINDS = {
    "m": Kind("a length", "1 cm"),
    "m2": Kind("an area", "13.86 m2"),
    "m4": Kind("a second moment of area", "6.4e3 m4"),
    "kg": Kind("a mass", "2502 t"),
    "kg m2": Kind("a moment of inertia", "6.3e7 kg m2"),
    "kg/m3": Kind("a density", "2400 kg/m3"),
    "s": Kind("a time", "5 ms"),
    "Hz": Kind("a frequency", "20 Hz", frozenset({"hertz"})),
    "1/s": Kind("a rate", "0.838 1/s", frozenset({"second", "minute", "hour"})),
    "m/s": Kind("a velocity", "0.36 m/s"),
    "m/s2": Kind("an acceleration", "2.3 m/s2"),
    "N": Kind("a force", "121 MN"),
    "Pa": Kind("a stress", "33 GPa"),
    "N/m": Kind("a stiffness", "1e11 N/m"),
    "N m/rad": Kind(
        "a rotational stiffness", "3e7 N m/rad", one_of=frozenset({"radian", "degree"})
    ),
    "rad": Kind("an angle", "45 deg", one_of=frozenset({"radian", "degree"})),
    "N m2": Kind("a bending or twisting stiffness", "8e7 N m2"),
    "N/m^1.5": Kind("a stiffness of Hertz contact", "2.75e9 N/m^1.5"),
    "m/N": Kind("a flexibility", "1e-11 m/N"),
    "N s": Kind("an impulse", "829 kN s"),
    "J": Kind("an energy", "4 kJ"),
    "1/kg": Kind("an acceleration per force", "1.5e-6 1/kg"),
}
"""Kinds of quantity by the SI unit that all their values have inside the program."""

SPELLED = (
    "Pa", "kPa", "MPa", "GPa", "N", "kN", "MN", "GN", "daN", "m", "mm", "cm", "dm", "km", "kg",
    "g", "t", "kt", "s", "ms", "min", "h", "sec", "Hz", "kHz", "MHz", "J", "kJ", "MJ", "rad",
    "deg", "kgf", "tf", "lb", "lbf", "kip", "kips", "psi", "ksi", "psf", "ksf", "pcf", "ft", "in",
)  # fmt: skip
"""Units as they are spelled, of which another spelling may be meant: ``Gpa``, ``KN``."""

_TON_FORCE = "'tf' (1000 kgf), or 'kip' (a US ton is 2 kip)"
_TONNE = "'t' (1000 kg)"
_UNCLEAR = {
    "ton": f"{_TONNE} or 'short_ton' (907 kg)",
    **dict.fromkeys(("force_ton", "tonf", "Tonf", "TONF", "tonsf"), _TON_FORCE),
    **dict.fromkeys(("mt", "Mt", "MT", "T"), _TONNE),
    **dict.fromkeys(("k", "K"), "'kip' (1000 lbf)"),
    **dict.fromkeys(("kn", "Kn"), "'kN' (a force) or 'knot' (a velocity)"),
    **dict.fromkeys(("mil", "mils"), "'in' (1 mil is 0.001 in)"),
    **dict.fromkeys(("gr", "gs"), "'g'"),
    "mN": "'MN', or 'N'",
    "mPa": "'MPa', or 'Pa'",
    "Mm": "'mm', or 'km'",
    "Ms": "'ms', or 's'",
    "sq": "'ft2' or 'm2'",
    "short": "'short_ton' (907 kg)",
}
"""Names, as written or as pint has them, that are easily misread; what to write."""
_UNKNOWN = frozenset(("pcs", "a", "b", "c", "e", "u", "G", "M", "S", "P"))
"""Units of pint that no engineer writes: the parsec, the barn, the gauss."""
_ENGINEERING = {
    "kt": "Gg",
    **dict.fromkeys(("gal", "gals", "Gals", "GAL", "GALS"), "Gal"),
    "psf": "lbf/ft2",
    "ksf": "kip/ft2",
    "plf": "lbf/ft",
    "klf": "kip/ft",
    "pli": "lbf/in",
    "kli": "kip/in",
    "pcf": "lb/ft3",
    "kcf": "klb/ft3",
    "lbm": "lb",
    "kp": "kgf",
    "gm": "g",
    **dict.fromkeys(("sqft", "sf"), "ft2"),
    "sqin": "in2",
    "sqm": "m2",
    "ips": "in/s",
    "kmh": "km/h",
    "cps": "Hz",
    "°": "deg",
}
"""Names of engineers that pint does not know, or takes for others: the gallon, the knot."""
# Pint takes Nm for a measure of yarn.
_JOINED = re.compile(r"((?:k|M|G|da)?N(?=m|mm|cm|s)|(?:kgf|tf|kg|t)(?=m|mm|cm))(mm|cm|m|s)")
_WEIGHT = {"kg": "kgf", "t": "tf", "lb": "lbf", "klb": "kip"}
"""Unit of the weight of a mass, by that of the mass."""

_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻−–", "0123456789---")
_NAME = r"(?:[^\W\d_]+(?:_[^\W\d_]+)*|°)"
_FACTOR = rf"({_NAME})(?:(?:\^|\*\*)?([+-]?\d{{1,2}}(?:\.5)?))?"
_OPERATOR = r"(\s*[*·⋅./-]\s*|\s+)"
_FIRST = re.compile(rf"(1\s*/\s*)?{_FACTOR}")
_NEXT = re.compile(rf"{_OPERATOR}{_FACTOR}")
_HALVES = re.compile(r"(?<=[^\W\d_])(?:\^|\*\*)?(?:\(3/2\)|3/2)")
_DIVISOR = re.compile(r"/\s*\(([^()]*)\)")


@dataclass(frozen=True)
class _Measured:
    """A unit taken apart: factor to SI base units, exponents of the dimensions, names in it."""

    factor: float
    dimension: tuple[tuple[str, str], ...]
    symbols: frozenset[str]

    def is_of(self, unit: str) -> bool:
        """Return True if it measures the kind of quantity of an SI unit."""
        kind = KINDS[unit]
        only = kind.symbols is None or self.symbols <= kind.symbols
        one = not kind.one_of or bool(self.symbols & kind.one_of)
        return self.dimension == _measure(unit).dimension and only and one


@cache
def _registry() -> pint.UnitRegistry[float]:
    """The registry of units, made on first use: importing pint takes longer than all the rest."""
    import pint

    return pint.UnitRegistry()


def _without_brackets(text: str) -> str:
    """A unit in plain digits, without brackets: ``kN/(m·s)`` is kN/m/s, ``m^(3/2)`` is m^1.5."""
    plain = _HALVES.sub("^1.5", text.translate(_SUPERSCRIPTS).strip().removesuffix("."))

    def divided(match: re.Match[str]) -> str:
        # Behind the sign of division, products divide and quotients multiply.
        return "/" + re.sub(
            _OPERATOR, lambda sign: "*" if "/" in sign[0] else "/", match[1].strip()
        )

    return _DIVISOR.sub(divided, plain)


def _factors(text: str) -> Iterator[tuple[str, float]]:
    """Names, as pint knows them, and exponents of the factors of a unit."""
    plain = _without_brackets(text)
    position, match = 0, _FIRST.match(plain)
    while match is not None:
        operator, name, exponent = match.groups()
        # A sign of division holds for the factor behind it alone.
        sign, power = -1.0 if operator and "/" in operator else 1.0, float(exponent or 1)
        if name in _ENGINEERING:
            for part, inner in _factors(_ENGINEERING[name]):
                yield part, sign * power * inner
        elif joined := _JOINED.fullmatch(name):
            yield joined[1], sign
            yield joined[2], sign * power  # m2 of kgm2
        else:
            yield name, sign * power
        position = match.end()
        match = _NEXT.match(plain, position)
    if not position or position < len(plain):
        raise UnitError(f"'{text}' cannot be read as a unit")


@lru_cache(maxsize=512)
def _measure(text: str) -> _Measured:
    import pint

    symbols = set()
    total = _registry().Quantity(1.0)
    try:
        for name, exponent in list(_factors(text)):
            parsed = _registry().parse_unit_name(name)
            symbol = parsed[0][1] if parsed else ""
            write = _UNCLEAR.get(name, "" if name == "short_ton" else _UNCLEAR.get(symbol, ""))
            if write:
                raise UnitError(f"'{name}' is not accepted, it is easily misread; write {write}")
            if not parsed or name in _UNKNOWN:
                raise UnitError(f"'{name}' is not a unit known here{_meant(name)}")
            symbols.add(symbol)
            total = total * _registry().Quantity(1.0, name) ** exponent
        base = total.to_base_units()
    except (pint.PintError, OverflowError) as error:
        raise UnitError(f"'{text}' cannot be used as a unit here") from error
    dimension = tuple(sorted((str(k), f"{v:g}") for k, v in base.dimensionality.items()))
    return _Measured(base.magnitude, dimension, frozenset(symbols))


def _unit_of(measured: _Measured) -> str | None:
    return next((unit for unit in KINDS if measured.is_of(unit)), None)


def si_factor(text: str, unit: str) -> float:
    """Return the factor from a unit to an SI unit of `KINDS`, of which it must measure the kind.

    Units are written ``cm``, ``m/s2``, ``m/s^2`` or ``kg·m²``. Where an acceleration is expected
    ``g`` is the standard gravity, elsewhere the gram; ``t`` is the tonne. UnitError where the text
    is not a unit, or measures something else.
    """
    if unit == "m/s2" and text.strip() != "Mg":  # which is a tonne
        in_records = ACCELERATION_UNITS.get(plain_unit(text))
        if in_records is not None:
            return in_records
    measured, si = _measure(text), _measure(unit)
    if not measured.is_of(unit):
        other = _unit_of(measured)
        if other is not None:
            given = KINDS[other].name
        elif measured.dimension == si.dimension:  # rad/s in place of hertz
            given = f"not accepted as a unit of {KINDS[unit].name}; write '{unit}'"
        elif measured.dimension:
            given = "a quantity of another dimension"
        else:
            given = "a number without dimension"
        raise UnitError(f"'{text}' is {given}{_meant(text, unit) or _of_weight(text, unit)}")
    return measured.factor / si.factor


def _meant(text: str, kind: str = "") -> str:
    """A question for the unit that is spelled with other capitals, of a kind if one is given."""
    for unit in SPELLED:
        alike = unit.lower() == text.strip().lower() and unit != text.strip()
        if alike and (not kind or _measure(unit).is_of(kind)):
            return f"; did you mean '{unit}'?"
    return ""


def _of_weight(text: str, unit: str) -> str:
    """The unit to write in place of one of weights for masses, or of masses for weights."""
    for swap in (_WEIGHT, {weight: mass for mass, weight in _WEIGHT.items()}):
        names = re.split(f"({_NAME})", text)
        other = "".join(swap.get(name, name) for name in names)
        if other != text and _measure(other).is_of(unit):
            return f"; write '{other}'"
    if _measure(text).dimension == _measure(f"{unit} m/s2").dimension:
        return "; divide weights by 9.81 m/s2 and write the unit of the mass"
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
    unit = _unit_of(_measure(text))
    if unit is None:
        raise UnitError(f"'{text}' measures no kind of quantity known here")
    return scale(value, si_factor(text, unit)), unit
