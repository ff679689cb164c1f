"""The store of the stage, `calibrate.nc`, and its scalars by the names of `summary.json`.

Displacements and velocities are those of the mass centres, positive towards the wall; forces push
the floors away from it. What begins with `stick_` is of the stick, the rest of the 3D model.
"""

import math
from pathlib import Path
from typing import Any

import numpy as np

from impactfem.stages.calibrate.compute import CalibrationStudy
from impactfem.stages.calibrate.experiment import WallHistory
from impactfem.stages.stores import Output, damping_outputs, damping_values, dataset
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar

OUTPUTS = {
    "time": Output("time", "s"),
    "floor": Output("floor", "", "number of a floor that may hit"),
    "floor_mass": Output("floor", "kg"),
    "displacement": Output("time floor", "m"),
    "velocity": Output("time floor", "m/s"),
    "force": Output("time floor", "N"),
    "opening": Output("time floor", "m", "distance of the wall from the nearest point"),
    "stick_displacement": Output("time floor", "m"),
    "stick_velocity": Output("time floor", "m/s"),
    "stick_force": Output("time floor", "N"),
    "stick_opening": Output("time floor", "m", "distance of the wall from the nearest point"),
    "kinetic_energy": Output("time", "J"),
    "elastic_energy": Output("time", "J"),
    "damped_energy": Output("time", "J", "taken by damping so far"),
    "numerical_energy": Output("time", "J", "taken by the time stepping so far"),
    "contact_work": Output("time", "J", "done by the contact so far"),
    "complementarity": Output("time", "-", "residual of the contact condition"),
    "constraint_floor": Output("constraint", "", "number of its floor", label=True),
    "constraint_position": Output("constraint", "m", "along the edge"),
    "constraint_length": Output("constraint", "m", "that it stands for"),
    "step": Output("step", "s", "times of the first impact"),
    "constraint_force": Output("step constraint", "N"),
    "case": Output("case", "", "damping, that of the building first"),
    **damping_outputs("case"),
    "epsilon": Output("case", "-", "restitution by equation 5"),
    "xi_c": Output("case", "-", "damping ratio of the contact by equation 4"),
    "K_Ceq": Output("case", "N/m", "stiffness of the contact by equation 6"),
    "impact_time": Output("case", "s", "first impact of the top floor"),
    "impact_duration": Output("case", "s", "of the same impact"),
    "impulse": Output("case", "N s", "of the same impact, the largest on its way"),
    "approach_velocity": Output("case", "m/s", "before the same impact"),
}


def write_calibration(path: Path, study: CalibrationStudy, key: str) -> None:
    """Write `calibrate.nc`; the key is the hash of the inputs of the stage."""
    prepared, cases, structure = study.prepared, study.cases, study.case.structure
    experiment, contact = prepared.experiment, cases[0].run.contact
    impacts = [case.impacts[-1].first_complete() for case in cases]
    # Forces of the constraints matter, and are not zero, in the first impact only.
    near = slice(max(0, impacts[0].first - 5), impacts[0].last + 6)
    floors = np.array(experiment.floors)
    values = {
        "time": contact.time,
        "floor": floors,
        "floor_mass": prepared.mass,
        **_histories(cases[0].run.history, ""),
        **_histories(study.stick, "stick_"),
        "kinetic_energy": contact.energy.kinetic,
        "elastic_energy": contact.energy.elastic,
        "damped_energy": contact.energy.damped,
        "numerical_energy": contact.energy.numerical,
        "contact_work": contact.energy.contact,
        "complementarity": contact.residual,
        "constraint_floor": floors[study.model.floor_of],
        "constraint_position": prepared.position,
        "constraint_length": prepared.length,
        "step": contact.time[near],
        "constraint_force": contact.force[near],
        "case": [case.name for case in cases],
        **damping_values([case.damping for case in cases]),
        **{
            name: [getattr(c.penalty, name) for c in cases] for name in ("epsilon", "xi_c", "K_Ceq")
        },
        "impact_time": [impact.start for impact in impacts],
        "impact_duration": [impact.duration for impact in impacts],
        "impulse": [impact.largest_impulse for impact in impacts],
        "approach_velocity": [impact.approach for impact in impacts],
    }
    attributes = {
        "title": study.case.title,
        "inputs": key,
        "case_hash": study.case.content_hash(),
        "building": structure.building if structure else "",
        "side": experiment.side,
        "gap": experiment.gap,
        "separation": experiment.separation,
        "displaced_floor": experiment.displaced_floor,
        "displacement_at_start": experiment.displacement,
        "pull": experiment.pull,
        "stick_contact_update": study.case.pounding.update,
    }
    scalars = calibration_scalars(study)
    write_netcdf(path, dataset(OUTPUTS, values, attributes=attributes, scalars=scalars))


def _histories(history: WallHistory, prefix: str) -> dict[str, Any]:
    names = ("displacement", "velocity", "force", "opening")
    return {f"{prefix}{name}": getattr(history, name) for name in names}


def calibration_scalars(study: CalibrationStudy) -> list[Scalar]:
    """All scalars of the stage."""
    main, experiment, model = study.cases[0], study.prepared.experiment, study.model
    impact, penalty, contact = main.impacts[-1].first_complete(), main.penalty, main.run.contact
    energy, comparison, top = contact.energy, study.comparison, f"floor {experiment.floors[-1]}"
    # From the last time before the first impact to its end.
    before, end = impact.first - 1, impact.last
    taken = energy.damped + energy.numerical
    by_contact = float(energy.contact[before] - energy.contact[end])
    dissipated = float(taken[end] - taken[before]) + by_contact
    again, again_3d = comparison.stick.second, comparison.model.second
    none = "no second impact within the window"
    of_stick = "of the stick" if again else f"{none}, stick"
    of_model = "of the 3D model" if again_3d else f"{none}, 3D model"
    by_equation_5 = f"by the impulse: equation 5 of Bodnar et al. 2022, {top}"
    lost = "by the damping of the building and the contact, during the first impact"
    at_nodes = "of that: the energy of the contact nodes, which falls with mesh and step"
    overshoot = "displacement of the stick after the impact over that of the 3D model, less 1"
    on_return = "the same on its return to the wall"
    unevenness = (
        f"largest departure of the slab of floor {experiment.displaced_floor} from its "
        f"displacement before the release, over it; pull = {experiment.pull}"
    )
    rows: list[tuple[str, float | None, str, str]] = [
        ("impact_time", impact.start, "s", f"first impact, {top}"),
        ("impact_duration", impact.duration, "s", top),
        ("impulse", impact.largest_impulse, "N s", top),
        ("approach_velocity", impact.approach, "m/s", f"mass centre, {top}"),
        ("epsilon", penalty.epsilon, "-", by_equation_5),
        ("xi_c", penalty.xi_c, "-", "by ε: equation 4"),
        ("K_Ceq", penalty.K_Ceq, "N/m", "by ε and the duration: equation 6"),
        ("peak_force", impact.peak_force, "N", top),
        ("energy_dissipated", dissipated, "J", lost),
        ("energy_dissipated.contact", by_contact, "J", at_nodes),
    ]
    for found in main.impacts:
        first = found.impacts[0] if found.impacts else None
        name = f"floor_{found.floor}"
        note = "" if first else f"no impact; nearest {1e3 * found.closest:.4g} mm"
        rows += [
            (f"{name}.impacts", float(found.number), "-", note),
            (f"{name}.impact_time", first.start if first else None, "s", note),
            (f"{name}.impact_duration", first.duration if first else None, "s", note),
            (f"{name}.impulse", first.largest_impulse if first else None, "N s", note),
        ]
    rows += [
        ("stick_delay", comparison.delay, "s", "of the stick's first impact"),
        ("second_impulse", again.largest_impulse if again else None, "N s", of_stick),
        ("second_impact_time", again.start if again else None, "s", of_stick),
        ("second_impulse_3d", again_3d.largest_impulse if again_3d else None, "N s", of_model),
        ("stick_impulse_ratio", comparison.ratio("largest_impulse"), "-", "stick over 3D"),
        ("stick_duration_ratio", comparison.ratio("duration"), "-", "stick over 3D"),
        ("rebound_overshoot", comparison.rebound_overshoot, "-", overshoot),
        ("return_overshoot", comparison.return_overshoot, "-", on_return),
        ("basis_vectors", float(len(model.eigenvalue)), "-", ""),
        ("basis_error", model.difference, "-", "transfer functions"),
        ("start_unevenness", model.uneven, "-", unevenness),
        ("constraints", float(len(model.floor_of)), "-", ""),
        ("complementarity", float(contact.residual.max()), "-", "residual"),
        ("penetration", float(contact.penetration.max()), "m", ""),
        ("energy_residual", energy.residual, "-", ""),
        ("energy_gained", energy.gained, "-", "by the contact"),
    ]
    for one in study.cases[1:]:
        α, β = one.damping.coefficients
        note = "" if math.isnan(α) else f"α = {α:.4g} 1/s, β = {β:.4g} s"
        rows += [
            (f"epsilon.{one.name}", one.penalty.epsilon, "-", note),
            (f"K_Ceq.{one.name}", one.penalty.K_Ceq, "N/m", note),
        ]
    return [Scalar(f"calibration.{name}", value, unit, note) for name, value, unit, note in rows]
