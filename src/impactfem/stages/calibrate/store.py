"""The store of the stage: `calibrate.nc`.

Displacements and velocities are those of the mass centres, positive towards the wall; forces push
the floors away from it. What begins with `stick_` is of the stick, the rest of the 3D model.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from impactfem.stages.calibrate.compute import CalibrationStudy
from impactfem.stages.calibrate.history import WallHistory
from impactfem.stages.calibrate.scalars import calibration_scalars
from impactfem.stages.stores import Output, dataset
from impactfem.system.files import write_netcdf

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
    "mass_coefficient": Output("case", "1/s", "α of Rayleigh damping"),
    "stiffness_coefficient": Output("case", "s", "β of Rayleigh damping"),
    "epsilon": Output("case", "-", "restitution by equation 5"),
    "xi_c": Output("case", "-", "damping ratio of the contact by equation 4"),
    "K_Ceq": Output("case", "N/m", "stiffness of the contact by equation 6"),
    "impact_time": Output("case", "s", "first impact of the top floor"),
    "impact_duration": Output("case", "s", "of the same impact"),
    "impulse": Output("case", "N s", "of the same impact, the largest on its way"),
    "approach_velocity": Output("case", "m/s", "before the same impact"),
}


def write_calibration(path: Path, study: CalibrationStudy, key: str) -> None:
    """Write `calibrate.nc`.

    Args:
        path: The file.
        study: The stage's results.
        key: Hash of the stage's inputs.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    prepared, cases = study.prepared, study.cases
    experiment, contact = prepared.experiment, study.main.run.contact
    near = _near_first_impact(study)
    impacts = [case.impacts[-1].first_complete() for case in cases]
    floors = np.array(experiment.floors)
    values = {
        "time": contact.time,
        "floor": floors,
        "floor_mass": prepared.mass,
        **_histories(study.main.run.history, ""),
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
        "mass_coefficient": [case.damping.alpha for case in cases],
        "stiffness_coefficient": [case.damping.beta for case in cases],
        "epsilon": [case.penalty.epsilon for case in cases],
        "xi_c": [case.penalty.xi_c for case in cases],
        "K_Ceq": [case.penalty.K_Ceq for case in cases],
        "impact_time": [impact.start for impact in impacts],
        "impact_duration": [impact.duration for impact in impacts],
        "impulse": [impact.largest_impulse for impact in impacts],
        "approach_velocity": [impact.approach for impact in impacts],
    }
    attributes = {
        "title": study.case.title,
        "inputs": key,
        "case_hash": study.case.content_hash(),
        "building": study.case.structure.building if study.case.structure else "",
        "side": experiment.side,
        "gap": experiment.gap,
        "separation": prepared.separation,
        "displaced_floor": experiment.displaced_floor,
        "displacement_at_start": experiment.displacement,
        "pull": experiment.pull,
        "stick_contact_update": study.case.pounding.update,
    }
    scalars = calibration_scalars(study)
    write_netcdf(path, dataset(OUTPUTS, values, attributes=attributes, scalars=scalars))


def _near_first_impact(study: CalibrationStudy) -> slice:
    """The steps whose forces of the constraints are kept.

    They matter, and are not zero, in the first impact only.
    """
    first = study.main.impacts[-1].first_complete()
    return slice(max(0, first.first - 5), first.last + 6)


def _histories(history: WallHistory, prefix: str) -> dict[str, Any]:
    names = ("displacement", "velocity", "force", "opening")
    histories = {f"{prefix}{name}": getattr(history, name) for name in names}
    return {name: values for name, values in histories.items() if values is not None}
