"""The stage `sticks`: calibrated sticks, pounding, impact forces, floor spectra."""

from __future__ import annotations

import hashlib
from pathlib import Path

from impactfem.case import Case
from impactfem.case.facing import facing_floors
from impactfem.coupling.force_history import ForceHistory, write_forces, write_forces_csv
from impactfem.plot.floor_products import write_floor_products
from impactfem.stages.building.stage import building_key
from impactfem.stages.building.targets import from_structure, with_structure_targets
from impactfem.stages.calibrate.calibrated_contact import asks_calibration, with_contact_of_run
from impactfem.stages.calibrate.stage import calibrate_key
from impactfem.stages.inputs import inputs_key, tolerances
from impactfem.stages.pounding.checks import stick_checks
from impactfem.stages.pounding.compute import STEPS, run_sticks
from impactfem.stages.pounding.facing_checks import facing_checks
from impactfem.stages.pounding.figures import stick_figures
from impactfem.stages.pounding.store import write_motion, write_sticks
from impactfem.stages.pounding.tables import stick_tables
from impactfem.stages.stage import Stage
from impactfem.system.log import Steps

STICK_ROOMS = ("motion", "spectra", "sticks", "coupling", "stages/pounding")
STICK_INPUTS = (
    "materials",
    "damping",
    "buildings",
    "calibration",
    "motions",
    "loads",
    "contact_laws",
    "contacts",
    "pounding",
    "spectra",
)


def stick_inputs_key(case: Case, sections: tuple[str, ...], files: tuple[Path, ...] = ()) -> str:
    """Hash of what sticks depend on, and what the values depend on that they take from 3D.

    Args:
        case: The case.
        sections: Names of the sections of the case file that count.
        files: Further files whose content counts.
    """
    keys = [inputs_key(case, sections, STICK_ROOMS, files)]
    if from_structure(case):
        keys.append(building_key(case))
    if asks_calibration(case):
        keys.append(calibrate_key(case))
    if facing := facing_floors(case).pairs:
        keys.append(repr(facing))  # plan sizes of the mesh count here only
    return keys[0] if len(keys) == 1 else hashlib.sha256("".join(keys).encode()).hexdigest()


def _run(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    case = with_contact_of_run(with_structure_targets(case, folder), folder)
    study = run_sticks(case, steps.step)
    files = [folder / name for name in ("motion.nc", "forces.nc", "forces.csv", "sticks.nc")]
    with steps.step("stores"):
        write_motion(files[0], study, key)
        response = study.response
        write_forces(files[1], response, case.content_hash(), key)
        write_forces_csv(files[2], ForceHistory.of_response(response))
        write_sticks(files[3], study, key)
    with steps.step("tables and figures"):
        files += stick_tables(folder)
        files += stick_figures(folder)
        files += write_floor_products(
            folder,
            folder / "sticks.nc",
            broadening=case.spectra.broadening,
            clipping=case.spectra.clipping,
        )
    return files


def _needs(case: Case) -> tuple[str, ...]:
    asked = {"building": from_structure(case), "calibrate": asks_calibration(case)}
    return tuple(name for name, needed in asked.items() if needed)


STICKS = Stage(
    name="sticks",
    steps={**STEPS, "stores": 2.0, "tables and figures": 4.0},
    rooms=STICK_ROOMS,
    key=lambda case: stick_inputs_key(case, STICK_INPUTS),
    store="sticks.nc",
    run=_run,
    needs=_needs,
    checks=lambda case, folder: [
        *stick_checks(folder, case.pounding.points_per_impact, tolerances(case)),
        *facing_checks(folder, case),
    ],
)
