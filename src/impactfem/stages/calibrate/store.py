"""The store of the stage, `calibrate.nc`, and its scalars by the names of `summary.json`.

Displacements and velocities are those of the mass centres, positive towards the wall; forces push
the floors away from it. What begins with `stick_` is of the stick, the rest of the 3D model.
"""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.stages.calibrate.compute import CalibrationStudy
from impactfem.stages.calibrate.experiment import WallHistory
from impactfem.stages.calibrate.impact import PenaltyParameters, WallComparison, WallImpact
from impactfem.stages.results import outputs, scalars, value, values
from impactfem.stages.stores import Output, damping_outputs, damping_values, dataset
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, with_scalars

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
    **outputs(PenaltyParameters, "case"),
    **outputs(WallImpact, "case"),
    "impacts": Output("floor", "", "number of impacts"),
    **outputs(CalibrationStudy),
    **outputs(WallComparison),
}


def write_calibration(path: Path, study: CalibrationStudy, key: str) -> None:
    """Write `calibrate.nc`; the key is the hash of the inputs of the stage."""
    prepared, cases, structure = study.prepared, study.cases, study.building.structure
    experiment, contact = prepared.experiment, cases[0].run.contact
    impacts = [case.impacts[-1].first_complete() for case in cases]
    # Forces of the constraints matter, and are not zero, in the first impact only.
    near = slice(max(0, impacts[0].first - 5), impacts[0].last + 6)
    floors = np.array(experiment.floors)
    results = {
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
        **values(PenaltyParameters, (case.penalty for case in cases)),
        **values(WallImpact, impacts),
        "impacts": [floor.number for floor in cases[0].impacts],
        **value(study),
        **value(study.comparison, known_only=False),
    }
    attributes = {
        "title": study.building.case.title,
        "inputs": key,
        "case_hash": study.building.case.content_hash(),
        "building": structure.building if structure else "",
        "side": experiment.side,
        "gap": experiment.gap,
        "separation": experiment.separation,
        "displaced_floor": experiment.displaced_floor,
        "displacement_at_start": experiment.displacement,
        "pull": experiment.pull,
        "unilateral_scheme": experiment.unilateral_scheme,
        "stick_contact_update": study.building.case.pounding.update,
    }
    store = dataset(OUTPUTS, results, attributes=attributes)
    write_netcdf(path, with_scalars(store, calibration_scalars(store)))


def _histories(history: WallHistory, prefix: str) -> dict[str, Any]:
    names = ("displacement", "velocity", "force", "opening")
    return {f"{prefix}{name}": getattr(history, name) for name in names}


def calibration_scalars(store: xr.Dataset) -> list[Scalar]:
    """Return the scalars of the stage: the building's own damping, floors, further dampings."""
    own, further = store.isel(case=0), store.isel(case=slice(1, None))
    return [
        *scalars(own, "calibration.{variable}", "impact_time impact_duration impulse peak_force"),
        *scalars(own, "calibration.{variable}", "approach_velocity epsilon xi_c K_Ceq"),
        *scalars(store, "calibration.floor_{floor}.{variable}", "impacts"),
        *scalars(store, "calibration.{variable}", "stick_delay second_impulse second_impact_time"),
        *scalars(store, "calibration.{variable}", "energy_dissipated basis_error"),
        *scalars(further, "calibration.{variable}.{case}", "epsilon"),
        *scalars(further, "calibration.{variable}.{case}", "K_Ceq", detail=True),
    ]
