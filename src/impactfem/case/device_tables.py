"""Tables of a device: its modes, its matrices, the floor spectra that are given for it."""

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import scipy.linalg
from pydantic import ConfigDict

from impactfem.case.base import Section, rule
from impactfem.case.leaf import Text, Whole, Words
from impactfem.case.quantity import Acceleration, Frequency, Length, Si
from impactfem.case.reading import TableFile
from impactfem.case.table import MOST_POINTS, Table, name_and_unit, read_lines, read_table
from impactfem.case.unit import (
    UnitError,
    si_factor,
)
from impactfem.records.file import read_number
from impactfem.system.errors import Fault


class DeviceMode(Section):
    """One mode of a device, in one direction: one row of the table of modes.

    A mode that moves along two axes, or along one and about another, has a row for each.
    """

    frequency: Frequency
    """Natural frequency."""
    effective_mass: Annotated[float, Si("kg", ge=0)] = 0.0
    """Effective mass along the axis; 0 for a mode about one."""
    effective_inertia: Annotated[float, Si("kg m2", ge=0)] = 0.0
    """Effective moment of inertia about the axis; 0 along one."""
    height: Length = 0.0
    """Height of a mode along x or y above the anchor: overturning moment over force."""
    direction: Annotated[
        str, Words("'x', 'y', 'z', 'rx', 'ry' or 'rz': along or about an axis", "r?[xyz]")
    ]
    """Direction of the mode: along an axis, or about one."""
    damping: Annotated[float | None, Si("-", ge=0, lt=1)] = None
    """Damping ratio; without this column, by damping of the device."""

    # Checked at the only one of these columns that each table has.
    @rule("direction", "effective_mass", "effective_inertia")
    @staticmethod
    def _carries_something(direction: str, mass: float, inertia: float) -> Iterator[str]:
        if direction.startswith("r") and not (inertia > 0.0 and mass == 0.0):
            yield "expected effective_inertia above 0 and effective_mass 0 about an axis"
        if not direction.startswith("r") and not (mass > 0.0 and inertia == 0.0):
            yield "expected effective_mass above 0 and effective_inertia 0 along an axis"

    @rule("direction", "height")
    @staticmethod
    def _above_the_anchor(direction: str, height: float) -> Iterator[str]:
        if direction not in ("x", "y") and height != 0.0:
            yield "expected height 0: only a mode along x or y acts above the anchor"


MODES_FILE = TableFile(
    "a table of modes (CSV)", lambda path, faults: read_table(path, DeviceMode, faults)
)
COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
_ANCHORED = re.compile(r"([1-9][0-9]{0,8})\.(r?[xyz])")
_MISWRITTEN = re.compile(r"[0-9]+\.r?[xyz]", re.IGNORECASE)
MOST = 1000
"""Largest number of degrees of freedom of a matrix in a file."""
SYMMETRIC = 1e-6
"""Largest difference of two symmetric entries over the largest entry."""


@dataclass(frozen=True)
class NamedMatrix:
    """A symmetric matrix of a file, in SI."""

    names: tuple[str, ...]  #: of its degrees of freedom, from the header
    rows: tuple[tuple[float, ...], ...]
    #: whether each degree of freedom is a rotation, by the unit in the header; else a translation
    turns: tuple[bool, ...] = ()


def _read_matrix(
    path: Path, faults: list[Fault], translation: str, *rotation: str
) -> NamedMatrix | None:
    """Read a symmetric matrix (CSV), and convert it to SI.

    The header has for each degree of freedom its name and the unit of its diagonal entry, of one of
    these kinds. An entry off the diagonal has the square root of the product of two such units.
    """
    example = f"'1.y [{translation}]' and '1.rx [{rotation[0]}]'"
    what = f"a matrix (CSV) with its degrees of freedom and their units as header, {example}"
    before = len(faults)
    lines = read_lines(path, what, "the names of the degrees of freedom", faults, MOST)
    if lines is None:
        return None
    (number, headers), *table = lines
    first = f"line {number}"
    names = [name_and_unit(header)[0] for header in headers]
    twice = sorted(name for name, count in Counter(names).items() if count > 1)
    if len(names) > MOST:
        expected = f"expected at most {MOST} degrees of freedom"
        faults.append(Fault(path, first, None, expected, "matrix"))
    if twice or not all(names):
        found = f"found {', '.join(twice)} twice" if twice else "one is empty"
        faults.append(
            Fault(path, first, None, f"expected names that are all different; {found}", "matrix")
        )
    if all(read_number(name) is not None for name in names):
        expected = "expected the names of the degrees of freedom as header, found numbers"
        faults.append(Fault(path, first, None, expected, "matrix"))
        return None
    factors, turns = [], []
    for header, name in zip(headers, names, strict=True):
        kinds, unit = (translation, *rotation), name_and_unit(header)[1] or ""
        if support := _ANCHORED.fullmatch(name):
            kinds = rotation if support[2].startswith("r") else (translation,)
        try:
            kind = next((kind for kind in kinds if _measures(unit, kind)), kinds[0])
            factors.append(si_factor(unit, kind))
            turns.append(kind != translation)
        except UnitError as error:
            examples = " or ".join(f"'{name} [{kind}]'" for kind in kinds[:2])
            expected = f"{error if unit else 'no unit'}; expected the unit of the diagonal entry"
            key = f"{first}, column {header}"
            faults.append(Fault(path, key, None, f"{expected} in brackets, {examples}", "matrix"))
    if len(table) != len(names) and len(faults) == before:
        expected = f"expected {len(names)} rows below the header, as it has names; found "
        faults.append(Fault(path, first, None, f"{expected}{len(table)}", "matrix"))
    numbers = [[read_number(cell) for cell in cells] for _, cells in table]
    for (line, cells), values in zip(table, numbers, strict=True):
        if None in values:
            wrong = cells[values.index(None)]
            faults.append(Fault(path, f"line {line}", wrong, "expected a finite number", "matrix"))
    if len(faults) > before:
        return None
    K = np.array(numbers, dtype=float)
    # The first two entries that differ although they are to be the same.
    with np.errstate(over="ignore"):  # of numbers that no matrix has
        apart = np.tril(np.abs(K - K.T)) > SYMMETRIC * np.abs(K).max()
    for i, k in np.argwhere(apart)[:1]:
        expected = f"expected a symmetric matrix, found {K[k, i]:g} at {names[k]}, {names[i]}"
        faults.append(Fault(path, f"{names[i]}, {names[k]}", float(K[i, k]), expected, "matrix"))
        return None
    K *= np.sqrt(np.outer(factors, factors))
    return NamedMatrix(tuple(names), tuple(map(tuple, K.tolist())), tuple(turns))


def _measures(unit: str, kind: str) -> bool:
    try:
        si_factor(unit, kind)
    except UnitError:
        return False
    return True


def read_mass_matrix(path: Path, faults: list[Fault]) -> NamedMatrix | None:
    """Read a mass matrix (CSV) in units of its header, as kg and kg m2; None with faults."""
    return _read_matrix(path, faults, "kg", "kg m2")


def read_stiffness_matrix(path: Path, faults: list[Fault]) -> NamedMatrix | None:
    """Read a stiffness matrix (CSV) in units of its header, as N/m and N m/rad or N m."""
    return _read_matrix(path, faults, "N/m", "N m/rad", "J")


_MASS_FILE = TableFile("a mass matrix (CSV)", read_mass_matrix)
_STIFFNESS_FILE = TableFile("a stiffness matrix (CSV)", read_stiffness_matrix)


class DeviceMatrices(Section):
    """Matrices of a device, in place of springs and beam: tables (CSV).

    The header of both names the degrees of freedom alike: ``1.y`` is the motion along y of the
    first support, ``2.rx`` the rotation about x of the second one; every other name is a motion of
    the device's own, absolute. Each name has the unit of its diagonal entry in brackets: in the
    mass matrix a mass or a moment of inertia, ``1.y [t]``, ``2.rx [t m2]``; in the stiffness matrix
    ``1.y [kN/m]``, ``2.rx [kN m/rad]``. An entry off the diagonal has the square root of the
    product of the units of its row and column, as t m and kN. Below the header is the symmetric
    matrix, a line a row.
    """

    mass: Annotated[NamedMatrix, _MASS_FILE]
    """Mass matrix, with the units of mass and moment of inertia in its header."""
    stiffness: Annotated[NamedMatrix, _STIFFNESS_FILE]
    """Stiffness matrix, with the units of stiffness in its header."""

    @rule("stiffness", "mass")
    @staticmethod
    def _of_the_same_motions(stiffness: NamedMatrix, mass: NamedMatrix) -> Iterator[str]:
        if stiffness.names != mass.names:
            yield "expected the same names in the same order as in the header of mass"
        elif stiffness.turns != mass.turns:
            pairs = zip(mass.names, mass.turns, stiffness.turns, strict=True)
            name = next(name for name, of_mass, turn in pairs if of_mass != turn)
            yield f"expected units of the same motions: {name} is a rotation in one of the headers"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the degrees of freedom."""
        return self.mass.names

    @property
    def anchored(self) -> dict[int, int]:
        """For each degree of freedom of a support: 6 (support - 1) + its component."""
        matches = ((index, _ANCHORED.fullmatch(name)) for index, name in enumerate(self.names))
        return {k: 6 * (int(m[1]) - 1) + COMPONENTS.index(m[2]) for k, m in matches if m}

    @property
    def own(self) -> tuple[str, ...]:
        """Names of the device's own motions."""
        return tuple(name for name in self.names if _ANCHORED.fullmatch(name) is None)

    @property
    def total_masses(self) -> dict[str, float]:
        """Mass that moves with the supports along "x", "y" and "z", without axes they lack [kg]."""
        M, K = np.array(self.mass.rows), np.array(self.stiffness.rows)
        free = np.setdiff1d(np.arange(len(M)), list(self.anchored))
        masses = {}
        for component, axis in enumerate("xyz"):
            u = np.zeros(len(M))
            u[[k for k, column in self.anchored.items() if column % 6 == component]] = 1.0
            if u.any():
                # The device follows the supports without inertia. A mechanism is refused elsewhere.
                force = K[np.ix_(free, free)], -(K @ u)[free]
                u[free] = np.linalg.lstsq(*force, rcond=None)[0]
                masses[axis] = float(u @ M @ u)
        return masses

    @property
    def first_frequency(self) -> float | None:
        """First natural frequency on supports at rest [Hz]; None of matrices that have none."""
        M, K = np.array(self.mass.rows), np.array(self.stiffness.rows)
        free = np.ix_(*2 * [np.setdiff1d(np.arange(len(M)), list(self.anchored))])
        try:
            largest = float(scipy.linalg.eigh(M[free], K[free], eigvals_only=True)[-1])
        except (scipy.linalg.LinAlgError, ValueError, IndexError):
            return None
        return 1.0 / (2.0 * math.pi * math.sqrt(largest)) if largest > 0.0 else None

    def lacks(self, supports: int) -> Iterator[str]:
        """Contradictions to a number of supports of the device, in words."""
        wrong = [name for name in self.own if _MISWRITTEN.fullmatch(name)]
        if wrong:
            yield (
                f"{wrong[0]} is no motion of a support; expected numbers from 1 and small letters, "
                "as 1.x or 2.rz"
            )
            return
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


Direction = Annotated[str, Words("'x', 'y' or 'z': along an axis", "[xyz]")]


class GivenPoint(Section):
    """One row of a table of floor spectra: a point of the spectrum of a direction and damping."""

    frequency: Frequency
    """Frequency, ascending or descending."""
    acceleration: Acceleration
    """Pseudo-acceleration there."""
    direction: Direction
    """Direction of the motion."""
    damping: Annotated[float, Si("-", ge=0, lt=1)]
    """Damping ratio it holds for; those of the modes must lie between the table's."""
    support: Annotated[int, Whole(1)] = 0
    """Number of the support, from 1, of a device with several; without this column the spectra are
    those of all."""


class ProductPoint(Section):
    """Columns of `products/floor_spectra.csv` of a run that are read."""

    model_config = ConfigDict(extra="ignore")

    building: Text
    floor: Text
    direction: Text
    damping: Annotated[float, Si("-", ge=0, lt=1)]
    frequency: Frequency
    broadened: Annotated[float, Si("m/s2", ge=0)]


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
class GivenSpectra:
    """The spectra of a file."""

    #: All of them; in place of the support 0, where the file names none.
    curves: tuple[GivenSpectrum, ...]
    #: Building and floor of each of them, in the products of a run; else none.
    places: tuple[tuple[str, str], ...] = ()

    def at(self, building: str, floors: Sequence[int]) -> tuple[GivenSpectrum, ...]:
        """The spectra of a device in a building, by the floor of each of its supports."""
        return tuple(
            one.model_copy(update={"support": support})
            for support, floor in enumerate(floors, 1)
            for one in self._of(building, floor, support)
        )

    def lacks(self, building: str, floors: Sequence[int]) -> Iterator[str]:
        """Rows that such a device does not find in the file, in words."""
        known = {one.support for one in self.curves if one.support}
        for number in sorted(known - set(range(1, len(floors) + 1))):
            yield f"it has spectra of support {number}; expected those of 1 to {len(floors)}"
        for support, floor in enumerate(floors, 1):
            if not self._of(building, floor, support):
                what = f"floor {floor} of building {building}"
                yield f"it has no spectrum of {what if self.places else f'support {support}'}"

    def _of(self, building: str, floor: int, support: int) -> list[GivenSpectrum]:
        if not self.places:
            return [one for one in self.curves if one.support in (0, support)]
        place = (building, str(floor))
        return [one for one, of in zip(self.curves, self.places, strict=True) if of == place]


def read_given_spectra(path: Path, faults: list[Fault]) -> GivenSpectra | None:
    """Read floor spectra: `GivenPoint`, or `products/floor_spectra.csv` of a run.

    Of the latter the broadened spectra of the device's floor are taken.
    """
    header = read_lines(path, "a table of floor spectra (CSV)", "", [], MOST_POINTS)
    names = set(header[0][1]) if header else set()
    product = {"building", "floor"} <= names
    ordinate = "broadened" if product else "acceleration"
    of = ("building", "floor") if product else ("support",)
    keys = (*of, "direction", "damping")

    def in_order(table: Table[Any]) -> Iterator[Fault]:
        return table.disorder("frequency", "direction and damping", *keys)

    model: Any = ProductPoint if product else GivenPoint
    table = read_table(path, model, faults, in_order, most=MOST_POINTS)
    if table is None:
        return None
    curves, places = [], []
    for (*place, direction, damping), points in table.curves("frequency", ordinate, *keys).items():
        frequency, acceleration = zip(*sorted(points), strict=True)
        curves.append(
            GivenSpectrum(
                support=0 if product else place[0],
                direction=direction,
                damping=damping,
                frequency=frequency,
                acceleration=acceleration,
            )
        )
        places += [tuple(place)] if product else []
    return GivenSpectra(tuple(curves), tuple(places))


SPECTRA_FILE = TableFile("a table of floor spectra (CSV)", read_given_spectra)
