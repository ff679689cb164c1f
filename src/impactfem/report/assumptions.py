"""The assumptions of a case, and the conventions of the report."""

import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from impactfem.report.buildings import in_3d, wall_is_used
from impactfem.report.facts import quantity
from impactfem.report.run_files import RunFiles
from impactfem.report.sections import TEMPLATES
from impactfem.spectra.design import broadening_words
from impactfem.spectra.frequency_list import rg_1_122_frequencies
from impactfem.spectra.resolved import POINTS

PUBLISHED = "Data missing in the publication, and values adopted"
"""Heading of the assumptions in place of published data."""
MOST_CHANGES = 12
"""Number of keys that are named where a case differs from the one that its reference is of."""


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
            f" The 3D model has steps of {quantity(transient['time_step'], 's')} and is valid up "
            f"to {transient['maximum_frequency']:g} Hz: its spectra end there."
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
        (PUBLISHED, published),
    )
    return [(title, entries) for title, entries in groups if entries]
