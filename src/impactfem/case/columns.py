"""The column table of a structure."""

from __future__ import annotations

import math
from typing import ClassVar

from pydantic import Field

from impactfem.case.leaf import Length, PositiveLength
from impactfem.case.levels import Storeys
from impactfem.case.members import TOUCH, Member, MemberName


class Column(Member):
    """A vertical column of rectangular section: one row of the column table."""

    kind: ClassVar[str] = "column"
    levels_column: ClassVar[str] = "storeys"

    column: MemberName = Field(description="Name of the column, unique in the table.")
    storeys: Storeys = Field(
        description="Storeys it stands in, each from the floor below to the floor of its number."
    )
    x: Length = Field(description="Position along the building.")
    y: Length = Field(description="Position across the building.")
    width_x: PositiveLength = Field(description="Side of the section along x.")
    width_y: PositiveLength = Field(description="Side of the section along y.")

    @property
    def coordinates(self) -> dict[str, float]:
        """Coordinates of its axis [m] by their column."""
        return {"x": self.x, "y": self.y}

    def lies_on(self, other: Member) -> bool:
        """Whether two stand on one point."""
        here, there = self.coordinates.values(), other.coordinates.values()
        return isinstance(other, Column) and math.dist(tuple(here), tuple(there)) <= TOUCH
