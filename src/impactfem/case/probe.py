"""Probes: the points of the 3D model whose motion the user asks for."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, present
from impactfem.case.leaf import Length, Name, Whole, Words, refuse

Point = tuple[float, float, float]
_Point = tuple[Length, Length, Length]
_GroupName = Annotated[
    str,
    Words(
        "the name of a physical group of the mesh, for example 'edge_8' or 'floor_8'",
        "(?:floor|storey|beam|column)_[1-9][0-9]*(?:_[a-z0-9]+)*|(?:edge|centre)_[1-9][0-9]*|base",
    ),
]
_STANDARD = "(?:centre|edge|line)_[1-9][0-9]*"
OUTSIDE = 1.0
"""Distance of a point from the building that is always taken for a point of it [m]."""
_WAYS = "point, or from with to and count, or group"


class Probe(Section):
    """A point of the 3D model whose motion is recorded, or several of them.

    Either ``point``, or ``from``, ``to`` and ``count``, or ``group``. Several points are named
    ``corner_1``, ``corner_2`` and so on. Always there, without a table: ``centre_1`` and so on, the
    mass centre of each floor; ``edge_1`` and so on, the middle of each impact edge; ``line_1`` and
    so on, from the middle of its impact edge to the opposite one, across the highest floor that
    contacts may strike; without contacts across the top floor.
    """

    name: Name = Field(description="Name of the probe; that of several ones gets a number each.")
    point: _Point | None = Field(
        default=None, description="Coordinates (x, y, z) of one point; the nearest node is taken."
    )
    start: _Point | None = Field(
        default=None, alias="from", description="First of several points on a straight line."
    )
    end: _Point | None = Field(
        default=None, alias="to", validate_default=True, description="Last of these points."
    )
    count: Annotated[int, Whole(2, 10_000)] | None = Field(
        default=None,
        validate_default=True,
        description="Number of these points, equally far apart, both ends included.",
    )
    group: _GroupName | None = Field(
        default=None,
        validate_default=True,
        description="Physical group of the mesh: every node of it.",
    )

    @field_validator("start")
    @classmethod
    def _not_beside_point(cls, value: Point | None, info: ValidationInfo) -> Point | None:
        if value is not None and info.data.get("point") is not None:
            raise refuse(f"expected one way only: {_WAYS}")
        return value

    @field_validator("end")
    @classmethod
    def _away_from_start(cls, value: Point | None, info: ValidationInfo) -> Point | None:
        if not present(info, ["start"]):
            return value
        if (value is None) != (info.data["start"] is None):
            raise refuse("expected from and to together")
        if value is not None and value == info.data["start"]:
            raise refuse("expected another point than from")
        return value

    @field_validator("count")
    @classmethod
    def _of_line(cls, value: int | None, info: ValidationInfo) -> int | None:
        if not present(info, ["start", "end"]):
            return value
        if value is None and info.data["start"] is not None:
            raise refuse("missing; expected a whole number of at least 2 beside from and to")
        if value is not None and info.data["start"] is None:
            raise refuse("expected no count, only beside from and to")
        return value

    @field_validator("group")
    @classmethod
    def _one_way(cls, value: str | None, info: ValidationInfo) -> str | None:
        if not present(info, ["point", "start", "end", "count"]):
            return value
        other = info.data["point"] is not None or info.data["start"] is not None
        if value is None and not other:
            raise refuse(f"missing; expected one of {_WAYS}")
        if value is not None and other:
            raise refuse(f"expected one way only: {_WAYS}")
        return value

    @property
    def points(self) -> tuple[tuple[str, Point], ...]:
        """Names and coordinates [m] of the points; none for a group, whose nodes the mesh has."""
        if self.point is not None:
            return ((self.name, self.point),)
        if self.start is None or self.end is None or self.count is None:
            return ()
        last = self.count - 1
        return tuple(
            (self.numbered(k + 1), _between(self.start, self.end, k / last))
            for k in range(self.count)
        )

    def numbered(self, number: int) -> str:
        """Name of one of several points, counted from 1."""
        return f"{self.name}_{number}"

    def claims(self, name: str) -> bool:
        """Whether a point of this probe has, or in a group may have, a name."""
        if self.point is not None:
            return name == self.name
        match = re.fullmatch(rf"{re.escape(self.name)}_([1-9][0-9]*)", name)
        return match is not None and (self.count is None or int(match[1]) <= self.count)


def name_fault(probes: Sequence[Probe]) -> str | None:
    """What is wrong with the names of probes, in words; None when each point has its own.

    Args:
        probes: The probes of the user, beside those that are always there.
    """
    names: dict[str, Probe] = {}
    points: dict[str, list[Probe]] = {}  # by what is before the number at the end of their name
    for probe in probes:
        first = probe.numbered(1) if probe.point is None else probe.name
        if re.fullmatch(_STANDARD, first) is not None:
            return (
                f"expected another name than {probe.name}: centre_1, edge_1, line_1 and so on are "
                "always there"
            )
        other = names.setdefault(probe.name.lower(), probe)
        if other is not probe:
            return f"expected unique names, found {other.name} and {probe.name}"
        if probe.point is not None:
            points.setdefault(probe.name.rpartition("_")[0], []).append(probe)
    for several in probes:
        for one in points.get(several.name, ()) if several.point is None else ():
            if several.claims(one.name):
                return f"expected unique names, found {several.name} and {one.name}"
    return None


def _between(a: Point, b: Point, share: float) -> Point:
    """The point at a share of the way from a to b; both ends are met exactly."""
    x, y, z = ((1.0 - share) * p + share * q for p, q in zip(a, b, strict=True))
    return x, y, z
