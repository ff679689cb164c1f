"""The stage `calibrate`: penalty parameters from an impact of the 3D model on a rigid wall."""

from __future__ import annotations

import hashlib
from pathlib import Path

from impactfem.case import Case
from impactfem.log import Steps
from impactfem.parallel import communicator, on_root
from impactfem.results.wall_checks import wall_checks
from impactfem.results.wall_figures import wall_figures
from impactfem.results.wall_tables import wall_tables
from impactfem.study.building import BUILDING_INPUTS, BUILDING_ROOMS, building_key
from impactfem.study.inputs import inputs_key, matrices_key, published_values
from impactfem.study.stage import Stage
from impactfem.study.stored import stored
from impactfem.study.storey_factor import storey_factor
from impactfem.study.structure_targets import with_structure_targets

CALIBRATE_ROOMS = (*BUILDING_ROOMS, "sticks", "transient", "wall")
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
    from impactfem.building.stage import mesh_of_run
    from impactfem.wall.stage import prepare, run_calibrate
    from impactfem.wall.store import write_calibration

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
