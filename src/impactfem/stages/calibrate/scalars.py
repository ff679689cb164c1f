"""The scalar results of the stage `calibrate`, by the names of `summary.json`."""

from __future__ import annotations

from impactfem.stages.calibrate.compute import CalibrationStudy, DampedRun
from impactfem.stages.calibrate.impact import WallImpact
from impactfem.system.scalar import Scalar


def calibration_scalars(study: CalibrationStudy) -> list[Scalar]:
    """All scalars of the stage."""
    top = f"floor {study.prepared.experiment.floors[-1]}"
    main, impact = study.main, study.main.impacts[-1].first_complete()
    return [
        Scalar("calibration.impact_time", impact.start, "s", f"first impact, {top}"),
        Scalar("calibration.impact_duration", impact.duration, "s", top),
        Scalar("calibration.impulse", impact.largest_impulse, "N s", top),
        Scalar("calibration.approach_velocity", impact.approach, "m/s", f"mass centre, {top}"),
        Scalar(
            "calibration.epsilon",
            main.penalty.epsilon,
            "-",
            f"by the impulse: equation 5 of Bodnar et al. 2022, {top}",
        ),
        Scalar("calibration.xi_c", main.penalty.xi_c, "-", "by ε: equation 4"),
        Scalar("calibration.K_Ceq", main.penalty.K_Ceq, "N/m", "by ε and the duration: equation 6"),
        Scalar("calibration.peak_force", impact.peak_force, "N", top),
        *_energy(main, impact),
        *_floors(study),
        *_stick(study),
        *_solver(study),
        *_dampings(study),
    ]


def _energy(main: DampedRun, impact: WallImpact) -> list[Scalar]:
    energy = main.run.contact.energy
    first, last = impact.first - 1, impact.last
    damped = float(energy.damped[last] - energy.damped[first])
    damped += float(energy.numerical[last] - energy.numerical[first])
    contact = float(energy.contact[first] - energy.contact[last])
    return [
        Scalar(
            "calibration.energy_dissipated",
            damped + contact,
            "J",
            "by the damping of the building and the contact, during the first impact",
        ),
        Scalar(
            "calibration.energy_dissipated.contact",
            contact,
            "J",
            "of that: the energy of the contact nodes, which falls with mesh and step",
        ),
    ]


def _floors(study: CalibrationStudy) -> list[Scalar]:
    scalars = []
    for found in study.main.impacts:
        first = found.impacts[0] if found.impacts else None
        name = f"calibration.floor_{found.floor}"
        note = "" if first else f"no impact; nearest {1e3 * found.closest:.4g} mm"
        scalars += [
            Scalar(f"{name}.impacts", float(found.number), "-", note),
            Scalar(f"{name}.impact_time", first.start if first else None, "s", note),
            Scalar(f"{name}.impact_duration", first.duration if first else None, "s", note),
            Scalar(f"{name}.impulse", first.largest_impulse if first else None, "N s", note),
        ]
    return scalars


def _stick(study: CalibrationStudy) -> list[Scalar]:
    comparison = study.comparison
    second, own = comparison.stick.second, comparison.model.second
    none = "no second impact within the window"
    return [
        Scalar("calibration.stick_delay", comparison.delay, "s", "of the stick's first impact"),
        Scalar(
            "calibration.second_impulse",
            second.largest_impulse if second else None,
            "N s",
            "of the stick" if second else f"{none}, stick",
        ),
        Scalar(
            "calibration.second_impact_time",
            second.start if second else None,
            "s",
            "of the stick" if second else f"{none}, stick",
        ),
        Scalar(
            "calibration.second_impulse_3d",
            own.largest_impulse if own else None,
            "N s",
            "of the 3D model" if own else f"{none}, 3D model",
        ),
        Scalar("calibration.stick_impulse_ratio", comparison.impulse_ratio, "-", "stick over 3D"),
        Scalar("calibration.stick_duration_ratio", comparison.duration_ratio, "-", "stick over 3D"),
        Scalar(
            "calibration.rebound_overshoot",
            comparison.rebound_overshoot,
            "-",
            "displacement of the stick after the impact over that of the 3D model, less 1",
        ),
        Scalar(
            "calibration.return_overshoot",
            comparison.return_overshoot,
            "-",
            "the same on its return to the wall",
        ),
    ]


def _solver(study: CalibrationStudy) -> list[Scalar]:
    contact, experiment = study.main.run.contact, study.prepared.experiment
    return [
        Scalar("calibration.basis_vectors", float(len(study.model.eigenvalue)), "-"),
        Scalar("calibration.basis_error", study.model.difference, "-", "transfer functions"),
        Scalar(
            "calibration.start_unevenness",
            study.model.uneven,
            "-",
            f"largest departure of the slab of floor {experiment.displaced_floor} from its "
            f"displacement before the release, over it; pull = {experiment.pull}",
        ),
        Scalar("calibration.constraints", float(len(study.model.floor_of)), "-"),
        Scalar("calibration.complementarity", float(contact.residual.max()), "-", "residual"),
        Scalar("calibration.penetration", float(contact.penetration.max()), "m"),
        Scalar("calibration.energy_residual", contact.energy.residual, "-"),
        Scalar("calibration.energy_gained", contact.energy.gained, "-", "by the contact"),
    ]


def _dampings(study: CalibrationStudy) -> list[Scalar]:
    scalars = []
    for one in study.cases[1:]:
        note = f"α = {one.damping.alpha:.4g} 1/s, β = {one.damping.beta:.4g} s"
        scalars += [
            Scalar(f"calibration.epsilon.{one.name}", one.penalty.epsilon, "-", note),
            Scalar(f"calibration.K_Ceq.{one.name}", one.penalty.K_Ceq, "N/m", note),
        ]
    return scalars
