"""The mesh of a structure from a file of the user's."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, field_validator

from impactfem.case.base import Section
from impactfem.case.leaf import File, Length, PositiveLength, Text, refuse


class ShellGroup(Section):
    """The thickness of shells, by the names of their physical groups."""

    groups: Text = Field(
        description="Pattern of the names of the groups, with * and ? as in a shell: `floor_*`."
    )
    thickness: PositiveLength = Field(description="Thickness of the shells.")


class BeamGroup(Section):
    """The rectangular section of beams or columns, by the names of their physical groups."""

    groups: Text = Field(
        description="Pattern of the names of the groups, with * and ? as in a shell: `column_*`."
    )
    width: PositiveLength = Field(
        description="Side of the section: of beams the horizontal one, of columns that along x."
    )
    depth: PositiveLength = Field(
        description="Side of the section: of beams the vertical one, of columns that along y."
    )
    offset: Length = Field(
        default=0.0,
        description="Of beams: height of the axis above the line of nodes; negative below it.",
    )


class FileMesh(Section):
    """A mesh of second order from a file of gmsh, with named physical groups.

    docs/mesh-groups.md says how the groups are named. Each group of shells or beams matches one
    pattern.
    """

    type: Literal["file"] = Field(description="Read from a file.")
    file: File = Field(description="The mesh: a .msh file of gmsh.")
    shells: tuple[ShellGroup, ...] = Field(
        min_length=1, description="Thicknesses of the groups of shells."
    )
    beams: tuple[BeamGroup, ...] = Field(
        default=(), description="Sections of the groups of beams and columns."
    )

    @field_validator("shells", "beams")
    @classmethod
    def _each_pattern_once(
        cls, value: tuple[ShellGroup, ...] | tuple[BeamGroup, ...]
    ) -> tuple[ShellGroup, ...] | tuple[BeamGroup, ...]:
        patterns = [entry.groups for entry in value]
        for pattern in patterns:
            if patterns.count(pattern) > 1:
                raise refuse(f"expected each pattern once, found '{pattern}' twice")
        return value
