"""The reference page of the case file, made from its schema and `case-file.md.in`.

``python docs/_ext/case_reference.py docs`` writes ``docs/case-file.md`` and
``docs/case.schema.json``.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic.fields import FieldInfo

from impactfem.case.base import Section
from impactfem.case.calibration import Target
from impactfem.case.design_spectrum import SpectrumPoint
from impactfem.case.device_tables import DeviceMode
from impactfem.case.floors import Floor
from impactfem.case.members import Bay, Beam, Column, Wall
from impactfem.case.model import CaseFile
from impactfem.case.place import one_line
from impactfem.case.quantity import Quantity, Ratio
from impactfem.case.report import PublishedRow, Reference
from impactfem.case.soil import ImpedanceRow
from impactfem.case.table import leaf_of

__all__ = ["json_schema", "reference_page", "schema_text", "write_reference"]
_TABLE_MODELS: tuple[tuple[str, str, type[Section]], ...] = (
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
    ("Published values", "`published`: one row a result that was published.", PublishedRow),
)


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


SHORT = {
    "a file name in quotes, relative to the folder of the case file": "a file name",
    "a name of letters, digits, '_' and '-' that begins with a letter, for example 'B1'": "a name",
    "a text in quotes": "a text",
    "a name of a-z, 0-9 and single '_', for example 'gable_west'": "a name of a-z, 0-9 and '_'",
}
"""Values that the top of the page explains once."""
FEWEST_SHARED = 3
"""Least number of equal keys that are not written again."""
SKETCHES = {
    "[damping]": (
        "damping",
        "Damping ratio over frequency of the types rayleigh, constant and table",
    ),
    "[[buildings]]": (
        "buildings",
        "Plan of two buildings with the axes x and y: axis, length, width and setback",
    ),
    "[buildings.soil.raft]": (
        "soil",
        "Section through a raft: length, thickness, embedment, and the base at its top",
    ),
    "[[buildings.structure.added_mass]]": (
        "added_mass",
        "Plan of a slab with strips of added mass along both edges and in the middle",
    ),
    '[buildings.structure.mesh] type = "generated"': (
        "mesh",
        "Plan with its corner, length, width, walls, beam, columns, wall setback and impact edge",
    ),
    "[wall_impact]": (
        "wall_impact",
        "A building with its displaced floor, the displacement, the gap and the rigid wall",
    ),
    "[transient]": (
        "transient",
        "Plan of a floor: line load on the impact edge, patch width, and the standard probes",
    ),
    "[[devices]]": (
        "devices",
        "A device with point, radius, stiffness, mass and mass height; a device on two supports",
    ),
    "[devices.beam]": ("device_beam", "A body on a beam on a base on springs on the floor"),
    '[[motions]] type = "synthetic"': (
        "motions",
        "Two buildings on the ground and the directions x, y and z of the motions",
    ),
    '[motions.spectrum] type = "corner-periods"': (
        "design_spectrum",
        "Elastic spectrum with its level, amplification and corner periods",
    ),
    "[wave_passage]": ("wave_passage", "Wave fronts that reach two buildings one after the other"),
    '[contact_laws.NAME] type = "kelvin-voigt"': (
        "contact_laws",
        "Force over penetration of the Kelvin-Voigt, Hertz and damped Hertz laws",
    ),
    "[[contacts]]": (
        "contacts",
        "Two floors with the points a and b, the normal from a to b, the gap and the forces",
    ),
    "[contacts.a]": (
        "contact_point",
        "A floor beside a storey: offset, relative height in the flexible part, patch width",
    ),
    "[pounding]": ("pounding", "Force of an impact with its time steps"),
    "Floor table": (
        "floors",
        "Elevation and stick: floors, storeys, storey heights, rigid zones and mass centres",
    ),
    "Bay table": ("bays", "Wall of a storey with an opening: centre, sill, width and height"),
    "Beam table": ("beams", "Section of a beam below a slab: width, depth and negative offset"),
}
"""Drawing of a section, and its description."""


def reference_page() -> str:
    """The reference page of the case file and its tables, in Markdown."""
    beside = _Writer(json_schema(Reference, "What the report stands beside"), "reference")
    text = Path(__file__).with_name("case-file.md.in").read_text(encoding="utf-8")
    for mark, parts in {
        "@sections@": _Writer(json_schema()).sections(),
        "@tables@": (_csv_section(*entry) for entry in _TABLE_MODELS),
        "@reference@": beside.sections("Top of the reference"),
    }.items():
        text = text.replace(mark, "".join(parts))
    return text.rstrip() + "\n"


def schema_text() -> str:
    """The JSON schema as the text of a file."""
    return json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n"


def write_reference(folder: Path) -> list[Path]:
    """Write the reference page and the schema into a folder; gives the files."""
    texts = {"case-file.md": reference_page(), "case.schema.json": schema_text()}
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return [folder / name for name in texts]


@dataclass
class _Writer:
    """Walks the schema from its root; a table that occurs twice is written once.

    Args:
        schema: The JSON schema.
        place: What anchors of keys at its top begin with.
        headings: The heading under which each table was written, by the name of its definition.
        written: Names of the definitions that were written.
        tables: Rows of the tables that were written, by heading and key.
    """

    schema: dict[str, Any]
    place: str = ""
    headings: dict[str, str] = field(default_factory=dict)
    written: set[str] = field(default_factory=set)
    tables: dict[str, dict[str, tuple[str, ...]]] = field(default_factory=dict)

    def sections(self, heading: str = "Top of the file") -> Iterator[str]:
        """The sections of all tables, outer ones first."""
        yield from self._section(heading, "", self.schema)

    def _section(self, heading: str, path: str, table: dict[str, Any]) -> Iterator[str]:
        inner: list[tuple[str, str, str]] = []
        rows = []
        required = table.get("required", [])
        name = self.place if heading.startswith("Top") else _anchor(heading)
        for key, entry in table["properties"].items():
            inner.extend(self._tables_in(key, path, entry))
            default = "**required**" if key in required else _default(entry)
            value = _value(*self._accepts(key, path, entry), default)
            rows.append((_linked(key, name), value, entry["description"]))
        title = f"`{heading}`" if heading.startswith("[") else heading
        rows, shared = self._without_shared(rows, heading)
        yield f"## {title}\n\n{_sketch(heading)}{table['description']}\n\n{shared}"
        yield _markdown(("Key", "Value", "Meaning"), rows)
        for inner_heading, inner_path, name in inner:
            if self.headings[name] == inner_heading and name not in self.written:
                self.written.add(name)
                yield from self._section(inner_heading, inner_path, self.schema["$defs"][name])

    def _without_shared(
        self, rows: list[tuple[str, str, str]], heading: str
    ) -> tuple[list[tuple[str, str, str]], str]:
        """The rows that no other table has, and a sentence that names the others."""
        lines = {_bare(key): (_bare(key), *rest) for key, *rest in rows}
        for other, known in self.tables.items():
            same = [key for key, line in lines.items() if known.get(key) == line]
            if len(same) >= FEWEST_SHARED:
                keys = ", ".join(row[0] for row in rows if _bare(row[0]) in same)
                kept = [row for row in rows if _bare(row[0]) not in same]
                return kept, f"As in [`{other}`](#{_slug(other)}): {keys}.\n\n"
        self.tables[heading] = lines
        return rows, ""

    def _tables_in(
        self, key: str, path: str, entry: dict[str, Any]
    ) -> Iterator[tuple[str, str, str]]:
        """Heading, path and definition of the tables a key holds."""
        inner = f"{path}.{key}" if path else key
        names = _references(entry)
        if "items" in entry:
            heading = f"[[{inner}]]"
        elif "additionalProperties" in entry:
            heading = f"[{inner}.NAME]"
        else:
            heading = f"[{inner}]"
        for name in names:
            tag = self.schema["$defs"][name]["properties"].get("type", {}).get("const")
            full = f'{heading} type = "{tag}"' if tag else heading
            self.headings.setdefault(name, full)
            yield full, inner, name

    def _accepts(self, key: str, path: str, entry: dict[str, Any]) -> tuple[str, str]:
        """What a key accepts in words, and its SI unit."""
        words: list[str] = []
        for full, _, name in self._tables_in(key, path, entry):
            first = self.headings[name]
            to = f"[`{first}`](#{_slug(first)})"
            words.append(
                f"table {to}" if full == first else f"table `{full}`, with the keys of {to}"
            )
        alternatives = [item for item in entry.get("oneOf", []) if "$ref" not in item]
        if words and not alternatives:
            return " or ".join(words), ""
        for item in alternatives or [entry]:
            text, unit = _plain(item)
            words.append(text)
        return " or ".join(words), unit


def _references(entry: dict[str, Any]) -> list[str]:
    """Names of the definitions a property refers to, itself or by its items."""
    if "$ref" in entry:
        return [str(entry["$ref"]).rsplit("/", 1)[-1]]
    names = []
    for item in (*entry.get("oneOf", []), *entry.get("anyOf", [])):
        names.extend(_references(item))
    for key in ("items", "additionalProperties"):
        if isinstance(entry.get(key), dict):
            names.extend(_references(entry[key]))
    return names


def _plain(entry: dict[str, Any]) -> tuple[str, str]:
    """What a value without tables accepts, and its SI unit."""
    if "prefixItems" in entry:
        parts = [_plain(part) for part in entry["prefixItems"]]
        if len(set(parts)) > 1:
            each = [f"{words} [{unit}]" if unit else words for words, unit in parts]
            return f"list of {' and '.join(each)}", ""
        words, unit = parts[0]
        return f"list of {len(parts)}, each {words}", unit
    if "items" in entry and "x-accepts" not in entry:
        words, unit = _plain(entry["items"])
        return f"list, each {words}", unit
    if "enum" in entry:
        return " or ".join(f'`"{value}"`' for value in entry["enum"]), ""
    if "const" in entry:
        return f'`"{entry["const"]}"`', ""
    if isinstance(entry.get("additionalProperties"), dict):
        words, unit = _plain(entry["additionalProperties"])
        return f"table by names, each {words}", unit
    if entry.get("type") == "boolean":
        return "`true` or `false`", ""
    words, unit = entry["x-accepts"], entry.get("x-unit", "")
    examples = entry.get("examples")
    return (f'{words}, as `"{examples[0]}"`' if examples else words), unit


def _default(entry: dict[str, Any]) -> str:
    if "default" not in entry or entry["default"] in ({}, []):
        return "optional"
    return f"default `{json.dumps(entry['default'], ensure_ascii=False)}`"


def _value(words: str, unit: str, default: str) -> str:
    """What a key takes, its SI unit, and on a line of its own what holds when it is left out."""
    return f"{words} [{unit}]<br>{default}" if unit not in ("", "-") else f"{words}<br>{default}"


def _anchor(heading: str) -> str:
    """What anchors of keys of a table begin with: 'motions.record' of '[[motions]] type = ...'."""
    return re.sub(r'[\[\]"]', "", heading).replace(" type = ", ".")


def _slug(heading: str) -> str:
    """The anchor of a heading, as MyST makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def _linked(key: str, place: str) -> str:
    """A key that may be linked to: place.key."""
    name = f"{place}.{key}" if place else key
    return f'<a id="{name}" href="#{name}">`{key}`</a>'


def _bare(cell: str) -> str:
    """A cell without the anchor of its key."""
    return re.sub(r"</?a[^>]*>", "", cell)


def _sketch(heading: str) -> str:
    """The drawing of a section, if it has one."""
    if heading not in SKETCHES:
        return ""
    name, words = SKETCHES[heading]
    return f"![{words}](figures/sketches/case_{name}.svg)\n\n"


def _csv_section(title: str, about: str, model: type[Section]) -> str:
    rows = [
        (_linked(name, _slug(title)), _value(*_column(info)), one_line(info))
        for name, info in model.model_fields.items()
    ]
    return f"### {title}\n\n{_sketch(title)}{about}\n\n" + _markdown(
        ("Column", "Value", "Meaning"), rows
    )


def _column(info: FieldInfo) -> tuple[str, str, str]:
    leaf = leaf_of(info)
    if isinstance(leaf, Quantity):
        words, unit = f"{leaf.kind.name} {leaf.bound}".strip(), leaf.kind.unit
    elif isinstance(leaf, Ratio):
        words, unit = f"a number {leaf.bound}".strip(), "-"
    else:
        words, unit = leaf.phrase.replace(" in quotes", ""), ""
    if info.is_required():
        return words, unit, "**required**"
    # A default that is not a number stands for something else: the description says what.
    none = info.default is None or info.default != info.default
    return words, unit, "optional" if none else f"default `{info.default:g}`"


def _markdown(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    lines = [head, tuple("---" for _ in head), *rows]
    return "".join(f"|{'|'.join(_cell(c) for c in row)}|\n" for row in lines) + "\n"


def _cell(text: str) -> str:
    for words, short in SHORT.items():
        text = text.replace(words, short)
    return text.replace("|", "\\|").replace("\n", " ")


def main(arguments: list[str]) -> int:
    """Write the two files into the folder that is the only argument."""
    if len(arguments) != 1 or not Path(arguments[0]).is_dir():
        sys.stderr.write("usage: python docs/_ext/case_reference.py FOLDER\n")
        return 2
    for path in write_reference(Path(arguments[0])):
        sys.stdout.write(f"{path}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
