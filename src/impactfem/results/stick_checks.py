"""The checks of the stage `sticks` in words: accuracy, and whether linear analysis is meant."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from impactfem.results.check import Check
from impactfem.results.open_store import open_store
from impactfem.scalar import from_json


def stick_checks(folder: Path, points_per_impact: int) -> list[Check]:
    """The checks of the stage.

    Args:
        folder: The run's folder, with `sticks.nc`.
        points_per_impact: Least number of steps asked of an impact.
    """
    with open_store(folder / "sticks.nc") as store:
        values = {s.name: s.value for s in from_json(store.attrs["scalars"]) if s.value is not None}
        restitution = store["impact_restitution"].values
        notes = {s.name: s.note for s in from_json(store.attrs["scalars"])}
    known = restitution[np.isfinite(restitution)].tolist()
    # With fewer steps an impact the speeds before and after say nothing.
    fine = values.get("pounding.steps_per_impact_min", 0.0) >= points_per_impact and bool(known)
    return [
        *_acceptance(notes),
        *_calibration(values),
        *_impacts(values, known, fine),
        *_accuracy(values, points_per_impact),
        *_linearity(values),
    ]


def _acceptance(notes: Mapping[str, str]) -> list[Check]:
    """How the motions stand to a reviewer's criteria: told, not warned of."""
    asked = {name: note for name, note in notes.items() if ".acceptance." in name}
    asked |= {name: note for name, note in notes.items() if ".correlation." in name}
    if not asked:
        return []
    missed = [
        name.removeprefix("motion.").replace("acceptance.", "")
        for name, note in asked.items()
        if note.startswith("missed")
    ]
    which = f"; missed: {', '.join(missed)}" if missed else ""
    met = len(asked) - len(missed)
    return [(True, f"motion: {met} of {len(asked)} acceptance criteria met (SRP 3.7.1){which}")]


def _calibration(values: Mapping[str, float]) -> list[Check]:
    if "sticks.stiffness_factor" not in values:
        return []
    heights = [v for name, v in values.items() if name.startswith("sticks.storey_height.")]
    return [
        (
            True,
            f"sticks: stiffness factor {values['sticks.stiffness_factor']:.4g} on the storeys, "
            f"rigid zones {round(values['sticks.rigid_below'], 6):.3g} m below and "
            f"{round(values['sticks.rigid_above'], 6):.3g} m above the mass centres, "
            f"storey heights {', '.join(f'{h:.3g}' for h in heights)} m",
        ),
        (
            True,
            f"sticks: largest error {100 * values['sticks.frequency_error_max']:.2g} % in a target "
            f"frequency, {100 * values['sticks.mass_error_max']:.2g} % in an effective mass",
        ),
    ]


def _impacts(values: Mapping[str, float], restitution: list[float], fine: bool) -> list[Check]:
    required = values.get("pounding.required_separation")
    apart = "" if required is None else f"; a gap of {100 * required:.3g} cm would prevent contact"
    if "pounding.main_impact_time" not in values:
        return [(True, f"pounding: no impact{apart}")]
    force = max(v for name, v in values.items() if name.startswith("pounding.peak_force."))
    return [
        (
            True,
            f"pounding: {values['pounding.impacts']:.0f} impacts, the largest with "
            f"{force / 1e6:.4g} MN at {values['pounding.main_impact_time']:.4g} s for "
            f"{1e3 * values['pounding.main_impact_duration']:.3g} ms{apart}",
        ),
        *(
            [
                (
                    True,
                    "pounding: effective restitution "
                    f"{values['pounding.main_impact_restitution']:.3g} in the largest impact, "
                    f"{min(restitution):.3g} to {max(restitution):.3g} in all (the buildings' own "
                    "forces act meanwhile)",
                )
            ]
            if fine
            else []
        ),
    ]


def _accuracy(values: Mapping[str, float], asked: int) -> list[Check]:
    residual = values["pounding.energy_residual"]
    lines = [(residual <= 1e-9, f"energy: discrete identity within {residual:.1e}")]
    if "pounding.steps_per_impact_min" in values:
        steps = values["pounding.steps_per_impact_min"]
        lines += [
            (
                steps >= asked,
                f"steps: {steps:.3g} in the law's shortest impact (reduced mass), {asked} asked",
            ),
            (
                True,
                "energy: time stepping in contact lost "
                f"{values['pounding.contact_energy_defect']:.1e} of the largest kinetic energy",
            ),
        ]
    points, bound = values["frs.points_per_cycle"], values["frs.peak_error_bound"]
    lines.append(
        (
            bound <= 0.05,
            f"spectra: {points:.3g} points in a cycle of the highest frequency, peaks at most "
            f"{100 * bound:.2g} % low",
        )
    )
    return lines


def _linearity(values: Mapping[str, float]) -> list[Check]:
    lines: list[Check] = []
    if "pounding.penetration_over_gap" in values:
        over = values["pounding.penetration_over_gap"]
        lines.append((over <= 0.5, f"contact: penetration up to {over:.2g} of the gap"))
    if "pounding.bearing_pressure_max" in values:
        text = f"{values['pounding.bearing_pressure_max'] / 1e6:.3g} MPa"
        ratio = values.get("pounding.bearing_ratio_max")
        of = "" if ratio is None else f", {ratio:.2g} of the compressive strength"
        lines.append((ratio is None or ratio <= 1.0, f"linear? mean bearing pressure {text}{of}"))
    if "pounding.shear_stress_max" in values:
        stress = f"{values['pounding.shear_stress_max'] / 1e6:.3g} MPa"
        shear = f"{values['pounding.storey_shear_max'] / 1e6:.3g} MN"
        ratio = values.get("pounding.cracking_ratio_max")
        of = "" if ratio is None else f", {ratio:.2g} of the tensile strength"
        text = (
            f"linear? storey shear in impacts up to {shear}, shear stress up to {stress}{of} "
            "(on the shear areas of the sticks; no stress where these stand for the bending of a "
            "frame)"
        )
        lines.append((ratio is None or ratio <= 1.0, text))
    return lines
