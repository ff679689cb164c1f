"""The mesh of a structure by the generator: as written in the case file, and with its tables."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from impactfem.case.base import Section
from impactfem.case.bays import Bay
from impactfem.case.leaf import ElementSize, Extent, File, PositiveLength
from impactfem.case.members import Beam, Column, Wall


class Acroterion(Section):
    """The low wall on the edges of the top floor."""

    height: PositiveLength = Field(description="Height above the mid-plane of the top slab.")
    thickness: PositiveLength = Field(description="Thickness of the low wall.")


class _Generated(Section):
    """What a generated mesh has in common before and after its tables are read.

    The fields that differ stand here too, for the order of all fields.
    """

    type: Literal["generated"] = Field(description="Made by the generator from tables.")
    length: Extent = Field(description="Length of the rectangular plan, along x.")
    width: Extent = Field(description="Width of the plan, along y.")
    slab_thickness: PositiveLength = Field(description="Thickness of all slabs.")
    walls: Path | tuple[Wall, ...]
    bays: Path | tuple[Bay, ...] | None
    beams: Path | tuple[Beam, ...] | None
    columns: Path | tuple[Column, ...] | None
    acroterion: Acroterion | None = Field(
        default=None, description="Low wall on the edges of the top floor; default none."
    )
    impact_edge: Literal["x-", "x+", "y-", "y+"] = Field(
        description="Side of the plan that faces the other building."
    )
    size: ElementSize = Field(description="Target size of the elements.")
    floor_size: ElementSize | None = Field(
        default=None, description="Target size in the slabs, in place of size."
    )
    storey_size: ElementSize | None = Field(
        default=None, description="Target size in the walls, in place of size."
    )
    beam_size: ElementSize | None = Field(
        default=None, description="Target size along the beams, in place of size."
    )
    column_size: ElementSize | None = Field(
        default=None, description="Target size along the columns, in place of size."
    )


class GeneratedMeshEntry(_Generated):
    """A mesh made by the generator: a rectangular plan, with floors at the levels of the building.

    Positions in plan are counted from a corner of the building, x along its length, y across.
    """

    walls: File = Field(description="Wall table: a CSV file, one row a wall.")
    bays: File | None = Field(
        default=None, description="Bay table: a CSV file, one row an opening in a wall."
    )
    beams: File | None = Field(default=None, description="Beam table: a CSV file, one row a beam.")
    columns: File | None = Field(
        default=None, description="Column table: a CSV file, one row a column."
    )


class GeneratedMesh(_Generated):
    """A mesh made by the generator, with its tables."""

    walls: tuple[Wall, ...]
    bays: tuple[Bay, ...]
    beams: tuple[Beam, ...]
    columns: tuple[Column, ...]
