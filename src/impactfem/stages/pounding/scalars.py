"""The scalar results of the stage `pounding`, by the names of `summary.json`."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import combinations

import numpy as np

from impactfem.case import Case
from impactfem.coupling.force_history import PairEnds
from impactfem.coupling.impacts import largest_means
from impactfem.motion.acceptance import CORRELATION_LIMIT, pair_correlation
from impactfem.motion.from_case import GroundMotion
from impactfem.stages.pounding.compute import StickStudy
from impactfem.stages.pounding.foundation import DIRECTIONS
from impactfem.sticks.element import COMPONENTS
from impactfem.sticks.modes import Modes
from impactfem.sticks.stick import Stick
from impactfem.system.scalar import Scalar

Row = tuple[str, float | None, str, str]
"""Name, value, unit and note of a scalar."""
MEASURES = {
    "pga": ("pga", "m/s2"),
    "time_of_pga": ("time_of_pga", "s"),
    "pgv": ("pgv", "m/s"),
    "pgd": ("pgd", "m"),
    "arias_intensity": ("arias", "m/s"),
    "duration_5_95": ("duration_5_95", "s"),
    "end_velocity": ("end_velocity", "m/s"),
    "end_displacement": ("end_displacement", "m"),
}
"""Measures of a motion: attribute and unit by the name of the scalar."""
MAIN_IMPACT = {
    "force": ("peak_force", "N"),
    "time": ("peak_time", "s"),
    "duration": ("duration", "s"),
    "impulse": ("impulse", "N s"),
    "approach_velocity": ("approach", "m/s"),
    "restitution": ("restitution", "-"),
}
"""The same of the main impact."""
DEMANDS = {
    "bearing_pressure": "Pa",
    "bearing_ratio": "-",
    "storey_shear": "N",
    "shear_stress": "Pa",
    "cracking_ratio": "-",
}
"""What an impact asks of the buildings, with its unit."""
LARGEST = "of the largest values"
SHORT, LONG = 0.2, 2.0
"""Periods in which a motion stands for its target, in first periods of the buildings: EN 1998-1,
3.2.3.1.2(4)c."""


def stick_scalars(study: StickStudy) -> list[Scalar]:
    """All scalars of the stage.

    Names without a building are those of the first building of the case file, the one that is
    studied; `floor_k` in `pounding.*` stands for the pairs on its floor k.
    """
    modes = mode_rows(study.case, study.system.sticks, study.modes)
    parts = (_calibration, _pounding, _foundations, _checks, _spectra)
    others = (row for part in parts for row in part(study))
    return [Scalar(*row) for row in (*_motion(study), *modes, *others)]


def _motion(study: StickStudy) -> list[Row]:
    rows: list[Row] = []
    for index, motion in enumerate(study.motions):
        name = "motion" if index == 0 else f"motion.{motion.direction}"
        spectrum, origin = motion.spectrum, motion.accelerogram.origin
        largest = int(np.argmax(spectrum.psa[0, 0]))
        note = f"pseudo-acceleration at {spectrum.damping[0]:.3g} damping"
        rows += [
            (f"{name}.{of}", getattr(motion.measures, field), unit, origin if of == "pga" else "")
            for of, (field, unit) in MEASURES.items()
        ]
        rows += [
            (f"{name}.sa_max", float(spectrum.psa[0, 0, largest]), "m/s2", note),
            (f"{name}.sa_max_frequency", float(spectrum.frequency[largest]), "Hz", ""),
        ]
        if motion.misfit is not None:
            note = "computed over target spectrum at the matched frequencies"
            rows += [
                (f"{name}.misfit_rms", motion.misfit.rms, "-", f"{note}, less 1"),
                (f"{name}.misfit_largest", motion.misfit.largest_ratio, "-", note),
                (f"{name}.misfit_smallest", motion.misfit.smallest_ratio, "-", note),
                *_over_target(study, motion, name),
            ]
        for verdict in motion.acceptance.verdicts if motion.acceptance is not None else ():
            limit = f"{'at least' if verdict.at_least else 'at most'} {verdict.limit:g}"
            note = f"{'met' if verdict.passed else 'missed'}: {limit} is required"
            if math.isfinite(verdict.at):
                note += f"; at {verdict.at:.3g} Hz"
                matched = verdict.at if motion.misfit is None else motion.misfit.frequency[0]
                if verdict.at < matched * (1.0 - 1e-9):
                    note += f", below the {matched:.3g} Hz from which it was matched on"
            of = f"{name}.acceptance.{verdict.name}"
            rows.append((of, float(verdict.value), verdict.unit, note))
    for a, b in combinations(study.motions, 2):
        if a.accelerogram.time_step == b.accelerogram.time_step:
            rho = pair_correlation(a.accelerogram, b.accelerogram)
            word = "met" if abs(rho) <= CORRELATION_LIMIT else "missed"
            note = f"{word}: at most {CORRELATION_LIMIT:g} in size is required"
            rows.append((f"motion.correlation.{a.direction}_{b.direction}", rho, "-", note))
    delays, relative = study.case.delays, study.response.relative
    first = study.system.sticks[0].name
    for building, moved in relative.items():
        name, later = f"motion.passage.{building}", delays[building] - delays[first]
        left = later * math.hypot(*(one.measures.end_velocity for one in study.motions))
        apart = float(np.linalg.norm(moved[0], axis=1).max())
        note = f"largest way of the ground under it from that under {first}"
        rows += [
            (f"{name}.delay", later, "s", f"of the waves after {first}; negative: before it"),
            (f"{name}.apart", apart, "m", note),
            (f"{name}.left", abs(left), "m", "of it, by the velocity at the end"),
        ]
    return rows


def _over_target(study: StickStudy, motion: GroundMotion, name: str) -> list[Row]:
    """A synthetic motion over its target, where the buildings answer and at zero period."""
    direction, rows = motion.direction, list[Row]()
    firsts = [float(one.frequency[k]) for one in study.modes for k in one.of_family(direction)[:1]]
    if direction in DIRECTIONS:
        k = DIRECTIONS.index(direction)
        firsts += [float(one.frequency[k]) for one in study.foundations]
    if motion.misfit is not None and firsts:
        f, r = motion.misfit.frequency, motion.misfit.ratio
        meant = (f >= min(firsts) / LONG) & (f <= max(firsts) / SHORT)
        if meant.any():
            low, high = f[meant][[0, -1]]
            note = (
                f"mean from {low:.3g} Hz to {high:.3g} Hz, {SHORT:g} to {LONG:g} of the first "
                f"periods along {direction}"
            )
            rows.append((f"{name}.over_target", float(r[meant].mean()), "-", note))
    level = motion.target_pga
    if level is not None:
        note = f"{level:.4g} m/s2 at zero period"
        rows.append((f"{name}.pga_over_target", motion.measures.pga / level, "-", note))
    return rows


def mode_rows(case: Case, sticks: Iterable[Stick], modes: Iterable[Modes]) -> list[Row]:
    """Masses and modes of sticks along the direction of calibration or pounding; y for vertical."""
    direction = case.calibration.direction if case.calibration else case.shown_direction
    direction = direction if direction in DIRECTIONS else "y"
    axis, component = {"x": "y", "y": "x"}[direction], COMPONENTS.index(direction)
    rows: list[Row] = []
    for stick, found in zip(sticks, modes, strict=True):
        name = f"sticks.{stick.name}"
        for number, index in enumerate(found.of_family(direction)[:6], start=1):
            note = f"mode {number} of the family bending about e_{axis}, natural order"
            mass = float(found.effective_mass[component, index])
            rows += [
                (f"{name}.frequency.{number}", float(found.frequency[index]), "Hz", note),
                (f"{name}.effective_mass.{number}", mass, "kg", note),
            ]
        rows.append((f"{name}.mass", float(sum(floor.mass for floor in stick.floors)), "kg", ""))
    return rows


def _calibration(study: StickStudy) -> list[Row]:
    calibration = study.calibration
    if calibration is None:
        return []
    values = calibration.parameters
    how = "fitted to" if study.case.calibration and study.case.calibration.mode == "fit" else "of"
    note = f"{how} the case's targets; shared by the buildings of its table"
    frequency_error = float(np.max(np.abs(calibration.frequency_error)))
    mass_error = float(np.nanmax(np.abs(calibration.mass_error)))
    heights = enumerate(values.heights, start=1)
    return [
        ("sticks.stiffness_factor", values.factor, "-", f"on all storeys; {note}"),
        ("sticks.rigid_below", values.below, "m", note),
        ("sticks.rigid_above", values.above, "m", note),
        *((f"sticks.storey_height.{k}", float(height), "m", note) for k, height in heights),
        ("sticks.frequency_error_max", frequency_error, "-", ""),
        ("sticks.mass_error_max", mass_error, "-", ""),
    ]


def _pounding(study: StickStudy) -> list[Row]:
    system, response = study.system, study.response
    studied, rows = system.sticks[0], list[Row]()
    sides = PairEnds.of_pairs(system.pairs).sides(studied.name)
    for dofs, floor in zip(system.floor_dofs(studied.name), studied.floors, strict=True):
        touching = [
            columns
            for side, columns in sides.items()
            if side.floor == floor.number and side.relative_height is None
        ]
        name = f"floor_{floor.number}"
        peak = float(np.linalg.norm(response.absolute_acceleration[:, dofs[:3]], axis=1).max())
        force, depth = 0.0, 0.0
        if touching:
            force = max(float(response.force[:, j].sum(axis=1).max()) for j in touching)
            depth = max(0.0, *(float((-response.gap[:, j]).max()) for j in touching))
            rows += [
                (f"pounding.peak_force.{name}", force, "N", ""),
                (f"pounding.penetration.{name}", depth, "m", ""),
            ]
        rows.append((f"pounding.peak_acceleration.{name}", peak, "m/s2", "absolute, mass centre"))
        if force > 0.0:
            rows += [
                (f"pounding.force_over_acceleration.{name}", force / peak, "kg", LARGEST),
                (f"pounding.penetration_over_force.{name}", depth / force, "m/N", LARGEST),
            ]
    note = "top floor, relative to the ground under it"
    swings = list[tuple[float, str]]()
    on_soil = {one.building: float(one.frequency.min()) for one in study.foundations}
    for stick, modes in zip(system.sticks, study.modes, strict=True):
        top = system.floor_dofs(stick.name)[-1, :3]
        lowest = min(float(modes.frequency[0]), on_soil.get(stick.name, np.inf))
        last = response.time >= response.time[-1] - 1.0 / lowest
        for label, run in (("", response), ("_no_contact", study.free)):
            moved = run.u[:, top]
            if stick.name in run.relative:
                moved = moved - run.relative[stick.name][0]
            size = np.linalg.norm(moved, axis=1)
            peak = float(size.max())
            if run is response:
                # About its mean: a load that stays holds the building away from rest.
                swing = np.linalg.norm(moved[last] - moved[last].mean(axis=0), axis=1).max()
                swings.append((float(swing) / peak if peak > 0.0 else 0.0, stick.name))
            rows.append((f"pounding.peak_displacement{label}.{stick.name}", peak, "m", note))
    swing, name = max(swings)
    rows.append(("pounding.swing_at_end", swing, "-", name))
    main = study.main_impact
    note = f"pair {main.pair.name}" if main else "no impact"
    rows += [
        (f"pounding.main_impact_{name}", getattr(main, field) if main else None, unit, note)
        for name, (field, unit) in MAIN_IMPACT.items()
    ]
    return [*rows, ("pounding.impacts", float(len(study.impacts)), "-", "")]


def _foundations(study: StickStudy) -> list[Row]:
    rows: list[Row] = []
    for one in study.foundations:
        name, least = f"soil.{one.building}", float(one.pressure.min())
        for k, axis in enumerate(DIRECTIONS):
            note = f"first mode along {axis}"
            lengthened = float(one.clamped_frequency[k] / one.frequency[k])
            rows += [
                (f"{name}.frequency.{axis}", float(one.frequency[k]), "Hz", note),
                (f"{name}.period_ratio.{axis}", lengthened, "-", f"over clamped, {note}"),
                (f"{name}.damping.{axis}", float(one.ratio[k]), "-", f"soil included, {note}"),
            ]
        note = "of the underside, over that by gravity; negative: the raft would lift there"
        band = f"model of the soil, {one.band[0]:.3g} to {one.band[1]:.3g} Hz"
        rows += [
            (f"{name}.radiated", one.radiated, "J", "energy"),
            (f"{name}.least_pressure", least, "Pa", "of the underside; negative: tension"),
            (f"{name}.least_pressure_ratio", least / one.static_pressure, "-", note),
            (f"{name}.stiffness_error", float(one.stiffness_error.max()), "-", f"of |S|, {band}"),
            (f"{name}.damping_error", float(one.damping_error.max()), "-", f"of Im S, {band}"),
        ]
    return rows


def _checks(study: StickStudy) -> list[Row]:
    found, energy = study.impacts, study.response.energy
    steps = study.steps_of_law if found else None
    observed = float(min(impact.steps for impact in found)) if found else None
    separation = max((s.required for s in study.separations), default=None)
    of_law = (
        "shortest duration of the laws themselves over the step, with the effective masses of the "
        f"pairs, not with the mass of one floor; {study.case.pounding.points_per_impact} are "
        "required"
    )
    if study.unilateral:
        of_law = "fewest of the impacts with at least a tenth of the largest force"
    of_run = "fewest of an impact in the run; one that other forces cut short counts, too"
    apart = "largest approach of a pair without contact: the gap that would have prevented it"
    rows: list[Row] = [
        ("steps_per_impact_min", steps, "-", of_law),
        ("steps_per_impact_observed", observed, "-", of_run),
        ("energy_residual", energy.residual, "-", "of the discrete identity"),
        ("required_separation", separation, "m", apart),
    ]
    if study.peaks is not None:
        points = [point.line for point in study.response.exerted[0] if point.line]
        of_lines = f"{len(set(points))} lines along which 3D models touch"
        rows.append(("contact_points", float(len(points)), "-", of_lines))
        for name, other, how in (
            ("halved", study.halved, "about half of the points of contact"),
            ("doubled_step", study.doubled, "steps twice as long"),
        ):
            for what, of in (
                ("force", "force of a line"),
                ("mean_force", "mean over 5 ms of such a force"),
                ("frs", "floor spectral ordinate of each floor"),
                ("pfa", "acceleration of each floor"),
            ):
                change = None
                if other is not None and study.peaks.force > 0.0:
                    change = study.peaks.change(other, what)
                note = f"largest {of} with {how}, over that of the case, less 1"
                rows.append((f"{name}_{what}_change", change, "-", note))
    if study.unilateral:
        note = "of forces and speeds, over the largest speed"
        rows.append(("complementarity", study.response.residual, "-", note))
    if study.facing:
        nearest = min(study.facing, key=lambda approach: approach.distance)
        note = f"{nearest.facing.name}, in no contact pair; negative: one inside the other"
        rows.append(("facing_distance_min", nearest.distance, "m", note))
    if found:
        # Of unilateral contact there is none: what it takes is what the scheme takes.
        lost = sum(impact.defect for impact in found) / float(np.max(energy.kinetic))
        defect = None if study.unilateral else lost
        note = "energy that the time stepping lost in contact, over the largest kinetic energy"
        mean = float(largest_means(study.response.time, study.response.force).max())
        of_force = "largest mean over 5 ms of the force of a pair"
        over = max((i.penetration / i.pair.gap for i in found if i.pair.gap > 0.0), default=None)
        rows += [
            ("contact_energy_defect", defect, "-", note),
            ("penetration_over_gap", over, "-", "over the pairs with a gap"),
            ("mean_force_5ms", mean, "N", of_force),
        ]
    for name, unit in DEMANDS.items():
        values = [getattr(check, name) for check in study.checks]
        known = [value for value in values if np.isfinite(value)]
        if known:
            rows.append((f"{name}_max", max(known), unit, "over all impacts"))
    return [(f"pounding.{name}", value, unit, note) for name, value, unit, note in rows]


def _spectra(study: StickStudy) -> list[Row]:
    floors, free, s = study.floors, study.floors_free, study.floors.spectra
    studied, direction = study.system.sticks[0].name, study.case.shown_direction
    along = floors.directions.index(direction)
    note = f"direction {direction}, {study.case.spectra.damping[0]:.3g} damping, mass centre"
    rows: list[Row] = []
    for k, (building, number) in enumerate(study.stations):
        name = f"frs.floor_{number}" if building == studied else f"frs.{building}.floor_{number}"
        psa, pfa = floors.psa[0, k, along], float(floors.pfa[k, along])
        peak, frequency = float(psa.max()), float(s.frequency[psa.argmax()])
        rows += [
            (f"{name}.peak", peak, "m/s2", note),
            (f"{name}.peak_frequency", frequency, "Hz", note),
            (f"{name}.pfa", pfa, "m/s2", f"direction {direction}"),
            (f"{name}.peak_over_pfa", peak / pfa if pfa > 0.0 else None, "-", LARGEST),
            (f"{name}.pfa_no_contact", float(free.pfa[k, along]), "m/s2", ""),
            (f"{name}.peak_no_contact", float(free.psa[0, k, along].max()), "m/s2", note),
        ]
    resolved = study.resolved_frequency
    largest = floors.psa[0][..., s.frequency <= resolved * (1.0 + 1e-9)].max(axis=-1)
    at = np.unravel_index(int(largest.argmax()), largest.shape)
    building, number = study.stations[at[0]]
    note = f"{building}, floor {number}, direction {floors.directions[at[1]]}; of all floors"
    rows += [
        ("frs.largest", float(largest[at]), "m/s2", f"{note}, in the resolved band"),
        ("frs.resolved_frequency", resolved, "Hz", ""),
    ]
    how = f"at the highest frequency, {s.method}, records made {s.upsampling_factor} times finer"
    return [
        *rows,
        ("frs.points_per_cycle", s.points_per_cycle, "-", how),
        ("frs.peak_error_bound", s.peak_error_bound, "-", "loss of a peak by the samples"),
    ]
