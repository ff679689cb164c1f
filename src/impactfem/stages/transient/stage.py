"""The stage `transient`: ground motion and impacts on the 3D building."""

from pathlib import Path

from impactfem.case import BuildingInTime
from impactfem.case.transient import transient_files
from impactfem.coupling.force_history import read_forces
from impactfem.coupling.given_forces import given_forces
from impactfem.stages.building.stage import BUILDING
from impactfem.stages.calibrate.stage import CALIBRATE
from impactfem.stages.check import Check
from impactfem.stages.drawing import Figures
from impactfem.stages.inputs import published_values
from impactfem.stages.pounding.model_checks import stick_against_model
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.reduce.stage import REDUCE, model_key
from impactfem.stages.stage import DRAWING, StageOf
from impactfem.stages.stores import of_run
from impactfem.stages.transient import curve_figures, film, floor_figures, pictures
from impactfem.stages.transient.checks import impulse_check, samples_check, transient_checks
from impactfem.stages.transient.figures import TransientData
from impactfem.stages.transient.limits import transient_verdicts
from impactfem.stages.transient.tables import transient_tables
from impactfem.system.log import Steps
from impactfem.system.parallel import on_root


def _reduces(building: BuildingInTime) -> bool:
    return building.transient.solver != "full"


def _compute(building: BuildingInTime, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.dynamics.checkpoints import remove_checkpoints
    from impactfem.stages.reduce.compute import reduced_on_root
    from impactfem.stages.transient.compute import run_transient
    from impactfem.stages.transient.export import write_motion
    from impactfem.stages.transient.full_run import CHECKPOINTS
    from impactfem.stages.transient.prepared import prepared_of_run
    from impactfem.stages.transient.store import write_stores

    run = building.run_folder(folder)
    with steps.step("inputs"):
        prepared = on_root(lambda: prepared_of_run(building, run, POUNDING.key(building)))
        reduced = None
        if _reduces(building):
            reduced = reduced_on_root(folder, on_root(lambda: model_key(building)), building)
    basis = None if reduced is None else reduced.basis
    study = run_transient(prepared, folder, steps, basis=basis, key=key)

    def write() -> list[Path]:
        if study is None:
            return []
        motion = folder / "transient_motion.vtkhdf"
        # Remove the files of earlier results.
        for path in (folder / "transient_maps.nc", motion):
            path.unlink(missing_ok=True)
        with steps.step("stores"):
            files = write_stores(folder, study, key)
        if building.transient.export:
            with steps.step("export"):
                files += write_motion(motion, study, key, lambda part: steps.within("export", part))
        # Last of all: until here a failure costs no time steps.
        remove_checkpoints(folder / CHECKPOINTS)
        return files

    return on_root(write)


def _checks(building: BuildingInTime, folder: Path) -> list[Check]:
    found, transient = transient_checks(folder), building.transient
    # Forces of another program are not the stick's, nor are those of 3D models that pound.
    if transient.forces is not None:
        given, own = given_forces(transient), read_forces(of_run(folder, "forces.nc"))
        found += impulse_check(given, own, transient.forces.name)
    elif not building.pounds:
        found += stick_against_model(folder)
    return found


TRANSIENT = StageOf[BuildingInTime](
    name="transient",
    title="The 3D model in time",
    about="The impacts and the ground motion on the 3D model: floor spectra, waves, transfer.",
    headlines=(
        "reduced basis of {transient.basis_vectors} vectors",
        "floor spectra up to {transient.frs.largest} below {transient.frs.resolved_frequency}",
    ),
    steps={
        "inputs": 2.0,
        "matrices": 0.0,
        "time steps": 0.0,
        "spectra": 3.0,
        "maps": 15.0,
        "stores": 3.0,
        "export": 0.0,
        DRAWING: 20.0,
    },
    sections=("transient", "structure", "damping"),
    files=lambda building: transient_files(building.transient),
    stores={"transient": "transient.nc", "maps": "transient_maps.nc"},
    compute=_compute,
    tabulate=lambda building, folder: transient_tables(folder, published_values(building)),
    figures=Figures.of(TransientData, curve_figures, floor_figures, pictures, film),
    drawn_from=("devices",),
    checks=_checks,
    verdicts=transient_verdicts,
    announces=lambda case: (
        [samples_check(case.transient.time_step, case.transient.maximum_frequency)]
        if case.transient is not None
        else []
    ),
    subjects=lambda case: case.in_time,
    section="transient",
    needs=lambda building: (
        REDUCE if _reduces(building) else BUILDING,
        *((CALIBRATE,) if building.transient.spread == "calibrated" else ()),
        POUNDING,
    ),
    collective=True,
)
