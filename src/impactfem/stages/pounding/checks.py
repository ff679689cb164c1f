"""The checks of the stage `pounding` in words: accuracy, and whether linear analysis is meant."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import xarray as xr

from impactfem.case import Case
from impactfem.case.contact_checks import allowed
from impactfem.case.facing import facing_floors
from impactfem.motion.from_case import PEAK
from impactfem.stages.check import HALVED, QUIET, Check, digits, end_check, limited
from impactfem.stages.stores import names_of, open_store, open_stores
from impactfem.system.scalar import Scalar, scalars_of

IDENTITY = 1e-9
"""Largest residual of the discrete energy identity."""
DEFECT = 0.05
"""What the time stepping may take or add in contact, of what the contact laws take."""
UNKNOWN = "too few points, no contact force, or the run to compare with failed"
COMPLEMENTARITY = 1e-10
"""Largest residual of unilateral contact."""
BETWEEN = 0.05
"""Part of a peak of a spectrum that may be lost between two samples."""
TARGET = (0.9, 1.3)
"""Spectrum of a motion over its target where the buildings answer, as a mean. EN 1998-1,
3.2.3.1.2(4)c, has 0.9 for each ordinate of the mean of three motions or more, US NRC SRP 3.7.1 has
1.3 for each of one; the ordinates of one motion scatter, and tell no more than their mean."""
SOIL_STIFFNESS, SOIL_DAMPING = 0.2, 0.1
"""Largest errors of the model of a soil against its formulas or its table, of |S| and of Im S. The
rocking of a tall building is the most affected: its resonance is governed by Im S."""
LEFT = 0.01
"""What the ground may leave of its motion between two buildings, in parts of the least gap."""
SWING_AT_END = "pounding.swing_at_end"
SWING = 0.5
"""Largest displacement in the last period of a run over the largest of all. Two neighbours that
swing against each other by half of it come as near as one of them did with all of it."""
PENETRATION = 0.5
"""Largest penetration in parts of the gap."""
STRENGTH = 1.0
"""Largest stress in parts of the strength with which linear analysis is still meant."""
APART = 0.2
"""Largest relative difference of the frequencies of a stick and a 3D model.

Sections taken as cracked have half the stiffness (EN 1998-1, 4.3.1(7)) and so a frequency 29 %
lower: models that differ in this, or in a factor or a unit, are told from models that differ in
mesh, rigid zones and joints."""


def facing_checks(folder: Path, case: Case) -> list[Check]:
    """Whether floors that face each other and are in no pair stay apart, as far as it is known."""
    checks: list[Check] = [(None, line) for line in facing_floors(case).unknown_lines]
    with open_store(folder / "pounding.nc") as store:
        if "facing" not in store.dims:
            return checks
        nearest = store.isel(facing=store["facing_distance_min"].argmin("facing"))
        count = int((store["facing_distance_min"] < 0.0).sum())
        names = f"{nearest['facing_a'].item()} and {nearest['facing_b'].item()}"
        by = f"{1e3 * abs(float(nearest['facing_distance_min'])):.4g} mm"
        at = f"{float(nearest['facing_time']):.4g} s"
        if count:
            more = f", and {count - 1} more do" if count > 1 else ""
            text = (
                f"facing floors: {names} overlap by {by} at {at} and are in no pair{more} "
                "(tables/facing_floors.csv); list them in [[contacts]]"
            )
        else:
            text = (
                f"facing floors: {store.sizes['facing']} in no pair keep apart; the nearest, "
                f"{names}, by {by} at {at}"
            )
    return [(not count, text), *checks]


def distance_check(
    names: Sequence[str], gaps: Sequence[float], distances: Sequence[float]
) -> list[Check]:
    """The check that the points of the pairs are their gaps apart; a computation takes the gaps.

    Names of the pairs, their gaps as given [m], and the distances of their points along the normals
    [m], nan where they are not known. No check where none is.
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
        count = f"{len(known)} pair{'s' if len(known) > 1 else ''}"
        return [(True, f"contact: {count}, the gap equals the geometry")]
    name, gap, distance = max(off, key=lambda one: abs(one[2] - one[1]))
    text = (
        f"contact: the points of {name} are {distance:.4g} m apart along the normal by axis and "
        f"offset, and its gap is {gap:.4g} m; the gap counts"
    )
    others = len(off) - 1
    return [(False, f"{text}; so it is for {others} more" if others else text)]


def soil_checks(building: str, errors: Sequence[float], band: str) -> list[Check]:
    """Check the errors of the model of the soil under a building in a band of frequencies.

    Errors of the stiffness, over |S|, and of the damping, over Im S.
    """
    checks = []
    for error, limit, what, of, affected in zip(
        errors,
        (SOIL_STIFFNESS, SOIL_DAMPING),
        ("stiffness", "damping"),
        ("|S|", "Im S"),
        ("frequencies of the building", "heights of its resonances"),
        strict=True,
    ):
        text = f"soil: {what} of the model of the soil of {building}, largest error {band},"
        met, text = limited(text, error, limit, f"% of {of}")
        if not met:
            text += (
                ": no springs, dashpots and masses have these impedances (tables/soil.csv of a "
                f"run has each component). The error affects the {affected}. Compare with a run "
                'with model = "cone" in [buildings.soil] for a long or embedded raft; a soil '
                "layer that resonates has no such model"
            )
        checks.append((met, text))
    return checks


def stick_checks(
    folder: Path, points_per_impact: int, tolerances: Mapping[str, float]
) -> list[Check]:
    """The checks of `pounding.nc`, with the least number of steps that is required of an impact.

    The tolerances are the largest relative differences from a published value that count as
    reproduced, by the name of the result; empty for a case without a reference.
    """
    with open_store(folder / "pounding.nc") as store:
        scalars = scalars_of(store)
        values = {s.name: s.value for s in scalars if s.value is not None}
        swinging = next((s.note for s in scalars if s.name == SWING_AT_END), "")
        pairs = [store[f"pair{of}"].values.tolist() for of in ("", "_rest_gap", "_distance")]
        restitution = store["impact_restitution"].dropna("impact").values.tolist()
        # With fewer steps an impact the speeds before and after say nothing.
        if values.get("pounding.steps_per_impact_min", 0.0) < points_per_impact:
            restitution = []
        moving = store["pfa"].where(store["pfa"] > QUIET * store["pfa"].max())
        ratio = store["psa"].isel(damping=0, frequency=-1) / moving
        ended = end_check(
            "pounding",
            names_of(store, "station"),
            names_of(store, "direction"),
            ratio.transpose("station", "direction").values,
            float(store["frequency"][-1]),
            jumps=begins_with_jump(store),
        )
        return [
            *_motions(scalars),
            *_passage(values, pairs[1]),
            *distance_check(*pairs),
            *_calibration(store, values, tolerances),
            *_impacts(values, restitution),
            *_accuracy(store, values, points_per_impact, swinging),
            ended,
            *_linearity(values),
            *_foundations(store, values),
        ]


def _motions(scalars: Sequence[Scalar]) -> list[Check]:
    """A reviewer's criteria, and whether synthetic motions are not scaled away from targets."""
    criteria = {
        s.name.removeprefix("motion.").replace("acceptance.", ""): s
        for kind in (".acceptance.", ".correlation.")
        for s in scalars
        if kind in s.name
    }
    missed = [
        f"{name.replace('_', ' ')} {digits(s.value or 0.0)} ({s.note.removeprefix('missed: ')})"
        for name, s in criteria.items()
        if s.note.startswith("missed")
    ]
    synthetic = any(".acceptance." in s.name for s in criteria.values())
    what = f"SRP 3.7.1{'' if synthetic else ', independence of the components alone'}"
    text = (
        f"motion: {what} (for information): {len(criteria) - len(missed)} of "
        f"{len(criteria)} criteria met{'; not met: ' if missed else ''}{', '.join(missed)}"
    )
    # No limit, as no case asks for these.
    lines: list[Check] = [(None, text)] if criteria else []
    for kind, words, (low, high) in (
        ("over_target", "spectrum", TARGET),
        ("pga_over_target", "peak ground acceleration", PEAK),
    ):
        for one in scalars:
            of, _, last = one.name.rpartition(".")
            if of.startswith("motion") and last == kind and one.value is not None:
                text = (
                    f"{of}: its {words} is {digits(100.0 * one.value)} % of the target's, "
                    f"{one.note} (at least {100 * low:g} %, at most {100 * high:g} %)"
                )
                lines.append((low <= one.value <= high, text))
    return lines


def _changed(values: Mapping[str, float], name: str, text: str) -> Check:
    """What fewer points of contact or longer steps change in 3D pounding.

    Peak accelerations have no limit: without a law they grow as steps become shorter.
    """
    met = True
    for what, words in (
        ("force", " the largest force by"),
        ("mean_force", ", the largest mean over 5 ms by"),
        ("frs", ", the largest ordinates of floor spectra by up to"),
    ):
        change = values[f"pounding.{name}_{what}_change"]
        good, text = limited(f"{text}{words}", change, HALVED, "%")
        met = met and bool(good)
    change = values[f"pounding.{name}_pfa_change"]
    return met, f"{text}, the accelerations of floors by up to {digits(100 * change)} %"


def _passage(values: Mapping[str, float], gaps: Sequence[float]) -> list[Check]:
    """When waves reach each building, and what motions that do not end at rest do to its gaps."""
    lines: list[Check] = []
    least = min((gap for gap in gaps if gap > 0.0), default=math.inf)
    prefix = "motion.passage."
    names = [name.removeprefix(prefix) for name in values if name.startswith(prefix)]
    for building in dict.fromkeys(name.rpartition(".")[0] for name in names):
        delay, apart, left = (
            1e3 * values[f"{prefix}{building}.{of}"] for of in ("delay", "apart", "left")
        )
        text = (
            f"ground: waves reach {building} {abs(delay):.3g} ms "
            f"{'later' if delay > 0.0 else 'sooner'} than the first building; the ground under it "
            f"moves up to {apart:.3g} mm from that, and {left:.2g} mm are left at the end"
        )
        # Without a gap that is open at rest there is nothing to compare with.
        met = left <= 1e3 * LEFT * least if math.isfinite(least) else None
        if met is False:
            text += ", which changes gaps: baseline = 'rest' of [[motions]] takes it out"
        lines.append((met, text))
    return lines


def _calibration(
    store: xr.Dataset, values: Mapping[str, float], tolerances: Mapping[str, float]
) -> list[Check]:
    """What was fitted, and how near it comes; no limit without a tolerance for each target."""
    if "sticks.stiffness_factor" not in values:
        return []
    heights = [v for name, v in values.items() if name.startswith("sticks.storey_height.")]
    factor = values["sticks.stiffness_factor"]
    times, off = (1.0 / factor, "stiff") if factor < 1.0 else (factor, "soft")
    fitted = (
        f"sticks fitted: storey stiffness x {factor:.3g} (floor table {times:.3g} times too {off}),"
        f" rigid zones {round(values['sticks.rigid_below'], 6):.3g} m below and "
        f"{round(values['sticks.rigid_above'], 6):.3g} m above the mass centres, "
        f"storey heights {', '.join(f'{h:.3g}' for h in heights)} m"
    )
    text = (
        "sticks: largest error of a target frequency "
        f"{100 * values['sticks.frequency_error_max']:.2g} %"
    )
    if "sticks.mass_error_max" in values:
        text += f", of an effective mass {100 * values['sticks.mass_error_max']:.2g} %"
    errors: dict[str, float] = {}
    for kind in ("frequency", "effective_mass") if "target" in store.dims else ():
        error = abs(store[f"calibrated_{kind}"] / store[f"target_{kind}"] - 1.0)
        # A target table may leave a mass out.
        for one in error.dropna("target"):
            building, mode = one["target_building"].item(), one["target_mode"].item()
            errors[f"sticks.{building}.{kind}.{mode}"] = float(one)
    if not errors or any(name not in tolerances for name in errors):
        return [(None, fitted), (None, text)]
    missed = [
        limited(name, error, tolerances[name], "%")[1]
        for name, error in errors.items()
        if error > tolerances[name]
    ]
    within = "(limits: the tolerances of the case's reference)"
    if missed:
        within += f"; beyond: {', '.join(missed)}"
    return [(None, fitted), (not missed, f"{text} {within}")]


def _impacts(values: Mapping[str, float], restitution: list[float]) -> list[Check]:
    required = values.get("pounding.required_separation")
    apart = "" if required is None else f"; a gap of {100 * required:.3g} cm would prevent contact"
    if "pounding.main_impact_time" not in values:
        return [(None, f"pounding: no impact{apart}")]
    # Not one of those by floor: these are of the first building alone.
    force = values["pounding.main_impact_force"]
    lines: list[Check] = [
        (
            None,
            f"pounding: {values['pounding.impacts']:.0f} impacts, the largest with "
            f"{force / 1e6:.4g} MN at {values['pounding.main_impact_time']:.4g} s for "
            f"{1e3 * values['pounding.main_impact_duration']:.3g} ms{apart}",
        )
    ]
    # Above 1 the buildings' own forces part the floors, not the impact; below 0 the places that
    # touch have parted, and the middles of floors that turn have not.
    meant = [one for one in restitution if 0.0 <= one <= 1.0]
    if meant:
        main = values.get("pounding.main_impact_restitution", math.inf)
        largest = f"{main:.3g} in the largest impact, " if 0.0 <= main <= 1.0 else ""
        of = f"{len(meant)} of {len(restitution)}" if len(meant) < len(restitution) else "all"
        text = f"pounding: effective restitution {largest}{min(meant):.3g} to {max(meant):.3g}"
        lines.append((None, f"{text} in {of} (the buildings' own forces act meanwhile)"))
    for count, text in (
        (sum(one > 1.0 for one in restitution), "the buildings' own forces part the floors"),
        (sum(one < 0.0 for one in restitution), "the middles of floors that turn still approach"),
    ):
        if count:
            lines.append((None, f"pounding: in {count} impacts {text}: no restitution"))
    return lines


def _accuracy(
    store: xr.Dataset, values: Mapping[str, float], required: int, swinging: str
) -> list[Check]:
    """Rest at the end, energy, steps in an impact, the time stepping in contact, spectra."""
    lines: list[Check] = []
    if SWING_AT_END in values and store["pair"].size:
        text = f"pounding: in the last period of the run {swinging} still moves by"
        swing = values[SWING_AT_END]
        met, text = limited(text, swing, SWING, "% of its largest displacement")
        if not met:
            text += "; what comes after it is not computed: see duration of [pounding]"
        lines.append((met, text))
    residual = values["pounding.energy_residual"]
    lines.append(limited("energy: discrete identity", residual, IDENTITY))
    if "pounding.steps_per_impact_min" in values:
        steps = values["pounding.steps_per_impact_min"]
        # Unilateral contact has no law that could take anything: its larger impacts count.
        unilateral = "pounding.contact_energy_defect" not in values
        of = "in the larger impacts" if unilateral else "per impact of two free floors"
        met, text = limited(f"steps: {of}", steps, required, least=True)
        fewest = values["pounding.steps_per_impact_observed"]
        if fewest < required and not unilateral:
            force = store["impact_peak_force"]
            short = force.isel(impact=store["impact_steps"].argmin("impact")) / force.max()
            text += (
                f"; {fewest:.0f} in the shortest contact, of {100.0 * float(short):.2g} % of the "
                "largest force, which other forces end: its error is in that of the energy below"
            )
        lines.append((met, text))
    if "pounding.contact_points" in values:
        text = f"contact: {values['pounding.contact_points']:.0f} points in 3D"
        if "pounding.halved_force_change" not in values:
            lines.append((None, f"{text}; what half of them change is not known: {UNKNOWN}"))
        else:
            lines.append(_changed(values, "halved", f"{text}; half of them change"))
    if "pounding.doubled_step_force_change" in values:
        lines.append(_changed(values, "doubled_step", "contact: steps twice as long change"))
    elif "pounding.complementarity" in values:
        what = "contact: what steps twice as long change is not known"
        lines.append((None, f"{what}: {UNKNOWN}"))
    if "pounding.complementarity" in values:
        error = values["pounding.complementarity"]
        lines.append(limited("contact: complementarity", error, COMPLEMENTARITY))
    if "pounding.contact_energy_defect" in values:
        lost = values["pounding.contact_energy_defect"]
        text = f"{digits(lost)} of the largest kinetic energy"
        defect = float(abs(store["impact_defect"]).sum())
        by_laws = float((store["impact_dissipated"] - store["impact_defect"]).sum())
        # An elastic law takes nothing but round-off.
        if by_laws <= IDENTITY * defect:
            lines.append((None, f"energy: time stepping in contact takes {text}"))
        else:
            share = "energy: error of time stepping in contact, signs left out,"
            met, share = limited(share, defect / by_laws, DEFECT, "% of what the laws take")
            lines.append((met, f"{share}; in sum it takes {text}"))
    points, bound = values["frs.points_per_cycle"], values["frs.peak_error_bound"]
    text = f"spectra: {points:.3g} points in a cycle of the highest frequency, peaks low by"
    return [*lines, limited(text, bound, BETWEEN, "%")]


def begins_with_jump(store: xr.Dataset) -> bool:
    """Whether the force of a pair of `pounding.nc` begins with a jump."""
    return "pair" in store.dims and bool((store["pair_onset_force"] > 0.0).any())


def _foundations(store: xr.Dataset, values: Mapping[str, float]) -> list[Check]:
    """How far each building on soil is from one that lifts, and its model from the soil."""
    lines: list[Check] = []
    for name in names_of(store, "foundation") if "foundation" in store.dims else ():
        off = [values[f"soil.{name}.{of}_error"] for of in ("stiffness", "damping")]
        band = "from the first frequency on soil to twice the first one clamped"
        x, y = (100 * (values[f"soil.{name}.period_ratio.{axis}"] - 1.0) for axis in "xy")
        text = (
            f"soil: first periods of the stick of {name} longer than clamped by {x:.3g} % (x) and "
            f"{y:.3g} % (y)"
        )
        least = values[f"soil.{name}.least_pressure_ratio"]
        lift = (
            f"soil: least pressure under the raft of {name} {100 * least:.3g} % of that by gravity"
        )
        if least < 0.0:
            lift += ": it would lift, and linear analysis overrates the soil there"
        lines += [(None, text), *soil_checks(name, off, band), (least >= 0.0, lift)]
    return lines


def _linearity(values: Mapping[str, float]) -> list[Check]:
    """Whether linear analysis is still meant; no limit where the material has no strength."""
    lines: list[Check] = []
    if "pounding.penetration_over_gap" in values:
        over = values["pounding.penetration_over_gap"]
        lines.append(limited("contact: penetration", over, PENETRATION, "% of the gap"))
    shear = (
        f"storey shear in impacts up to {values.get('pounding.storey_shear_max', 0) / 1e6:.3g} MN"
    )
    of_frames = (
        " (on the shear areas of the sticks; no stress where these stand for the bending of a "
        "frame)"
    )
    for name, ratio, kind, before, after in (
        ("bearing_pressure", "bearing_ratio", "compressive", "mean bearing pressure", ""),
        ("shear_stress", "cracking_ratio", "tensile", f"{shear}, shear stress up to", of_frames),
    ):
        if f"pounding.{name}_max" not in values:
            continue
        text = f"linear analysis: {before} {values[f'pounding.{name}_max'] / 1e6:.3g} MPa"
        met, ratio_of = None, values.get(f"pounding.{ratio}_max")
        if ratio_of is not None:
            met, text = limited(f"{text} =", ratio_of, STRENGTH, f"% of the {kind} strength")
        lines.append((met, text + after))
    return lines


def stick_against_model(folder: Path, stage: str = "transient") -> list[Check]:
    """The check of the fundamental modes along the shown direction, as a line of a stage.

    Nothing fits a stick to the 3D model unless the case asks for it. One that is too stiff or too
    soft hits at other times and with other speeds than the building that its forces are put on.
    There is none for a vertical direction, along which nothing bends.
    """
    with open_stores(folder) as opened:
        building, sticks = opened("building.nc"), opened("pounding.nc")
        name, direction = str(building.attrs["building"]), str(sticks.attrs["shown_direction"])
        if direction == "z":
            return []
        # The most mass, not the lowest: a mode that twists may be lower, and moves some mass, too.
        mass = building["effective_mass"].sel(direction=direction)
        model = float(building["frequency"].isel(mode=mass.argmax("mode")))
        one = sticks.sel(building=name, mode_direction=direction)
        main = one["mode_effective_mass"].argmax("mode")
        stick = float(one["mode_frequency"].isel(mode=main))
        forces = "impact forces are those" if sticks.sizes.get("impact") else "stick is that"
    off = stick / model - 1.0
    text = (
        f"{stage}: {name} along {direction}, stick {stick:.3g} Hz, 3D model {model:.3g} Hz: "
        "difference"
    )
    met, text = limited(text, abs(off), APART, "%")
    if not met:
        text += (
            f"; the {forces} of another building than the 3D model: give the stick the "
            "stiffness of the 3D model, as a [calibration] with from_structure = true does"
        )
    return [(met, text)]
