"""The page of the verification manual, made from the rows of one run, or of several.

``impactfem verify --json FILE`` and then ``python docs/_ext/verification.py FILE`` write
``docs/verification.md``; further files are those of heavy benchmarks, run by themselves. A file of
``impactfem verify --validation`` makes ``docs/validation.md``, from its template here.
"""

from __future__ import annotations

import inspect
import json
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from impactfem.system.errors import Fault, ImpactfemError, InputError
from impactfem.verify import validation
from impactfem.verify.manual import BENCHMARKS, FULL, GROUPS
from impactfem.verify.row import Row

Entry = Mapping[str, Any]

PAGE = Path(__file__).parents[1] / "verification.md"
VALIDATION = PAGE.with_name("validation.md")
KEYS = {"benchmark", "error", "passed", *(field.name for field in fields(Row))}
_INTRODUCTION = """\
<!-- Written by `python docs/_ext/verification.py FILE`; edit the benchmarks, not this page. -->

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
    python docs/_ext/verification.py verify.json

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
    title_of = {module.__name__: title for title, group in GROUPS.items() for module in group}
    passed = sum(bool(entry["passed"]) for entry in entries)
    count = sum(map(bool, by_name.values()))
    overview = [
        f"{len(entries)} rows of {count} benchmarks, {passed} within what is allowed.\n\n",
        "| Group | Benchmarks | Rows | Passed |\n|---|---|---|---|\n",
    ]
    sections = []
    for title in GROUPS:
        names = [name for name, run in known.items() if title_of[run.__module__] == title]
        if names:
            links = ", ".join(f"[{name}](#{name})" for name in names)
            within = [entry for name in names for entry in by_name[name]]
            good = sum(bool(entry["passed"]) for entry in within)
            overview.append(f"| {title} | {links} | {len(within)} | {good} |\n")
            sections.append(f"## {title}\n\n")
            sections.extend(section(name, by_name[name]) for name in names)
    return "".join([_INTRODUCTION, *overview, "\n", *sections]).rstrip() + "\n"


def validation_page(entries: Sequence[Entry]) -> str:
    """The page of the cases compared with other programs, in Markdown; their rows as of `page`."""
    sections = [
        shortened(name, [entry for entry in entries if entry["benchmark"] == name])
        for name in dict.fromkeys(entry["benchmark"] for entry in entries)
    ]
    passed = sum(bool(entry["passed"]) for entry in entries)
    count = f"{len(entries)} rows of {len(sections)} cases, {passed} within what is allowed."
    template = Path(__file__).with_name("validation.md.in").read_text(encoding="utf-8")
    text = template.replace("{{ count }}", count).replace("{{ cases }}", "".join(sections))
    return text.rstrip() + "\n"


def shortened(name: str, entries: Sequence[Entry], rows: int = 8) -> str:
    """Return the section of a case with the rows of largest error relative to their tolerance.

    Args:
        name: Name of the case.
        entries: All its rows, as of `page`.
        rows: Largest number of rows that are shown; failed rows are always shown.
    """

    def share(entry: Entry) -> float:
        if not entry["passed"] or entry["error"] is None:
            return float("inf")
        return float(abs(entry["error"]) / max(entry["tolerance"], 1e-300))

    limit = sorted(map(share, entries), reverse=True)[:rows][-1]
    shown = [entry for entry in entries if share(entry) >= limit]
    text = section(name, shown)
    if rest := len(entries) - len(shown):
        text += f"{rest} further rows have smaller errors relative to their tolerance.\n\n"
    return text


def section(name: str, entries: Sequence[Entry]) -> str:
    """What the page says of one benchmark, with its rows."""
    run = BENCHMARKS.get(name) or FULL.get(name) or validation.cases()[name]
    heading = f"### `{name}`\n\n{_as_markdown(inspect.getdoc(run) or '')}\n\n"
    if not entries:
        return heading + "Runs with `--full` only.\n\n"
    cases, sources = (list(dict.fromkeys(e[key] for e in entries)) for key in ("name", "source"))
    head = ["Quantity", "Reference", "Computed", "Unit", "Error", "Allowed"]
    lines = [head, ["---"] * 6, *map(_cells, entries)]
    # What is the same in all rows is said once, sources below the table.
    if len(cases) > 1:
        names = [entry["name"] for entry in entries]
        again = [k > 0 and names[k - 1] == name for k, name in enumerate(names)]
        first = [
            "Case",
            "---",
            *("" if a else _plain(n) for a, n in zip(again, names, strict=True)),
        ]
        lines = [[cell, *line] for cell, line in zip(first, lines, strict=True)]
    if len(sources) > 1:
        last = ["Source", "---", *(str(sources.index(entry["source"]) + 1) for entry in entries)]
        lines = [[*line, cell] for cell, line in zip(last, lines, strict=True)]
    table = "".join(f"| {' | '.join(line)} |\n" for line in lines)
    numbered = [f"({k}) {_plain(source)}" for k, source in enumerate(sources, 1)]
    below = (
        f"Sources: {'; '.join(numbered)}" if len(sources) > 1 else f"Source: {_plain(sources[0])}"
    )
    return f"{heading}{table}\n{below}.\n\n"


def read_entries(path: Path) -> list[Entry]:
    """Read the rows that `impactfem verify --json` wrote.

    Raises:
        InputError: The file cannot be read, or holds something else.
    """
    expected = "expected the file that `impactfem verify --json FILE` writes"
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError([Fault(path, "", None, f"{error.strerror}; {expected}")]) from None
    except ValueError as error:
        raise InputError([Fault(path, "", None, f"no JSON ({error}); {expected}")]) from None
    if not isinstance(found, list) or not all(
        isinstance(entry, dict) and entry.keys() >= KEYS for entry in found
    ):
        raise InputError([Fault(path, "", None, expected)])
    return found


def _cells(entry: Entry) -> list[str]:
    kind = " short" if entry["at_least"] else " abs" if entry["absolute"] else ""
    computed = "no number" if entry["computed"] is None else f"{entry['computed']:.6g}"
    error = "no number" if entry["error"] is None else f"{entry['error']:.1e}{kind}"
    if not entry["passed"]:
        error = f"**{error}, fails**"
    reference, allowed = f"{entry['reference']:.6g}", f"{entry['tolerance']:.2g}{kind}"
    return [_plain(entry["quantity"]), reference, computed, _plain(entry["unit"]), error, allowed]


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


def main(files: Iterable[str]) -> int:
    """Write the page from the files of the rows."""
    paths = [Path(file) for file in files]
    if not paths:
        sys.stderr.write("usage: python docs/_ext/verification.py FILE...\n")
        return 2
    try:
        entries = [entry for path in paths for entry in read_entries(path)]
        beside = {entry["benchmark"] for entry in entries} == set(validation.cases())
        file, text = (VALIDATION, validation_page(entries)) if beside else (PAGE, page(entries))
    except ImpactfemError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2 if isinstance(error, InputError) else 1
    file.write_text(text, encoding="utf-8")
    sys.stdout.write(f"{file}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
