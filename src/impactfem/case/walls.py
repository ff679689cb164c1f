"""The wall table of a structure."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from impactfem.case.leaf import Length, PositiveLength
from impactfem.case.levels import Storeys
from impactfem.case.members import Line, MemberName


class Wall(Line):
    """A straight wall: one row of the wall table; its mid-plane stands on the line of the row."""

    kind: ClassVar[str] = "wall"
    levels_column: ClassVar[str] = "storeys"

    wall: MemberName = Field(description="Name of the wall, unique in the table.")
    storeys: Storeys = Field(
        description="Storeys it stands in, each from the floor below to the floor of its number."
    )
    x1: Length = Field(description="Position along the building of the end where bays are counted.")
    y1: Length = Field(description="Position across the building of that end.")
    x2: Length = Field(description="Position along the building of the other end.")
    y2: Length = Field(description="Position across the building of the other end.")
    thickness: PositiveLength = Field(description="Thickness of the wall.")
