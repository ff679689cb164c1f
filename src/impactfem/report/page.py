"""The page itself: what a run's files say, put into the template."""

from __future__ import annotations

import base64
import csv
import html
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from impactfem.plot.words import as_html, read_words
from impactfem.report.beside import (
    ABSENT,
    DIFFERS,
    GIVEN,
    REPRODUCED,
    SHOWN,
    UNPUBLISHED,
    compared_values,
    count,
    farthest,
    places,
)
from impactfem.report.overview import facts, number, quantity, tiles, wall_is_used
from impactfem.report.run_files import COMPARISON, RunFiles
from impactfem.stages.stage import Stage
from impactfem.system.errors import Fault, ImpactfemError, InputError
from impactfem.system.files import atomic
from impactfem.system.log import LOGGER

ROWS = 400
"""Rows of a table that a page shows; the rest is in the file."""
TYPES = {".svg": "image/svg+xml", ".png": "image/png", ".mp4": "video/mp4"}
REPORT = "report.html"
COMPARED = (
    "Comparison with another run",
    "Floor spectra of both runs, which the first table names, at the points that move.",
)
STATUSES = (REPRODUCED, DIFFERS, GIVEN, UNPUBLISHED, SHOWN, ABSENT)
KINDS = ("equation", "figure", "table")
FARTHEST = 8
"""Number of results that differ on the first page."""
GOVERNING = ("svg_figure_13_centre_spectrum", "svg_figure_10_floor_spectra")
KEY_WORDS = ("energy", "steps", "points in a cycle", "band", "Sturm", "mass matrix")
"""Words of the checks that the first page shows."""
TEMPLATES = files("impactfem.report") / "templates"


def write_report(folder: Path, stages: Sequence[Stage]) -> Path:
    """Make `report.html`, which needs no other file and no network, from the files of a run.

    Raises:
        InputError: A stage of the run is none of those given: the run is of another version.
        ImpactfemError: The folder holds no run, or a file cannot be read or written.
    """
    run = RunFiles(folder)
    known = {stage.name: stage for stage in stages}
    unknown = [name for name in run.stages if name.rpartition("/")[2] not in known]
    if unknown:
        expected = (
            f"the run has stages that this version does not know: {', '.join(unknown)}; expected a "
            "run of this version: 'impactfem run' makes it again"
        )
        raise InputError([Fault(run.folder, "", None, expected)])
    text = _render(run, known)
    with atomic(folder / REPORT) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return folder / REPORT


def _render(run: RunFiles, known: Mapping[str, Stage]) -> str:
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    environment.filters |= {
        "number": number,
        "quantity": quantity,
        "address": lambda path: (
            f"data:{TYPES[path.suffix]};base64,{base64.b64encode(_read(path)).decode()}"
        ),
        "anchor": lambda path: _anchor(run, path),
        "inside": lambda path: str(path.relative_to(run.folder)),
        "title_of": lambda path: Path(path).stem.replace("_", " "),
    }
    stages = [_stage(run, name, known[name.rpartition("/")[2]]) for name in run.stages]
    if run.compared:
        stages.append(_stage(run, COMPARISON, None))
    figures = {one["anchor"]: one for stage in stages for one in stage["figures"]}
    written = [name for stage in stages for name in stage["files"]]
    reference = run.case["report"]["reference"]
    compared = [] if reference is None else places(reference, run.summary, written)
    tally = [(f"{kind}s", count(compared, kind)) for kind in KINDS]
    tally.append(("values", Counter(one.status for one in compared_values(compared))))
    for what, counts in tally if compared else []:
        found = ", ".join(f"{counts[status]} {status}" for status in STATUSES if counts[status])
        if found:
            LOGGER.debug("report: compared with the publication, %s: %s", what, found)
    seconds = run.provenance["seconds"]
    checks = {good: [c for c in run.checks if c["good"] is good] for good in (True, False, None)}
    return environment.from_string((TEMPLATES / "report.html").read_text("utf-8")).render(
        version=run.provenance["impactfem"],
        title=run.case["title"],
        css=Markup((TEMPLATES / "report.css").read_text("utf-8")),
        provenance=run.provenance,
        tiles=tiles(run),
        drawing=figures.get("svg_figure_02_case"),
        facts=facts(run),
        governing=next((figures[name] for name in GOVERNING if name in figures), None),
        met=len(checks[True]),
        unlimited=len(checks[None]),
        failed=checks[False],
        key_checks=[c for c in checks[True] if any(word in c["text"] for word in KEY_WORDS)],
        assumptions=assumptions(run.case),
        stages=stages,
        times={
            stage: sum(t for name, t in seconds.items() if name.startswith(f"{stage}: "))
            for stage in run.stages
        },
        publication={"title": "", "given": []} | (reference or {}),
        places=compared,
        kinds=[kind for kind in KINDS if any(place.item["kind"] == kind for place in compared)],
        statuses=STATUSES,
        given_status=GIVEN,
        tally=tally,
        differing=farthest(compared)[:FARTHEST],
        summary=run.summary,
    )


def _stage(run: RunFiles, name: str, stage: Stage | None) -> dict[str, Any]:
    """What the page shows of a stage; without one, of the comparison with another run."""
    title, about = COMPARED if stage is None else (stage.title, stage.about)
    figures, tables = run.files_of(name, "figures"), run.files_of(name, "tables")
    kinds = {kind: [path for path in figures if path.suffix == kind] for kind in (".html", *TYPES)}
    return {
        "name": name,
        "title": run.named(title, name),
        "about": about,
        "checks": [check for check in run.checks if check["stage"] == name],
        # A page as the text of an attribute, for a frame within this one.
        "scenes": [html.escape(_read(path).decode(), quote=True) for path in kinds[".html"][:1]],
        "figures": [_figure(run, one) for one in figures if one.suffix in (".svg", ".png")],
        "films": kinds[".mp4"],
        "tables": [_table(path) for path in tables],
        "files": [str(path.relative_to(run.folder)) for path in (*figures, *tables)],
    }


def _figure(run: RunFiles, path: Path) -> dict[str, Any]:
    """A figure as the page shows it; an SVG is a part of the page, so that its text is found."""
    words = read_words(path)
    return {
        "anchor": _anchor(run, path),
        "path": path,
        "svg": Markup(_read(path).decode()) if path.suffix == ".svg" else None,
        "caption": Markup(as_html(words.caption)),
        "seen": words.seen,
    }


def _anchor(run: RunFiles, path: Path | str) -> str:
    """Where the page shows a file: figures of several buildings have the same names."""
    inside = Path(path)
    if inside.is_relative_to(run.folder):
        inside = inside.relative_to(run.folder)
    return "_".join([inside.suffix[1:], *inside.parts[:-2], inside.stem])


def _table(path: Path) -> dict[str, Any]:
    """A CSV table: its header, the rows that are shown, and how many there are."""

    def cell(text: str) -> str:
        """Numbers have five digits."""
        try:
            return text if len(text) <= 6 else f"{float(text):.5g}"
        except ValueError:
            return text

    head, *rows = list(csv.reader(_read(path).decode().splitlines())) or [[]]
    shown = [[cell(text) for text in row] for row in rows[:ROWS]]
    return {"path": path, "head": head, "rows": shown, "count": len(rows)}


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise ImpactfemError(f"cannot read {path}: {error.strerror or error}") from error


def assumptions(case: Mapping[str, Any]) -> list[tuple[str, Sequence[Mapping[str, str]]]]:
    """What was assumed by a case (`text`) and why (`reason`), in groups with a title."""
    method = tomllib.loads((TEMPLATES / "assumptions.toml").read_text("utf-8"))
    wall = "wall_used" if wall_is_used(case) else "wall_unused"
    sections = {"structure": "structure", "wall_impact": wall}
    sections |= {name: name for name in ("transient", "devices")}
    own, reference = case["report"]["assumptions"], case["report"]["reference"] or {}
    groups = (
        (
            "The method",
            sum((method[key] for name, key in sections.items() if case[name]), method["always"]),
        ),
        ("This case", own),
        (
            "What the publication leaves out, and what is taken in its place",
            reference.get("assumptions", ()),
        ),
    )
    return [(title, entries) for title, entries in groups if entries]
