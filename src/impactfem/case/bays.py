"""The bay table of a structure: openings in its walls."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated

from pydantic import Field

from impactfem.case.base import Section
from impactfem.case.leaf import Depth, Length, PositiveLength, Text, Whole, nearest
from impactfem.case.members import TOUCH, Site, Wall
from impactfem.case.table import Table, column_key, read_table
from impactfem.system.errors import Fault


class Bay(Section):
    """A rectangular opening in a wall: one row of the bay table.

    Two rectangles that touch make one opening of another shape.
    """

    bay: Text = Field(description="Name or index of the bay; several may share it.")
    wall: Text = Field(description="Name of the wall it is in.")
    storey: Annotated[int, Whole(1)] = Field(description="The storey it is in.")
    centre: Length = Field(description="Position of its middle along the wall, from (x1, y1).")
    sill: Depth = Field(description="Height of its lower edge above the floor below it.")
    width: PositiveLength = Field(description="Width of the opening.")
    height: PositiveLength = Field(description="Height of the opening.")

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
    path: Path, walls: Table[Wall] | None, site: Site, faults: list[Fault]
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
        by_name = {wall.wall: wall for wall in walls.rows}
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
