"""A case file that extends another one and says only what differs from it."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from impactfem.case.place import Place, value_at
from impactfem.case.source import EXTENDS, Source, file_names


def overlay_text(
    source: Source, changes: Mapping[Place, Any], folder: Path, model: type[BaseModel]
) -> str:
    """The text of a case file that extends a case and changes some of its values.

    A list is replaced as a whole by a file that extends another one, so that a change within a list
    writes all of it. Names of files are those relative to the folder of the case; they are written
    relative to the folder of the new file.

    Args:
        source: The case that is extended.
        changes: The new values by their places; every place must be one of the case.
        folder: Where the new file will be; it need not exist yet.
        model: The model of a case file, which tells the names of files from other texts.
    """
    raw = deepcopy(source.raw)
    for place, value in changes.items():
        value_at(place[:-1], raw)[place[-1]] = deepcopy(value)
    origin = source.path.parent.resolve()
    for place, name in list(file_names(raw, (), raw, model)):
        if not Path(name).is_absolute():
            value_at(place[:-1], raw)[place[-1]] = _relative(origin / name, folder)
    lines = [f"{EXTENDS} = {as_toml(_relative(origin / source.path.name, folder))}"]
    said = dict.fromkeys(_outside_lists(place) for place in changes)
    for place in said:
        key = ".".join(_key(str(part)) for part in place)
        lines.append(f"{key} = {as_toml(value_at(place, raw), rows=True)}")
    return "\n".join(lines) + "\n"


def as_toml(value: Any, *, rows: bool = False) -> str:
    """A value in TOML.

    Args:
        value: A text, number, truth value, list or table.
        rows: Whether each table of a list gets a line of its own.
    """
    if isinstance(value, Mapping):
        inside = ", ".join(f"{_key(key)} = {as_toml(item)}" for key, item in value.items())
        return f"{{ {inside} }}" if inside else "{}"
    if isinstance(value, list | tuple):
        items = [as_toml(item) for item in value]
        if rows and any(isinstance(item, Mapping) for item in value):
            return "[\n" + "".join(f"  {item},\n" for item in items) + "]"
        return f"[{', '.join(items)}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        # JSON's escapes are TOML's; the control character 127 is not escaped by JSON.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)  # a whole number or a float: nan, inf and 1e-05 are TOML, too


def _outside_lists(place: Place) -> Place:
    """The part of a place up to its first list."""
    for end, part in enumerate(place):
        if isinstance(part, int):
            return place[:end]
    return place


def _relative(path: Path, folder: Path) -> str:
    return os.path.relpath(path, folder.resolve())


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else as_toml(key)
