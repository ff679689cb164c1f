"""Short tables of the report, and numbers in words."""

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pint

UNITS: pint.UnitRegistry[float] = pint.UnitRegistry()
PREFIXED = {
    "N": "newton",
    "N s": "newton * second",
    "N/m": "newton / metre",
    "Pa": "pascal",
    "s": "second",
    "m": "metre",
}
SMALL = 0.1
"""Part of the ZPA, or of the largest force, without impact up to which no ratio is formed."""
RESIDUAL = 1e-9
"""Part of a spectrum with impacts up to which that without them is rounding."""


@dataclass(frozen=True)
class Facts:
    """A short table: its title, names of the columns with units, cells, and a note below it."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


def table(title: str, columns: str, rows: Iterable[Sequence[Any]], note: str = "") -> Facts:
    """A table with columns like "height [m] {:.2f}; floors {}", each with the format of a cell."""
    parts = [re.split(r" (?=± \{|\{)", column.strip(), maxsplit=1) for column in columns.split(";")]
    cells = [[f.format(v) for (_, f), v in zip(parts, row, strict=True)] for row in rows]
    return Facts(title, [name for name, _ in parts], cells, note)


def digits(value: float, count: int) -> str:
    """A value with so many digits."""
    return f"{value:.{count}g}" if np.isfinite(value) else "not known"


def number(value: float | None, digits: int = 5) -> str:
    """A value with so many digits; a dash for none."""
    if value is None:
        return "–"
    if value != 0.0 and not 1e-3 <= abs(value) < 1e6:
        return f"{value:.{digits - 1}g}" if math.isfinite(value) else "–"
    return f"{value:.{digits}g}"


def quantity(value: float | None, unit: str, *, digits: int = 5) -> str:
    """A value with its unit, with a prefix where the unit takes one, and so many digits.

    Whole numbers without a unit, as counts, have all their digits.
    """
    if value is not None and unit == "-" and float(value).is_integer():
        return f"{value:,.0f}"
    if value is None or unit == "-":
        return number(value, digits)
    if unit in PREFIXED and value != 0.0:
        compact = UNITS.Quantity(value, PREFIXED[unit]).to_compact()
        return f"{compact.magnitude:.{digits}g} {compact.units:~D}".replace(" * ", " ").replace(
            " / ", "/"
        )
    return f"{number(value, digits)} {unit}"
