"""The page of the verification manual and its rows, made from one run, or from several.

``impactfem verify --json FILE`` and then ``python docs/_ext/verification.py FILE`` write
``docs/verification.md``, all rows into ``docs/verification.csv``, and the rows of the benchmarks
with a page of their own into ``docs/benchmarks/NAME.csv``. Further files are those of heavy
benchmarks, run by themselves. A file of ``impactfem verify --validation`` makes
``docs/validation.md``, from its template here.
"""

from __future__ import annotations

import csv
import inspect
import io
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
COLUMNS = (
    "benchmark",
    "case",
    "quantity",
    "unit",
    "reference",
    "computed",
    "deviation",
    "tolerance",
    "passed",
    "source",
)
_INTRODUCTION = """\
<!-- Written by `python docs/_ext/verification.py FILE`; edit the benchmarks, not this page. -->

# Verification manual

Each benchmark compares computed values with an independent reference: a closed form, a published
benchmark, a standard, or the same value by another method. `impactfem verify` repeats all
benchmarks on your machine and returns exit code 1 if one fails. `--only NAME` selects benchmarks.

The tables give, for each benchmark, the number of rows and the largest deviation divided by its
tolerance: values up to 1 pass. [verification.csv](verification.csv) lists every row with quantity,
reference, computed value, deviation, tolerance and source. Eleven benchmarks have
[pages with drawings](benchmarks/index.md).

A deviation is relative to the reference. "abs" marks the difference in the unit of the row, used
if the reference is zero or a bound. "short" marks the shortfall below a lower bound. Tolerances
are set by the expected error: rounding for exact methods, the printed digits for published
values, the known order of the error for a mesh or a time step. The docstring of each benchmark
in `src/impactfem/verify` derives its reference and its tolerance. The last digits differ between
machines.

To regenerate this page:

    impactfem verify --full --json verify.json
    python docs/_ext/verification.py verify.json

The heavy benchmarks can run separately, `impactfem verify --full --only NAME --json NAME.json`;
the second command accepts several files.

"""


def page(entries: Sequence[Entry]) -> str:
    """Return the page in Markdown.

    Args:
        entries: Rows as `impactfem verify --json` writes them, of all benchmarks; those of the
            heavy ones may be missing.

    Raises:
        ImpactfemError: A benchmark has no rows, or rows belong to none.
    """
    by_name = _by_name(entries)
    title_of = {module.__name__: title for title, group in GROUPS.items() for module in group}
    passed = sum(bool(entry["passed"]) for entry in entries)
    count = sum(map(bool, by_name.values()))
    overview = [
        f"{len(entries)} rows of {count} benchmarks, {passed} within tolerance.\n\n",
        "| Group | Benchmarks | Rows | Passed |\n|---|---|---|---|\n",
    ]
    sections = []
    for title in GROUPS:
        names = [name for name, run in _known().items() if title_of[run.__module__] == title]
        if not names:
            continue
        within = [entry for name in names for entry in by_name[name]]
        good = sum(bool(entry["passed"]) for entry in within)
        link = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
        overview.append(f"| [{title}](#{link}) | {len(names)} | {len(within)} | {good} |\n")
        sections.append(f"## {title}\n\n")
        sections.append(
            "| Benchmark | Rows | Deviation / tolerance | Source |\n|---|---|---|---|\n"
        )
        sections.extend(_summary(name, by_name[name]) for name in names)
        sections.append("\n")
        sections.extend(description(name) for name in names)
    return "".join([_INTRODUCTION, *overview, "\n", *sections]).rstrip() + "\n"


def table(entries: Sequence[Entry], columns: Sequence[str] = COLUMNS) -> str:
    """The rows as CSV.

    Args:
        entries: Rows of any number of benchmarks.
        columns: The columns, some of `COLUMNS`.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    cases: dict[str, set[str]] = {}
    for entry in entries:
        cases.setdefault(entry["benchmark"], set()).add(entry["name"])
    for entry in entries:
        quantity, reference, computed, unit, deviation, tolerance = _values(entry)
        row = {
            "benchmark": entry["benchmark"],
            # Of a benchmark with one case its name says what the benchmark's own name says.
            "case": entry["name"] if len(cases[entry["benchmark"]]) > 1 else "",
            "quantity": quantity,
            "unit": unit,
            "reference": reference,
            "computed": computed,
            "deviation": deviation,
            "tolerance": tolerance,
            "passed": "yes" if entry["passed"] else "no",
            "source": entry["source"],
        }
        writer.writerow([row[column] for column in columns])
    return text.getvalue()


def tables(entries: Sequence[Entry], folder: Path) -> dict[Path, str]:
    """The CSV files of the benchmarks that have a page in a folder."""
    texts = {}
    for name, rows in _by_name(entries).items():
        if rows and (folder / f"{name}.md").is_file():
            several = {key: len({row[key] for row in rows}) > 1 for key in ("name", "source")}
            columns = [
                column
                for column in COLUMNS[1:]
                if column != "passed"
                and (column != "case" or several["name"])
                and (column != "source" or several["source"])
            ]
            texts[folder / f"{name}.csv"] = table(rows, columns)
    return texts


def description(name: str) -> str:
    """Heading and first paragraph of the description of a benchmark."""
    text = (inspect.getdoc(_known()[name]) or "").partition("\n\n")[0]
    return f"### `{name}`\n\n{_as_markdown(text)}\n\n"


def _known() -> dict[str, Any]:
    return {**BENCHMARKS, **FULL}


def _by_name(entries: Sequence[Entry]) -> dict[str, list[Entry]]:
    """The rows of each benchmark; raises an error for a missing or an unknown benchmark."""
    by_name: dict[str, list[Entry]] = {name: [] for name in _known()}
    strange = sorted({entry["benchmark"] for entry in entries} - set(by_name))
    if strange:
        raise ImpactfemError(f"rows of benchmarks that do not exist: {', '.join(strange)}")
    for entry in entries:
        by_name[entry["benchmark"]].append(entry)
    missing = [name for name in BENCHMARKS if not by_name[name]]
    if missing:
        raise ImpactfemError(f"no rows of the benchmarks {', '.join(missing)}: run all of them")
    return by_name


def _summary(name: str, entries: Sequence[Entry]) -> str:
    """The line of a benchmark in the table of its group."""
    if not entries:
        return f"| [{name}](#{name}) | - | runs with `--full` only | - |\n"
    sources = "; ".join(dict.fromkeys(_plain(entry["source"]) for entry in entries))
    failed = sum(not entry["passed"] for entry in entries)
    share = max(map(_share, entries))
    largest = "0" if share == 0.0 else f"{share:.2g}" if share >= 0.01 else "< 0.01"
    if failed:
        largest = f"**{failed} rows fail**"
    return f"| [{name}](#{name}) | {len(entries)} | {largest} | {sources} |\n"


def _share(entry: Entry) -> float:
    """The deviation over the tolerance; zero for a row without a number or a tolerance."""
    if not entry["tolerance"] or entry["error"] is None:
        return 0.0
    return float(entry["error"]) / float(entry["tolerance"])


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
    """The section of a case compared with other programs, with its rows."""
    run = validation.cases()[name]
    heading = f"### `{name}`\n\n{_as_markdown(inspect.getdoc(run) or '')}\n\n"
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


def _values(entry: Entry) -> list[str]:
    """Quantity, reference, computed value, unit, deviation and tolerance as texts."""
    kind = " short" if entry["at_least"] else " abs" if entry["absolute"] else ""
    computed = "no number" if entry["computed"] is None else f"{entry['computed']:.6g}"
    error = "no number" if entry["error"] is None else f"{entry['error']:.1e}{kind}"
    reference, allowed = f"{entry['reference']:.6g}", f"{entry['tolerance']:.2g}{kind}"
    return [entry["quantity"], reference, computed, entry["unit"], error, allowed]


def _cells(entry: Entry) -> list[str]:
    quantity, reference, computed, unit, error, allowed = _values(entry)
    if not entry["passed"]:
        error = f"**{error}, fails**"
    return [_plain(quantity), reference, computed, _plain(unit), error, allowed]


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
        if {entry["benchmark"] for entry in entries} == set(validation.cases()):
            texts = {VALIDATION: validation_page(entries)}
        else:
            texts = {PAGE: page(entries), PAGE.with_suffix(".csv"): table(_in_order(entries))}
            texts |= tables(entries, PAGE.parent / "benchmarks")
    except ImpactfemError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2 if isinstance(error, InputError) else 1
    for file, text in texts.items():
        file.write_text(text, encoding="utf-8")
        sys.stdout.write(f"{file}\n")
    return 0


def _in_order(entries: Sequence[Entry]) -> list[Entry]:
    """The rows in the order of the benchmarks of the program."""
    return [entry for rows in _by_name(entries).values() for entry in rows]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
