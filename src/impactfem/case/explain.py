"""Pydantic's errors in plain words, with the key as it is written in the case file."""

from __future__ import annotations

import types
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from impactfem.case.leaf import Leaf, nearest
from impactfem.errors import Fault

# Names of the alternatives of a union, which pydantic puts into the place of an error. Besides
# these, the type that a table has.
_FORMS = {"grid", "list", "corner-periods"}

Location = tuple[int | str, ...]


def explain(
    error: ValidationError, file: Path, raw: Mapping[str, Any], model: type[BaseModel]
) -> list[Fault]:
    """Turn the errors of a validation into faults, each once.

    Args:
        error: What pydantic raised.
        file: The file the data are from.
        raw: The data as parsed from the file.
        model: The model they were validated against.
    """
    faults: dict[tuple[str, str], Fault] = {}
    for item in error.errors(include_url=False):
        if item["type"] == "too_short" and item["input"]:
            continue  # pydantic counts the valid items only; what is wrong with the others is told
        fault = _fault(item, file, raw, model)
        faults.setdefault((fault.key, fault.expected), fault)
    return list(faults.values())


def dotted(location: Location) -> str:
    """The place of a value in TOML's words: ``buildings[1].floors``."""
    key = ""
    for part in location:
        if isinstance(part, int):
            key += f"[{part}]"
        else:
            key += f".{part}" if key else part
    return key


def expectation(annotation: Any, metadata: list[Any] | tuple[Any, ...] = ()) -> str:
    """What a field accepts, in words that complete 'expected ...'."""
    for item in metadata:
        if isinstance(item, Leaf):
            return item.phrase
    origin, args = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return expectation(args[0], args[1:])
    if origin in (Union, types.UnionType):
        return " or ".join(dict.fromkeys(expectation(arg) for arg in args if arg is not type(None)))
    if origin is Literal:
        return " or ".join(f"'{arg}'" for arg in args)
    if origin is tuple and args[-1] is not Ellipsis:
        return f"a list of {len(args)} values, each {expectation(args[0])}"
    if origin is tuple:
        item = expectation(args[0])
        return "one or more tables" if item == "a table" else f"a list, each value {item}"
    if annotation is bool:
        return "true or false"
    return "a table"


def _fault(item: ErrorDetails, file: Path, raw: Mapping[str, Any], model: type[BaseModel]) -> Fault:
    location = _without_tags(item["loc"], raw)
    kind, value = item["type"], item["input"]
    parent, info = _field(model, location, raw)
    if kind == "fault":
        missing = not _exists(location, raw)
        return Fault(file, dotted(location), None if missing else value, item["msg"])
    if kind == "extra_forbidden":
        known = list(parent.model_fields) if parent is not None else []
        return Fault(
            file, dotted(location), None, f"unknown key; {nearest(str(location[-1]), known)}"
        )
    if kind in {"union_tag_not_found", "union_tag_invalid"}:
        # A table with a name of the user's choice has no field of its own, but that of all of them.
        holder = info or _field(model, location[:-1], raw)[1]
        words = " or ".join(f"'{tag}'" for tag in _tags(holder.annotation if holder else None))
        location = (*location, "type")
        given = value.get("type") if isinstance(value, Mapping) else None
        lead = "missing; expected" if given is None else "expected"
        return Fault(file, dotted(location), given, f"{lead} {words}")
    if kind in {"missing", "too_long"} and (kind == "too_long" or isinstance(location[-1], int)):
        # A list of a fixed length with too few or too many values: the fault is the list's.
        if kind == "missing":
            location = location[:-1]
            _, info = _field(model, location, raw)
        words = _words(info)
        return Fault(file, dotted(location), _at(location, raw), f"expected {words}")
    if kind == "missing":
        about = f": {info.description}" if info is not None and info.description else ""
        return Fault(file, dotted(location), None, f"missing; expected {_words(info)}{about}")
    if kind == "too_short":
        return Fault(file, dotted(location), value, "expected a list that is not empty")
    if kind in _TABLE_ERRORS and (info is None or isinstance(location[-1], int)):
        return Fault(file, dotted(location), value, "expected a table")
    return Fault(file, dotted(location), value, f"expected {_words(info)}")


_TABLE_ERRORS = {"model_type", "model_attributes_type", "dict_type"}


def _words(info: FieldInfo | None) -> str:
    if info is None:
        return "another value"
    return expectation(info.annotation, info.metadata)


def _without_tags(location: Location, raw: Any) -> Location:
    """The place of an error as keys and indices of the file."""
    cleaned: list[int | str] = []
    current = raw
    for part in location:
        is_key = isinstance(current, Mapping) and part in current
        if part == "[key]" or (not is_key and _is_tag(part, current)):
            continue
        cleaned.append(part)
        current = _step(current, part)
    return tuple(cleaned)


def _is_tag(part: int | str, current: Any) -> bool:
    """Whether a part of a place names an alternative of a union."""
    return part in _FORMS or (isinstance(current, Mapping) and part == current.get("type"))


def _step(current: Any, part: int | str) -> Any:
    if isinstance(current, Mapping):
        return current.get(part)
    if isinstance(current, list) and isinstance(part, int) and part < len(current):
        return current[part]
    return None


def _at(location: Location, raw: Any) -> Any:
    current = raw
    for part in location:
        current = _step(current, part)
    return current


def _exists(location: Location, raw: Any) -> bool:
    return _at(location, raw) is not None


def _field(
    model: type[BaseModel], location: Location, raw: Any
) -> tuple[type[BaseModel] | None, FieldInfo | None]:
    """The model that has the last key of a place, and the field of that key if it knows it."""
    annotation: Any = model
    parent: type[BaseModel] | None = None
    info: FieldInfo | None = None
    current = raw
    for part in location:
        current_table = current
        current = _step(current, part)
        if isinstance(part, int):
            items = [get_args(a) for a in _alternatives(annotation) if get_origin(a) is tuple]
            annotation = items[0][0] if items else None
            continue
        table = _table_of(annotation, current_table)
        if isinstance(table, type) and issubclass(table, BaseModel):
            parent, info = table, table.model_fields.get(part)
            annotation = None if info is None else info.annotation
        elif get_origin(table) is dict:
            parent, info = None, None
            annotation = get_args(table)[1]
        else:
            return None, None
    return parent, info


def _alternatives(annotation: Any) -> Iterator[Any]:
    origin = get_origin(annotation)
    if origin is Annotated:
        yield from _alternatives(get_args(annotation)[0])
    elif origin in (Union, types.UnionType):
        for arg in get_args(annotation):
            yield from _alternatives(arg)
    else:
        yield annotation


def _table_of(annotation: Any, current: Any) -> Any:
    """The model or dict among the alternatives of an annotation, by the ``type`` of the table."""
    tables = [
        a
        for a in _alternatives(annotation)
        if get_origin(a) is dict or (isinstance(a, type) and issubclass(a, BaseModel))
    ]
    if len(tables) > 1 and isinstance(current, Mapping):
        tables = [a for a in tables if _has_type(a, current.get("type"))] or tables
    return tables[0] if tables else None


def _has_type(table: Any, given: Any) -> bool:
    """Whether a model is the one for a type; without a type it is the one with a default."""
    info = getattr(table, "model_fields", {}).get("type")
    if info is None:
        return False
    return not info.is_required() if given is None else given in get_args(info.annotation)


def _tags(annotation: Any) -> list[str]:
    """The types of the tables of an annotation, wherever they stand in it."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        info = annotation.model_fields.get("type")
        return [] if info is None else [str(tag) for tag in get_args(info.annotation)]
    return [tag for arg in get_args(annotation) for tag in _tags(arg)]
