"""Errors of pydantic in plain words, with the keys of the case file."""

import itertools
import re
import types
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
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
from impactfem.case.quantity import BEYOND
from impactfem.case.source import Source
from impactfem.system.errors import MOST_FAULTS, Fault

REMOVED = {
    "device_analysis.solver": "removed: equipment is always analysed with the reduced model; remove"
    " the key, and lower transient.tolerance for more accuracy",
}
"""Replacements of removed keys, by their place."""
MISSING = {"missing", "either", "together", "one_of_them", "missing_section"}
"""Kinds of faults of a key that a table lacks."""
TABLES = "one or more tables"
"""Words for an array of tables."""

# Names of the alternatives of a union, which pydantic puts into the place of an error. Besides
# these, the type that a table has.
_FORMS = {"grid", "list", "table", "corner-periods", "rayleigh"}


def explain(errors: Sequence[ErrorDetails], source: Source, model: type[BaseModel]) -> list[Fault]:
    """Turn the errors of a validation against a model into faults, each once."""
    faults: dict[tuple[str, str], Fault] = {}
    inside = {item["loc"][:end] for item in errors for end in range(len(item["loc"]))}
    for number, item in enumerate(errors):
        if number >= MOST_FAULTS:  # nobody reads so many, and words for each take their time
            rest = f"{len(errors) - number} further faults"
            return [*faults.values(), Fault(source.path, "", None, rest)]
        if item["type"] == "too_short" and item["loc"] in inside:
            continue  # pydantic counts the valid items only; the others have errors
        if item["type"] == REPORTED:
            continue
        fault = replace(source.fault(*_fault(item, source.raw, model)), kind=item["type"])
        faults.setdefault((fault.key, fault.expected), fault)
    return without_consequences(list(faults.values()))


def without_consequences(faults: Sequence[Fault]) -> list[Fault]:
    """Leave out what is missing in a table with a key that is misspelled: it is what was meant."""
    tables, keys = set[str](), set[str]()
    for fault in faults:
        hint = re.search("did you mean '(.+?)'", fault.expected)
        if fault.kind == "extra_forbidden" and hint is not None:
            above, dot, _ = fault.key.rpartition(".")
            tables.add(above)
            keys.add(f"{above}{dot}{hint[1]}")
    return [
        fault
        for fault in faults
        if not (fault.kind in MISSING and fault.key.rpartition(".")[0] in tables)
        and not (fault.kind == "tuple_type" and fault.key in keys)
    ]


def expectation(annotation: Any, metadata: list[Any] | tuple[Any, ...] = ()) -> str:
    """Words for the values that a field accepts; they complete 'expected ...'."""
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
        return TABLES if item == "a table" else f"a list, each value {item}"
    if annotation is bool:
        return "true or false"
    return "a table"


def expected_of(item: ErrorDetails, info: FieldInfo | None, within: Place = ()) -> str:
    """Expectation of a value that a field, or a list in it, does not accept."""
    context = item.get("ctx", {})
    if "inside" in context:
        return item["msg"]
    lead = "a finite value: " if item["type"] == "finite_number" else ""
    if BEYOND in (context.get("le"), -context.get("ge", 0.0)):
        lead = f"a value below {BEYOND:g} in SI units: "
    words = context.get("expected", "a table") if info is None else _words(info, within)
    return f"expected {lead}{words}"


def _fault(
    item: ErrorDetails, raw: Mapping[str, Any], model: type[BaseModel]
) -> tuple[Place, Any, str]:
    """The place of an error, the value there, and what was expected of it."""
    kind, context = item["type"], item.get("ctx", {})
    place = _without_tags(item["loc"], raw)
    parent, info = field_at(model, place, raw)
    # A table named by the user has no field but that of all such tables.
    holder = field_at(model, place[:-1], raw)[1]
    if "inside" in context or kind == UNREADABLE:
        if info is None and parent is not None and place[-1] in parent.model_fields:
            # A key that is left out goes by the name of its field, which is not always the key.
            place = (*place[:-1], parent.model_fields[str(place[-1])].alias or place[-1])
        place = (*place, *context.get("inside", ()))
        value = value_at(place, raw)
        return place, None if isinstance(value, Mapping) else value, item["msg"]
    if kind == "extra_forbidden":
        if (replaced := REMOVED.get(dotted(place))) is not None:
            return place, None, replaced
        known = list(fields_by_key(parent)) if parent is not None else []
        types = " or ".join(_tags(form_of(holder) if holder else None, str(place[-1])))
        hint = f"a key of type {types}" if types else nearest(str(place[-1]), known)
        given = value_at(place, raw)
        parts = given if isinstance(given, list) else [given]
        what = "table" if any(isinstance(part, Mapping) for part in parts) else "key"
        return place, None, f"unknown {what}; {hint}"
    if kind in {"union_tag_not_found", "union_tag_invalid"}:
        of_all = info or holder
        words = " or ".join(_tags(form_of(of_all) if of_all else None))
        given = value_at((*place, "type"), raw)
        known = [tag.strip("'") for tag in words.split(" or ")]
        close = nearest(given, known) if isinstance(given, str) else ""
        hint = f"; {close}" if close.startswith("did") else ""
        lead = "missing; " if given is None else ""
        return (*place, "type"), given, f"{lead}expected {words}{hint}"
    if kind == "missing" and not isinstance(place[-1], int):
        about = f": {one_line(info)}" if info is not None and info.description else ""
        return place, None, f"missing; expected {_words(info)}{about}"
    if kind in {"missing", "too_short", "too_long"}:
        # The list is at fault, which lacks an item, or has one too many.
        place = place[:-1] if kind == "missing" else place
        given = value_at(place, raw)
        words = _words(field_at(model, place, raw)[1], within=place)
        if kind != "missing":
            bound = context["min_length" if kind == "too_short" else "max_length"]
            lead = "at least" if kind == "too_short" else "at most"
            words = f"{lead} {bound} value{'s' if bound != 1 else ''}"
        return place, given, f"expected {words}, found {len(given)}"
    value = value_at(place, raw)
    if kind == "tuple_type" and isinstance(value, Mapping) and _words(info) == TABLES:
        return place, None, f"expected {TABLES}, [[{dotted(place)}]], not [{dotted(place)}]"
    return place, value, expected_of(item, info, place)


def _words(info: FieldInfo | None, within: Place = ()) -> str:
    """Words for the values of a field, or of the list in it where a place ends with indices."""
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
