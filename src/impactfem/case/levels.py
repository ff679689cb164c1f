"""Numbers of storeys or floors in a cell of a table: ``1``, ``2-8`` or ``1 3 5-7``."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import ValidationInfo

from impactfem.case.leaf import Leaf, refuse

_RANGE = re.compile(r"(\d{1,4})(?:-(\d{1,4}))?")


@dataclass(frozen=True)
class Levels(Leaf):
    """Numbers and ranges of numbers, ascending; held as a tuple of all of them.

    Args:
        word: What is numbered: ``storeys`` or ``floors``.
    """

    word: str

    @property
    def phrase(self) -> str:
        """What is expected, in words."""
        return f"numbers of {self.word}, ascending from 1: '3', '2-8' or '1 3 5-7'"

    def check(self, value: Any, info: ValidationInfo) -> tuple[int, ...]:
        """Give the numbers one by one."""
        levels: tuple[int, ...] = ()
        if isinstance(value, str):
            levels = self._read(value)
        elif isinstance(value, list | tuple):
            levels = tuple(value)
        ascending = all(a < b for a, b in itertools.pairwise((0, *levels)))
        if not levels or not ascending:
            raise refuse(f"expected {self.phrase}")
        return levels

    def _read(self, text: str) -> tuple[int, ...]:
        levels: list[int] = []
        for match in map(_RANGE.fullmatch, text.split()):
            if match is None:
                return ()
            first, last = int(match[1]), int(match[2] or match[1])
            if last < first:
                return ()
            levels.extend(range(first, last + 1))
        return tuple(levels)

    def schema(self) -> dict[str, Any]:
        """The JSON schema of the text."""
        return {"type": "string", "pattern": r"^\s*[0-9-]+(\s+[0-9-]+)*\s*$"}


Storeys = Annotated[tuple[int, ...], Levels("storeys")]
Floors = Annotated[tuple[int, ...], Levels("floors")]
