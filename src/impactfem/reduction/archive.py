"""Dataclasses of arrays as flat names and arrays, for NumPy's archive."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from types import NoneType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

T = TypeVar("T")


def to_arrays(value: Any, name: str = "") -> dict[str, Any]:
    """Return the fields of a dataclass as arrays by dotted names; None is left out.

    Fields are arrays, numbers, dataclasses, and tuples of numbers, texts or dataclasses.
    """
    if value is None:
        return {}
    if is_dataclass(value):
        parts = {field.name: getattr(value, field.name) for field in fields(value)}
    elif isinstance(value, tuple) and any(map(is_dataclass, value)):
        parts = {str(number): part for number, part in enumerate(value)}
    else:
        return {name: np.asarray(value)}
    prefix = f"{name}." if name else ""
    return {
        key: array
        for part, x in parts.items()
        for key, array in to_arrays(x, prefix + part).items()
    }


def from_arrays(kind: type[T], content: Mapping[str, Any], name: str = "") -> T:
    """Return the dataclass that `to_arrays` took apart; KeyError without one of its fields."""
    found: T = _read(kind, content, name)
    return found


def _read(kind: Any, content: Mapping[str, Any], name: str) -> Any:
    options = get_args(kind)
    if NoneType in options:
        if not any(key == name or key.startswith(f"{name}.") for key in content):
            return None
        (kind,) = (option for option in options if option is not NoneType)
    prefix = f"{name}." if name else ""
    if is_dataclass(kind):
        hints = get_type_hints(kind)
        values = {
            field.name: _read(hints[field.name], content, prefix + field.name)
            for field in fields(kind)
        }
        return kind(**values)  # type: ignore[operator]
    if get_origin(kind) is not tuple:
        return kind(content[name]) if kind in (int, float, str) else content[name]
    (item, _) = get_args(kind)
    if not is_dataclass(item):
        return tuple(item(x) for x in content[name].tolist())
    parts: list[Any] = []
    while any(key.startswith(f"{prefix}{len(parts)}.") for key in content):
        parts.append(_read(item, content, f"{prefix}{len(parts)}"))
    return tuple(parts)
