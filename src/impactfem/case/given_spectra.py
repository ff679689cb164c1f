"""Floor spectra that are given for a device: a table of its own, or the products of a run."""

from __future__ import annotations

import csv
import io
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field

from impactfem.case.base import Section
from impactfem.case.leaf import Acceleration, Frequency, Ratio, Whole, Words, read_number
from impactfem.case.table import MOST_POINTS, column_key, read_table
from impactfem.system.errors import Fault
from impactfem.system.text_file import read_text

PRODUCT = ("building", "floor", "direction", "damping [-]", "frequency [Hz]", "broadened [m/s2]")
"""Columns of `products/floor_spectra.csv` that are read; it has more."""
Direction = Annotated[str, Words("'x', 'y' or 'z': along an axis", "[xyz]")]


class GivenPoint(Section):
    """One row of a table of floor spectra: a point of the spectrum of a direction and damping."""

    frequency: Frequency = Field(description="Frequency, ascending or descending.")
    acceleration: Acceleration = Field(description="Pseudo-acceleration there.")
    direction: Direction = Field(description="Direction of the motion.")
    damping: Annotated[float, Ratio(at_least=0, below=1)] = Field(
        description="Damping ratio it holds for; those of the modes must lie between the table's."
    )
    support: Annotated[int, Whole(1)] = Field(
        default=0,
        description="Number of the support, from 1, of a device with several; without this column "
        "the spectra are those of all.",
    )


class GivenSpectrum(Section):
    """The spectrum of one support, direction and damping.

    Args:
        support: Number of the support, from 1.
        direction: "x", "y" or "z".
        damping: Damping ratio [-].
        frequency: Ascending [Hz].
        acceleration: Pseudo-acceleration at these [m/s2].
    """

    support: int
    direction: str
    damping: float
    frequency: tuple[float, ...]
    acceleration: tuple[float, ...]


@dataclass(frozen=True)
class _Curve:
    """A spectrum of a file, with where it holds as the file says it."""

    support: int
    building: str
    floor: str
    direction: str
    damping: float
    frequency: tuple[float, ...]
    acceleration: tuple[float, ...]


@dataclass(frozen=True)
class GivenSpectra:
    """The spectra of a file.

    Args:
        curves: All of them.
        product: Whether they are the products of a run, for all floors of its buildings.
    """

    curves: tuple[_Curve, ...]
    product: bool

    def at(self, building: str, floors: Sequence[int]) -> tuple[GivenSpectrum, ...]:
        """The spectra of a device.

        Args:
            building: Name of the building it stands in.
            floors: Number of the floor of each of its supports.
        """
        return tuple(
            GivenSpectrum(
                support=support,
                direction=one.direction,
                damping=one.damping,
                frequency=one.frequency,
                acceleration=one.acceleration,
            )
            for support, floor in enumerate(floors, 1)
            for one in self.curves
            if self._holds(one, building, floor, support)
        )

    def lacks(self, building: str, floors: Sequence[int]) -> Iterator[str]:
        """What a device does not find in the file, in words; arguments as above."""
        known = {one.support for one in self.curves if one.support}
        for number in sorted(known - set(range(1, len(floors) + 1))):
            yield f"it has spectra of support {number}; expected those of 1 to {len(floors)}"
        for support, floor in enumerate(floors, 1):
            if not any(self._holds(one, building, floor, support) for one in self.curves):
                yield (
                    f"it has no spectrum of floor {floor} of building {building}"
                    if self.product
                    else f"it has no spectrum of support {support}"
                )

    def _holds(self, one: _Curve, building: str, floor: int, support: int) -> bool:
        if self.product:
            return (one.building, one.floor) == (building, str(floor))
        return one.support in (0, support)


def read_given_spectra(path: Path, faults: list[Fault]) -> GivenSpectra | None:
    """Read floor spectra; what is wrong with them is appended to ``faults``.

    Args:
        path: A CSV file with the columns of ``GivenPoint``, or `products/floor_spectra.csv` of a
            run, of which the broadened spectra of the device's floor are taken.
        faults: Every fault of the table is appended here.

    Returns:
        The spectra, or None when there were faults.
    """
    before = len(faults)
    text = read_text(path, "a table of floor spectra (CSV)")
    if isinstance(text, Fault):
        faults.append(text)
        return None
    header = next((line for line in text.splitlines() if line.strip()), "")
    product = {"building", "floor"} <= {cell.strip() for cell in header.split(",")}
    try:
        rows = _product_rows(path, text, faults) if product else _table_rows(path, faults)
    except csv.Error as error:
        faults.append(Fault(path, "", None, f"no table (CSV) of floor spectra: {error}"))
    if len(faults) > before:
        return None
    curves = []
    for place, points in rows.items():
        if len(points) < 2:
            line = points[0][0]
            expected = "expected at least 2 frequencies of each direction and damping"
            faults.append(Fault(path, f"line {line}", None, expected))
            continue
        sign = math.copysign(1.0, points[1][1] - points[0][1])
        for (_, a, _), (line, b, _) in itertools.pairwise(points):
            if (b - a) * sign <= 0.0:
                expected = (
                    "expected the frequencies of a direction and damping in order, each once; "
                    f"before: {a:g} Hz"
                )
                faults.append(Fault(path, column_key(line, "frequency"), f"{b:g} Hz", expected))
                break  # one says it of all that follow
        pairs = sorted((f, S) for _, f, S in points)
        curves.append(_Curve(*place, tuple(f for f, _ in pairs), tuple(S for _, S in pairs)))
    return None if len(faults) > before else GivenSpectra(tuple(curves), product)


# By support, building, floor, direction and damping: the lines, frequencies and ordinates.
_Rows = dict[tuple[int, str, str, str, float], list[tuple[int, float, float]]]


def _table_rows(path: Path, faults: list[Fault]) -> _Rows:
    table = read_table(path, GivenPoint, faults, MOST_POINTS)
    rows: _Rows = {}
    for line, row in zip(table.lines, table.rows, strict=True) if table is not None else ():
        place = (row.support, "", "", row.direction, row.damping)
        rows.setdefault(place, []).append((line, row.frequency, row.acceleration))
    return rows


def _product_rows(path: Path, text: str, faults: list[Fault]) -> _Rows:
    """The broadened spectra of the products of a run."""
    count = text.count("\n")
    if count > MOST_POINTS + 1:
        expected = f"{count} lines; expected at most {MOST_POINTS} points of spectra"
        faults.append(Fault(path, "", None, expected))
        return {}
    table = csv.DictReader(io.StringIO(text))
    missing = [name for name in PRODUCT if name not in (table.fieldnames or ())]
    if missing:
        expected = f"missing columns of products/floor_spectra.csv: {', '.join(missing)}"
        faults.append(Fault(path, "line 1", None, expected))
        return {}
    rows: _Rows = {}
    for row in table:
        cells = [(row[name] or "").strip() for name in PRODUCT]
        numbers = [read_number(cell) for cell in cells[3:]]
        damping, frequency, ordinate = (math.nan if n is None else n for n in numbers)
        if not (0.0 <= damping < 1.0 and frequency > 0.0 and ordinate >= 0.0):
            expected = "expected a damping from 0 to 1, a positive frequency and an acceleration"
            found = ", ".join(cells[3:])
            faults.append(Fault(path, f"line {table.line_num}", found, expected))
            continue
        place = (0, cells[0], cells[1], cells[2], damping)
        rows.setdefault(place, []).append((table.line_num, frequency, ordinate))
    if not rows and not faults:
        faults.append(Fault(path, "", None, "the table has no row below its header"))
    return rows
