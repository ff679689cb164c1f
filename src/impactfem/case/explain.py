"""Pydantic's errors in plain words, with the key as it is written in the case file."""

import itertools
import types
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from impactfem.case.base import REPORTED, UNREADABLE, Leaf, Written, nearest
from impactfem.case.leaf import OneOrMore
from impactfem.case.place import (
    Place,
    alternatives,
    dotted,
    field_at,
    fields_by_key,
    form_of,
    one_line,
    step,
    value_at,
)
from impactfem.case.source import Source
from impactfem.system.errors import MOST_FAULTS, Fault

TABLES = "one or more tables"
"""What is said of an array of tables."""
LIST, NOT_EMPTY = "a list, ", "a list that is not empty"
"""And of a list of any length."""

# Names of the alternatives of a union, which pydantic puts into the place of an error. Besides
# these, the type that a table has.
_FORMS = {"grid", "list", "table", "corner-periods", "rayleigh"}


def places(error: ValidationError, raw: Any) -> list[tuple[Place, str]]:
    """The place of each error in a content that was validated, and its kind."""
    return [(_without_tags(item["loc"], raw), item["type"]) for item in error.errors()]


def explain(error: ValidationError, source: Source, model: type[BaseModel]) -> list[Fault]:
    """Turn the errors of a validation against a model into faults, each once."""
    faults: dict[tuple[str, str], Fault] = {}
    errors = error.errors(include_url=False)
    inside = {item["loc"][:end] for item in errors for end in range(len(item["loc"]))}
    for number, item in enumerate(errors):
        if number >= MOST_FAULTS:  # nobody reads so many, and words for each take their time
            rest = f"{error.error_count() - number} further faults"
            return [*faults.values(), Fault(source.path, "", None, rest)]
        if item["type"] == "too_short" and item["loc"] in inside:
            continue  # pydantic counts the valid items only; what is wrong with the others is told
        if item["type"] == REPORTED:
            continue
        fault = replace(source.fault(*_fault(item, source.raw, model)), kind=item["type"])
        faults.setdefault((fault.key, fault.expected), fault)
    return list(faults.values())


def expectation(annotation: Any, metadata: list[Any] | tuple[Any, ...] = ()) -> str:
    """What a field accepts, in words that complete 'expected ...'."""
    for item in metadata:
        if isinstance(item, Leaf):
            return item.phrase
        if isinstance(item, Written):
            return expectation(item.form)
        if isinstance(item, OneOrMore):
            some = "such values" if item.count == 1 else f"{item.count} such values"
            return f"{expectation(get_args(annotation)[0])}; or a list of {some}"
    origin, args = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return expectation(args[0], args[1:])
    if origin in (Union, types.UnionType):
        return " or ".join(dict.fromkeys(expectation(arg) for arg in args if arg is not type(None)))
    if origin is Literal:
        return " or ".join(f"'{arg}'" for arg in args)
    if origin is tuple and args[-1] is not Ellipsis:
        items = list(dict.fromkeys(map(expectation, args)))
        each = ", each " if len(items) == 1 else ": "
        return f"a list of {len(args)} values{each}{', and '.join(items)}"
    if origin is tuple:
        item = expectation(args[0])
        return TABLES if item == "a table" else f"{LIST}each value {item}"
    if annotation is bool:
        return "true or false"
    return "a table"


def expected_of(item: ErrorDetails, info: FieldInfo | None) -> str:
    """What was expected of a single value that a field does not accept."""
    return item["msg"] if "inside" in item.get("ctx", {}) else f"expected {_words(info)}"


def _fault(
    item: ErrorDetails, raw: Mapping[str, Any], model: type[BaseModel]
) -> tuple[Place, Any, str]:
    """The place of an error, the value there, and what was expected of it."""
    place = _without_tags(item["loc"], raw)
    kind, value = item["type"], value_at(place, raw)
    parent, info = field_at(model, place, raw)
    if "inside" in item.get("ctx", {}) or kind == UNREADABLE:
        if info is None and parent is not None and place[-1] in parent.model_fields:
            # A key that is left out goes by the name of its field, which is not always the key.
            place = (*place[:-1], parent.model_fields[str(place[-1])].alias or place[-1])
        inside = item.get("ctx", {}).get("inside", ())
        place = (*place, *inside)
        return place, value_at(place, raw), item["msg"]
    if kind == "extra_forbidden":
        known = list(fields_by_key(parent)) if parent is not None else []
        holder = field_at(model, place[:-1], raw)[1]
        types = " or ".join(_tags(form_of(holder) if holder else None, str(place[-1])))
        hint = f"a key of type {types}" if types else nearest(str(place[-1]), known)
        return place, None, f"unknown key; {hint}"
    if kind in {"union_tag_not_found", "union_tag_invalid"}:
        # A table with a name of the user's choice has no field of its own, but that of all of them.
        holder = info or field_at(model, place[:-1], raw)[1]
        words = " or ".join(_tags(form_of(holder) if holder else None))
        place = (*place, "type")
        given = value.get("type") if isinstance(value, Mapping) else None
        lead = "missing; expected" if given is None else "expected"
        return place, given, f"{lead} {words}"
    if kind in {"missing", "too_long"} and (kind == "too_long" or isinstance(place[-1], int)):
        # A list of a fixed length with too few or too many values: the fault is the list's.
        if kind == "missing":
            place = place[:-1]
            _, info = field_at(model, place, raw)
        words, given = _words(info, within=place), value_at(place, raw)
        if words.startswith(LIST) and given:
            words = f"at most {item['ctx']['max_length']} values, found {len(given)}"
        return place, given, f"expected {words}"
    if kind == "missing":
        about = f": {one_line(info)}" if info is not None and info.description else ""
        return place, None, f"missing; expected {_words(info)}{about}"
    if kind == "too_short":
        least = item["ctx"]["min_length"]
        many = f"at least {least} values, found {len(value)}" if least > 1 else NOT_EMPTY
        return place, value, f"expected {many}"
    of_table = kind in {"model_type", "model_attributes_type", "dict_type"}
    if of_table and (info is None or isinstance(place[-1], int)):
        return place, value, "expected a table"
    if kind == "tuple_type" and isinstance(value, Mapping) and _words(info) == TABLES:
        return place, None, f"expected {TABLES}, [[{dotted(place)}]], not [{dotted(place)}]"
    if kind == "literal_error" and info is None:
        # A value of a table with names of the user's choice, which has no field of its own.
        return place, value, f"expected {item['ctx']['expected']}"
    return place, value, f"expected {_words(info, within=place)}"


def _words(info: FieldInfo | None, within: Place = ()) -> str:
    """What a field accepts, or the lists in it at the indices that a place ends with."""
    if info is None:
        return "another value"
    annotation, metadata = info.annotation, info.metadata
    last = itertools.takewhile(lambda part: isinstance(part, int), reversed(within))
    for index in reversed([*last]):
        lists = [one for one in alternatives(annotation) if get_origin(one) is tuple]
        if lists:
            items = get_args(lists[0])
            annotation, metadata = items[0 if items[-1] is Ellipsis else int(index)], []
    return expectation(annotation, metadata)


def _without_tags(place: Place, raw: Any) -> Place:
    """The place of an error as keys and indices of the file."""
    cleaned: list[int | str] = []
    current = raw
    entered = True
    for part in place:
        is_key = isinstance(current, Mapping) and part in current
        # A table of a union is entered by its type, which may be the name of a key of it as well.
        is_type = entered and isinstance(current, Mapping) and part == current.get("type")
        entered = False
        if part == "[key]" or is_type or (not is_key and part in _FORMS):
            continue
        if isinstance(part, int) and current is not None and not isinstance(current, list):
            continue  # a single value, of one or more
        cleaned.append(part)
        current = step(current, part)
        entered = True
    return tuple(cleaned)


def _tags(annotation: Any, key: str = "type") -> list[str]:
    """The types, in quotes, of the tables of an annotation that have a key."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        info = annotation.model_fields.get("type")
        known = info is not None and key in fields_by_key(annotation)
        return [f"'{tag}'" for tag in get_args(info.annotation)] if info and known else []
    return [tag for arg in get_args(annotation) for tag in _tags(arg, key)]
