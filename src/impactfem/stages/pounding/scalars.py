"""The scalar results of the stage `pounding`, by the names of `summary.json`."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from impactfem.motion import CORRELATION_LIMIT, pair_correlation
from impactfem.stages.pounding.compute import StickStudy, station_dofs, steps_of_law
from impactfem.sticks.modes import DIRECTIONS
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
        m = motion.measures
        largest = int(np.argmax(motion.spectrum.psa[0, 0]))
        scalars += [
            Scalar(f"{name}.pga", m.pga, "m/s2", motion.accelerogram.origin),
            Scalar(f"{name}.time_of_pga", m.time_of_pga, "s"),
            Scalar(f"{name}.pgv", m.pgv, "m/s"),
            Scalar(f"{name}.pgd", m.pgd, "m"),
            Scalar(f"{name}.arias_intensity", m.arias, "m/s"),
            Scalar(f"{name}.duration_5_95", m.duration_5_95, "s"),
            Scalar(f"{name}.end_velocity", m.end_velocity, "m/s"),
            Scalar(f"{name}.end_displacement", m.end_displacement, "m"),
            Scalar(
                f"{name}.sa_max",
                float(motion.spectrum.psa[0, 0, largest]),
                "m/s2",
                f"pseudo-acceleration at {motion.spectrum.damping[0]:.3g} damping",
            ),
            Scalar(f"{name}.sa_max_frequency", float(motion.spectrum.frequency[largest]), "Hz"),
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
                    f"{'at least' if verdict.at_least else 'at most'} {verdict.limit:g} is asked",
                )
                for verdict in motion.acceptance.verdicts
            ]
    for a, b in combinations(study.motions, 2):
        if a.accelerogram.time_step == b.accelerogram.time_step:
            rho = pair_correlation(a.accelerogram, b.accelerogram)
            word = "met" if abs(rho) <= CORRELATION_LIMIT else "missed"
            note = f"{word}: at most {CORRELATION_LIMIT:g} in size is asked"
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
            mass = result.effective_mass[DIRECTIONS.index(direction), index]
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
    return [
        Scalar("sticks.stiffness_factor", values.factor, "-", f"on all storeys; {note}"),
        Scalar("sticks.rigid_below", values.below, "m", note),
        Scalar("sticks.rigid_above", values.above, "m", note),
        *(
            Scalar(f"sticks.storey_height.{k}", float(height), "m", note)
            for k, height in enumerate(values.heights, start=1)
        ),
        Scalar(
            "sticks.frequency_error_max", float(np.max(np.abs(calibration.frequency_error))), "-"
        ),
        Scalar("sticks.mass_error_max", float(np.nanmax(np.abs(calibration.mass_error))), "-"),
    ]


def _pounding(study: StickStudy) -> list[Scalar]:
    system, response = study.system, study.response
    studied = system.sticks[0]
    dofs = station_dofs(system)[: len(studied.floors)]
    scalars = []
    for k, floor in enumerate(studied.floors):
        columns = [
            j
            for j, pair in enumerate(system.pairs)
            for end in (pair.a, pair.b)
            if end is not None
            and (end.building, end.floor, end.relative_height) == (studied.name, floor.number, None)
        ]
        name = f"floor_{floor.number}"
        if columns:
            force = float(response.force[:, columns].max())
            depth = float(max((-response.gap[:, columns]).max(), 0.0))
            scalars += [
                Scalar(f"pounding.peak_force.{name}", force, "N"),
                Scalar(f"pounding.penetration.{name}", depth, "m"),
            ]
        peak = float(np.linalg.norm(response.absolute_acceleration[:, dofs[k, :3]], axis=1).max())
        scalars.append(
            Scalar(f"pounding.peak_acceleration.{name}", peak, "m/s2", "absolute, mass centre")
        )
        if columns and force > 0.0:
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
    values = (
        ("force", "peak_force", "N"),
        ("time", "peak_time", "s"),
        ("duration", "duration", "s"),
        ("impulse", "impulse", "N s"),
        ("approach_velocity", "approach", "m/s"),
        ("restitution", "restitution", "-"),
    )
    note = f"pair {main.pair.name}" if main else "no impact"
    return [
        *scalars,
        *(
            Scalar(
                f"pounding.main_impact_{name}",
                getattr(main, field) if main else None,
                unit,
                note,
            )
            for name, field, unit in values
        ),
        Scalar("pounding.impacts", float(len(study.impacts)), "-"),
    ]


def _checks(study: StickStudy) -> list[Scalar]:
    found = study.impacts
    asked = study.case.pounding.points_per_impact
    fewest = float(min(impact.steps for impact in found)) if found else None
    by_law = steps_of_law(study) if found else None
    required = max((s.required for s in study.separations), default=None)
    scalars = [
        Scalar(
            "pounding.steps_per_impact_min",
            by_law,
            "-",
            "shortest duration of the laws themselves over the step, with the effective masses of "
            f"the pairs, not with the mass of one floor; {asked} are asked",
        ),
        Scalar(
            "pounding.steps_per_impact_observed",
            fewest,
            "-",
            "fewest of an impact in the run; one that other forces cut short counts, too",
        ),
        Scalar("pounding.energy_residual", study.energy.residual, "-", "of the discrete identity"),
        Scalar(
            "pounding.required_separation",
            required,
            "m",
            "largest approach of a pair without contact: the gap that would have prevented it",
        ),
    ]
    if study.facing:
        nearest = min(study.facing, key=lambda approach: approach.distance)
        note = f"{nearest.facing.name}, in no contact pair; negative: one inside the other"
        scalars.append(Scalar("pounding.facing_distance_min", nearest.distance, "m", note))
    if found:
        stored = float(np.max(study.energy.kinetic))
        defect = sum(impact.defect for impact in found) / stored
        scalars += [
            Scalar(
                "pounding.contact_energy_defect",
                defect,
                "-",
                "energy that the time stepping lost in contact, over the largest kinetic energy",
            ),
            Scalar(
                "pounding.penetration_over_gap",
                max((i.penetration / i.pair.gap for i in found if i.pair.gap > 0.0), default=None),
                "-",
                "over the pairs with a gap",
            ),
        ]
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
            scalars.append(Scalar(f"pounding.{name}_max", max(known), unit, "over all impacts"))
    return scalars


def _spectra(study: StickStudy) -> list[Scalar]:
    floors, free = study.floors, study.floors_free
    f = floors.spectra.frequency
    studied = study.system.sticks[0].name
    direction = study.case.shown_direction
    column = floors.directions.index(direction)
    xi = study.case.spectra.damping[0]
    note = f"direction {direction}, {xi:.3g} damping, mass centre"
    scalars = []
    for k, (building, number) in enumerate(study.stations[: floors.pfa.shape[0]]):
        name = f"frs.floor_{number}" if building == studied else f"frs.{building}.floor_{number}"
        largest = int(np.argmax(floors.psa[0, k, column]))
        scalars += [
            Scalar(f"{name}.peak", float(floors.psa[0, k, column, largest]), "m/s2", note),
            Scalar(f"{name}.peak_frequency", float(f[largest]), "Hz", note),
            Scalar(f"{name}.pfa", float(floors.pfa[k, column]), "m/s2", f"direction {direction}"),
            Scalar(
                f"{name}.peak_over_pfa",
                float(floors.psa[0, k, column, largest] / floors.pfa[k, column]),
                "-",
                LARGEST,
            ),
            Scalar(f"{name}.pfa_no_contact", float(free.pfa[k, column]), "m/s2"),
            Scalar(f"{name}.peak_no_contact", float(free.psa[0, k, column].max()), "m/s2", note),
        ]
    s = floors.spectra
    return [
        *scalars,
        Scalar(
            "frs.points_per_cycle",
            s.points_per_cycle,
            "-",
            f"at the highest frequency, {s.method}, records made {s.upsampling_factor} times finer",
        ),
        Scalar("frs.peak_error_bound", s.peak_error_bound, "-", "loss of a peak by the samples"),
    ]
