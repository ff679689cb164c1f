"""The stage `calibrate`: penalty parameters from an impact of the 3D model on a rigid wall."""

from __future__ import annotations

from pathlib import Path

from impactfem.case import Case
from impactfem.stages.building.stage import BUILDING, storey_factor
from impactfem.stages.building.targets import with_structure_targets
from impactfem.stages.calibrate.checks import wall_checks
from impactfem.stages.calibrate.figures import wall_figures
from impactfem.stages.calibrate.tables import wall_tables
from impactfem.stages.inputs import matrices_key, published_values
from impactfem.stages.stage import DRAWING, Stage
from impactfem.system.log import Steps
from impactfem.system.parallel import communicator, on_root

DAMPINGS = ("damping", "damping_cases")


def _model_key(case: Case) -> str:
    """Hash of what the reduced model depends on: not on gap, displacement and times."""
    asked = case.wall_impact
    if asked is None:
        return ""
    own = asked.model_dump_json(include={"floors", "displaced_floor", "pull"})
    return matrices_key(case, CALIBRATE.modules, own, DAMPINGS)


def _compute(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
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

    def write() -> list[Path]:
        if study is None:
            return []
        with steps.step("stores"):
            write_calibration(folder / "calibrate.nc", study, key)
        return [folder / "calibrate.nc"]

    return on_root(write)


CALIBRATE = Stage(
    name="calibrate",
    title="Impact on a rigid wall",
    about="Restitution and contact stiffness from an impact of the 3D model, and the stick beside "
    "it.",
    headlines=(
        "ε = {calibration.epsilon}",
        "K_Ceq = {calibration.K_Ceq}",
        "impact of {calibration.impact_duration}",
    ),
    steps={
        "inputs": 2.0,
        "matrices": 5.0,
        "basis": 60.0,
        "impact": 1.0,
        "stick": 3.0,
        "stores": 1.0,
        DRAWING: 4.0,
    },
    sections=(*BUILDING.sections, *DAMPINGS, "calibration", "wall_impact", "pounding"),
    computed_by=("compute", "store"),
    drawn_by=("figures", "tables"),
    stores={"calibrate": "calibrate.nc"},
    compute=_compute,
    draw=lambda case, folder: [
        *wall_tables(folder, published_values(case)),
        *wall_figures(folder),
    ],
    checks=lambda case, folder: wall_checks(folder),
    needs=lambda case: (BUILDING,),
    lacks=lambda case: "wall_impact" if case.wall_impact is None else None,
    collective=True,
)
