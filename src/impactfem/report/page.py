"""The page: the decision report, and an appendix with a section for each stage.

An appendix compares each equation, figure and table of a publication with the results.
"""

import base64
import hashlib
import html
import itertools
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from impactfem.report import checks, publication
from impactfem.report.answers import answers
from impactfem.report.assumptions import PUBLISHED, assumptions, conventions, of_another_case
from impactfem.report.decision import chapters
from impactfem.report.facts import number, quantity
from impactfem.report.governing import band_limits, governing
from impactfem.report.run_files import RunFiles
from impactfem.report.sections import TEMPLATES, anchor, numeric, sections
from impactfem.stages.manifest import Label
from impactfem.stages.stage import Stage
from impactfem.system.errors import Fault, InputError
from impactfem.system.files import atomic
from impactfem.system.log import LOGGER

REPORT = "report.html"
SCRIPT = re.compile(r"<script[^>]*>(.*?)</script>", re.S)


def write_report(folder: Path, stages: Sequence[Stage]) -> Path:
    """Make `report.html`, which needs no other file and no network, from the files of a run.

    InputError where the run is of another version, with a stage that is none of these;
    ImpactfemError where the folder holds no run, or a file cannot be read or written.
    """
    run = RunFiles(folder)
    known = {stage.name: stage for stage in stages}
    unknown = [name for name in run.stages if Label.of(name).stage not in known]
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
        "anchor": lambda path: anchor(run, path),
        "inside": lambda path: str(path.relative_to(run.folder)),
        "title_of": lambda path: Path(path).stem,
        "numeric": numeric,
        # A text of a style sheet: nothing of it can end the text, or the sheet.
        "quoted": lambda text: Markup(
            '"' + "".join(c if c.isalnum() else f"\\{ord(c):x} " for c in text) + '"'
        ),
    }
    numbers = itertools.count(1)
    spectra = governing(run)
    decision = chapters(run, known, spectra, numbers)
    shown = {one.path for chapter in decision for one in chapter.pictures}
    appendix = sections(run, known, numbers, shown)
    listed = [path for chapter in decision for path in chapter.paths]
    written = [str(path.relative_to(run.folder)) for path in listed]
    written += [name for one in appendix for name in one.files]
    seconds = run.provenance["seconds"]
    other_checks = [one for one in run.checks if one["passed"] is not False]
    script = (TEMPLATES / "report.js").read_text("utf-8")
    scenes = [html.unescape(one.scene) for one in decision]
    return environment.from_string((TEMPLATES / "report.html").read_text("utf-8")).render(
        title=run.case["title"],
        css=Markup((TEMPLATES / "report.css").read_text("utf-8")),
        script=Markup(script),
        policy=content_policy([script, *(text for one in scenes for text in SCRIPT.findall(one))]),
        provenance=run.provenance,
        signed={k: run.case["report"].get(k) for k in ("author", "checker", "revision")},
        answers=answers(run, spectra),
        chapters=decision,
        count=checks.count(run.checks),
        severities=checks.SEVERITIES,
        failures=checks.rows(checks.failures(run.checks)),
        other_checks={
            run.named(known[Label.of(stage).stage].title, stage): checks.rows(
                [one for one in other_checks if one["stage"] == stage]
            )
            for stage in dict.fromkeys(one["stage"] for one in other_checks)
        },
        assumptions=assumptions(run.case),
        published=PUBLISHED,
        band_limits=band_limits(spectra),
        conventions=conventions(run),
        sections=appendix,
        times={
            stage: sum(t for name, t in seconds.items() if name.startswith(f"{stage}: "))
            for stage in run.stages
        },
        scalars=len(run.summary),
        **_publication(run, list(dict.fromkeys(written))),
    )


def _publication(run: RunFiles, written: Sequence[str]) -> dict[str, Any]:
    """Return what the template needs to compare the results with a publication.

    `written` are files of the run that the page shows, relative to its folder.
    """
    reference = run.case["report"]["reference"]
    compared = [] if reference is None else publication.places(reference, run.summary, written)
    tally = [(f"{kind}s", publication.count(compared, kind)) for kind in publication.KINDS]
    values = publication.compared_values(compared)
    tally.append(("values", Counter(one.status for one in values)))
    for what, counts in tally if compared else []:
        found = ", ".join(
            f"{counts[status]} {status}" for status in publication.STATUSES if counts[status]
        )
        if found:
            LOGGER.debug("report: compared with the publication, %s: %s", what, found)
    # Kinds and numbers in the publication of what a file shows, by the file.
    shown_as: dict[str, list[tuple[str, str]]] = {}
    for place in compared:
        for name in place.shows:
            shown_as.setdefault(name, []).append((place.item["kind"], place.item["number"]))
    return {
        "publication": {"title": "", "given": []} | (reference or {}),
        "of_another_case": of_another_case(run.case),
        "shown_as": shown_as,
        "places": compared,
        "kinds": [k for k in publication.KINDS if any(p.item["kind"] == k for p in compared)],
        "statuses": publication.STATUSES,
        "given_status": publication.GIVEN,
        "tally": tally,
        "reasons": list(dict.fromkeys(one.reason for one in values if one.reason)),
        "differing": publication.farthest(compared)[: publication.FARTHEST],
    }


def content_policy(scripts: Sequence[str]) -> str:
    """What a page may load and run: nothing but these scripts and data within the page.

    Frames within the page have the same policy.
    """
    digests = [base64.b64encode(hashlib.sha256(text.encode()).digest()) for text in scripts]
    allowed = " ".join(f"'sha256-{digest.decode()}'" for digest in digests)
    return (
        f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; img-src data:; "
        "media-src data:; base-uri 'none'; form-action 'none'"
    )
