"""The JSON schema of the case file, and its keys in words.

The reference page of the documentation and `impactfem explain` are made from it.
"""

from __future__ import annotations

import json
from typing import Any

from pydantic.fields import FieldInfo

from impactfem.case.base import Section
from impactfem.case.calibration import Target
from impactfem.case.capacities import BoltPosition, QualificationPoint
from impactfem.case.design_spectrum import SpectrumPoint
from impactfem.case.device_tables import DeviceMode
from impactfem.case.floors import Floor
from impactfem.case.members import Bay, Beam, Column, Wall
from impactfem.case.model import CaseFile
from impactfem.case.quantity import Si
from impactfem.case.report import PublishedRow
from impactfem.case.soil import ImpedanceRow
from impactfem.case.table import leaf_of

TABLE_MODELS: tuple[tuple[str, str, type[Section]], ...] = (
    ("Floor table", "`floors` of `[[buildings]]`: one row a floor, bottom to top.", Floor),
    ("Target table", "`targets` of `[calibration]`: one row a mode of a building.", Target),
    (
        "Design spectrum",
        "`file` of `[motions.spectrum]` with type `table`: one row a point, in order of frequency "
        "or period; several dampings one after another.",
        SpectrumPoint,
    ),
    ("Wall table", "`walls` of `[buildings.structure.mesh]`: one row a wall.", Wall),
    (
        "Bay table",
        "`bays` of `[buildings.structure.mesh]`: one row a rectangular opening in a wall.",
        Bay,
    ),
    ("Beam table", "`beams` of `[buildings.structure.mesh]`: one row a beam.", Beam),
    ("Column table", "`columns` of `[buildings.structure.mesh]`: one row a column.", Column),
    (
        "Impedance table",
        "`file` of `[buildings.soil]` with type `table`: one row a component and a frequency, in "
        "order of frequency.",
        ImpedanceRow,
    ),
    ("Mode table", "`modes` of `[[devices]]`: one row a mode and a direction.", DeviceMode),
    (
        "Bolt table",
        "`positions` of `[devices.anchors]`: one row a bolt, from the anchor point.",
        BoltPosition,
    ),
    (
        "Qualification spectrum",
        "`file` of `[devices.required_spectrum]` and `[devices.test_spectrum]`: one row a point, "
        "in order of frequency; spectra of several axes one after another.",
        QualificationPoint,
    ),
    ("Published values", "`published`: one row a result that was published.", PublishedRow),
)
"""Heading, description and model of each table that a case file names."""


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
        table["title"] = name.removesuffix("Entry").removesuffix("Setup")
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
    entry["description"] = " ".join(entry["description"].split())
    default = entry.get("default", ...)
    # What is left out follows from other keys, or is the empty content of no file.
    if default is None or (entry.get("type") == "string" and default in ([], {})):
        del entry["default"]
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


def references(entry: dict[str, Any]) -> list[str]:
    """Names of the definitions a property refers to, itself or by its items."""
    if "$ref" in entry:
        return [str(entry["$ref"]).rsplit("/", 1)[-1]]
    names = []
    for item in (*entry.get("oneOf", []), *entry.get("anyOf", [])):
        names.extend(references(item))
    for key in ("items", "additionalProperties"):
        if isinstance(entry.get(key), dict):
            names.extend(references(entry[key]))
    return names


def accepted(entry: dict[str, Any]) -> tuple[str, str]:
    """Words for a value without tables, and its SI unit."""
    if "prefixItems" in entry:
        parts = [accepted(part) for part in entry["prefixItems"]]
        if len(set(parts)) > 1:
            each = [f"{words} [{unit}]" if unit else words for words, unit in parts]
            return f"list of {' and '.join(each)}", ""
        words, unit = parts[0]
        return f"list of {len(parts)}, each {words}", unit
    if "anyOf" in entry and entry["anyOf"][-1].get("type") == "array":
        item, array = entry["anyOf"]
        words, unit = accepted(item)
        count = array.get("maxItems")
        return f"{words}, or a list of {count or 'such values'}".replace("of 2", "of two"), unit
    if "items" in entry:
        words, unit = accepted(entry["items"])
        return f"list, each {words}", unit
    if "enum" in entry:
        return " or ".join(f'`"{value}"`' for value in entry["enum"]), ""
    if "const" in entry:
        return f'`"{entry["const"]}"`', ""
    if isinstance(entry.get("additionalProperties"), dict):
        words, unit = accepted(entry["additionalProperties"])
        return f"table by names, each {words}", unit
    if entry.get("type") == "boolean":
        return "`true` or `false`", ""
    words, unit = entry.get("x-accepts", f"a {entry.get('type', 'value')}"), entry.get("x-unit", "")
    examples = entry.get("examples")
    return (f'{words}, as `"{examples[0]}"`' if examples else words), unit


def default_of(entry: dict[str, Any]) -> str:
    """The default of a property in words; "optional" without one."""
    if "default" not in entry or entry["default"] in ({}, []):
        return "optional"
    return f"default `{json.dumps(entry['default'], ensure_ascii=False)}`"


def column(info: FieldInfo) -> tuple[str, str, str]:
    """Words for a column of a table, its SI unit, and its default in words."""
    leaf = leaf_of(info)
    if isinstance(leaf, Si):
        words, unit = leaf.accepts, leaf.unit
    else:
        words, unit = leaf.phrase.replace(" in quotes", ""), ""
    if info.is_required():
        return words, unit, "**required**"
    # The description says what a default means that is not a number.
    none = info.default is None or info.default != info.default
    shown = info.default if isinstance(info.default, str) else f"{info.default or 0.0:g}"
    return words, unit, "optional" if none else f"default `{shown}`"
