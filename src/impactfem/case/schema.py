"""The JSON schema of the case file, for editors and for the reference page."""

from __future__ import annotations

from typing import Any

from impactfem.case.base import Section
from impactfem.case.model import CaseFile

__all__ = ["json_schema"]


def json_schema(
    model: type[Section] = CaseFile, title: str = "Case file of impactfem"
) -> dict[str, Any]:
    """The JSON schema (2020-12) of a case file, or of another TOML file that it names.

    Quantities are texts with a unit. Two keywords are added to those of the standard: ``x-unit``,
    the SI unit that results give the quantity in, and ``x-accepts``, what is accepted in words.
    What a schema cannot say, such as the names a reference may have, ``load_case`` checks.

    Args:
        model: The model of the file.
        title: What the file is.
    """
    schema = model.model_json_schema()
    schema["title"] = title
    definitions: dict[str, Any] = schema.pop("$defs")
    for name, table in definitions.items():
        table["title"] = name.removesuffix("Entry")
    for table in (schema, *definitions.values()):
        table["description"] = table["description"].replace("``", "`")
        table["properties"] = {
            key: _finished(key, entry) for key, entry in table["properties"].items()
        }
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return head | schema | {"$defs": definitions}


def _finished(key: str, entry: dict[str, Any]) -> dict[str, Any]:
    """A property with its title, without what TOML cannot say, and its default with a unit."""
    entry = _without_null(entry) | {"title": key.replace("_", " ").capitalize()}
    if "default" in entry:
        entry["default"] = _with_unit(entry["default"], entry)
    return entry


def _without_null(entry: dict[str, Any]) -> dict[str, Any]:
    """An optional key is left out in TOML, which has no null."""
    alternatives = [item for item in entry.get("anyOf", []) if item != {"type": "null"}]
    if len(alternatives) == len(entry.get("anyOf", [])):
        return entry
    rest = {k: v for k, v in entry.items() if k not in {"anyOf", "default"}}
    if len(alternatives) == 1:
        only: dict[str, Any] = alternatives[0]
        return only | rest
    return {"anyOf": alternatives} | rest


def _with_unit(default: Any, entry: dict[str, Any]) -> Any:
    """A default as it would be written: quantities are SI floats in the model."""
    if isinstance(default, list | tuple):
        items = entry.get("prefixItems", [entry.get("items", {})] * len(default))
        return [_with_unit(value, item) for value, item in zip(default, items, strict=True)]
    if entry.get("type") == "string" and isinstance(default, float):
        return f"{default:g} {entry['x-unit']}"
    return default
