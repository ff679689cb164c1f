"""The reference entry of a key, a result or a check, for `impactfem explain`.

Keys come from the models of the case file and of the fit file, results from the table of
`docs/results.md`, checks from the sections of `docs/how-to/failed-checks.md`.
"""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any

from impactfem.case.schema import (
    TABLE_MODELS,
    accepted,
    column,
    default_of,
    json_schema,
    references,
)
from impactfem.system.errors import Fault, InputError
from impactfem.system.files import in_source_tree

CHECKS_PAGE, RESULTS_PAGE = "docs/how-to/failed-checks.md", "docs/results.md"
WIDTH = 96  # of the text
MOST_ENTRIES = 6
"""Largest number of entries that are printed in full; more are listed by their names."""
ANY = "NAME"
"""Part of a path that is a name of the user's choice."""
UNITS = (
    (r"_over_(pfa|sticks|target|gap|near|inside)|_ratio\b|_change$|_error\b|_error_max$", "-"),
    (r"displacement_spread", "-"),
    (r"transfer\.floor_\d+(_to_\d+hz)?$", "1/kg"),
    (r"penetration_over_force\.", "m/N"),
    (r"force_over_acceleration\.|mass(\.\w+)?$", "kg"),
    (r"frequency|nyquist|\.(near_highest_at|far_highest_below|highest|lowest)$", "Hz"),
    (r"duration|time|delay$|crossing|wave_far_edge|wave_reversal|strong_phase", "s"),
    (r"epsilon|restitution|xi_c", "-"),
    (r"K_Ceq", "N/m"),
    (r"force|uplift|tension|weight|storey_shear_max", "N"),
    (r"impulse", "N s"),
    (r"pressure|stress", "Pa"),
    (r"velocity|wave_speed|pgv|arias", "m/s"),
    (r"pga|pfa|zpa|sa_max|acceleration|frs\.largest|\.peak(_no_contact|\.|$)", "m/s2"),
    (r"displacement|penetration|pgd|separation|distance|storey_height|rigid_(above|below)", "m"),
    (r"radiated|energy_dissipated", "J"),
    (r"moment\.", "N m"),
)
"""SI units of results by patterns of their names, the first that matches."""


@dataclass(frozen=True)
class Entry:
    """The reference entry of a key of a file."""

    path: tuple[str, ...]  #: parts of its dotted path; `ANY` for a name, "" for an optional one
    table: str  #: the heading of its table: ``[[contacts]]``
    value: str  #: what it accepts
    default: str
    text: str  #: its description
    page: str  #: where it is documented
    inner: tuple[str, ...] = ()  #: keys of the tables that it holds

    @property
    def name(self) -> str:
        """Its dotted path."""
        return ".".join(part for part in self.path if part)

    def lines(self) -> Iterator[str]:
        """The entry as text."""
        if self.table:
            yield f"  in       {self.table}"
        yield from _wrapped(f"  value    {self.value}", 11)
        yield f"  default  {self.default}"
        yield from _wrapped(f"  {self.text}", 2)
        if self.inner:
            yield from _wrapped(f"  keys     {', '.join(self.inner)}", 11)
        yield f"  see      {self.page}"


def explain(name: str, run: Path | None = None) -> list[str]:
    """Return the reference entries of a key, a result or a check, as lines of text.

    Args:
        name: Name of the key, with or without indices and names of the case
            (``contacts[0].gap``), of the result, or id of the check.
        run: Folder of a run, whose value of the result is added.

    Raises:
        InputError: The name is unknown; with the nearest name. Or the folder has no results.
    """
    query = name.strip().strip("`'\"")
    summary = _summary(run) if run is not None else {}
    found = [*_check(query), *_keys(query), *_result(query, summary)] or _information(query)
    if not found:
        expected = "expected a key of a case or fit file, a result of summary.json, or a check"
        near = _nearest(query, summary)
        raise InputError(
            [Fault("command line", "NAME", name, near or f"{expected}; see 'impactfem --help'")]
        )
    return found


def checks() -> dict[str, tuple[str, str]]:
    """Return heading and text of the section of each check, by the last part of its id.

    ``steps-per-impact`` is that of ``pounding.steps_per_impact``.
    """
    page = in_source_tree(CHECKS_PAGE).read_text(encoding="utf-8")
    sections = re.findall(r"(?ms)^### (.*?)\n(.*?)(?=^##|\Z)", page)
    return {slug(heading): (heading, _plain(text)) for heading, text in sections}


def slug(heading: str) -> str:
    """Return the anchor of a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def _check(query: str) -> list[str]:
    """The section of a check, by its id; the stage before its name may be left out."""
    sections = checks()
    # `B2/pounding.steps_per_impact` or `Steps per impact`
    word = slug(re.split(r"[/:.]\s*", query)[-1].replace("_", " "))
    if word not in sections:
        return []
    page = CHECKS_PAGE.removeprefix("docs/")
    text = _wrapped(f"  {sections[word][1]}", 2)
    return [f"{query}: check of results", *text, f"  see      {page}#{word}"]


def _information(query: str) -> list[str]:
    """The quantity of a check without limits, which cannot fail, by its id."""
    # Imported here: all stages declare their criteria.
    import impactfem.run.stages  # noqa: F401
    from impactfem.stages.check import CRITERIA

    criterion = CRITERIA.get(query.rpartition("/")[2])
    if criterion is None:
        return []
    return [f"{query}: for information, without limits", f"  {criterion.quantity}"]


def _keys(query: str) -> list[str]:
    """The entries of a key, of the case file before the fit file."""
    parts = tuple(re.findall(r'"[^"]*"|[^.\[\]"\s]+', re.sub(r"\[\d+\]", "", query)))
    lines: list[str] = []
    for kind, entries in _entries().items():
        costs = {k: cost for k, one in enumerate(entries) if (cost := _cost(one.path, parts)) >= 0}
        best = [entries[k] for k in costs if costs[k] == min(costs.values())]
        # A last part that is nearly one of the keys of the table is no name of the case.
        best = [one for one in best if parts[-1] in one.path or not _typo(parts[-1], one.inner)]
        if not best and len(parts) == 1:  # the last part of a path alone
            best = [one for one in entries if one.path[-1] == parts[0]]
        alike: dict[tuple[str, str, str, str], list[Entry]] = {}
        for one in best:
            alike.setdefault((one.name, one.value, one.default, one.text), []).append(one)
        names = dict.fromkeys(one.name for one in best)
        if len(alike) > MOST_ENTRIES and len(names) > 1:
            lines.append(f"{query}: several keys of the {kind} have this name")
            lines += [f"  {one}" for one in names]
            continue
        before = None
        for (name, *_), several in alike.items():
            if name != before:
                lines.append(f"{name}: key of the {kind}")
            before = name
            lines += several[0].lines()
            others = [one.table for one in several[1:] if one.table != several[0].table]
            lines += _wrapped(f"  same in  {', '.join(others)}", 11) if others else []
    return lines


def _typo(part: str, keys: tuple[str, ...]) -> bool:
    """Whether a part of a name is nearly one of these keys."""
    return bool(get_close_matches(part, keys, n=1, cutoff=0.8))


def _cost(path: tuple[str, ...], parts: tuple[str, ...]) -> int:
    """Number of parts of a name that are names of the case in a path; -1 where they differ."""
    if not parts:
        return 0 if all(part in ("", ANY) for part in path) else -1
    if not path:
        return -1
    costs = [_cost(path[1:], parts[1:])] if path[0] == parts[0] else []
    if path[0] in ("", ANY):
        costs.append(_cost(path[1:], parts))
        taken = _cost(path[1:], parts[1:])
        costs.append(taken + 1 if taken >= 0 else -1)
    return min((cost for cost in costs if cost >= 0), default=-1)


@cache
def _entries() -> dict[str, list[Entry]]:
    """All keys, by the kind of their file."""
    from impactfem.case.report import Reference
    from impactfem.fit.fit_file import FitFile

    case = list(_Walk(json_schema(), "case-file.md").entries())
    for title, about, model in TABLE_MODELS:
        match = re.match(r"`(\w+)`(?: of `\[+([\w.]+)\]+`)?", about)
        place = [] if match is None else [*(match[2] or "").split("."), match[1]]
        for name, info in model.model_fields.items():
            words, unit, default = column(info)
            text = " ".join((info.description or "").split())
            case.append(
                Entry(
                    (*(part for key in place if key for part in (key, "")), name),
                    f"{title} (CSV)",
                    _with_unit(words, unit),
                    _default(default),
                    _bare(text),
                    f"case-file.md#{slug(title)}.{name}",
                )
            )
    return {
        "case file": case,
        "fit file": list(_Walk(json_schema(FitFile, "Fit file of impactfem"), "fit.md").entries()),
        "reference file": list(
            _Walk(json_schema(Reference, "Reference"), "case-file.md", "reference").entries()
        ),
    }


class _Walk:
    """Walks a schema from its root to all keys; a definition has the anchors of its first place."""

    def __init__(self, schema: dict[str, Any], page: str, place: str = "") -> None:
        self._schema, self._page, self._place = schema, page, place
        self._headings: dict[str, str] = {}  # first heading of each definition

    def entries(self) -> Iterator[Entry]:
        """All keys, outer ones first."""
        yield from self._table("", (), self._schema, self._place, ())

    def _table(
        self,
        heading: str,
        path: tuple[str, ...],
        table: dict[str, Any],
        anchor: str,
        within: tuple[str, ...],
    ) -> Iterator[Entry]:
        required, inner = table.get("required", []), []
        for key, entry in table["properties"].items():
            names = references(entry)
            own = (*path, key)
            keys = dict.fromkeys(
                k for name in names for k in self._schema["$defs"][name]["properties"]
            )
            mark: tuple[str, ...] = ()
            if "additionalProperties" in entry:
                mark = (ANY,)
            elif "items" in entry and "name" in keys:  # `[devices.pump]` of a variant
                mark = ("",)
            shown = ".".join(part for part in own if part)
            for name in names:
                head = f"[[{shown}]]" if "items" in entry else f"[{shown}]"
                head = f"[{shown}.{ANY}]" if "additionalProperties" in entry else head
                tag = self._schema["$defs"][name]["properties"].get("type", {}).get("const")
                head += f' type = "{tag}"' if tag else ""
                self._headings.setdefault(name, head)
                inner.append((head, (*own, *mark), name))
            words = " or ".join(head for head, _, name in inner if name in names) if names else ""
            others = [one for one in entry.get("oneOf", []) if "$ref" not in one]
            value = [f"table {words}"] if words else []
            if not names or others:
                value += [_with_unit(*accepted(one)) for one in others or [entry]]
            place = f"#{anchor}.{key}" if anchor else f"#{key}"
            yield Entry(
                (*own, *mark) if names else own,
                heading,
                _bare(" or ".join(value)),
                "none (required)"
                if key in required
                else _bare(default_of(entry)).removeprefix("default "),
                _bare(entry["description"]),
                self._page + (place if self._page == "case-file.md" else ""),
                tuple(keys),
            )
        for head, own, name in inner:
            if name not in within:
                first = re.sub(r'[\[\]"]', "", self._headings[name]).replace(" type = ", ".")
                inside = (*within, name)
                definition = self._schema["$defs"][name]
                yield from self._table(head, own, definition, first, inside)


def _result(query: str, summary: dict[str, dict[str, Any]]) -> list[str]:
    """The entry of a result: what it is, its unit, and its value in a run."""
    entry = summary.get(query)
    text = None
    # Results of a further building with a 3D model have its name behind the first word.
    alike = query.replace(".no_impact", ".impact")
    for name in dict.fromkeys((query, alike, re.sub(r"^(\w+)\.[\w-]+\.", r"\1.", alike))):
        text = text or next((about for one, about in _results() if one.fullmatch(name)), None)
    if entry is None and text is None:
        return []
    unit = unit_of(query) if entry is None else entry["unit"]
    lines = [f"{query}: result of summary.json"]
    lines.append(f"  unit     {'none (a ratio or a number)' if unit == '-' else unit}")
    if entry is not None:
        value = "none in this run" if entry["value"] is None else f"{entry['value']:.6g}"
        lines.append(f"  value    {value}")
        if entry.get("paper") is not None:
            lines.append(f"  published {entry['paper']:.6g}")
        lines += _wrapped(f"  note     {entry['note']}", 11) if entry["note"] else []
    lines += _wrapped(f"  {text}", 2) if text else []
    return [*lines, f"  see      {RESULTS_PAGE.removeprefix('docs/')}#summaryjson"]


def unit_of(name: str) -> str:
    """Return the SI unit of a result by its name; "-" of a ratio or a number."""
    component = re.search(r"\.([fm])[xyz]\.", f"{name}.")
    if component and ".relative_difference" not in name:
        return "N" if component[1] == "f" else "N m"
    return next((unit for pattern, unit in UNITS if re.search(pattern, name)), "-")


@cache
def _results() -> list[tuple[re.Pattern[str], str]]:
    """Patterns of the names of results, and what they are; whole names before their variants."""
    page = in_source_tree(RESULTS_PAGE).read_text(encoding="utf-8")
    part = re.search(r"(?ms)^## [^\n]*summary\.json.*?(?=^## |\Z)", page)
    whole, variants = [], []
    for line in part[0].splitlines() if part else ():
        cells = re.split(r"(?<!\\)\|", line.strip().strip("|"))
        names = re.findall(r"`([\w.<>*]+)`", cells[0])
        if len(cells) < 2 or not names or names[0].startswith("."):
            continue
        text, base = _plain(cells[-1]), names[0]
        # The description may name further results.
        words = {name.split(".")[0] for name in names}
        names += [
            name
            for name in re.findall(r"`(\.?[A-Za-z]\w*(?:\.[\w<>*]+)*)`", cells[-1])
            if name.split(".")[0] in words | {""}
        ]
        for name in names:
            if not name.startswith("."):
                base = name
                whole.append((_pattern(name), text))
                continue
            # ".mass" stands for the base with its last parts replaced.
            parts = base.split(".")
            tail = f"{name}{parts[-1]}" if name.endswith(".") else name
            for end in range(len(parts) - 1, 0, -1):
                variants.append((_pattern(".".join(parts[:end]) + tail), text))
    return whole + variants


def _pattern(name: str) -> re.Pattern[str]:
    """The pattern of a name with placeholders: N, K, X, NAME, CASE, <building>, *."""
    parts = []
    for part in name.split("."):
        text = re.sub(r"<\w+>|NAME|CASE", r"[\\w-]+", part)
        text = re.sub(r"^[NK]$|(?<=_)K(?=_|$)", r"\\d+", text)
        text = re.sub(r"^([fm])[XYZ]$", r"\1[xyz]", text)
        text = re.sub(r"^X$", r".+", re.sub(r"^x$", r"[xyz]", text))
        parts.append(text.replace("*", ".*"))
    return re.compile(r"\.".join(parts) + r"(\.[\w-]+)?")


def _summary(run: Path) -> dict[str, dict[str, Any]]:
    """The results of a run by name."""
    path = run / "summary.json"
    try:
        return {one["name"]: one for one in json.loads(path.read_text(encoding="utf-8"))}
    except (OSError, ValueError, TypeError, KeyError) as error:
        expected = "expected the folder of a run, with the file summary.json"
        raise InputError([Fault("command line", "--run", str(run), expected)]) from error


def _nearest(query: str, summary: dict[str, dict[str, Any]]) -> str:
    """Words that name the nearest known names."""
    keys = [one.name for entries in _entries().values() for one in entries]
    known = dict.fromkeys([*checks(), *summary, *keys])
    bare = re.sub(r"\[\d+\]", "", query)
    near = get_close_matches(bare, known, n=3, cutoff=0.6)
    near = near or get_close_matches(slug(bare.replace("_", " ")), known, n=3, cutoff=0.6)
    return f"unknown name; did you mean {' or '.join(map(repr, near))}?" if near else ""


def _plain(text: str) -> str:
    """Text of a page without the marks of Markdown, on one line."""
    return _bare(re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", " ".join(text.split())))


def _default(words: str) -> str:
    """A default in the words of the reference page, as a value."""
    return _bare(words).removeprefix("default ").replace("required", "none (required)")


def _bare(text: str) -> str:
    return text.replace("`", "").replace("**", "")


def _with_unit(words: str, unit: str) -> str:
    return _bare(words) + (f" [{unit}]" if unit not in ("", "-") else "")


def _wrapped(text: str, indent: int) -> list[str]:
    return textwrap.wrap(
        text, WIDTH, subsequent_indent=" " * indent, break_long_words=False, break_on_hyphens=False
    )
