"""The stage `ensemble`: many motions through the sticks."""

from pathlib import Path

from impactfem.case import Case
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.plot.floor_products import write_floor_products
from impactfem.stages.building.targets import with_structure_sticks
from impactfem.stages.calibrate.selection import with_contact_of_run
from impactfem.stages.drawing import Figures
from impactfem.stages.ensemble import figures
from impactfem.stages.ensemble.compute import run_ensemble
from impactfem.stages.ensemble.figures import (
    EnsembleData,
    ensemble_checks,
    ensemble_table,
    published_results,
)
from impactfem.stages.ensemble.store import write_ensemble
from impactfem.stages.pounding.stage import POUNDING, motions_key
from impactfem.stages.reduce.stage import models_of_run
from impactfem.stages.stage import DRAWING, StageOf
from impactfem.system.executor import workers
from impactfem.system.files import kept_in_one_file
from impactfem.system.log import Steps
from impactfem.system.parallel import on_root


def _compute(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    case = on_root(lambda: with_contact_of_run(with_structure_sticks(case, folder), folder))
    with steps.step("sticks"):
        calibration = on_root(lambda: calibration_of(case))
        ready = (calibration, system_of(case, calibration))
        models = on_root(lambda: models_of_run(case, folder))
    members_key = on_root(lambda: motions_key(case))
    with workers() as executor:
        if executor is None:
            return []  # this rank has worked for rank 0 until now
        with (
            steps.step("members"),
            kept_in_one_file(folder / "ensemble" / "members") as members,
        ):
            result = run_ensemble(
                case,
                ready,
                members,
                members_key,
                executor,
                lambda done, of: steps.within("members", done / of),
                models,
            )
    with steps.step("stores"):
        write_ensemble(folder / "ensemble.nc", case, result, key)
    return [folder / "ensemble.nc"]


def _tabulate(case: Case, folder: Path) -> list[Path]:
    products = write_floor_products(
        folder / "ensemble", folder / "ensemble.nc", case.spectra, statistic="mean"
    )
    return [*ensemble_table(folder, published_results(case)), *products]


ENSEMBLE = StageOf[Case](
    name="ensemble",
    title="Many motions",
    about="The pounding under other motions: bands of every result.",
    headlines=("{ensemble.members} motions",),
    steps={"sticks": 2.0, "members": 40.0, "stores": 1.0, DRAWING: 2.0},
    sections=("ensemble",),
    files=lambda case: tuple(case.ensemble.files()) if case.ensemble is not None else (),
    stores={"ensemble": "ensemble.nc"},
    compute=_compute,
    tabulate=_tabulate,
    figures=Figures.of(EnsembleData, figures),
    checks=lambda case, folder: ensemble_checks(folder, published_results(case)),
    subjects=lambda case: () if case.ensemble is None else (case,),
    section="ensemble",
    needs=lambda case: (POUNDING,),
    collective=True,
)
