"""The mass and stiffness matrices of a device, from files of another program."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pydantic import Field

from impactfem.case.base import Section
from impactfem.case.leaf import File, read_number
from impactfem.system.errors import Fault
from impactfem.system.text_file import read_text

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
_ANCHORED = re.compile(r"([1-9][0-9]*)\.(r?[xyz])")
MOST = 1000
"""Largest number of degrees of freedom of a matrix in a file."""
SYMMETRIC = 1e-6
"""How far two entries that are to be the same may differ, of the largest entry."""


class DeviceMatricesEntry(Section):
    """Matrices of a device, in place of springs and beam: tables (CSV) in SI.

    The header of both names the degrees of freedom alike: ``1.y`` is the motion along y of the
    first support, ``2.rx`` the rotation about x of the second one; every other name is a motion of
    the device's own, absolute. Below it is the symmetric matrix, a line a row.
    """

    mass: File = Field(description="Mass matrix [kg, kg m, kg m2].")
    stiffness: File = Field(description="Stiffness matrix [N/m, N, N m].")


class DeviceMatrices(Section):
    """Matrices of a device.

    Args:
        names: Of the degrees of freedom, n of them.
        mass: n rows of n numbers [kg, kg m, kg m2].
        stiffness: Likewise [N/m, N, N m].
    """

    names: tuple[str, ...]
    mass: tuple[tuple[float, ...], ...]
    stiffness: tuple[tuple[float, ...], ...]

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
