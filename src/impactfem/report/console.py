"""The end of a run on the console: gap, impacts, governing spectra, equipment, checks, report."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from impactfem.report.answers import MAIN_FORCE
from impactfem.report.facts import quantity
from impactfem.report.governing import Spectrum, governing
from impactfem.report.run_files import RunFiles
from impactfem.stages.check import severity_counts
from impactfem.stages.verdict import pair_words

LINES = 12
"""Most lines, with those of the header, the checks and the report."""
HEADER = ("result", "with impact", "without impact", "capacity", "verdict (ratio)", "place")
NONE = "-"
REPORT = "report.html"
VERDICTS = {True: "passed", False: "exceeded", None: "no capacity"}
SHORT = {
    "device.anchor_interaction": "bolts, interaction",
    "device.anchor_tension": "bolt tension",
    "device.anchor_shear": "bolt shear",
    "device.required_spectrum": "required spectrum",
    "device.test_spectrum": "test spectrum",
    "device.zpa": "ZPA at the device",
    "pounding.required_gap": "gap, time history",
    "pounding.code_gap": "gap, code",
    "pounding.floor_acceleration": "floor ZPA, sticks",
    "transient.floor_acceleration": "floor ZPA, 3D model",
    "pounding.storey_drift": "storey drift / height",
}
"""Verdicts in few words."""
EQUIPMENT = ("device.anchor_tension", "device.zpa")
"""Verdicts that are shown without a capacity."""
Row = tuple[str, ...]


def console_lines(run: RunFiles, published: int = 0) -> list[str]:
    """Return at most `LINES` lines: a header, results in columns, checks by severity, the report.

    A run of the first stages may have no result; then there is no header.
    `published` is the number of results with a published value.
    """
    last = [checks_line(run.checks)]
    if published:
        last.append(f"published values: {published} compared in the report, or with -v")
    page = run.folder / REPORT
    last.append(f"report: {page}" if page.is_file() else f"results: {run.folder}")
    rows = [*_gaps(run), *_impacts(run), *map(_spectrum, _spectra(run)), *_verdicts(run)]
    return [*_columns([HEADER, *rows[: LINES - 1 - len(last)]] if rows else []), *last]


def checks_line(checks: Sequence[Mapping[str, Any]]) -> str:
    """Return the number of checks by severity."""
    counts = severity_counts(checks)
    return (
        f"checks: {counts['invalid']} invalid (do not use), {counts['limited']} limited, "
        f"{counts['passed']} passed, {counts['information']} information"
    )


def _columns(rows: Sequence[Row]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    cells = ([one.ljust(width) for one, width in zip(row, widths, strict=True)] for row in rows)
    return ["  ".join(row).rstrip() for row in cells]


def _shown(value: float | None, unit: str) -> str:
    if value is None or not math.isfinite(value):
        return NONE
    return quantity(value, unit, digits=3).replace("m/s2", "m/s²")


def _verdict_row(one: Mapping[str, Any]) -> Row:
    unit, id = one["unit"], one["id"]
    demand, free = _shown(one["demand"], unit), _shown(one["demand_without_impact"], unit)
    if id in ("pounding.required_gap", "pounding.code_gap"):  # of the run without contact
        demand, free = NONE, demand
    ratio = "" if one["ratio"] is None else f" ({one['ratio']:.2g})"
    verdict = f"{VERDICTS[one['passed']]}{ratio}"
    words = SHORT.get(id, one["quantity"])
    if id == "device.anchor_tension" and one["capacity"] is None:
        words = "anchor tension x n"  # the number of anchors is not known
    return words, demand, free, _shown(one["capacity"], unit), verdict, one["place"]


def _gaps(run: RunFiles) -> list[Row]:
    ids = ("pounding.required_gap", "pounding.code_gap")
    return [_verdict_row(v) for v in run.verdicts if v["id"] in ids and v["demand"] is not None]


def _impacts(run: RunFiles) -> list[Row]:
    count = run.values.get("pounding.impacts")
    if count is None:
        return []
    force = next((one for one in run.summary if one["name"] == MAIN_FORCE), None)
    text, place = f"{count:.0f}", ""
    if force is not None and force["value"]:
        text += f", {_shown(force['value'], force['unit'])} up to 100 Hz"
        place = pair_words(force["note"].removeprefix("pair "))
    return [("impacts", text, NONE, NONE, NONE, place)]


def _spectra(run: RunFiles) -> list[Spectrum]:
    """Return the governing spectrum, and that of an anchor or of a further building."""
    spectra = governing(run)
    anchors = [one for one in spectra if one.at_anchor]
    others = [one for one in spectra[1:] if one.building != spectra[0].building]
    return [*spectra[:1], *(anchors or others)[:1]]


def _spectrum(one: Spectrum) -> Row:
    free = NONE if one.free is None else _shown(one.free_peak, "m/s2")
    damping = f", {100.0 * one.damping:.3g} %" if math.isfinite(one.damping) else ""
    peak = f"{_shown(one.peak, 'm/s2')} at {one.at:.3g} Hz"
    return f"spectrum{damping}", peak, free, NONE, NONE, f"{one.words}, {one.direction}"


def _verdicts(run: RunFiles) -> list[Row]:
    """Return the verdicts by given capacities, the largest ratio first, then those of equipment."""
    some = [one for one in run.verdicts if not one["id"].endswith("_gap")]
    given = [one for one in some if one["passed"] is not None and one["key"]]
    given.sort(key=lambda one: -(math.inf if one["ratio"] is None else one["ratio"]))
    # Without a capacity, the largest ordinate at a device is that of the governing spectrum.
    rest = [one for one in some if one["passed"] is None and one["id"] in EQUIPMENT]
    return [_verdict_row(one) for one in (*given, *rest)]
