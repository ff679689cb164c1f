"""The parts of a building's mesh: what the names of its physical groups say."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Protocol, TypeVar

from impactfem.system.errors import Fault

SHELLS = ("floor", "storey")

_NAME = re.compile(r"[a-z0-9]+(?:_[a-z0-9]+)*")
_GROUP = re.compile(rf"(floor|storey|beam|column)_([1-9][0-9]*)(?:_({_NAME.pattern}))?")
_MARK = re.compile(r"(edge|centre)_([1-9][0-9]*)")
SCHEME = (
    "floor_<k>[_<part>], storey_<k>[_<part>], beam_<k>[_<part>], column_<k>[_<part>], "
    "edge_<k>, centre_<k> or base, with <k> from 1 and <part> of a-z, 0-9 and single _"
)


@dataclass(frozen=True, order=True)
class Part:
    """A set of shells or beams of one section: the physical group ``floor_8_acroterion``.

    Args:
        family: ``floor`` (slabs), ``storey`` (walls), ``beam`` or ``column``.
        level: Number k of the floor, or of the storey below it; from 1 upwards.
        name: What stands behind the number; empty when nothing does.
    """

    family: str
    level: int
    name: str = ""

    @property
    def group(self) -> str:
        """Name of the physical group."""
        start = f"{self.family}_{self.level}"
        return f"{start}_{self.name}" if self.name else start

    @property
    def dimension(self) -> int:
        """2 for shells, 1 for beams."""
        return 2 if self.family in SHELLS else 1

    @property
    def scaled(self) -> bool:
        """Whether the storey stiffness factor acts on it: walls and columns."""
        return self.family in ("storey", "column")


@dataclass(frozen=True, order=True)
class Mark:
    """A set of nodes that carries no stiffness: ``edge_8``, ``centre_8`` or ``base``.

    Args:
        kind: ``edge``, ``centre`` or ``base``.
        level: Number of the floor; 0 for the base.
    """

    kind: str
    level: int = 0

    @property
    def group(self) -> str:
        """Name of the physical group."""
        return self.kind if self.kind == "base" else f"{self.kind}_{self.level}"


def parse_group(group: str) -> Part | Mark | None:
    """What the name of a physical group says; None when it is none of the scheme's."""
    if group == "base":
        return Mark("base")
    if match := _MARK.fullmatch(group):
        return Mark(match[1], int(match[2]))
    if match := _GROUP.fullmatch(group):
        return Part(match[1], int(match[2]), match[3] or "")
    return None


def usable_name(name: str) -> bool:
    """Whether a name can stand behind the number of a group."""
    return _NAME.fullmatch(name) is not None


class OfParts(Protocol):
    """What is said of some parts, by patterns of the names of their groups."""

    @property
    def parts(self) -> tuple[str, ...]:
        """The patterns."""
        ...


Entry = TypeVar("Entry", bound=OfParts)


def entry_of(part: Part, entries: Sequence[Entry]) -> Entry | None:
    """The first entry with a pattern that matches the part's group; None without one."""
    return next((entry for entry in entries if _matches(part, entry)), None)


def pattern_faults(
    entries: Sequence[OfParts], parts: Sequence[Part], path: Path, key: str
) -> Iterator[Fault]:
    """Patterns that match no part, and parts that match two entries.

    Args:
        entries: The entries.
        parts: All parts of the mesh.
        path: The case file, for messages.
        key: Where in it the entries stand, ``structure.damping``.
    """
    names = ", ".join(part.group for part in parts)
    for index, entry in enumerate(entries):
        for k, pattern in enumerate(entry.parts):
            if not any(fnmatchcase(part.group, pattern) for part in parts):
                expected = f"expected a pattern of the parts of the mesh: {names}"
                yield Fault(path, f"{key}[{index}].parts[{k}]", pattern, expected)
    for part in parts:
        own = [index for index, entry in enumerate(entries) if _matches(part, entry)]
        if len(own) > 1:
            expected = f"also matched by {key}[{own[0]}]; expected one entry for {part.group}"
            yield Fault(path, f"{key}[{own[1]}].parts", part.group, expected)


def _matches(part: Part, entry: OfParts) -> bool:
    return any(fnmatchcase(part.group, pattern) for pattern in entry.parts)
