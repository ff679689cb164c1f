"""The page itself: what a run's files say, put into the template, beside a publication.

Every equation, figure and table of the publication is shown with how near ours comes.
"""

import base64
import fnmatch
import hashlib
import html
import itertools
import math
import re
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from impactfem.report.caveats import flags
from impactfem.report.decision import anchors_table, answers
from impactfem.report.governing import bands_table, governing, spectra_table
from impactfem.report.overview import buildings, in_3d, number, quantity, wall_is_used
from impactfem.report.run_files import DRAWING, SPECTRA, RunFiles
from impactfem.report.sections import TEMPLATES, Picture, anchor, numeric, picture, sections
from impactfem.report.verdicts import verdicts_table
from impactfem.spectra.design import broadening_words
from impactfem.spectra.frequency_list import rg_1_122_frequencies
from impactfem.spectra.resolved import POINTS
from impactfem.stages.manifest import Label
from impactfem.stages.stage import Stage
from impactfem.system.errors import Fault, InputError
from impactfem.system.files import atomic
from impactfem.system.log import LOGGER

REPORT = "report.html"
SCRIPT = re.compile(r"<script[^>]*>(.*?)</script>", re.S)
REPRODUCED, DIFFERS, GIVEN = "reproduced", "differs", "given or fitted"
UNPUBLISHED, ABSENT, SHOWN = "no number published", "not computed", "shown"
STATUSES = (REPRODUCED, DIFFERS, GIVEN, UNPUBLISHED, SHOWN, ABSENT)
KINDS = ("equation", "figure", "table")
FARTHEST = 8
"""Number of results that differ on the first page."""
MOST_CHANGES = 12
"""Number of keys that are named where a case differs from the one that its reference is of."""


@dataclass(frozen=True)
class Compared:
    """One result and its published value."""

    name: str  #: name of the result
    ours: float | None  #: ours, SI; None where it was not computed, or the stage ran and has none
    published: float | None  #: the published one, SI
    unit: str  #: their SI unit
    #: (ours − published) / |published|; None without one of them, or when it is zero.
    difference: float | None
    tolerance: float  #: largest |difference| that counts as reproduced
    #: What the publication says: "=", or ">" or "<" its value, which holds or does not, whatever
    #: the tolerance.
    relation: str
    #: What ours is: "result", or "input", "fitted", "scaled", "selected" or "derived", which counts
    #: as `GIVEN` where it comes near.
    kind: str
    status: str  #: `REPRODUCED`, `GIVEN`, `DIFFERS` or `ABSENT`
    reason: str  #: why it differs; "" when it does not

    @property
    def distance(self) -> float:
        """|log| of ours over the published value; inf without a ratio."""
        if not self.ours or not self.published or self.ours * self.published < 0.0:
            return math.inf
        return abs(math.log(self.ours / self.published))


@dataclass(frozen=True)
class Place:
    """An equation, figure or table of the publication with ours."""

    item: Mapping[str, Any]  #: its kind, number, title and what the case tells of it
    shows: Sequence[str]  #: files of the run that show ours, relative to its folder
    lacking: Sequence[str]  #: patterns of files that no stage of the run wrote
    compared: Sequence[Compared]  #: the results with a published value

    @property
    def status(self) -> str:
        """The worst of its results, or of what is given; without values, whether ours is shown."""
        states = {one.status for one in self.compared}
        if self.item.get("given"):
            states.add(GIVEN)
        if self.lacking and not self.shows:
            states.add(ABSENT)
        ranked = (DIFFERS, REPRODUCED, GIVEN, ABSENT)
        otherwise = SHOWN if self.item["kind"] == "equation" else UNPUBLISHED
        return next((status for status in ranked if status in states), otherwise)

    @property
    def standing(self) -> str:
        """How many results are reproduced, where some are not; what is given is no result."""
        results = [one for one in self.compared if one.kind == "result"]
        near = sum(one.status == REPRODUCED for one in results)
        differs = self.status == DIFFERS and results
        return f"{near} of {len(results)} reproduced" if differs else ""


def places(
    reference: Mapping[str, Any], summary: Sequence[Mapping[str, Any]], written: Sequence[str]
) -> list[Place]:
    """Compare a run with a publication: its scalar results, and files relative to its folder."""
    results = {entry["name"]: entry for entry in summary}
    made = []
    for item in reference["items"]:
        files = {pattern: fnmatch.filter(written, pattern) for pattern in item["shows"]}
        shows = [name for names in files.values() for name in names]
        lacking = [pattern for pattern, names in files.items() if not names]
        compared = [_compared(value, results.get(value["name"])) for value in item["values"]]
        made.append(Place(item, shows, lacking, compared))
    return made


def count(found: Sequence[Place], kind: str) -> Counter[str]:
    """How many places of a kind have each status."""
    return Counter(place.status for place in found if place.item["kind"] == kind)


def compared_values(found: Sequence[Place]) -> list[Compared]:
    """The compared values, each once."""
    return list({one.name: one for place in found for one in place.compared}.values())


def farthest(found: Sequence[Place]) -> list[Compared]:
    """The results that differ, those that are farthest from the published ones first."""
    values = compared_values(found)
    differing = [one for one in values if one.status == DIFFERS and one.kind == "result"]
    return sorted(differing, key=lambda one: -one.distance)


def _compared(value: Mapping[str, Any], entry: Mapping[str, Any] | None) -> Compared:
    """A value of the publication with the entry of the summary, if there is one."""
    result = entry or {"value": None, "paper": None, "unit": ""}
    ours, published = result["value"], result["paper"]
    # Runs of before 0.2 have neither.
    relation, kind = result.get("relation") or "=", result.get("kind") or "result"
    difference = None
    if published is None:
        status = ABSENT
    elif ours is None:
        # The stage ran and has no such result, as a second impact that does not happen.
        status = DIFFERS
    else:
        difference = (ours - published) / abs(published) if published != 0.0 else None
        if relation != "=":
            good = ours > published if relation == ">" else ours < published
        else:
            good = ours == 0.0 if difference is None else abs(difference) <= value["tolerance"]
        status = DIFFERS if not good else REPRODUCED if kind == "result" else GIVEN
    return Compared(
        name=value["name"],
        ours=ours,
        published=published,
        unit=result["unit"],
        difference=difference,
        tolerance=value["tolerance"],
        relation=relation,
        kind=kind,
        status=status,
        reason=(value["reason"] or "no reason is given") if status == DIFFERS else "",
    )


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
        "title_of": lambda path: Path(path).stem.replace("_", " "),
        "numeric": numeric,
        # A text of a style sheet: nothing of it can end the text, or the sheet.
        "quoted": lambda text: Markup(
            '"' + "".join(c if c.isalnum() else f"\\{ord(c):x} " for c in text) + '"'
        ),
    }
    numbers = itertools.count(1)
    cases = {one.name: one.title for one in known["pounding"].figures.declared}
    titles = {SPECTRA: "Governing floor response spectra", DRAWING: cases[DRAWING]}
    overall = [_overall(run, name, title, numbers) for name, title in titles.items()]
    shown = sections(run, known, numbers)
    written = [name for section in shown for name in section.files]
    written += [str(one.path.relative_to(run.folder)) for one in overall if one is not None]
    written = list(dict.fromkeys(written))
    reference = run.case["report"]["reference"]
    compared = [] if reference is None else places(reference, run.summary, written)
    tally = [(f"{kind}s", count(compared, kind)) for kind in KINDS]
    tally.append(("values", Counter(one.status for one in compared_values(compared))))
    for what, counts in tally if compared else []:
        found = ", ".join(f"{counts[status]} {status}" for status in STATUSES if counts[status])
        if found:
            LOGGER.debug("report: compared with the publication, %s: %s", what, found)
    # Kinds and numbers in the publication of what a file shows, by the file.
    beside: dict[str, list[tuple[str, str]]] = {}
    for place in compared:
        for name in place.shows:
            beside.setdefault(name, []).append((place.item["kind"], place.item["number"]))
    seconds = run.provenance["seconds"]
    spectra = governing(run)
    script = (TEMPLATES / "report.js").read_text("utf-8")
    scenes = [html.unescape(text) for one in shown for group in one.groups for text in group.scenes]
    return environment.from_string((TEMPLATES / "report.html").read_text("utf-8")).render(
        title=run.case["title"],
        css=Markup((TEMPLATES / "report.css").read_text("utf-8")),
        script=Markup(script),
        policy=content_policy([script, *(text for one in scenes for text in SCRIPT.findall(one))]),
        provenance=run.provenance,
        signed={k: run.case["report"].get(k) for k in ("author", "checker", "revision")},
        answers=answers(run, spectra),
        flags=flags(run, spectra),
        verdicts=verdicts_table(run.verdicts),
        tables=[
            one
            for one in (spectra_table(spectra), bands_table(spectra), anchors_table(run))
            if one and one.rows
        ],
        decision=overall[0],
        drawing=overall[1],
        buildings=buildings(run),
        met=sum(one["passed"] is True for one in run.checks),
        unlimited=sum(one["passed"] is None for one in run.checks),
        failed=[one for one in run.checks if one["passed"] is False],
        assumptions=assumptions(run.case),
        conventions=conventions(run),
        sections=shown,
        beside=beside,
        times={
            stage: sum(t for name, t in seconds.items() if name.startswith(f"{stage}: "))
            for stage in run.stages
        },
        publication={"title": "", "given": []} | (reference or {}),
        of_another_case=of_another_case(run.case),
        places=compared,
        kinds=[kind for kind in KINDS if any(place.item["kind"] == kind for place in compared)],
        statuses=STATUSES,
        given_status=GIVEN,
        tally=tally,
        differing=farthest(compared)[:FARTHEST],
        summary=run.summary,
    )


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


def _overall(run: RunFiles, stem: str, title: str, numbers: Iterator[int]) -> Picture | None:
    """A figure of the run as a whole."""
    path = next((run.folder / "figures").glob(f"{stem}.*"), None)
    return None if path is None else picture(path, title, anchor(run, path), next(numbers))


def conventions(run: RunFiles) -> list[tuple[str, str]]:
    """What the numbers of the page are: units, spectra, their ends, and rules of design."""
    said = [("Units", "SI; a prefix or another unit stands with the number. g is 9.80665 m/s².")]
    case, spectra = run.case, run.case["spectra"]
    grid = spectra["frequencies"]
    if isinstance(grid, dict) and grid["list"] == "rg1.122":
        grid = rg_1_122_frequencies(grid["maximum"])
    ends = (grid["minimum"], grid["maximum"]) if isinstance(grid, dict) else (grid[0], grid[-1])
    dampings = ", ".join(f"{100.0 * d:g} %" for d in spectra["damping"])
    low, high = (f"{end:g}" for end in ends)
    said.append(
        (
            "Floor spectra",
            f"Pseudo-acceleration, {dampings} of critical damping, from {low} to {high} Hz, of "
            f"histories with at least {spectra['points_per_cycle']} points in a cycle of the "
            "highest frequency. The first page uses the first damping and the resolved band: "
            f"frequencies with at least {POINTS:g} time steps in a cycle that mesh, basis and "
            "contact resolve, too.",
        )
    )
    text = (
        "The zero-period acceleration (ZPA) is the peak of a history that is limited to the "
        "resolved band by a low-pass filter without phase shift. The peak floor acceleration "
        "(PFA) of other tables is the largest sample of the history. A check states "
        "where a spectrum has not reached it."
    )
    said.append(("Zero-period acceleration", text))
    steps = f"The pounding has steps of {quantity(case['pounding']['time_step'], 's')}."
    if (transient := case["transient"]) is not None:
        steps += (
            f" The 3D model has steps of {quantity(transient['time_step'], 's')} and is meant up "
            f"to {transient['maximum_frequency']:g} Hz: its spectra are shown up to there."
        )
    said.append(("Cut-off", steps))
    text = broadening_words(spectra["broadening"])
    if spectra["clipping"]:
        text += "; narrow peaks reduced by 15 % before (ASCE 4-98, 3.4.2.3)"
    text = f"{text[0].upper()}{text[1:]}. Spectra elsewhere are as computed."
    said.append(("Broadening of design spectra", text))
    if (rules := case["device_analysis"]) is not None and case["devices"]:
        modes = rules["combination"]
        modes = modes if isinstance(modes, str) else " and ".join(modes)
        text = f"Modes by {modes}, directions by {rules['directions']}"
        text += ", with the missing mass" if rules["missing_mass"] else ", without the missing mass"
        said.append(("Response spectrum analysis", f"{text} (Regulatory Guide 1.92)."))
    return said


def of_another_case(case: Mapping[str, Any]) -> str:
    """That the reference was written for a case that this one extends; "" where it was not."""
    name, changes = case.get("reference_of"), list(case.get("changes", ()))
    if not name or not changes:
        return ""
    more = f" and {len(changes) - MOST_CHANGES} more keys" if len(changes) > MOST_CHANGES else ""
    return (
        f"The reference was written for {name}, which this case extends: its assumptions, reasons "
        "of differences and lists of fitted and selected values are those of that case. "
        f"This case differs from it in {', '.join(changes[:MOST_CHANGES])}{more}."
    )


def assumptions(case: Mapping[str, Any]) -> list[tuple[str, Sequence[Mapping[str, str]]]]:
    """What was assumed by a case (`text`) and why (`reason`), in groups with a title."""
    method = tomllib.loads((TEMPLATES / "assumptions.toml").read_text("utf-8"))
    wall = "wall_used" if wall_is_used(case) else "wall_unused"
    laws = {one["damping"].get("type", "rayleigh") for one in case["buildings"]}
    damping = "rayleigh" if laws == {"rayleigh"} else "other_damping"
    touched = in_3d(case)
    models = [one for one in (case["structure"], *case.get("further_structures", ())) if one]
    used = {
        "alike": case.get("wave_passage") is None,
        "waves": case.get("wave_passage"),
        "clamped": any(one.get("soil") is None for one in case["buildings"]),
        "soil": any(one.get("soil") is not None for one in case["buildings"]),
        damping: True,
        "sticks": any(one["name"] not in touched for one in case["buildings"]),
        "in_3d": touched,
        "structure": models,
        "fitted": any(one.get("calibration") for one in models),
        wall: case["wall_impact"],
        "chosen": not case["wall_impact"]
        and any(one.get("type") != "unilateral" for one in case["contact_laws"].values()),
        "transient": case["transient"] and any(one["building"] not in touched for one in models),
        "devices": case["devices"],
    }
    keys = [key for key, holds in used.items() if holds]
    own, reference = case["report"]["assumptions"], case["report"]["reference"] or {}
    published = list(reference.get("assumptions", ()))
    if words := of_another_case(case):
        reason = "Differences from the publication may have other reasons here."
        published.insert(0, {"text": words, "reason": reason})
    groups = (
        ("The method", sum((method[key] for key in keys), method["always"])),
        ("This case", own),
        ("What the publication leaves out, and what is taken in its place", published),
    )
    return [(title, entries) for title, entries in groups if entries]
