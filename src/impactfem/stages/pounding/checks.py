"""The checks of the stage `pounding` in words: accuracy, and whether linear analysis is meant."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.case import Case
from impactfem.case.contact_checks import allowed
from impactfem.case.facing import facing_floors, unknown_lines
from impactfem.stages.check import Check, end_check
from impactfem.stages.stores import open_store
from impactfem.system.scalar import scalars_of

Array = NDArray[np.float64]
IDENTITY = 1e-9
"""Largest residual of the discrete energy identity."""
DEFECT = 0.05
"""What the time stepping may take or add in contact, of what the contact laws take."""
BETWEEN = 0.05
"""Part of a peak of a spectrum that may be lost between two samples."""
PENETRATION = 0.5
"""Largest penetration in parts of the gap."""
STRENGTH = 1.0
"""Largest stress in parts of the strength with which linear analysis is still meant."""


def facing_checks(folder: Path, case: Case) -> list[Check]:
    """Whether floors in no pair stay apart, and which ones cannot be told.

    Args:
        folder: The run's folder, with `pounding.nc`.
        case: The case.

    Returns:
        The checks; none where all floors that face each other are in pairs.
    """
    with open_store(folder / "pounding.nc") as store:
        approach = [_approach(store)] if "facing" in store.dims else []
    return [*approach, *((None, line) for line in unknown_lines(facing_floors(case)))]


def _approach(store: xr.Dataset) -> Check:
    distances = store["facing_distance_min"].values
    k = int(distances.argmin())
    names = f"{store['facing_a'].values[k]} and {store['facing_b'].values[k]}"
    nearest, at = f"{1e3 * abs(distances[k]):.4g} mm", f"{store['facing_time'].values[k]:.4g} s"
    count = int((distances < 0.0).sum())
    if count:
        more = f", and {count - 1} more do" if count > 1 else ""
        return False, (
            f"facing floors: {names} overlap by {nearest} at {at} and are in no pair{more} "
            "(tables/facing_floors.csv); list them in [[contacts]]"
        )
    return True, (
        f"facing floors: {len(distances)} in no pair keep apart; the nearest, {names}, by "
        f"{nearest} at {at}"
    )


def distance_check(
    names: Sequence[str], gaps: Sequence[float], distances: Sequence[float]
) -> list[Check]:
    """The check that the points of the pairs are their gaps apart; a computation takes the gaps.

    Args:
        names: Names of the pairs.
        gaps: Their gaps as given [m].
        distances: Distances of their points along the normals [m]; nan where they are not known.

    Returns:
        The check; nothing where no distance is known.
    """
    known = [
        (name, gap, distance)
        for name, gap, distance in zip(names, gaps, distances, strict=True)
        if math.isfinite(distance)
    ]
    if not known:
        return []
    off = [one for one in known if abs(one[2] - one[1]) > allowed(one[1])]
    if not off:
        return [(True, f"contact: {len(known)} gaps are those of axes and offsets")]
    name, gap, distance = max(off, key=lambda one: abs(one[2] - one[1]))
    text = (
        f"contact: the points of {name} are {distance:.4g} m apart along the normal by axis and "
        f"offset, and its gap is {gap:.4g} m; the gap counts"
    )
    others = len(off) - 1
    return [(False, f"{text}; so it is for {others} more" if others else text)]


def stick_checks(
    folder: Path, points_per_impact: int, tolerances: Mapping[str, float]
) -> list[Check]:
    """The checks of the stage.

    Args:
        folder: The run's folder, with `pounding.nc`.
        points_per_impact: Least number of steps asked of an impact.
        tolerances: Largest relative difference from a published value that counts as reproduced,
            by the name of the result; empty for a case without a reference.
    """
    with open_store(folder / "pounding.nc") as store:
        scalars = scalars_of(store)
        values = {s.name: s.value for s in scalars if s.value is not None}
        restitution = store["impact_restitution"].values
        notes = {s.name: s.note for s in scalars}
        targets = _targets(store)
        apart = distance_check(
            [str(name) for name in store["pair"].values],
            [float(gap) for gap in store["pair_rest_gap"].values],
            [float(distance) for distance in store["pair_distance"].values],
        )
        defect = store["impact_defect"].values
        taken = store["impact_dissipated"].values - defect
        ended = _ended(store)
    known = restitution[np.isfinite(restitution)].tolist()
    # With fewer steps an impact the speeds before and after say nothing.
    fine = values.get("pounding.steps_per_impact_min", 0.0) >= points_per_impact
    fine = fine and "pounding.main_impact_restitution" in values
    return [
        *_acceptance(notes),
        *apart,
        *_calibration(values, targets, tolerances),
        *_impacts(values, known, fine),
        *_accuracy(values, points_per_impact),
        *_stepping(values, defect, taken),
        *_sampling(values),
        ended,
        *_linearity(values),
    ]


def _acceptance(notes: Mapping[str, str]) -> list[Check]:
    """How the motions stand to a reviewer's criteria: told, as no case asks for these."""
    asked = {name: note for name, note in notes.items() if ".acceptance." in name}
    asked |= {name: note for name, note in notes.items() if ".correlation." in name}
    if not asked:
        return []
    missed = [
        name.removeprefix("motion.").replace("acceptance.", "")
        for name, note in asked.items()
        if note.startswith("missed")
    ]
    met = len(asked) - len(missed)
    text = f"motion: {met} of {len(asked)} criteria of SRP 3.7.1 met, which no case has to meet"
    return [(None, f"{text}; missed: {', '.join(missed)}" if missed else text)]


def _targets(store: xr.Dataset) -> dict[str, float]:
    """Relative error of each target of the calibration, by the name of the result."""
    if "target" not in store.dims:
        return {}
    found: dict[str, float] = {}
    for kind in ("frequency", "effective_mass"):
        error = abs(store[f"calibrated_{kind}"] / store[f"target_{kind}"] - 1.0)
        # A target table may leave a mass out.
        for one in error.dropna("target"):
            building, mode = one["target_building"].item(), one["target_mode"].item()
            found[f"sticks.{building}.{kind}.{mode}"] = float(one)
    return found


def _calibration(
    values: Mapping[str, float], targets: Mapping[str, float], tolerances: Mapping[str, float]
) -> list[Check]:
    if "sticks.stiffness_factor" not in values:
        return []
    heights = [v for name, v in values.items() if name.startswith("sticks.storey_height.")]
    return [
        (
            None,
            f"sticks: stiffness factor {values['sticks.stiffness_factor']:.4g} on the storeys, "
            f"rigid zones {round(values['sticks.rigid_below'], 6):.3g} m below and "
            f"{round(values['sticks.rigid_above'], 6):.3g} m above the mass centres, "
            f"storey heights {', '.join(f'{h:.3g}' for h in heights)} m",
        ),
        _reached(values, targets, tolerances),
    ]


def _reached(
    values: Mapping[str, float], targets: Mapping[str, float], tolerances: Mapping[str, float]
) -> Check:
    """How near the sticks come to their targets; told where no tolerance is given for each."""
    text = (
        f"sticks: largest error {100 * values['sticks.frequency_error_max']:.2g} % in a target "
        "frequency"
    )
    if "sticks.mass_error_max" in values:
        text += f", {100 * values['sticks.mass_error_max']:.2g} % in an effective mass"
    if not targets or any(name not in tolerances for name in targets):
        return None, text
    missed = [
        f"{name} ({100 * error:.2g} %, {100 * tolerances[name]:g} % asked)"
        for name, error in targets.items()
        if error > tolerances[name]
    ]
    if missed:
        return False, f"{text}; beyond its tolerance in the case's reference: {', '.join(missed)}"
    return True, f"{text}; each within its tolerance in the case's reference"


def _impacts(values: Mapping[str, float], restitution: list[float], fine: bool) -> list[Check]:
    required = values.get("pounding.required_separation")
    apart = "" if required is None else f"; a gap of {100 * required:.3g} cm would prevent contact"
    if "pounding.main_impact_time" not in values:
        return [(None, f"pounding: no impact{apart}")]
    # Not one of those by floor: these are of the first building alone.
    force = values["pounding.main_impact_force"]
    return [
        (
            None,
            f"pounding: {values['pounding.impacts']:.0f} impacts, the largest with "
            f"{force / 1e6:.4g} MN at {values['pounding.main_impact_time']:.4g} s for "
            f"{1e3 * values['pounding.main_impact_duration']:.3g} ms{apart}",
        ),
        *(
            [
                (
                    None,
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
    text = f"energy: discrete identity within {residual:.1e}, {IDENTITY:g} asked"
    lines: list[Check] = [(residual <= IDENTITY, text)]
    if "pounding.steps_per_impact_min" in values:
        steps = values["pounding.steps_per_impact_min"]
        text = f"steps: {steps:.3g} in the law's shortest impact (reduced mass), {asked} asked"
        fewest = values["pounding.steps_per_impact_observed"]
        if fewest < asked:
            text += f"; {fewest:.0f} in the shortest of the run, which other forces cut short"
        lines.append((steps >= asked, text))
    return lines


def _stepping(values: Mapping[str, float], defect: Array, taken: Array) -> list[Check]:
    """What the time stepping takes or adds in contact, beside what the contact laws take.

    Args:
        values: The scalars.
        defect: Of each impact, positive where energy was lost, shape (n_impacts,) [J].
        taken: What the law takes along the same motion, shape (n_impacts,) [J].
    """
    if "pounding.contact_energy_defect" not in values:
        return []
    lost = values["pounding.contact_energy_defect"]
    kinetic = f"time stepping in contact lost {lost:.1e} of the largest kinetic energy"
    by_laws = float(taken.sum())
    # An elastic law takes nothing but round-off.
    if by_laws <= IDENTITY * float(np.abs(defect).sum()):
        return [(None, f"energy: {kinetic}")]
    share = float(np.abs(defect).sum()) / by_laws
    text = (
        f"energy: {kinetic}; without regard to the sign, impact by impact, {100 * share:.2g} % of "
        f"what the contact laws took, {100 * DEFECT:g} % asked"
    )
    return [(share <= DEFECT, text)]


def _sampling(values: Mapping[str, float]) -> list[Check]:
    points, bound = values["frs.points_per_cycle"], values["frs.peak_error_bound"]
    text = (
        f"spectra: {points:.3g} points in a cycle of the highest frequency, peaks at most "
        f"{100 * bound:.2g} % low, {100 * BETWEEN:g} % asked"
    )
    return [(bound <= BETWEEN, text)]


def _ended(store: xr.Dataset) -> Check:
    """Whether the spectra of the floors end at the peak acceleration."""
    pfa, names = store["pfa"], [str(name) for name in store["station"].values]
    ratio = store["psa"].isel(damping=0, frequency=-1) / pfa.where(pfa > 0.0)
    axes = [str(direction) for direction in store["direction"].values]
    last = float(store["frequency"][-1])
    return end_check("pounding", names, axes, ratio.transpose("station", "direction").values, last)


def _linearity(values: Mapping[str, float]) -> list[Check]:
    """Whether linear analysis is still meant; told where the material has no strength."""
    lines: list[Check] = []
    if "pounding.penetration_over_gap" in values:
        over = values["pounding.penetration_over_gap"]
        text = f"contact: penetration up to {over:.2g} of the gap, {PENETRATION:g} asked"
        lines.append((over <= PENETRATION, text))
    if "pounding.bearing_pressure_max" in values:
        text = f"{values['pounding.bearing_pressure_max'] / 1e6:.3g} MPa"
        met, of = _of_strength(values.get("pounding.bearing_ratio_max"), "compressive")
        lines.append((met, f"linear? mean bearing pressure {text}{of}"))
    if "pounding.shear_stress_max" in values:
        stress = f"{values['pounding.shear_stress_max'] / 1e6:.3g} MPa"
        shear = f"{values['pounding.storey_shear_max'] / 1e6:.3g} MN"
        met, of = _of_strength(values.get("pounding.cracking_ratio_max"), "tensile")
        text = (
            f"linear? storey shear in impacts up to {shear}, shear stress up to {stress}{of} "
            "(on the shear areas of the sticks; no stress where these stand for the bending of a "
            "frame)"
        )
        lines.append((met, text))
    return lines


def _of_strength(ratio: float | None, kind: str) -> tuple[bool | None, str]:
    if ratio is None:
        return None, ""
    return ratio <= STRENGTH, f", {ratio:.2g} of the {kind} strength, {STRENGTH:g} asked"
