"""Tables of a device: its modes, its matrices, the floor spectra that are given for it."""

from __future__ import annotations

import csv
import io
import itertools
import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import ValidationInfo, field_validator

from impactfem.case.base import Section, present, refuse
from impactfem.case.leaf import Whole, Words
from impactfem.case.quantity import Acceleration, Frequency, Length, Quantity, Ratio, read_number
from impactfem.case.reading import TableFile
from impactfem.case.table import MOST_POINTS, column_key, read_table
from impactfem.case.unit import INERTIA, MASS
from impactfem.system.errors import Fault
from impactfem.system.text_file import read_text


class DeviceMode(Section):
    """One mode of a device, in one direction: one row of the table of modes.

    A mode that moves along two axes, or along one and about another, has a row for each.
    """

    frequency: Frequency
    """Natural frequency."""
    effective_mass: Annotated[float, Quantity(MASS, at_least=0)] = 0.0
    """Effective mass along the axis; 0 for a mode about one."""
    effective_inertia: Annotated[float, Quantity(INERTIA, at_least=0)] = 0.0
    """Effective moment of inertia about the axis; 0 along one."""
    height: Length = 0.0
    """Of x and y: where it acts above the anchor, overturning moment over force."""
    direction: Annotated[
        str, Words("'x', 'y', 'z', 'rx', 'ry' or 'rz': along or about an axis", "r?[xyz]")
    ]
    """How it moves: along an axis, or about one."""
    damping: Annotated[float | None, Ratio(at_least=0, below=1)] = None
    """Damping ratio; without this column, by damping of the device."""

    # Checked at the only one of these columns that each table has.
    @field_validator("direction")
    @classmethod
    def _carries_something(cls, value: str, info: ValidationInfo) -> str:
        if present(info, ["effective_mass", "effective_inertia"]):
            mass, inertia = info.data["effective_mass"], info.data["effective_inertia"]
            if value.startswith("r") and not (inertia > 0.0 and mass == 0.0):
                raise refuse(
                    "expected effective_inertia above 0 and effective_mass 0 about an axis"
                )
            if not value.startswith("r") and not (mass > 0.0 and inertia == 0.0):
                raise refuse(
                    "expected effective_mass above 0 and effective_inertia 0 along an axis"
                )
        if value not in ("x", "y") and info.data.get("height", 0.0) != 0.0:
            raise refuse("expected height 0: only a mode along x or y acts above the anchor")
        return value


MODES_FILE = TableFile(
    "a table of modes (CSV)", lambda path, faults: read_table(path, DeviceMode, faults)
)
COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
_ANCHORED = re.compile(r"([1-9][0-9]*)\.(r?[xyz])")
MOST = 1000
"""Largest number of degrees of freedom of a matrix in a file."""
SYMMETRIC = 1e-6
"""How far two entries that are to be the same may differ, of the largest entry."""


@dataclass(frozen=True)
class NamedMatrix:
    """A matrix of a file.

    Args:
        names: Its header.
        rows: Its rows.
    """

    names: tuple[str, ...]
    rows: tuple[tuple[float, ...], ...]


def read_matrix(path: Path, faults: list[Fault]) -> NamedMatrix | None:
    """Read a symmetric matrix with a header; what is wrong is appended to ``faults``.

    Args:
        path: The file (CSV). Lines that begin with ``#`` and empty lines are skipped.
        faults: Every fault of the matrix is appended here.

    Returns:
        The matrix, or None when there were faults.
    """
    before = len(faults)
    text = read_text(path, "a matrix (CSV) with the names of its degrees of freedom as header")
    if isinstance(text, Fault):
        faults.append(text)
        return None
    try:
        lines = [
            (number, [cell.strip() for cell in next(csv.reader([line]))])
            for number, line in enumerate(text.splitlines(), 1)
            if line.strip() and not line.lstrip().startswith("#")
        ]
    except csv.Error as error:
        faults.append(Fault(path, "", None, f"no matrix (CSV): {error}"))
        return None
    if max(len(lines) - 1, *(len(cells) for _, cells in lines[:1]), 0) > MOST:
        expected = f"expected at most {MOST} degrees of freedom"
        faults.append(Fault(path, "", None, expected))
        return None
    names = tuple(lines[0][1]) if lines else ()
    first = f"line {lines[0][0]}" if lines else ""
    twice = sorted(name for name, count in Counter(names).items() if count > 1)
    if twice or not all(names):
        found = f"found {', '.join(twice)} twice" if twice else "one is empty"
        faults.append(Fault(path, first, None, f"expected names that are all different; {found}"))
    if names and all(read_number(name) is not None for name in names):
        expected = "expected the names of the degrees of freedom as header, found numbers"
        faults.append(Fault(path, first, None, expected))
    if len(lines) - 1 != len(names):
        expected = f"expected {len(names)} rows below the header, as it has names; found "
        faults.append(Fault(path, first, None, f"{expected}{len(lines) - 1}"))
    rows = []
    for number, cells in lines[1:]:
        values = [read_number(cell) for cell in cells]
        wrong = [cell for cell, value in zip(cells, values, strict=True) if value is None]
        if wrong:
            faults.append(Fault(path, f"line {number}", wrong[0], "expected a finite number"))
        elif len(cells) != len(names):
            expected = f"expected {len(names)} numbers as in the header, found {len(cells)}"
            faults.append(Fault(path, f"line {number}", None, expected))
        rows.append(tuple(value for value in values if value is not None))
    if len(faults) == before:
        faults.extend(_asymmetry(path, names, rows))
    return None if len(faults) > before else NamedMatrix(names, tuple(rows))


def _asymmetry(
    path: Path, names: tuple[str, ...], rows: list[tuple[float, ...]]
) -> Iterator[Fault]:
    """The first two entries that differ although they are to be the same."""
    largest = max(abs(value) for row in rows for value in row)
    for i, row in enumerate(rows):
        for k in range(i):
            if abs(row[k] - rows[k][i]) > SYMMETRIC * largest:
                expected = f"expected a symmetric matrix, found {rows[k][i]:g} at "
                where = f"{names[i]}, {names[k]}"
                yield Fault(path, where, row[k], f"{expected}{names[k]}, {names[i]}")
                return


MATRIX_FILE = TableFile("a matrix (CSV)", read_matrix, NamedMatrix((), ()))


class DeviceMatrices(Section):
    """Matrices of a device, in place of springs and beam: tables (CSV) in SI.

    The header of both names the degrees of freedom alike: ``1.y`` is the motion along y of the
    first support, ``2.rx`` the rotation about x of the second one; every other name is a motion of
    the device's own, absolute. Below it is the symmetric matrix, a line a row.
    """

    mass: Annotated[NamedMatrix, MATRIX_FILE]
    """Mass matrix [kg, kg m, kg m2]."""
    stiffness: Annotated[NamedMatrix, MATRIX_FILE]
    """Stiffness matrix [N/m, N, N m]."""

    @field_validator("stiffness")
    @classmethod
    def _of_the_same_motions(cls, value: NamedMatrix, info: ValidationInfo) -> NamedMatrix:
        if present(info, ["mass"]) and value.names != info.data["mass"].names:
            raise refuse("expected the same names in the same order as in the header of mass")
        return value

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the degrees of freedom."""
        return self.mass.names

    @property
    def anchored(self) -> dict[int, int]:
        """For each degree of freedom of a support: 6 (support - 1) + its component."""
        found = {}
        for index, name in enumerate(self.names):
            match = _ANCHORED.fullmatch(name)
            if match is not None:
                found[index] = 6 * (int(match[1]) - 1) + COMPONENTS.index(match[2])
        return found

    @property
    def own(self) -> tuple[str, ...]:
        """Names of the device's own motions."""
        return tuple(name for name in self.names if _ANCHORED.fullmatch(name) is None)

    def lacks(self, supports: int) -> Iterator[str]:
        """What does not go together with the supports of the device, in words.

        Args:
            supports: Their number.
        """
        anchored = {column // 6 + 1 for column in self.anchored.values()}
        strange = sorted(number for number in anchored if number > supports)
        if strange:
            yield (
                f"the matrices have a support {strange[0]}, the device has {supports}; expected "
                f"the motions of its supports as 1.x to {supports}.rz"
            )
        bare = [k for k in range(1, supports + 1) if k not in anchored]
        if bare:
            yield (
                f"the matrices have no motion of support {bare[0]}; expected at least one of "
                f"{', '.join(f'{bare[0]}.{name}' for name in COMPONENTS)} in their header"
            )
        if not self.own:
            yield "nothing but supports is in the matrices; expected motions of the device's own"


PRODUCT = ("building", "floor", "direction", "damping [-]", "frequency [Hz]", "broadened [m/s2]")
"""Columns of `products/floor_spectra.csv` that are read; it has more."""
Direction = Annotated[str, Words("'x', 'y' or 'z': along an axis", "[xyz]")]


class GivenPoint(Section):
    """One row of a table of floor spectra: a point of the spectrum of a direction and damping."""

    frequency: Frequency
    """Frequency, ascending or descending."""
    acceleration: Acceleration
    """Pseudo-acceleration there."""
    direction: Direction
    """Direction of the motion."""
    damping: Annotated[float, Ratio(at_least=0, below=1)]
    """Damping ratio it holds for; those of the modes must lie between the table's."""
    support: Annotated[int, Whole(1)] = 0
    """Number of the support, from 1, of a device with several; without this column the spectra are
    those of all."""


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


SPECTRA_FILE = TableFile("a table of floor spectra (CSV)", read_given_spectra, None)
