"""A place in a case file: keys and indices from the top, and the model that stands behind it."""

import re
import types
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from impactfem.case.base import Written, nearest

Place = tuple[int | str, ...]
SEARCHED = -1
"""Index of the table of [[contacts]] that a pair of [contact_search] has."""


def dotted(place: Place) -> str:
    """A place in TOML's words: ``buildings[1].floors``."""
    key = ""
    for part in place:
        if isinstance(part, int):
            key += f"[{part}]"
        else:
            key += f".{part}" if key else part
    return key


def step(current: Any, part: int | str) -> Any:
    """Return the value at a key or an index of a table or a list; None without one."""
    if isinstance(current, Mapping):
        return current.get(part)
    if isinstance(current, list) and isinstance(part, int) and part < len(current):
        return current[part]
    return None


def value_at(place: Place, raw: Any) -> Any:
    """Return the value at a place; None without one."""
    current = raw
    for part in place:
        current = step(current, part)
    return current


def field_at(
    model: type[BaseModel], place: Place, raw: Any
) -> tuple[type[BaseModel] | None, FieldInfo | None]:
    """The model that has the last key of a place, and the field of that key if it knows it.

    The tables of the content of the file say by their ``type`` which model is theirs.
    """
    annotation: Any = model
    parent: type[BaseModel] | None = None
    info: FieldInfo | None = None
    current = raw
    for part in place:
        above, current = current, step(current, part)
        if isinstance(part, int):
            items = [get_args(a) for a in alternatives(annotation) if get_origin(a) is tuple]
            annotation = items[0][0] if items else None
            continue
        tables = [
            a
            for a in alternatives(annotation)
            if get_origin(a) is dict or (isinstance(a, type) and issubclass(a, BaseModel))
        ]
        table = tables[0] if tables else None
        if len(tables) > 1 and isinstance(above, Mapping):
            given = above.get("type")
            for one in tables:
                tag = getattr(one, "model_fields", {}).get("type")
                # Without a type it is the one with a default.
                if tag is not None and (
                    not tag.is_required() if given is None else given in get_args(tag.annotation)
                ):
                    table = one
                    break
        if isinstance(table, type) and issubclass(table, BaseModel):
            parent, info = table, fields_by_key(table).get(str(part))
            annotation = None if info is None else form_of(info)
        elif get_origin(table) is dict:
            parent, info = None, None
            annotation = get_args(table)[1]
        else:
            return None, None
    return parent, info


def fields_by_key(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """The fields of a model by their keys in the file, which may be aliases: ``from``."""
    return {info.alias or name: info for name, info in model.model_fields.items()}


def one_line(info: FieldInfo) -> str:
    """The description of a field on one line."""
    return " ".join((info.description or "").split())


def form_of(info: FieldInfo) -> Any:
    """The type of what is written for a field."""
    return next((one.form for one in info.metadata if isinstance(one, Written)), info.annotation)


def alternatives(annotation: Any) -> Iterator[Any]:
    """The alternatives of an annotation that is a union, or itself."""
    origin = get_origin(annotation)
    if origin is Annotated:
        yield from alternatives(get_args(annotation)[0])
    elif origin in (Union, types.UnionType):
        for arg in get_args(annotation):
            yield from alternatives(arg)
    else:
        yield annotation


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
    """Why a value cannot be set at a place of a case, in words; None when it can.

    The tables and lists on the way must be there, but for tables without required keys. The last
    key may be one that the case leaves to its default.
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
                return f"unknown key; {nearest(part, known, f'{above}.' if above else '')}"
            if end < len(place):
                if not any(map(_needs_nothing, alternatives(form_of(info)))):
                    inside = dotted(place[:end])
                    return f"expected a table or list {inside} in this case; it has none"
                current = {}
                continue
        current = step(current, part)
    return None


def _needs_nothing(form: Any) -> bool:
    """Whether a form is a table without required keys."""
    table = isinstance(form, type) and issubclass(form, BaseModel)
    return table and not any(info.is_required() for info in form.model_fields.values())
