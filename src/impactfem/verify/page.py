"""The page of the verification manual, made from the rows of one run, or of several.

``impactfem verify --json FILE`` and then ``python -m impactfem.verify.page FILE docs`` write
``docs/verification.md``; further files are those of heavy benchmarks, run by themselves.
"""

from __future__ import annotations

import inspect
import json
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from impactfem.system.errors import Fault, ImpactfemError, InputError
from impactfem.verify.manual import BENCHMARKS, FULL

__all__ = ["NAME", "page", "read_entries", "section", "write_page"]

Entry = Mapping[str, Any]

NAME = "verification.md"
KEYS = frozenset(
    (
        *("benchmark", "name", "quantity", "unit", "source"),
        *("reference", "computed", "error", "tolerance", "absolute", "at_least", "passed"),
    )
)
GROUPS: Mapping[str, Sequence[str]] = {
    "Contact between sticks": ("laws", "pairs"),
    "Sticks and their time integration": ("sticks",),
    "Ground motion": ("motion",),
    "Oscillators and spectra": ("spectra",),
    "Shells": ("patch", "plates", "curved"),
    "Beams": ("beams",),
    "Waves and the 3D building in time": (
        "slab",
        "in_time",
        "floor_bar",
        "forced",
        "frame",
        "paper",
    ),
    "Unilateral contact": ("unilateral",),
    "Devices and response spectrum analysis": ("device", "device_spectra", "device_supports"),
}
"""Modules of the benchmarks by group; those of a module that is not listed come last."""
OTHERS = "Further benchmarks"
_INTRODUCTION = """\
<!-- Written by `python -m impactfem.verify.page FILE docs`; edit the benchmarks, not this page. -->

# Verification manual

Each benchmark compares what the program computes with a reference that the program did not make: a
closed form, a published benchmark, a standard, or the same value by another way. `impactfem verify`
computes all of them again on your machine and ends with exit code 1 if one fails; `--only NAME`
takes those with this in their name. The tests run them, too.

**Error** and **allowed** are relative to the reference, or, with "abs", the plain difference in the
unit of the row, where the reference is zero or a bound, or, with "short", what is missing to a
lower bound. A tolerance is set by what the comparison
deserves: rounding where both sides are exact, the digits that are printed where the reference is
published, and the error of the mesh or the step, known by its order, where it is not. The numbers
are those of one run; their last digits differ from machine to machine.

This page is made by

    impactfem verify --full --json verify.json
    python -m impactfem.verify.page verify.json docs

or, as the heavy benchmarks take their time, from one file of all others and one of each of these,
`impactfem verify --full --only NAME --json NAME.json`.

"""


def page(entries: Sequence[Entry]) -> str:
    """The page in Markdown.

    Args:
        entries: Rows as `impactfem verify --json` writes them, of all benchmarks; those of the
            heavy ones may be missing.

    Raises:
        ImpactfemError: A benchmark has no rows, or rows belong to none.
    """
    known = {**BENCHMARKS, **FULL}
    by_name: dict[str, list[Entry]] = {name: [] for name in known}
    strange = sorted({entry["benchmark"] for entry in entries} - set(known))
    if strange:
        raise ImpactfemError(f"rows of benchmarks that do not exist: {', '.join(strange)}")
    for entry in entries:
        by_name[entry["benchmark"]].append(entry)
    missing = [name for name in BENCHMARKS if not by_name[name]]
    if missing:
        raise ImpactfemError(f"no rows of the benchmarks {', '.join(missing)}: run all of them")
    groups = _groups(known)
    parts = [_INTRODUCTION, _overview(groups, by_name)]
    for title, names in groups.items():
        parts.append(f"## {title}\n\n")
        parts.extend(section(name, by_name[name]) for name in names)
    return "".join(parts).rstrip() + "\n"


def section(name: str, entries: Sequence[Entry]) -> str:
    """What the page says of one benchmark.

    Args:
        name: The benchmark.
        entries: Its rows.
    """
    run = BENCHMARKS.get(name) or FULL[name]
    about = _as_markdown(inspect.getdoc(run) or "")
    heading = f"### `{name}`\n\n{about}\n\n"
    if not entries:
        return heading + "Runs with `--full` only.\n\n"
    cases = _distinct(entry["name"] for entry in entries)
    sources = _distinct(entry["source"] for entry in entries)
    head = ["Quantity", "Reference", "Computed", "Unit", "Error", "Allowed"]
    if len(cases) > 1:
        head.insert(0, "Case")
    if len(sources) > 1:
        head.append("Source")
    lines = [head, ["---"] * len(head)]
    for entry in entries:
        cells = _cells(entry)
        if len(cases) > 1:
            cells.insert(0, _plain(entry["name"]))
        if len(sources) > 1:
            cells.append(_plain(entry["source"]))
        lines.append(cells)
    table = "".join(f"| {' | '.join(line)} |\n" for line in lines)
    source = f"\nSource: {_plain(sources[0])}.\n" if len(sources) == 1 else ""
    return f"{heading}{table}{source}\n"


def read_entries(path: Path) -> list[Entry]:
    """Read the rows that `impactfem verify --json` wrote.

    Args:
        path: The file.

    Raises:
        InputError: It cannot be read, or holds something else.
    """
    expected = "the file that `impactfem verify --json FILE` writes"
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(
            [Fault(path, "", None, f"{error.strerror}; expected {expected}")]
        ) from None
    except ValueError as error:
        raise InputError(
            [Fault(path, "", None, f"no JSON ({error}); expected {expected}")]
        ) from None
    if not isinstance(found, list) or not all(
        isinstance(entry, dict) and entry.keys() >= KEYS for entry in found
    ):
        raise InputError([Fault(path, "", None, f"expected {expected}")])
    return found


def write_page(entries: Sequence[Entry], folder: Path) -> Path:
    """Write the page into a folder; gives the file.

    Args:
        entries: As of `page`.
        folder: The folder.

    Raises:
        ImpactfemError: As of `page`.
    """
    path = folder / NAME
    path.write_text(page(entries), encoding="utf-8")
    return path


def _groups(known: Mapping[str, Any]) -> dict[str, list[str]]:
    """Benchmarks by the title of their group; groups without any are left out."""
    of_module = {module: title for title, modules in GROUPS.items() for module in modules}
    groups: dict[str, list[str]] = {title: [] for title in (*GROUPS, OTHERS)}
    for name, run in known.items():
        module = run.__module__.rsplit(".", 1)[-1]
        groups[of_module.get(module, OTHERS)].append(name)
    return {title: names for title, names in groups.items() if names}


def _overview(groups: Mapping[str, list[str]], by_name: Mapping[str, list[Entry]]) -> str:
    rows = [entry for entries in by_name.values() for entry in entries]
    passed = sum(bool(entry["passed"]) for entry in rows)
    head = "| Group | Benchmarks | Rows | Passed |\n|---|---|---|---|\n"
    lines = []
    for title, names in groups.items():
        links = ", ".join(f"[{name}](#{name})" for name in names)
        within = [entry for name in names for entry in by_name[name]]
        good = sum(bool(entry["passed"]) for entry in within)
        lines.append(f"| {title} | {links} | {len(within)} | {good} |\n")
    count = len([name for name in by_name if by_name[name]])
    total = f"{len(rows)} rows of {count} benchmarks, {passed} within what is allowed.\n\n"
    return f"{total}{head}{''.join(lines)}\n"


def _cells(entry: Entry) -> list[str]:
    kind = " short" if entry["at_least"] else " abs" if entry["absolute"] else ""
    computed = "no number" if entry["computed"] is None else f"{entry['computed']:.6g}"
    error = "no number" if entry["error"] is None else f"{entry['error']:.1e}{kind}"
    if not entry["passed"]:
        error = f"**{error}, fails**"
    return [
        _plain(entry["quantity"]),
        f"{entry['reference']:.6g}",
        computed,
        _plain(entry["unit"]),
        error,
        f"{entry['tolerance']:.2g}{kind}",
    ]


def _as_markdown(docstring: str) -> str:
    """A docstring, its indented equations left as they are."""
    paragraphs = docstring.split("\n\n")
    shown = [p if p.startswith("    ") else _plain(p, names=True) for p in paragraphs]
    return "\n\n".join(shown)


def _plain(text: str, *, names: bool = False) -> str:
    """Text in which no sign is markup, but for `names` between backticks where they are meant."""
    signs = r"([\\*_|<$\[\]#~])" if names else r"([\\*_|<$\[\]#~`])"
    parts = re.split(r"(`[^`]*`)", text) if names else [text]
    for i in range(0, len(parts), 2):
        parts[i] = re.sub(signs, r"\\\1", parts[i])
    return re.sub(r"(?m)^([-+]) ", r"\\\1 ", "".join(parts))


def _distinct(values: Iterator[str]) -> list[str]:
    return list(dict.fromkeys(values))


def main(arguments: list[str]) -> int:
    """Write the page: the files of the rows and the folder are the arguments."""
    *files, folder = map(Path, arguments or [""])
    if not files or not folder.is_dir():
        sys.stderr.write("usage: python -m impactfem.verify.page FILE... FOLDER\n")
        return 2
    try:
        path = write_page([entry for file in files for entry in read_entries(file)], folder)
    except ImpactfemError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2 if isinstance(error, InputError) else 1
    sys.stdout.write(f"{path}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
