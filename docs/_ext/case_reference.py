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

from impactfem.case.base import Section
from impactfem.case.place import one_line
from impactfem.case.report import Reference
from impactfem.case.schema import (
    TABLE_MODELS,
    accepted,
    column,
    default_of,
    json_schema,
    references,
)

__all__ = ["json_schema", "reference_page", "schema_text", "write_reference"]


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
    '[damping] type = "rayleigh"': (
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
        "@tables@": (_csv_section(*entry) for entry in TABLE_MODELS),
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
            default = "**required**" if key in required else default_of(entry)
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
        names = references(entry)
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
            text, unit = accepted(item)
            words.append(text)
        return " or ".join(words), unit


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
        (_linked(name, _slug(title)), _value(*column(info)), one_line(info))
        for name, info in model.model_fields.items()
    ]
    return f"### {title}\n\n{_sketch(title)}{about}\n\n" + _markdown(
        ("Column", "Value", "Meaning"), rows
    )


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
