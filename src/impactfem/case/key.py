"""A dotted key as people write it, ``buildings[0].stiffness_factor``; whether a case has it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from impactfem.case.leaf import nearest
from impactfem.case.place import Place, dotted, field_at, fields_by_key, step

_PART = re.compile(r"([A-Za-z0-9_-]+)((?:\[\d{1,6}\])*)")


def read_key(text: str) -> Place | None:
    """The place that a dotted key means; None when the text is no such key."""
    place: list[int | str] = []
    for part in text.strip().split("."):
        match = _PART.fullmatch(part)
        if match is None:
            return None
        place += [match[1], *(int(index) for index in re.findall(r"\d+", match[2]))]
    return tuple(place)


def key_fault(place: Place, raw: Mapping[str, Any], model: type[BaseModel]) -> str | None:
    """Why a value cannot be set at a place of a case; None when it can.

    The tables and lists on the way must be there. The last key may be one that the case leaves to
    its default.

    Args:
        place: The place.
        raw: The content of the case file.
        model: Its model.

    Returns:
        What was expected, in words that say how to mend it.
    """
    current: Any = raw
    for end, part in enumerate(place, start=1):
        above = dotted(place[: end - 1])
        if isinstance(part, int):
            if not isinstance(current, list):
                return f"expected no index: {above} is no list in this case"
            if part >= len(current):
                return f"expected an index below {len(current)}, the length of the list"
        elif isinstance(current, list):
            return f"expected an index: {above}[0] is the first one of the list"
        elif not isinstance(current, Mapping):
            return f"expected no key below {above}, which is a value"
        elif part not in current:
            parent, info = field_at(model, place[:end], raw)
            if info is None:
                known = list(current) if parent is None else list(fields_by_key(parent))
                return f"unknown key; {nearest(part, known)}"
            if end < len(place):
                return f"expected a table or list {dotted(place[:end])} in this case; it has none"
        current = step(current, part)
    return None
