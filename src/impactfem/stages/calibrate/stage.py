"""The stage `calibrate`: penalty parameters from an impact of the 3D model on a rigid wall."""

from __future__ import annotations

import hashlib
from pathlib import Path

from impactfem.case import Case
from impactfem.stages.building.factor_of_run import storey_factor
from impactfem.stages.building.stage import BUILDING_INPUTS, BUILDING_ROOMS, building_key
from impactfem.stages.building.targets import with_structure_targets
from impactfem.stages.calibrate.checks import wall_checks
from impactfem.stages.calibrate.figures import wall_figures
from impactfem.stages.calibrate.tables import wall_tables
from impactfem.stages.inputs import inputs_key, matrices_key, published_values
from impactfem.stages.stage import Stage
from impactfem.stages.stored import stored
from impactfem.system.log import Steps
from impactfem.system.parallel import communicator, on_root

CALIBRATE_ROOMS = (*BUILDING_ROOMS, "sticks", "coupling", "stages/calibrate")
DAMPINGS = ("damping", "damping_cases")
STEPS = {
    "inputs": 2.0,
    "matrices": 5.0,
    "basis": 60.0,
    "impact": 1.0,
    "stick": 3.0,
    "stores": 1.0,
    "tables and figures": 4.0,
}


def calibrate_key(case: Case) -> str:
    """Hash of what the stage depends on."""
    sections = (*BUILDING_INPUTS, *DAMPINGS, "calibration", "wall_impact", "pounding")
    own = inputs_key(case, sections, CALIBRATE_ROOMS)
    return hashlib.sha256(f"{own}{building_key(case)}".encode()).hexdigest()


def _model_key(case: Case) -> str:
    """Hash of what the reduced model depends on: not on gap, displacement and times."""
    asked = case.wall_impact
    if asked is None:
        return ""
    own = asked.model_dump_json(include={"floors", "displaced_floor", "pull"})
    return matrices_key(case, CALIBRATE_ROOMS, own, DAMPINGS)


def _run(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.stages.building.compute import mesh_of_run
    from impactfem.stages.calibrate.compute import prepare, run_calibrate
    from impactfem.stages.calibrate.store import write_calibration

    mesh = mesh_of_run(case, folder)
    with steps.step("inputs"):
        case = on_root(lambda: with_structure_targets(case, folder))
        prepared = on_root(lambda: prepare(case, mesh, storey_factor(folder)))
    study = run_calibrate(
        case,
        prepared,
        folder,
        communicator(),
        steps.step,
        model_key=on_root(lambda: _model_key(case)),
        within=steps.within,
    )

    return stored(
        study,
        folder / "calibrate.nc",
        lambda path, found: write_calibration(path, found, key),
        lambda: [*wall_tables(folder, published_values(case)), *wall_figures(folder)],
        steps,
    )


CALIBRATE = Stage(
    name="calibrate",
    steps=STEPS,
    rooms=CALIBRATE_ROOMS,
    key=calibrate_key,
    store="calibrate.nc",
    run=_run,
    checks=lambda case, folder: wall_checks(folder),
    lacks=lambda case: "wall_impact" if case.wall_impact is None else None,
    needs=lambda case: ("building",),
    collective=True,
)
