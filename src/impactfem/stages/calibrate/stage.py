"""The stage `calibrate`: penalty parameters from an impact of the 3D model on a rigid wall."""

from dataclasses import replace
from pathlib import Path

from impactfem.case import BuildingAtWall
from impactfem.stages.building.stage import target_models
from impactfem.stages.building.targets import with_structure_sticks
from impactfem.stages.calibrate import figures
from impactfem.stages.calibrate.checks import wall_checks
from impactfem.stages.calibrate.figures import CalibrationData
from impactfem.stages.calibrate.tables import wall_tables
from impactfem.stages.drawing import Figures
from impactfem.stages.inputs import published_values
from impactfem.stages.reduce.stage import REDUCE, model_key
from impactfem.stages.stage import DRAWING, StageOf
from impactfem.system.log import Steps


def _compute(building: BuildingAtWall, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.stages.building.compute import mesh_of_run
    from impactfem.stages.calibrate.compute import prepare, run_calibrate
    from impactfem.stages.calibrate.store import write_calibration
    from impactfem.stages.reduce.compute import reduced_of_run

    with steps.step("inputs"):
        wall = reduced_of_run(folder, model_key(building)).complete.wall
        case = with_structure_sticks(building.case, building.run_folder(folder))
        building = replace(building, case=case)
        prepared = prepare(building, mesh_of_run(building, folder))
    if wall is None:
        raise ValueError("the case has a wall impact, and the reduced building no wall")
    study = run_calibrate(building, prepared, wall, steps.step)
    with steps.step("stores"):
        write_calibration(folder / "calibrate.nc", study, key)
    return [folder / "calibrate.nc"]


CALIBRATE = StageOf[BuildingAtWall](
    name="calibrate",
    title="Impact on a rigid wall",
    about="Restitution and contact stiffness from an impact of the 3D model, and the stick beside "
    "it.",
    headlines=(
        "ε = {calibration.epsilon}",
        "contact stiffness {calibration.K_Ceq}",
        "impact of {calibration.impact_duration}",
    ),
    steps={"inputs": 2.0, "impact": 1.0, "stick": 3.0, "stores": 1.0, DRAWING: 4.0},
    sections=("damping_cases", "calibration", "wall_impact", "pounding"),
    # The stick before the wall is fitted to the modes of other buildings, too.
    further=lambda building: "".join(
        stage.key(building.case) for stage in target_models(building.case)
    ),
    stores={"calibrate": "calibrate.nc"},
    compute=_compute,
    tabulate=lambda building, folder: wall_tables(folder, published_values(building)),
    figures=Figures.of(CalibrationData, figures),
    checks=lambda building, folder: wall_checks(folder),
    needs=lambda building: (REDUCE,),
    subjects=lambda case: case.at_wall,
    section="wall_impact",
)
