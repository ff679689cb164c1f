"""The beam table of a structure."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from impactfem.case.leaf import Length, PositiveLength
from impactfem.case.levels import Floors
from impactfem.case.members import Line, MemberName


class Beam(Line):
    """A straight beam of rectangular section: one row of the beam table."""

    kind: ClassVar[str] = "beam"
    levels_column: ClassVar[str] = "floors"

    beam: MemberName = Field(description="Name of the beam, unique in the table.")
    floors: Floors = Field(description="Floors it carries.")
    x1: Length = Field(description="Position along the building of one end.")
    y1: Length = Field(description="Position across the building of that end.")
    x2: Length = Field(description="Position along the building of the other end.")
    y2: Length = Field(description="Position across the building of the other end.")
    width: PositiveLength = Field(description="Horizontal side of the section.")
    depth: PositiveLength = Field(description="Vertical side of the section.")
    offset: Length = Field(
        default=0.0,
        description="Height of its axis above the mid-plane of the slab; negative below it.",
    )
