"""Tables of walls with their bays, of beams and of columns of a generated mesh."""

import itertools
import math
from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self, TypeVar

from pydantic import Field, ValidationInfo

from impactfem.case.base import Section, nearest, rule
from impactfem.case.floors import floors_of
from impactfem.case.leaf import LONGEST_NAME, Floors, Levels, Storeys, Text, Whole, Words
from impactfem.case.quantity import Depth, Length, PositiveLength, Si
from impactfem.case.reading import reading_of
from impactfem.case.sections import Angle, MemberSection, SectionOf
from impactfem.case.table import Table, read_table
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


def heights_of_storeys(info: ValidationInfo) -> dict[int, float]:
    """Height of each storey of the building whose 3D model is read [m]; empty where not known.

    Its number is that of the floor above it.
    """
    building = reading_of(info).building
    return {floor.floor: floor.storey_height for floor in floors_of(building, info)}


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
    def lies_on(self, other: Self) -> bool:
        """Return True if two of a kind share more than points in plan."""


class Line(Member):
    """A straight member in plan, from (x1, y1) to (x2, y2)."""

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

    def lies_on(self, other: Self) -> bool:
        """Return True if two lie in one line and share more than an end."""
        (x1, y1), (x2, y2) = self.ends
        L = self.length
        tx, ty = (x2 - x1) / L, (y2 - y1) / L
        along = [(x - x1) * tx + (y - y1) * ty for x, y in other.ends]
        across = [(y - y1) * tx - (x - x1) * ty for x, y in other.ends]
        shared = min(L, max(along)) - max(0.0, min(along))
        return shared > TOUCH and max(map(abs, across)) <= TOUCH


def _two_ends(y2: float, x1: float, y1: float, x2: float) -> Iterator[str]:
    if math.hypot(x2 - x1, y2 - y1) <= TOUCH:
        yield "expected an end (x2, y2) away from (x1, y1)"


MemberRow = TypeVar("MemberRow", bound=Member)


def read_members(
    model: type[MemberRow], path: Path, faults: list[Fault], info: ValidationInfo
) -> Table[MemberRow] | None:
    """Read a table of walls, beams or columns; unknown sides of the plan are not checked."""
    heights = heights_of_storeys(info)
    limits = {"x": ("length", info.data.get("length")), "y": ("width", info.data.get("width"))}

    def placed(table: Table[MemberRow]) -> Iterator[Fault]:
        for line, row in table:
            unknown = ", ".join(str(k) for k in row.levels if heights and k not in heights)
            if unknown:
                known = ", ".join(map(str, heights))
                expected = f"the building has the {row.levels_column} {known}, not {unknown}"
                yield table.fault(line, row.levels_column, Levels.written(row.levels), expected)
            for column, value in row.coordinates.items():
                name, limit = limits[column[0]]
                if limit is not None and not -TOUCH <= value <= limit + TOUCH:
                    expected = (
                        f"expected a {row.kind} within the plan: 0 m to its {name}, {limit:g} m"
                    )
                    yield table.fault(line, column, value, expected)

    def one_on_another(table: Table[MemberRow]) -> Iterator[Fault]:
        """Two of a kind in one place would be joined into one, with the section of either."""
        for (first, one), (line, row) in itertools.combinations(table, 2):
            shared = sorted(set(one.levels) & set(row.levels))
            if shared and row.lies_on(one):
                level = f"{row.levels_column.removesuffix('s')} {shared[0]}"
                on = f"lies on {one.name} of line {first} in {level}"
                yield table.fault(line, row.kind, row.name, f"{on}; expected another place")

    checks = placed, one_on_another
    once = (model.kind,)
    context = info.context
    return read_table(path, model, faults, *checks, once=once, most=MOST_MEMBERS, context=context)


Side = Annotated[float | None, Si("m", gt=0)]


def section_or(first: str, second: str) -> Any:
    """The rule that members have either a section, or both sides of a rectangle."""

    def wrong(last: Any, section: Any, other: Any) -> Iterator[str]:
        missing = (other, last).count(None)
        if missing != (0 if section is None else 2):
            words = f"expected either section, or {first} and {second}"
            yield words if section is None else f"{words}, not both"

    return rule(second, "section", first, kind="section_or")(wrong)


class Beam(Line):
    """A straight beam: one row of the beam table."""

    MAY_BE_EMPTY = ("section", "width", "depth", "angle")

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
    section: Annotated[MemberSection | None, SectionOf()] = None
    """Rolled section or one of [sections], with a vertical web, in place of width and depth."""
    width: Side = None
    """Horizontal side of a rectangular section."""
    depth: Side = Field(default=None, validate_default=True)
    """Vertical side of a rectangular section."""
    angle: Angle = 0.0
    """Turn of the section about the axis of the beam, which points to +x, or to +y across x."""
    offset: Length = 0.0
    """Height of its axis above the mid-plane of the slab; negative below it."""

    _one_section = section_or("width", "depth")
    _apart = rule("y2", "x1", "y1", "x2")(_two_ends)


class Column(Member):
    """A vertical column: one row of the column table."""

    MAY_BE_EMPTY = ("section", "width_x", "width_y", "angle")

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
    section: Annotated[MemberSection | None, SectionOf()] = None
    """Rolled section or one of [sections], with its web along x, in place of the widths."""
    width_x: Side = None
    """Side of a rectangular section along x."""
    width_y: Side = Field(default=None, validate_default=True)
    """Side of a rectangular section along y."""
    angle: Angle = 0.0
    """Turn of the section in plan, from x towards y: 90 deg puts the web along y."""

    _one_section = section_or("width_x", "width_y")

    @property
    def coordinates(self) -> dict[str, float]:
        """Coordinates of its axis [m] by their column."""
        return {"x": self.x, "y": self.y}

    def lies_on(self, other: Self) -> bool:
        """Return True if two stand on one point."""
        return math.dist((self.x, self.y), (other.x, other.y)) <= TOUCH


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

    _apart = rule("y2", "x1", "y1", "x2")(_two_ends)


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


def read_bays(path: Path, faults: list[Fault], info: ValidationInfo) -> Table[Bay] | None:
    """Read a bay table."""
    walls, heights = info.data.get("walls"), heights_of_storeys(info)

    def placed(table: Table[Bay]) -> Iterator[Fault]:
        lines = [line for line, _ in table]
        words = [f" of line {line}" for line in lines]
        for k, column, expected in misplaced(table.rows, walls, heights, words):
            yield table.fault(lines[k], column, getattr(table.rows[k], column), expected)

    return read_table(path, Bay, faults, placed)


def misplaced(
    bays: Sequence[Bay],
    walls: Sequence[Wall] | None,
    heights: Mapping[int, float],
    words: Sequence[str],
) -> Iterator[tuple[int, str, str]]:
    """Find misplaced bays: number of the bay, its column, and what was expected.

    Args:
        bays: The bays.
        walls: The walls that they are in; None when not known.
        heights: Height of each storey that is known, by its number [m].
        words: Text after the name of each bay: where it is written.
    """
    by_name = {wall.wall: wall for wall in walls or ()}
    broken = False
    for k, bay in enumerate(bays if walls is not None else ()):
        wall = by_name.get(bay.wall)
        found = []
        if wall is None:
            found.append(("wall", f"unknown wall; {nearest(bay.wall, list(by_name))}"))
        elif bay.storey not in wall.storeys:
            storeys = ", ".join(map(str, wall.storeys))
            expected = f"expected a storey of {bay.wall}, which stands in {storeys}"
            found.append(("storey", expected))
        if wall is not None and not -TOUCH <= bay.left <= bay.right <= wall.length + TOUCH:
            column = "centre" if bay.width <= wall.length + TOUCH else "width"
            expected = (
                f"the bay goes from {bay.left:g} m to {bay.right:g} m along {bay.wall}; "
                f"expected 0 m to {wall.length:g} m at most"
            )
            found.append((column, expected))
        height = heights.get(bay.storey)
        if height is not None and bay.top > height + TOUCH:
            column = "sill" if bay.height <= height + TOUCH else "height"
            expected = (
                f"the bay goes up to {bay.top:g} m; expected at most the height of "
                f"storey {bay.storey}, {height:g} m"
            )
            found.append((column, expected))
        broken |= bool(found)
        yield from ((k, *one) for one in found)
    by_wall: dict[tuple[str, int], list[tuple[int, Bay]]] = defaultdict(list)
    for k, bay in enumerate(bays):
        by_wall[bay.wall, bay.storey].append((k, bay))
    for (name, storey), rows in by_wall.items():
        for (first, one), (k, bay) in itertools.combinations(rows, 2):
            along = min(one.right, bay.right) - max(one.left, bay.left)
            up = min(one.top, bay.top) - max(one.sill, bay.sill)
            if along > TOUCH and up > TOUCH:
                expected = (
                    f"bay {bay.bay} overlaps bay {one.bay}{words[first]} in {name}, storey "
                    f"{storey}; expected bays that share no more than an edge"
                )
                broken = True
                yield k, "centre", expected
    for (name, storey), rows in () if broken or walls is None else by_wall.items():
        # Bays that are in their wall and do not overlap may take all of it away.
        whole = by_name[name].length * heights.get(storey, math.inf)
        if sum(bay.width * bay.height for _, bay in rows) > whole * (1.0 - 1e-9):
            expected = f"nothing is left of {name} in storey {storey}; leave the wall out there"
            yield rows[-1][0], "bay", expected
