"""The page itself: what a run's files say, put into the template."""

from __future__ import annotations

import base64
import csv
import html
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from impactfem.plot.curves import CurveFigure, plain
from impactfem.report.assumptions import assumptions
from impactfem.report.beside import (
    ABSENT,
    DIFFERS,
    GIVEN,
    REPRODUCED,
    SHOWN,
    UNPUBLISHED,
    Compared,
    Place,
    count,
    count_values,
    farthest,
    places,
)
from impactfem.report.overview import facts, number, quantity, tiles
from impactfem.report.run_files import COMPARISON, RunFiles
from impactfem.stages.stage import Stage
from impactfem.system.errors import Fault, ImpactfemError, InputError
from impactfem.system.files import atomic
from impactfem.system.log import LOGGER

ROWS = 400
"""Rows of a table that a page shows; the rest is in the file."""

TYPES = {".png": "image/png", ".mp4": "video/mp4"}


REPORT = "report.html"
COMPARED = (
    "Comparison with another run",
    "Floor spectra of both runs, which the first table names, at the points that move.",
)
STATUSES = (REPRODUCED, DIFFERS, GIVEN, UNPUBLISHED, SHOWN, ABSENT)
FARTHEST = 8
"""So many results that differ stand on the first page."""
GOVERNING = ("plot_figure_13_centre_spectrum", "plot_figure_10_floor_spectra")
KEY_WORDS = ("energy", "steps", "points in a cycle", "band", "Sturm", "mass matrix")
"""What the checks of the first page speak of."""


def data_address(path: Path) -> str:
    """A picture or film as an address that holds its content."""
    return f"data:{TYPES[path.suffix]};base64,{base64.b64encode(_read(path)).decode()}"


def frame_document(path: Path) -> str:
    """A page as the text of an attribute, for a frame within another page."""
    return html.escape(_read(path).decode("utf-8"), quote=True)


def csv_table(path: Path) -> tuple[list[str], list[list[str]], int]:
    """The header of a CSV table, the rows that are shown, and how many there are."""
    rows = list(csv.reader(_read(path).decode("utf-8").splitlines()))
    if not rows:
        return [], [], 0
    return rows[0], [[cell(text) for text in row] for row in rows[1 : ROWS + 1]], len(rows) - 1


def cell(text: str) -> str:
    """A cell of a table, numbers with five digits."""
    try:
        number = float(text)
    except ValueError:
        return text
    return text if len(text) <= 6 else f"{number:.5g}"


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise ImpactfemError(f"cannot read {path}: {error.strerror or error}") from error


def write_report(folder: Path, stages: Sequence[Stage]) -> Path:
    """Make `report.html` from the files of a run.

    Args:
        folder: The run's folder.
        stages: All stages, with their headings and curves.

    Returns:
        The page, which needs no other file and no network.

    Raises:
        InputError: A stage of the run is none of them: the run is of another version.
        ImpactfemError: The folder holds no run, or a file cannot be read or written.
    """
    path = folder / REPORT
    text = _render(RunFiles(folder), {stage.name: stage for stage in stages})
    with atomic(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def _render(run: RunFiles, known: Mapping[str, Stage]) -> str:
    templates = files("impactfem.report") / "templates"
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    template = environment.from_string((templates / "report.html").read_text(encoding="utf-8"))
    shown = [*run.stages, *([COMPARISON] if run.compared else [])]
    unknown = [name for name in run.stages if name not in known]
    if unknown:
        expected = (
            f"the run has stages that this version does not know: {', '.join(unknown)}; expected a "
            "run of this version: 'impactfem run' makes it again"
        )
        raise InputError([Fault(run.folder, "", None, expected)])
    stages = [_stage(run, name, known.get(name)) for name in shown]
    plots = {plot["name"]: plot for stage in stages for plot in stage["plots"]}
    checks = run.checks
    reference = run.case["report"]["reference"]
    compared = (
        []
        if reference is None
        else places(reference, run.summary, [name for stage in stages for name in stage["files"]])
    )
    tally = [(f"{kind}s", count(compared, kind)) for kind in ("equation", "figure", "table")]
    tally.append(("values", count_values(compared)))
    for what, counts in tally if compared else []:
        found = ", ".join(f"{counts[status]} {status}" for status in STATUSES if counts[status])
        if found:
            LOGGER.info("report: compared with the publication, %s: %s", what, found)
    drawing = run.folder / "figures" / "figure_02_case.png"
    return template.render(
        version=run.provenance["impactfem"],
        title=run.case["title"],
        css=Markup((templates / "report.css").read_text(encoding="utf-8")),
        plotly=Markup(get_plotlyjs()),
        provenance=run.provenance,
        tiles=tiles(run),
        drawing=data_address(drawing) if drawing.is_file() else "",
        facts=facts(run),
        governing=next((plots[name] for name in GOVERNING if name in plots), None),
        met=len([check for check in checks if check["good"]]),
        told=len([check for check in checks if check["good"] is None]),
        failed=[check for check in checks if check["good"] is False],
        key_checks=[
            check
            for check in checks
            if check["good"] and any(word in check["text"] for word in KEY_WORDS)
        ],
        assumptions=assumptions(run.case),
        stages=stages,
        publication="" if reference is None else reference["title"],
        places=[_shown(place, stages) for place in compared],
        kinds=[
            kind
            for kind in ("equation", "figure", "table")
            if any(place.kind == kind for place in compared)
        ],
        statuses=STATUSES,
        given=[] if reference is None else reference.get("given", []),
        tally=tally,
        differing=[_numbers(one) for one in farthest(compared)[:FARTHEST]],
        times=_times(run),
        summary=[
            {
                **entry,
                "value_text": number(entry["value"]),
                "paper_text": f"{(entry.get('relation') or '').strip('=')}{number(entry['paper'])}",
                "kind_text": entry.get("kind") or "",
            }
            for entry in run.summary
        ],
    )


def _stage(run: RunFiles, name: str, stage: Stage | None) -> dict[str, Any]:
    """What the page shows of a stage; without one, of the comparison with another run."""
    title, about = COMPARED if stage is None else (stage.title, stage.about)
    curves = () if stage is None else stage.curves(run.folder)
    figures = run.files_of(name, "figures")
    tables = run.files_of(name, "tables")
    pictures = [path for path in figures if path.suffix == ".png"]
    films = [path for path in figures if path.suffix == ".mp4"]
    scenes = [path for path in figures if path.suffix == ".html"]
    return {
        "name": name,
        "title": title,
        "about": about,
        "checks": [check for check in run.checks if check["stage"] == name],
        "plots": [_plot(figure) for figure in curves],
        "scene": frame_document(scenes[0]) if scenes else "",
        "figures": [_embedded(path) for path in pictures],
        "films": [_embedded(path) for path in films],
        "tables": [_table(path) for path in tables],
        "files": [str(path.relative_to(run.folder)) for path in (*figures, *tables)],
    }


def _plot(drawn: CurveFigure) -> dict[str, str]:
    """A figure of curves to zoom into."""
    caption = plain(html.escape(drawn.caption))
    return {"name": f"plot_{drawn.name}", "caption": caption, "markup": drawn.to_html()}


def _embedded(path: Path) -> dict[str, str]:
    return {
        "anchor": _anchor(str(path)),
        "name": path.stem.replace("_", " "),
        "address": data_address(path),
    }


def _table(path: Path) -> dict[str, Any]:
    head, rows, whole = csv_table(path)
    return {
        "anchor": _anchor(str(path)),
        "name": path.stem.replace("_", " "),
        "file": f"tables/{path.name}",
        "head": head,
        "rows": rows,
        "count": whole,
    }


def _anchor(name: str) -> str:
    return f"{Path(name).suffix[1:]}_{Path(name).stem}"


def _shown(place: Place, stages: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """A place with its numbers as texts and links to where ours is shown."""
    known = {name for stage in stages for name in stage["files"]}
    return {
        "kind": place.kind,
        "number": place.number,
        "title": place.title,
        "tells": place.tells,
        "status": place.status,
        "standing": _standing(place),
        "lacking": place.lacking,
        "links": [
            (_anchor(name), Path(name).stem.replace("_", " "))
            for name in place.shows
            if name in known
        ],
        "compared": [_numbers(one) for one in place.compared],
    }


def _numbers(one: Compared) -> dict[str, str]:
    """A compared value as texts."""
    return {
        "name": one.name,
        "reason": one.reason,
        "status": one.kind if one.status == GIVEN else one.status,
        "ours_text": quantity(one.ours, one.unit),
        "published_text": f"{one.relation} {quantity(one.published, one.unit)}".removeprefix("= "),
        "difference_text": "" if one.difference is None else f"{100.0 * one.difference:+.1f} %",
        "tolerance_text": f"{100.0 * one.tolerance:g} %" if one.relation == "=" else "",
    }


def _standing(place: Place) -> str:
    """How many of its results come near enough, where some do not; what is given is no result."""
    results = [one for one in place.compared if one.kind == "result"]
    near = sum(one.status == REPRODUCED for one in results)
    return f"{near} of {len(results)} reproduced" if place.status == DIFFERS and results else ""


def _times(run: RunFiles) -> list[tuple[str, str, str, str]]:
    rows = []
    memory = run.provenance["peak_memory"]
    for stage, inputs in run.provenance["inputs"].items():
        own = [t for n, t in run.provenance["seconds"].items() if n.startswith(f"{stage}: ")]
        peak = memory.get(stage)
        text = "not known" if peak is None else f"{peak / 1e9:.2f}"
        rows.append((stage, f"{sum(own):.1f}", text, str(inputs)[:16]))
    return rows
