"""A place where a device is anchored to the building, and what else its spectrum is to cover."""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Iterator, Sequence
from typing import Annotated

from pydantic import Field, field_validator

from impactfem.case.base import Section
from impactfem.case.leaf import Length, PositiveLength, Words, refuse
from impactfem.case.probe import Probe

ProbePattern = Annotated[
    str,
    Words(
        "the name of a probe of [transient], or a pattern of names such as 'corner_*'",
        r"[A-Za-z0-9_*?-]+",
    ),
]
Point = tuple[Length, Length, Length]

_LINE_POINTS = 9


class DeviceSupport(Section):
    """One of several places where a device is anchored."""

    point: Point = Field(description="The anchor (x, y, z), on a floor of the building.")
    radius: PositiveLength = Field(
        description="Radius around it within which the nodes of the floor are tied to it."
    )
    envelope: tuple[ProbePattern, ...] = Field(
        default=(), description="As for a device with one anchor."
    )

    @field_validator("envelope")
    @classmethod
    def _each_once(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        return once(value)


def once(patterns: tuple[str, ...]) -> tuple[str, ...]:
    """Refuse a pattern that stands twice."""
    if len(set(patterns)) < len(patterns):
        raise refuse("expected each name or pattern once")
    return patterns


def chosen(names: Sequence[str], patterns: Sequence[str]) -> list[str]:
    """The names that patterns stand for, in the order of the names.

    Args:
        names: Names of probes.
        patterns: Names, or patterns with * and ?.
    """
    return [name for name in names if any(fnmatch.fnmatchcase(name, p) for p in patterns)]


def unknown_patterns(
    patterns: Sequence[str], probes: Sequence[Probe], floors: Sequence[int]
) -> Iterator[str]:
    """Patterns that stand for no probe of a case; how many a group has, the mesh will say.

    Args:
        patterns: Names and patterns.
        probes: The probes of the case.
        floors: Numbers of the floors; empty when not known, and then what is always there is not
            checked.
    """
    standard = [f"{kind}_{k}" for kind in ("centre", "edge") for k in floors]
    standard += [f"line_{k}" for k in range(1, _LINE_POINTS + 1)]
    named = [name for probe in probes for name, _ in probe.points]
    groups = [probe for probe in probes if probe.group is not None]
    for pattern in patterns:
        if chosen([*standard, *named], [pattern]):
            continue
        if not floors and re.fullmatch(r"(?:centre|edge)_[\d*?]+", pattern):
            continue
        if any(one.claims(pattern) or chosen([one.numbered(1)], [pattern]) for one in groups):
            continue
        yield pattern
