"""The scalar results of the stage `pounding`, by the names of `summary.json`."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from impactfem.motion import CORRELATION_LIMIT, pair_correlation
from impactfem.stages.pounding.compute import StickStudy
from impactfem.sticks.element import COMPONENTS
from impactfem.system.scalar import Scalar

LARGEST = "of the largest values"


def stick_scalars(study: StickStudy) -> list[Scalar]:
    """All scalars of the stage.

    Names without a building are those of the first building of the case file, the one that is
    studied; `floor_k` in `pounding.*` stands for the pairs on its floor k.
    """
    return [
        *_motion(study),
        *_modes(study),
        *_calibration(study),
        *_pounding(study),
        *_checks(study),
        *_spectra(study),
    ]


def _motion(study: StickStudy) -> list[Scalar]:
    scalars = []
    for index, motion in enumerate(study.motions):
        name = "motion" if index == 0 else f"motion.{motion.direction}"
        spectrum = motion.spectrum
        largest = int(np.argmax(spectrum.psa[0, 0]))
        scalars += [
            Scalar(f"{name}.{measure}", getattr(motion.measures, field), unit, note)
            for measure, field, unit, note in (
                ("pga", "pga", "m/s2", motion.accelerogram.origin),
                ("time_of_pga", "time_of_pga", "s", ""),
                ("pgv", "pgv", "m/s", ""),
                ("pgd", "pgd", "m", ""),
                ("arias_intensity", "arias", "m/s", ""),
                ("duration_5_95", "duration_5_95", "s", ""),
                ("end_velocity", "end_velocity", "m/s", ""),
                ("end_displacement", "end_displacement", "m", ""),
            )
        ]
        note = f"pseudo-acceleration at {spectrum.damping[0]:.3g} damping"
        scalars += [
            Scalar(f"{name}.sa_max", float(spectrum.psa[0, 0, largest]), "m/s2", note),
            Scalar(f"{name}.sa_max_frequency", float(spectrum.frequency[largest]), "Hz"),
        ]
        if motion.misfit is not None:
            note = "computed over target spectrum at the matched frequencies"
            scalars += [
                Scalar(f"{name}.misfit_rms", motion.misfit.rms, "-", f"{note}, less 1"),
                Scalar(f"{name}.misfit_largest", motion.misfit.largest_ratio, "-", note),
                Scalar(f"{name}.misfit_smallest", motion.misfit.smallest_ratio, "-", note),
            ]
        if motion.acceptance is not None:
            scalars += [
                Scalar(
                    f"{name}.acceptance.{verdict.name}",
                    float(verdict.value),
                    verdict.unit,
                    f"{'met' if verdict.passed else 'missed'}: "
                    f"{'at least' if verdict.at_least else 'at most'} {verdict.limit:g} "
                    "is required",
                )
                for verdict in motion.acceptance.verdicts
            ]
    for a, b in combinations(study.motions, 2):
        if a.accelerogram.time_step == b.accelerogram.time_step:
            rho = pair_correlation(a.accelerogram, b.accelerogram)
            word = "met" if abs(rho) <= CORRELATION_LIMIT else "missed"
            note = f"{word}: at most {CORRELATION_LIMIT:g} in size is required"
            name = f"motion.correlation.{a.direction}_{b.direction}"
            scalars.append(Scalar(name, rho, "-", note))
    return scalars


def _modes(study: StickStudy) -> list[Scalar]:
    direction = study.case.calibration.direction if study.case.calibration else "y"
    axis = {"x": "y", "y": "x"}[direction]
    scalars = []
    for stick, result in zip(study.system.sticks, study.modes, strict=True):
        family = result.of_family(direction)
        for number, index in enumerate(family[:6], start=1):
            note = f"mode {number} of the family bending about e_{axis}, natural order"
            prefix = f"sticks.{stick.name}"
            mass = result.effective_mass[COMPONENTS.index(direction), index]
            scalars += [
                Scalar(f"{prefix}.frequency.{number}", float(result.frequency[index]), "Hz", note),
                Scalar(f"{prefix}.effective_mass.{number}", float(mass), "kg", note),
            ]
        total = float(sum(floor.mass for floor in stick.floors))
        scalars.append(Scalar(f"sticks.{stick.name}.mass", total, "kg"))
    return scalars


def _calibration(study: StickStudy) -> list[Scalar]:
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
        Scalar("sticks.stiffness_factor", values.factor, "-", f"on all storeys; {note}"),
        Scalar("sticks.rigid_below", values.below, "m", note),
        Scalar("sticks.rigid_above", values.above, "m", note),
        *(Scalar(f"sticks.storey_height.{k}", float(height), "m", note) for k, height in heights),
        Scalar("sticks.frequency_error_max", frequency_error, "-"),
        Scalar("sticks.mass_error_max", mass_error, "-"),
    ]


def _pounding(study: StickStudy) -> list[Scalar]:
    system, response = study.system, study.response
    studied = system.sticks[0]
    scalars = []
    for dofs, floor in zip(system.floor_dofs(studied.name), studied.floors, strict=True):
        at = (studied.name, floor.number, None)
        columns = [
            j
            for j, pair in enumerate(system.pairs)
            for end in (pair.a, pair.b)
            if end is not None and (end.building, end.floor, end.relative_height) == at
        ]
        name = f"floor_{floor.number}"
        peak = float(np.linalg.norm(response.absolute_acceleration[:, dofs[:3]], axis=1).max())
        force, depth = 0.0, 0.0
        if columns:
            force = float(response.force[:, columns].max())
            depth = float(max((-response.gap[:, columns]).max(), 0.0))
            scalars += [
                Scalar(f"pounding.peak_force.{name}", force, "N"),
                Scalar(f"pounding.penetration.{name}", depth, "m"),
            ]
        note = "absolute, mass centre"
        scalars.append(Scalar(f"pounding.peak_acceleration.{name}", peak, "m/s2", note))
        if force > 0.0:
            scalars += [
                Scalar(f"pounding.force_over_acceleration.{name}", force / peak, "kg", LARGEST),
                Scalar(f"pounding.penetration_over_force.{name}", depth / force, "m/N", LARGEST),
            ]
    for stick in system.sticks:
        top = system.floor_dofs(stick.name)[-1, :3]
        for label, run in (("", response), ("_no_contact", study.free)):
            peak = float(np.linalg.norm(run.u[:, top], axis=1).max())
            name = f"pounding.peak_displacement{label}.{stick.name}"
            scalars.append(Scalar(name, peak, "m", "top floor, relative to the ground"))
    main = study.main_impact
    note = f"pair {main.pair.name}" if main else "no impact"
    for name, field, unit in (
        ("force", "peak_force", "N"),
        ("time", "peak_time", "s"),
        ("duration", "duration", "s"),
        ("impulse", "impulse", "N s"),
        ("approach_velocity", "approach", "m/s"),
        ("restitution", "restitution", "-"),
    ):
        value = getattr(main, field) if main else None
        scalars.append(Scalar(f"pounding.main_impact_{name}", value, unit, note))
    return [*scalars, Scalar("pounding.impacts", float(len(study.impacts)), "-")]


def _checks(study: StickStudy) -> list[Scalar]:
    found, energy = study.impacts, study.response.energy
    steps = study.steps_of_law if found else None
    observed = float(min(impact.steps for impact in found)) if found else None
    required = max((s.required for s in study.separations), default=None)
    rows: list[tuple[str, float | None, str, str]] = [
        (
            "steps_per_impact_min",
            steps,
            "-",
            "shortest duration of the laws themselves over the step, with the effective masses of "
            f"the pairs, not with the mass of one floor; {study.case.pounding.points_per_impact} "
            "are required",
        ),
        (
            "steps_per_impact_observed",
            observed,
            "-",
            "fewest of an impact in the run; one that other forces cut short counts, too",
        ),
        ("energy_residual", energy.residual, "-", "of the discrete identity"),
        (
            "required_separation",
            required,
            "m",
            "largest approach of a pair without contact: the gap that would have prevented it",
        ),
    ]
    if study.facing:
        nearest = min(study.facing, key=lambda approach: approach.distance)
        note = f"{nearest.facing.name}, in no contact pair; negative: one inside the other"
        rows.append(("facing_distance_min", nearest.distance, "m", note))
    if found:
        defect = sum(impact.defect for impact in found) / float(np.max(energy.kinetic))
        note = "energy that the time stepping lost in contact, over the largest kinetic energy"
        rows.append(("contact_energy_defect", defect, "-", note))
        over = max((i.penetration / i.pair.gap for i in found if i.pair.gap > 0.0), default=None)
        rows.append(("penetration_over_gap", over, "-", "over the pairs with a gap"))
    for name, unit in (
        ("bearing_pressure", "Pa"),
        ("bearing_ratio", "-"),
        ("storey_shear", "N"),
        ("shear_stress", "Pa"),
        ("cracking_ratio", "-"),
    ):
        values = [getattr(check, name) for check in study.checks]
        known = [value for value in values if np.isfinite(value)]
        if known:
            rows.append((f"{name}_max", max(known), unit, "over all impacts"))
    return [Scalar(f"pounding.{name}", value, unit, note) for name, value, unit, note in rows]


def _spectra(study: StickStudy) -> list[Scalar]:
    floors, free = study.floors, study.floors_free
    studied = study.system.sticks[0].name
    direction = study.case.shown_direction
    along = floors.directions.index(direction)
    xi = study.case.spectra.damping[0]
    note = f"direction {direction}, {xi:.3g} damping, mass centre"
    scalars = []
    for k, (building, number) in enumerate(study.stations[: floors.pfa.shape[0]]):
        name = f"frs.floor_{number}" if building == studied else f"frs.{building}.floor_{number}"
        psa, pfa = floors.psa[0, k, along], float(floors.pfa[k, along])
        peak, frequency = float(psa.max()), float(floors.spectra.frequency[psa.argmax()])
        scalars += [
            Scalar(f"{name}.peak", peak, "m/s2", note),
            Scalar(f"{name}.peak_frequency", frequency, "Hz", note),
            Scalar(f"{name}.pfa", pfa, "m/s2", f"direction {direction}"),
            Scalar(f"{name}.peak_over_pfa", peak / pfa, "-", LARGEST),
            Scalar(f"{name}.pfa_no_contact", float(free.pfa[k, along]), "m/s2"),
            Scalar(f"{name}.peak_no_contact", float(free.psa[0, k, along].max()), "m/s2", note),
        ]
    s = floors.spectra
    how = f"at the highest frequency, {s.method}, records made {s.upsampling_factor} times finer"
    return [
        *scalars,
        Scalar("frs.points_per_cycle", s.points_per_cycle, "-", how),
        Scalar("frs.peak_error_bound", s.peak_error_bound, "-", "loss of a peak by the samples"),
    ]
