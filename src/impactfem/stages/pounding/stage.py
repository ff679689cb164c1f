"""The stage `pounding`: calibrated sticks, pounding, impact forces, floor spectra."""

from __future__ import annotations

from pathlib import Path

from impactfem.case import Building3D, Case
from impactfem.case.contact_search import facing_floors
from impactfem.case.soil import TABLE_BAND, TableSoil
from impactfem.coupling.force_history import OTHER_FORCES, ForceHistory, write_forces
from impactfem.plot.floor_products import write_floor_products
from impactfem.stages.building.stage import BUILDING, target_models
from impactfem.stages.building.targets import with_structure_sticks
from impactfem.stages.calibrate.selection import asks_calibration, with_contact_of_run
from impactfem.stages.calibrate.stage import CALIBRATE
from impactfem.stages.check import Check
from impactfem.stages.drawing import Figures
from impactfem.stages.inputs import inputs_key, tolerances
from impactfem.stages.pounding import elevation, figures, model_figures
from impactfem.stages.pounding.checks import stick_checks
from impactfem.stages.pounding.compute import STEPS, run_sticks
from impactfem.stages.pounding.figures import PoundingData
from impactfem.stages.pounding.limits import pounding_verdicts
from impactfem.stages.pounding.model_checks import (
    facing_checks,
    soil_checks,
    stick_against_model,
)
from impactfem.stages.pounding.store import write_motion, write_sticks
from impactfem.stages.pounding.tables import stick_tables
from impactfem.stages.reduce.stage import REDUCE, models_of_run
from impactfem.stages.stage import DRAWING, Stage, StageOf
from impactfem.stages.stores import open_store
from impactfem.system.log import Steps


def _compute(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    case = with_contact_of_run(with_structure_sticks(case, folder), folder)
    if (models := models_of_run(case, folder)) is not None:
        from impactfem.reduction.contact_line import warn_of_narrow  # beside dolfinx

        warn_of_narrow(models.lines, case)
    study = run_sticks(case, steps.step, models=models)
    files = [folder / name for name in POUNDING.stores.values()]
    files.append(folder / "forces.csv")
    with steps.step("stores"):
        response = study.response
        write_sticks(folder / "pounding.nc", study, key)
        write_motion(folder / "motion.nc", study, key)
        write_forces(folder / "forces.nc", response, case.content_hash(), key)
        (folder / OTHER_FORCES).unlink(missing_ok=True)
        if study.other is not None:
            write_forces(folder / OTHER_FORCES, study.other, case.content_hash(), key)
            files.append(folder / OTHER_FORCES)
        ForceHistory.of_response(response).write_csv(folder / "forces.csv")
    return files


def _tabulate(case: Case, folder: Path) -> list[Path]:
    products = write_floor_products(folder, folder / "pounding.nc", case.spectra)
    return [*stick_tables(folder), *products]


def _needs(case: Case) -> tuple[Stage, ...]:
    return (
        *target_models(case),
        *((CALIBRATE,) if asks_calibration(case) else ()),
        *((REDUCE,) if case.pounding_in_3d else ()),
    )


def _facing(case: Case) -> str:
    """Plan sizes of the mesh count where floors face each other."""
    facing = facing_floors(case).pairs
    places = [(one.a, one.b, one.normal, one.opposite, one.level) for one in facing]
    return repr(places) if facing else ""


def _sticks_against_models(folder: Path, case: Case) -> list[Check]:
    """Sticks compared with 3D models of this run, where `transient` does not compare them."""
    found: list[Check] = []
    for building in case.modelled.values():
        path = building.folder(folder) / "building.nc"
        if building.transient is not None or building.pounds or not path.is_file():
            continue
        with open_store(path) as store:
            current = store.attrs["inputs"] == BUILDING.key(building)
        found += stick_against_model(path.parent) if current else []
    return found


POUNDING = StageOf[Case](
    name="pounding",
    title="Pounding",
    about="Ground motion, sticks or 3D models that pound, impact forces, floor spectra.",
    headlines=(
        "ground {motion*.pga}, spectrum {motion*.sa_max}",
        "{pounding.impacts} impacts, the largest {pounding.main_impact_band_force} up to 100 Hz",
        "at {pounding.main_impact_time} for {pounding.main_impact_duration}",
        "floor spectra up to {frs.largest} below {frs.resolved_frequency}",
    ),
    steps={**STEPS, "stores": 2.0, DRAWING: 4.0},
    sections=(
        "materials",
        "damping",
        "buildings",
        "soil",
        "calibration",
        "motions",
        "wave_passage",
        "loads",
        "contact_laws",
        "contacts",
        "pounding",
        "spectra",
    ),
    further=_facing,
    stores={"pounding": "pounding.nc", "motion": "motion.nc", "forces": "forces.nc"},
    compute=_compute,
    tabulate=_tabulate,
    figures=Figures.of(PoundingData, elevation, figures, model_figures),
    drawn_from=("devices",),
    checks=lambda case, folder: [
        *stick_checks(folder, case.pounding.points_per_impact, tolerances(case)),
        *facing_checks(folder, case),
        *_sticks_against_models(folder, case),
    ],
    verdicts=pounding_verdicts,
    announces=lambda case: [
        check
        for one in case.buildings
        if isinstance(one.soil, TableSoil)
        for check in soil_checks(one.name, one.soil.errors, TABLE_BAND)
    ],
    needs=_needs,
    subjects=lambda case: (case,),
)


def motions_key(subject: Case | Building3D, sections: tuple[str, ...] = ()) -> str:
    """Hash of what the response to a motion depends on, these sections included, but the motion."""
    rest = tuple(section for section in POUNDING.sections if section != "motions")
    case = subject.case if isinstance(subject, Building3D) else subject
    needed = [stage.key(case) for stage in _needs(case)]
    own = inputs_key(subject, (*rest, *sections))
    return "".join([own, *needed, _facing(case)])
