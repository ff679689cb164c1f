"""Tables of walls with their bays, of beams and of columns of a generated mesh."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, TypeVar

from pydantic import ValidationInfo, field_validator

from impactfem.case.base import Section, nearest, present, refuse
from impactfem.case.leaf import LONGEST_NAME, Floors, Storeys, Text, Whole, Words
from impactfem.case.quantity import Depth, Length, PositiveLength
from impactfem.case.table import Table, column_key, read_table
from impactfem.system.errors import Fault

TOUCH = 1e-6  # m: what is closer than this touches

MOST_MEMBERS = 2000

MemberName = Annotated[
    str,
    Words(
        "a name of a-z, 0-9 and single '_', for example 'gable_west'",
        "[a-z0-9]+(?:_[a-z0-9]+)*",
        longest=LONGEST_NAME,
    ),
]


@dataclass(frozen=True)
class Site:
    """What the tables of a structure are checked against; None is not known, and not checked.

    Args:
        length: Length of the plan along x [m].
        width: Width of the plan along y [m].
        heights: Height of each storey [m] by its number, which is that of the floor above it.
    """

    length: float | None = None
    width: float | None = None
    heights: dict[int, float] | None = None


class Member(Section, ABC):
    """A row of a table of walls, beams or columns."""

    kind: ClassVar[str]  # what it is; the column of its name as well
    levels_column: ClassVar[str]

    @property
    def name(self) -> str:
        """Its name, unique in the table."""
        return str(getattr(self, self.kind))

    @property
    def levels(self) -> tuple[int, ...]:
        """The storeys or floors it is in."""
        levels: tuple[int, ...] = getattr(self, self.levels_column)
        return levels

    @property
    @abstractmethod
    def coordinates(self) -> dict[str, float]:
        """Coordinates in plan [m] by their column, which begins with x or y."""

    @abstractmethod
    def lies_on(self, other: Member) -> bool:
        """Whether two of a kind share more than points in plan."""


class Line(Member):
    """A straight member in plan, from (x1, y1) to (x2, y2)."""

    @field_validator("y2", check_fields=False)
    @classmethod
    def _two_ends(cls, value: float, info: ValidationInfo) -> float:
        if present(info, ["x1", "y1", "x2"]):
            x1, y1, x2 = (info.data[name] for name in ("x1", "y1", "x2"))
            if math.hypot(x2 - x1, value - y1) <= TOUCH:
                raise refuse("expected an end (x2, y2) away from (x1, y1)")
        return value

    @property
    def coordinates(self) -> dict[str, float]:
        """Coordinates of both ends [m] by their column."""
        return {name: float(getattr(self, name)) for name in ("x1", "y1", "x2", "y2")}

    @property
    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Both ends in plan [m]."""
        x1, y1, x2, y2 = self.coordinates.values()
        return (x1, y1), (x2, y2)

    @property
    def length(self) -> float:
        """Distance between the ends [m]."""
        return math.dist(*self.ends)

    def lies_on(self, other: Member) -> bool:
        """Whether two lie in one line and share more than an end."""
        if not isinstance(other, Line):
            return False
        (x1, y1), (x2, y2) = self.ends
        L = self.length
        tx, ty = (x2 - x1) / L, (y2 - y1) / L
        along = [(x - x1) * tx + (y - y1) * ty for x, y in other.ends]
        across = [(y - y1) * tx - (x - x1) * ty for x, y in other.ends]
        shared = min(L, max(along)) - max(0.0, min(along))
        return shared > TOUCH and max(map(abs, across)) <= TOUCH


MemberRow = TypeVar("MemberRow", bound=Member)


def read_members(
    path: Path, model: type[MemberRow], site: Site, faults: list[Fault]
) -> Table[MemberRow] | None:
    """Read a table of walls, beams or columns; what is wrong with it is appended to ``faults``.

    Args:
        path: A CSV file with the columns of the model.
        model: ``Wall``, ``Beam`` or ``Column``.
        site: Where they stand.
        faults: Every fault of the table is appended here.

    Returns:
        The rows with the lines they stand on, or None when there were faults.
    """
    table = read_table(path, model, faults, MOST_MEMBERS)
    if table is None:
        return None
    broken = [
        *_name_faults(path, table),
        *_level_faults(path, table, site),
        *_plan_faults(path, table, site),
        *_twice_faults(path, table),
    ]
    faults.extend(broken)
    return None if broken else table


def _name_faults(path: Path, table: Table[MemberRow]) -> Iterator[Fault]:
    seen: dict[str, int] = {}
    for line, row in zip(table.lines, table.rows, strict=True):
        first = seen.setdefault(row.name, line)
        if first != line:
            key = column_key(line, table.headers[row.kind])
            expected = f"duplicate {row.kind}, the first is in line {first}"
            yield Fault(path, key, row.name, expected)


def _level_faults(path: Path, table: Table[MemberRow], site: Site) -> Iterator[Fault]:
    for line, row in zip(table.lines, table.rows, strict=True):
        unknown = [str(k) for k in row.levels if site.heights is not None and k not in site.heights]
        if unknown and site.heights is not None:
            key = column_key(line, table.headers[row.levels_column])
            known = ", ".join(map(str, site.heights))
            expected = f"the building has the {row.levels_column} {known}"
            yield Fault(path, key, ", ".join(unknown), expected)


def _plan_faults(path: Path, table: Table[MemberRow], site: Site) -> Iterator[Fault]:
    limits = {"x": ("length", site.length), "y": ("width", site.width)}
    for line, row in zip(table.lines, table.rows, strict=True):
        for column, value in row.coordinates.items():
            name, limit = limits[column[0]]
            if limit is not None and not -TOUCH <= value <= limit + TOUCH:
                key = column_key(line, table.headers[column])
                expected = f"expected a {row.kind} within the plan: 0 m to its {name}, {limit:g} m"
                yield Fault(path, key, value, expected)


def _twice_faults(path: Path, table: Table[MemberRow]) -> Iterator[Fault]:
    """Two of a kind in one place would be joined into one, with the section of either."""
    rows = list(zip(table.lines, table.rows, strict=True))
    for (first, one), (line, row) in itertools.combinations(rows, 2):
        shared = sorted(set(one.levels) & set(row.levels))
        if shared and row.lies_on(one):
            key = column_key(line, table.headers[row.kind])
            level = f"{row.levels_column.removesuffix('s')} {shared[0]}"
            expected = f"lies on {one.name} of line {first} in {level}; expected a place of its own"
            yield Fault(path, key, row.name, expected)


class Beam(Line):
    """A straight beam of rectangular section: one row of the beam table."""

    kind: ClassVar[str] = "beam"
    levels_column: ClassVar[str] = "floors"

    beam: MemberName
    """Name of the beam, unique in the table."""
    floors: Floors
    """Floors it carries."""
    x1: Length
    """Position along the building of one end."""
    y1: Length
    """Position across the building of that end."""
    x2: Length
    """Position along the building of the other end."""
    y2: Length
    """Position across the building of the other end."""
    width: PositiveLength
    """Horizontal side of the section."""
    depth: PositiveLength
    """Vertical side of the section."""
    offset: Length = 0.0
    """Height of its axis above the mid-plane of the slab; negative below it."""


class Column(Member):
    """A vertical column of rectangular section: one row of the column table."""

    kind: ClassVar[str] = "column"
    levels_column: ClassVar[str] = "storeys"

    column: MemberName
    """Name of the column, unique in the table."""
    storeys: Storeys
    """Storeys it stands in, each from the floor below to the floor of its number."""
    x: Length
    """Position along the building."""
    y: Length
    """Position across the building."""
    width_x: PositiveLength
    """Side of the section along x."""
    width_y: PositiveLength
    """Side of the section along y."""

    @property
    def coordinates(self) -> dict[str, float]:
        """Coordinates of its axis [m] by their column."""
        return {"x": self.x, "y": self.y}

    def lies_on(self, other: Member) -> bool:
        """Whether two stand on one point."""
        here, there = self.coordinates.values(), other.coordinates.values()
        return isinstance(other, Column) and math.dist(tuple(here), tuple(there)) <= TOUCH


class Wall(Line):
    """A straight wall: one row of the wall table; its mid-plane stands on the line of the row."""

    kind: ClassVar[str] = "wall"
    levels_column: ClassVar[str] = "storeys"

    wall: MemberName
    """Name of the wall, unique in the table."""
    storeys: Storeys
    """Storeys it stands in, each from the floor below to the floor of its number."""
    x1: Length
    """Position along the building of the end where bays are counted."""
    y1: Length
    """Position across the building of that end."""
    x2: Length
    """Position along the building of the other end."""
    y2: Length
    """Position across the building of the other end."""
    thickness: PositiveLength
    """Thickness of the wall."""


class Bay(Section):
    """A rectangular opening in a wall: one row of the bay table.

    Two rectangles that touch make one opening of another shape.
    """

    bay: Text
    """Name or index of the bay; several may share it."""
    wall: Text
    """Name of the wall it is in."""
    storey: Annotated[int, Whole(1)]
    """The storey it is in."""
    centre: Length
    """Position of its middle along the wall, from (x1, y1)."""
    sill: Depth
    """Height of its lower edge above the floor below it."""
    width: PositiveLength
    """Width of the opening."""
    height: PositiveLength
    """Height of the opening."""

    @property
    def left(self) -> float:
        """Position of the side nearer to the beginning of the wall [m]."""
        return self.centre - self.width / 2.0

    @property
    def right(self) -> float:
        """Position of the other side [m]."""
        return self.centre + self.width / 2.0

    @property
    def top(self) -> float:
        """Height of its upper edge above the floor below it [m]."""
        return self.sill + self.height


def read_bays(
    path: Path, walls: Sequence[Wall] | None, site: Site, faults: list[Fault]
) -> Table[Bay] | None:
    """Read a bay table; what is wrong with it is appended to ``faults``.

    Args:
        path: A CSV file with the columns of ``Bay``.
        walls: The walls; None when they are not known.
        site: Where the walls stand.
        faults: Every fault of the table is appended here.

    Returns:
        The bays with the lines they stand on, or None when there were faults.
    """
    table = read_table(path, Bay, faults)
    if table is None:
        return None
    broken = list(_overlaps(path, table))
    if walls is not None:
        by_name = {wall.wall: wall for wall in walls}
        broken += _wall_faults(path, table, by_name)
        broken += _edge_faults(path, table, by_name, site)
        broken += [] if broken else _nothing_left(path, table, by_name, site)
    faults.extend(broken)
    return None if broken else table


def _wall_faults(path: Path, table: Table[Bay], walls: Mapping[str, Wall]) -> Iterator[Fault]:
    for line, bay in zip(table.lines, table.rows, strict=True):
        wall = walls.get(bay.wall)
        if wall is None:
            key = column_key(line, table.headers["wall"])
            yield Fault(path, key, bay.wall, f"unknown wall; {nearest(bay.wall, list(walls))}")
        elif bay.storey not in wall.storeys:
            key = column_key(line, table.headers["storey"])
            storeys = ", ".join(map(str, wall.storeys))
            expected = f"expected a storey of {bay.wall}, which stands in {storeys}"
            yield Fault(path, key, bay.storey, expected)


def _edge_faults(
    path: Path, table: Table[Bay], walls: Mapping[str, Wall], site: Site
) -> Iterator[Fault]:
    """Bays that reach beyond the edges of their walls."""
    for line, bay in zip(table.lines, table.rows, strict=True):
        wall = walls.get(bay.wall)
        if wall is not None and not -TOUCH <= bay.left <= bay.right <= wall.length + TOUCH:
            column = "centre" if bay.width <= wall.length + TOUCH else "width"
            key = column_key(line, table.headers[column])
            expected = (
                f"the bay goes from {bay.left:g} m to {bay.right:g} m along {bay.wall}; "
                f"expected 0 m to {wall.length:g} m at most"
            )
            yield Fault(path, key, getattr(bay, column), expected)
        height = None if site.heights is None else site.heights.get(bay.storey)
        if height is not None and bay.top > height + TOUCH:
            column = "sill" if bay.height <= height + TOUCH else "height"
            key = column_key(line, table.headers[column])
            expected = (
                f"the bay goes up to {bay.top:g} m; expected at most the height of "
                f"storey {bay.storey}, {height:g} m"
            )
            yield Fault(path, key, getattr(bay, column), expected)


def _overlaps(path: Path, table: Table[Bay]) -> Iterator[Fault]:
    """Bays that share more than an edge."""
    for rows in _by_wall(table).values():
        for (first, one), (line, bay) in itertools.combinations(rows, 2):
            along = min(one.right, bay.right) - max(one.left, bay.left)
            up = min(one.top, bay.top) - max(one.sill, bay.sill)
            if along > TOUCH and up > TOUCH:
                key = column_key(line, table.headers["centre"])
                expected = (
                    f"bay {bay.bay} overlaps bay {one.bay} of line {first} in {bay.wall}, storey "
                    f"{bay.storey}; expected bays that share no more than an edge"
                )
                yield Fault(path, key, bay.centre, expected)


def _nothing_left(
    path: Path, table: Table[Bay], walls: Mapping[str, Wall], site: Site
) -> Iterator[Fault]:
    """Walls that their bays, which do not overlap, take away as a whole."""
    for (name, storey), rows in _by_wall(table).items():
        if site.heights is not None and storey in site.heights:
            whole = walls[name].length * site.heights[storey]
            if sum(bay.width * bay.height for _, bay in rows) > whole * (1.0 - 1e-9):
                line, bay = rows[-1]
                expected = f"nothing is left of {name} in storey {storey}; leave the wall out there"
                yield Fault(path, column_key(line, table.headers["bay"]), bay.bay, expected)


def _by_wall(table: Table[Bay]) -> dict[tuple[str, int], list[tuple[int, Bay]]]:
    rows = defaultdict(list)
    for line, bay in zip(table.lines, table.rows, strict=True):
        rows[bay.wall, bay.storey].append((line, bay))
    return rows
