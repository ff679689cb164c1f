"""The store of the stage: `calibrate.nc`.

Dimensions: `time` and `floor` (those that may hit); `case` (damping cases, the building's own
first), `constraint` (along the edges of the floors, bottom to top) and `step` (the times of the
first impact). Displacements and velocities are those of the mass centres, positive towards the
wall; forces push the floors away from it. `force`, `displacement`, `velocity` and `opening`
(distance of the wall from the nearest point) are of the 3D model, with `stick_` before the name of
the stick.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.dynamics.energy import Energy
from impactfem.stages.calibrate.compute import CalibrationStudy, DampedRun
from impactfem.stages.calibrate.history import WallHistory
from impactfem.stages.calibrate.scalars import calibration_scalars
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import with_scalars

Array = NDArray[np.float64]
Variables = dict[str, tuple[Any, ...]]


def write_calibration(path: Path, study: CalibrationStudy, key: str) -> None:
    """Write `calibrate.nc`.

    Args:
        path: The file.
        study: The stage's results.
        key: Hash of the stage's inputs.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    experiment = study.prepared.experiment
    contact = study.main.run.contact
    near = _near_first_impact(study)
    dataset = xr.Dataset(
        {
            **_histories(study.main.run.history, ""),
            **_histories(study.stick, "stick_"),
            "floor_mass": ("floor", study.prepared.mass, {"units": "kg"}),
            **_energies(contact.energy),
            "complementarity": ("time", contact.residual, {"units": "1"}),
            **_constraints(study, contact.force[near]),
            **_damping_cases(study.cases),
        },
        coords={
            "time": ("time", contact.time, {"units": "s"}),
            "step": ("step", contact.time[near], {"units": "s"}),
            "floor": ("floor", np.array(experiment.floors), {}),
            "case": ("case", np.array([c.name for c in study.cases], dtype=object), {}),
        },
        attrs={
            "title": study.case.title,
            "inputs": key,
            "case_hash": study.case.content_hash(),
            "building": study.case.structure.building if study.case.structure else "",
            "side": experiment.side,
            "gap": experiment.gap,
            "separation": study.prepared.separation,
            "displaced_floor": experiment.displaced_floor,
            "displacement_at_start": experiment.displacement,
            "pull": experiment.pull,
            "stick_contact_update": study.case.pounding.update,
        },
    )
    write_netcdf(path, with_scalars(dataset, calibration_scalars(study)))


def _near_first_impact(study: CalibrationStudy) -> slice:
    """The steps whose forces of the constraints are kept.

    They matter, and are not zero, in the first impact only.
    """
    first = study.main.impacts[-1].first_complete()
    return slice(max(0, first.first - 5), first.last + 6)


def _histories(history: WallHistory, prefix: str) -> Variables:
    dims = ("time", "floor")
    variables: Variables = {
        f"{prefix}displacement": (dims, history.displacement, {"units": "m"}),
        f"{prefix}velocity": (dims, history.velocity, {"units": "m/s"}),
        f"{prefix}force": (dims, history.force, {"units": "N"}),
    }
    if history.opening is not None:
        variables[f"{prefix}opening"] = (dims, history.opening, {"units": "m"})
    return variables


def _energies(energy: Energy) -> Variables:
    return {
        "kinetic_energy": ("time", energy.kinetic, {"units": "J"}),
        "elastic_energy": ("time", energy.elastic, {"units": "J"}),
        "damped_energy": ("time", energy.damped, {"units": "J"}),
        "numerical_energy": ("time", energy.numerical, {"units": "J"}),
        "contact_work": ("time", energy.contact, {"units": "J"}),
    }


def _constraints(study: CalibrationStudy, force: Array) -> Variables:
    """The constraints, and their forces in the steps of the first impact."""
    floors = np.array(study.prepared.experiment.floors)
    return {
        "constraint_floor": ("constraint", floors[study.model.floor_of]),
        "constraint_position": (
            "constraint",
            study.prepared.position,
            {"units": "m", "note": "along the edge"},
        ),
        "constraint_length": ("constraint", study.prepared.length, {"units": "m"}),
        "constraint_force": (("step", "constraint"), force, {"units": "N"}),
    }


def _damping_cases(cases: Sequence[DampedRun]) -> Variables:
    """Penalty parameters by damping case, and what they come from: the top floor's impact."""
    parameters = np.array([[c.penalty.epsilon, c.penalty.xi_c, c.penalty.K_Ceq] for c in cases])
    impacts = [c.impacts[-1].first_complete() for c in cases]
    alpha, beta = np.array([[c.damping.alpha, c.damping.beta] for c in cases]).T
    return {
        "mass_coefficient": ("case", alpha, {"units": "1/s"}),
        "stiffness_coefficient": ("case", beta, {"units": "s"}),
        "epsilon": ("case", parameters[:, 0], {"units": "1"}),
        "xi_c": ("case", parameters[:, 1], {"units": "1"}),
        "K_Ceq": ("case", parameters[:, 2], {"units": "N/m"}),
        "impact_time": ("case", np.array([i.start for i in impacts]), {"units": "s"}),
        "impact_duration": ("case", np.array([i.duration for i in impacts]), {"units": "s"}),
        "impulse": ("case", np.array([i.largest_impulse for i in impacts]), {"units": "N s"}),
        "approach_velocity": ("case", np.array([i.approach for i in impacts]), {"units": "m/s"}),
    }
