"""Checks of the stage `pounding`: motions, contact, energy, time step, and linear analysis."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.case.contact_checks import ROUNDED, SAME
from impactfem.coupling.impacts import FORCE_BAND
from impactfem.motion.from_case import PEAK
from impactfem.stages.check import (
    HALVED,
    PROGRAM_FAULT,
    QUIET,
    Check,
    Criterion,
    digits,
    end_check,
    end_of_spectra,
)
from impactfem.stages.pounding.model_checks import fit_checks, foundation_checks
from impactfem.stages.stores import names_of, open_stores

SWING_AT_END = "pounding.swing_at_end"
SWING = 0.5
"""Largest displacement in the last period of a run over the largest of all. Two neighbours that
swing against each other by half of it come as near as one of them did with all of it."""
LEFT = 0.01
"""Relative displacement that the ground may keep between two buildings, over the least gap."""
ELASTIC = 1e-9
"""Dissipation over time stepping error up to which contact laws are elastic."""

FORCES = ("pounding.main_impact_*", "pounding.peak_force.*", "pounding.mean_force_5ms")
"""Patterns of the names of impact forces."""

MOTION_CRITERIA = Criterion("pounding.motion_criteria", "satisfied criteria of SRP 3.7.1")
MOTION_SPECTRUM = Criterion(
    "pounding.motion_spectrum",
    "mean of the spectrum of the motion over its target",
    "%",
    # EN 1998-1, 3.2.3.1.2(4)c, has 0.9 for each ordinate of the mean of three motions or more, US
    # NRC SRP 3.7.1 has 1.3 for each ordinate of one motion; the ordinates of one motion scatter.
    lower=0.9,
    upper=1.3,
    consequence="The motion does not represent its target spectrum at the periods of the buildings",
    remedy="Use another motions.seed, a longer motions.duration, or a smaller motions.scale",
    concerns=("pounding.impacts",),
)
MOTION_PEAK = Criterion(
    "pounding.motion_peak",
    "peak ground acceleration over that of the target",
    "%",
    lower=PEAK[0],
    upper=PEAK[1],
    consequence="The motion does not represent its target at high frequencies",
    remedy="Set motions.pga to the peak ground acceleration of the spectrum of the motion",
)
PASSAGE = Criterion(
    "pounding.wave_passage",
    "relative displacement of the ground left at the end",
    "mm",
    consequence="It changes the gap",
    remedy='Set motions.baseline = "rest"',
)
GAP = Criterion(
    "pounding.gap_geometry",
    "difference between a gap and its distance by axes and offsets",
    "mm",
    consequence="The specified gap is used",
    remedy="Correct contacts.gap, or axis and offset",
    concerns=("pounding.required_separation", "pounding.main_impact_*"),
)
IMPACTS = Criterion("pounding.impacts", "number of impacts")
RESTITUTION = Criterion("pounding.restitution", "effective restitution")
SWINGING = Criterion(
    "pounding.swing_at_end",
    "displacement in the last period relative to the largest",
    "%",
    upper=SWING,
    consequence="Later impacts are not computed",
    remedy="Raise pounding.duration",
)
ENERGY = Criterion(
    "pounding.energy_residual",
    "residual of the discrete energy identity",
    upper=1e-9,
    severity="invalid",
    consequence="The time stepping does not conserve energy",
    remedy=PROGRAM_FAULT,
    concerns=("pounding.*", "frs.*"),
)
STEPS = Criterion(
    "pounding.steps_per_impact",
    "least number of time steps in an impact",
    consequence="Impact force, duration and restitution depend on the time step",
    remedy="Reduce pounding.time_step",
    concerns=FORCES,
)
HALF_OF_THE_POINTS = Criterion(
    "pounding.half_of_the_points",
    "largest change with half of the contact points",
    "%",
    upper=HALVED,
    consequence="Impact forces depend on the number of contact points",
    remedy="Reduce pounding.contact_spacing, or refine the mesh",
    concerns=FORCES,
)
DOUBLE_STEP = Criterion(
    "pounding.double_step",
    "largest change with a time step of twice the length",
    "%",
    upper=HALVED,
    consequence="Impact forces depend on the time step",
    remedy="Reduce pounding.time_step",
    concerns=FORCES,
)
COMPLEMENTARITY = Criterion(
    "pounding.complementarity",
    "residual of complementarity",
    upper=1e-10,
    severity="invalid",
    consequence="The unilateral contact is not solved",
    remedy=PROGRAM_FAULT,
    concerns=("pounding.*", "frs.*"),
)
CONTACT_ENERGY = Criterion(
    "pounding.contact_energy",
    "error of time stepping in contact",
    "% of the dissipated energy",
    upper=0.05,
    consequence="The time step changes the restitution",
    remedy="Reduce pounding.time_step",
    concerns=FORCES,
)
SAMPLING = Criterion(
    "pounding.spectrum_sampling",
    "largest error of spectral peaks between samples",
    "%",
    upper=0.05,
    consequence="Spectral ordinates at high frequencies are too low by this error",
    remedy="Reduce pounding.time_step, or lower spectra.frequencies",
    concerns=("frs.*",),
)
SPECTRUM_END = end_of_spectra("pounding", "frs.*.pfa")
PENETRATION = Criterion(
    "pounding.penetration",
    "largest penetration",
    "% of the gap",
    upper=0.5,
    consequence="The contact is so soft that it changes the gap",
    remedy="Raise contact_laws.stiffness",
    concerns=FORCES,
)
BEARING = Criterion(
    "pounding.bearing_pressure",
    "largest mean bearing pressure",
    "% of the compressive strength",
    upper=1.0,
    consequence="Concrete crushes; linear contact is not valid",
    remedy="Check contacts.bearing_area; use results as an upper bound of the force",
    concerns=FORCES,
)
SHEAR = Criterion(
    "pounding.storey_shear",
    "largest shear stress of a storey in impacts",
    "% of the tensile strength",
    upper=1.0,
    consequence="Walls crack; linear analysis is not valid. The stress has no meaning where shear "
    "areas represent the bending of a frame",
    remedy="Reduce buildings.stiffness_factor to a cracked stiffness",
    concerns=FORCES,
)
UNKNOWN = "too few points, no contact force, or the run to compare with failed"


def distance_check(
    names: Sequence[str], gaps: Sequence[float], distances: Sequence[float]
) -> list[Check]:
    """Check that the points of each pair are its gap apart; a computation uses the gap.

    Args:
        names: Of the pairs.
        gaps: As given [m].
        distances: Of the points along the normals [m]; nan where not known.
    """
    known = [
        (abs(distance - gap), gap, distance, name)
        for name, gap, distance in zip(names, gaps, distances, strict=True)
        if math.isfinite(distance)
    ]
    if not known:
        return []
    off, gap, distance, name = max(known, key=lambda pair: pair[0])
    others = sum(pair[0] > SAME + ROUNDED for pair in known) - 1
    detail = f"gap {gap:.4g} m, distance {distance:.4g} m"
    if others > 0:
        detail += f"; the same applies to {others} more pairs"
    return [GAP.check(1e3 * off, name, detail, upper=1e3 * (SAME + ROUNDED))]


def stick_checks(
    folder: Path, points_per_impact: int, tolerances: Mapping[str, float]
) -> list[Check]:
    """Return the checks of `pounding.nc`.

    Args:
        folder: Of the run.
        points_per_impact: Least number of time steps required in an impact.
        tolerances: Largest relative differences from a published value that count as reproduced, by
            the name of the result; empty for a case without a reference.
    """
    with open_stores(folder) as opened:
        store, motion = opened("pounding.nc"), opened("motion.nc")
        moving = store["pfa"].where(store["pfa"] > QUIET * store["pfa"].max())
        ratio = store["psa"].isel(damping=0, frequency=-1) / moving
        ended = end_check(
            SPECTRUM_END,
            names_of(store, "station"),
            names_of(store, "direction"),
            ratio.transpose("station", "direction").values,
            float(store["frequency"][-1]),
            jumps=begins_with_jump(store),
        )
        return [
            *_motions(motion),
            *_passage(store),
            *distance_check(
                names_of(store, "pair"),
                store["pair_rest_gap"].values.tolist(),
                store["pair_distance"].values.tolist(),
            ),
            *fit_checks(store, tolerances),
            *_impacts(store, points_per_impact),
            *_accuracy(store, points_per_impact),
            ended,
            *_linearity(store),
            *foundation_checks(store),
        ]


def _motions(motion: xr.Dataset) -> Iterator[Check]:
    """Criteria of reviewers, and the spectra of synthetic motions relative to their targets."""
    if "criterion" in motion.dims:
        failed = [
            f"{one['criterion_motion'].item()} {one['criterion'].item().replace('_', ' ')} "
            f"{digits(float(one['criterion_value']))} (required: "
            f"{'at least' if one['criterion_at_least'] else 'at most'} "
            f"{float(one['criterion_limit']):g})"
            for _, one in motion.groupby("criterion", squeeze=False)
            for one in (one.isel(criterion=k) for k in range(one.sizes["criterion"]))
            if not one["criterion_passed"]
        ]
        count = motion.sizes["criterion"]
        alone = set(names_of(motion, "criterion")) == {"correlation"}
        place = f"of {count}{', independence of components alone' if alone else ''}"
        detail = f"not satisfied: {', '.join(failed)}" if failed else ""
        yield MOTION_CRITERIA.check(count - len(failed), place, detail)
    for name, criterion in (("over_target", MOTION_SPECTRUM), ("pga_over_target", MOTION_PEAK)):
        for k, value in enumerate(motion[name].values.tolist()):
            one = motion.isel(motion=k)
            place, detail = f"motion along {one['direction'].item()}", ""
            if name == "over_target":
                low, high = (float(one[f"over_target_{end}"]) for end in ("from", "to"))
                detail = f"mean from {low:.3g} Hz to {high:.3g} Hz"
            if math.isfinite(value):
                yield criterion.check(value, place, detail)


def _changed(criterion: Criterion, change: xr.DataArray, place: str) -> Check:
    """What fewer points of contact or longer steps change in 3D pounding.

    Spectra are those up to `FORCE_BAND`; the resolved band states what is above. Peak accelerations
    have no limit: without a law they grow as steps become shorter.
    """
    *limited, pfa = change.sel(changed=["force", "mean_force", "frs", "pfa"]).values.tolist()
    texts = ("largest force", "largest mean over 5 ms", f"floor spectra up to {FORCE_BAND:g} Hz")
    detail = ", ".join(
        f"{text} {digits(100 * value)} %" for text, value in zip(texts, limited, strict=True)
    )
    detail += f", peak floor accelerations {digits(100 * pfa)} % (no limit)"
    return criterion.check(max(limited), place, detail)


def _passage(store: xr.Dataset) -> Iterator[Check]:
    """When waves reach each building, and what motions that do not end at rest do to its gaps."""
    gaps = [gap for gap in store["pair_rest_gap"].values.tolist() if gap > 0.0]
    # Without a gap that is open at rest there is nothing to compare with.
    limit = 1e3 * LEFT * min(gaps) if gaps else None
    for k, name in enumerate(names_of(store, "building")):
        building = store.isel(building=k)
        delay, apart, left = (
            1e3 * float(building[f"passage_{of}"]) for of in ("delay", "apart", "left")
        )
        if math.isfinite(delay):
            detail = (
                f"waves arrive {abs(delay):.3g} ms {'later' if delay > 0.0 else 'earlier'} than at "
                f"the first building; largest relative displacement {apart:.3g} mm"
            )
            yield PASSAGE.check(left, name, detail, upper=limit)


def _impacts(store: xr.Dataset, required: int) -> Iterator[Check]:
    gap = ""
    if "required_separation" in store:
        needed = 100 * float(store["required_separation"])
        gap = f"gap required to avoid contact {needed:.3g} cm"
    count = store.sizes["impact"]
    if not count:
        yield IMPACTS.check(0, "", gap)
        return
    main = store.isel(impact=store["impact_peak_force"].argmax("impact"))
    largest = (
        f"largest {float(main['impact_band_force']) / 1e6:.4g} MN up to 100 Hz, peak "
        f"{float(main['impact_peak_force']) / 1e6:.4g} MN at "
        f"{float(main['impact_peak_time']):.4g} s, duration "
        f"{1e3 * float(main['impact_duration']):.3g} ms"
    )
    yield IMPACTS.check(count, "", f"{largest}; {gap}" if gap else largest)
    # With fewer steps an impact the velocities before and after are inaccurate.
    if not float(store["steps_per_impact_min"]) >= required:
        return
    restitution = store["impact_restitution"].dropna("impact").values.tolist()
    # Above 1 the buildings' own forces separate the floors, not the impact; below 0 the places that
    # touch have separated, and the middles of floors that turn have not.
    known = [value for value in restitution if 0.0 <= value <= 1.0]
    if known:
        of_main = float(main["impact_restitution"])
        largest = f"{of_main:.3g} in the largest impact, " if 0.0 <= of_main <= 1.0 else ""
        of = f"{len(known)} of {len(restitution)}" if len(known) < len(restitution) else "all"
        text = f"{largest}{min(known):.3g} to {max(known):.3g} in {of}"
        yield RESTITUTION.check(detail=f"{text}, structural forces during contact included")
    for undefined, text in (
        (sum(value > 1.0 for value in restitution), "structural forces separate the floors"),
        (sum(value < 0.0 for value in restitution), "floors rotate and still approach"),
    ):
        if undefined:
            yield RESTITUTION.check(detail=f"undefined in {undefined} impacts: {text}")


def _accuracy(store: xr.Dataset, required: int) -> Iterator[Check]:
    """Rest at the end, energy, steps in an impact, the time stepping in contact, spectra."""
    if store["pair"].size:
        swinging = store.isel(building=store["swing_at_end"].argmax("building"))
        yield SWINGING.check(float(swinging["swing_at_end"]), str(swinging["building"].item()))
    yield ENERGY.check(float(store["energy_residual"]))
    unilateral = "complementarity" in store
    steps = float(store["steps_per_impact_min"]) if store.sizes["impact"] else math.nan
    if math.isfinite(steps):
        # Unilateral contact has no law that dissipates: its larger impacts count.
        place = "larger impacts" if unilateral else "two free floors"
        detail, fewest = "", float(store["steps_per_impact_observed"])
        if fewest < required and not unilateral:
            force = store["impact_peak_force"]
            short = force.isel(impact=store["impact_steps"].argmin("impact")) / force.max()
            detail = (
                f"{fewest:.0f} in the shortest contact, with {100.0 * float(short):.2g} % of the "
                "largest force; other forces end it, and the error of energy includes it"
            )
        yield STEPS.check(steps, place, detail, lower=required)
    if "contact_points" in store:
        points = f"{float(store['contact_points']):.0f} points in 3D"
        halved = store["change"].sel(comparison="halved")
        if halved.notnull().all():
            yield _changed(HALF_OF_THE_POINTS, halved, points)
        else:
            yield HALF_OF_THE_POINTS.check(place=points, detail=f"not known: {UNKNOWN}")
        doubled = store["change"].sel(comparison="doubled_step")
        if doubled.notnull().all():
            yield _changed(DOUBLE_STEP, doubled, "")
        elif unilateral:
            yield DOUBLE_STEP.check(detail=f"not known: {UNKNOWN}")
    if unilateral:
        yield COMPLEMENTARITY.check(float(store["complementarity"]))
    if "contact_energy_defect" in store:
        lost = f"{digits(float(store['contact_energy_defect']))} of the largest kinetic energy"
        defect = float(abs(store["impact_defect"]).sum())
        by_laws = float((store["impact_dissipated"] - store["impact_defect"]).sum())
        # An elastic law dissipates nothing but round-off.
        if by_laws <= ELASTIC * defect:
            yield CONTACT_ENERGY.check(detail=f"{lost}; the contact laws are elastic")
        else:
            yield CONTACT_ENERGY.check(defect / by_laws, "absolute values", f"in sum {lost}")
    points = f"{float(store['points_per_cycle']):.3g} points per cycle of the highest frequency"
    yield SAMPLING.check(float(store["peak_error_bound"]), "", points)


def begins_with_jump(store: xr.Dataset) -> bool:
    """Return whether the force of a pair of `pounding.nc` begins with a jump."""
    return "pair" in store.dims and bool((store["pair_onset_force"] > 0.0).any())


def _linearity(store: xr.Dataset) -> Iterator[Check]:
    """Validity of linear analysis; no limit where the material has no strength."""
    if not store.sizes["impact"]:
        return
    if "penetration_over_gap" in store:
        yield _penetration(store)
    for criterion, stress, ratio in (
        (BEARING, "impact_bearing_pressure", "impact_bearing_ratio"),
        (SHEAR, "impact_shear_stress", "impact_cracking_ratio"),
    ):
        # nan if nothing is known.
        largest, part = float(store[stress].max()), float(store[ratio].max())
        if not math.isfinite(largest):
            continue
        detail = f"{largest / 1e6:.3g} MPa"
        if criterion is SHEAR:
            detail += f"; storey shear {float(store['impact_storey_shear'].max()) / 1e6:.3g} MN"
        known = math.isfinite(part)
        detail += "" if known else "; the strength is not given"
        yield criterion.check(part if known else None, "", detail)


def _penetration(store: xr.Dataset) -> Check:
    """The largest penetration, with the factor on the stiffness that brings it to the limit.

    An impact of given energy m v²/2 = ∫ K δ^p dδ penetrates by δ ~ K^(-1/(p + 1)): p is 1.5 in laws
    of Hertz's kind, 1 in linear ones.
    """
    pairs = store.sel(pair=store["impact_pair"].values)
    gaps = pairs["pair_rest_gap"].values
    parts = np.where(gaps > 0.0, store["impact_penetration"].values / gaps, -np.inf)
    k, largest = int(np.argmax(parts)), float(store["penetration_over_gap"])
    power = 1.5 if pairs["pair_stiffness_unit"].values[k] == "N/m^1.5" else 1.0
    factor = (largest / PENETRATION.upper) ** (power + 1.0)
    percent = 100.0 * PENETRATION.upper
    detail = "" if factor <= 1.0 else f"{factor:.2g} times the stiffness gives about {percent:g} %"
    return PENETRATION.check(largest, str(store["impact_pair"].values[k]), detail)
