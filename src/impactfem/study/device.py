"""The stage `device`: devices in the 3D model and by response spectra, for every damping case."""

from __future__ import annotations

import hashlib
from pathlib import Path

from impactfem.case import Case
from impactfem.case.structure import structure_files
from impactfem.case.transient import transient_files
from impactfem.log import Steps
from impactfem.parallel import communicator, on_root
from impactfem.results.device_checks import device_checks
from impactfem.results.device_figures import device_figures
from impactfem.results.device_tables import device_tables
from impactfem.study.calibrate import CALIBRATE_ROOMS, DAMPINGS, calibrate_key
from impactfem.study.calibrated_contact import with_contact_of_run
from impactfem.study.inputs import inputs_key, published_values
from impactfem.study.stage import Stage
from impactfem.study.sticks import STICK_INPUTS, STICK_ROOMS, stick_inputs_key
from impactfem.study.storey_factor import storey_factor
from impactfem.study.structure_targets import with_structure_targets

DEVICE_ROOMS = tuple(dict.fromkeys((*CALIBRATE_ROOMS, *STICK_ROOMS, "device", "equipment")))
STEPS = {
    "inputs": 4.0,
    "matrices": 5.0,
    "basis": 90.0,
    "damping cases": 40.0,
    "stores": 3.0,
    "tables and figures": 10.0,
}


def _key(case: Case) -> str:
    sections = (*STICK_INPUTS, "transient", "devices", "device_analysis", "damping_cases")
    files = transient_files(case.transient) if case.transient is not None else ()
    own = stick_inputs_key(case, sections, files)
    rooms = inputs_key(case, ("structure",), DEVICE_ROOMS)
    return hashlib.sha256(f"{own}{rooms}{calibrate_key(case)}".encode()).hexdigest()


def _model_key(case: Case) -> str:
    """Hash of what the reduced model depends on: not on motions, forces, masses of devices."""
    transient, wall = case.transient, case.wall_impact
    if transient is None:
        return ""
    own = transient.model_dump_json(include={"maximum_frequency", "tolerance", "eccentricity"})
    own += "" if wall is None else wall.model_dump_json(include={"floors", "displaced_floor"})
    own += "".join(device.model_dump_json(include={"point", "radius"}) for device in case.devices)
    files = structure_files(case.structure) if case.structure is not None else ()
    sections = ("materials", *DAMPINGS, "buildings", "structure", "contacts")
    rooms = inputs_key(case, sections, DEVICE_ROOMS, files)
    return hashlib.sha256(f"{own}{rooms}".encode()).hexdigest()


def _run(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.building.stage import mesh_of_run
    from impactfem.equipment.stage import prepare, run_devices
    from impactfem.equipment.store import write_devices

    mesh = mesh_of_run(case, folder)
    with steps.step("inputs"):
        case = on_root(lambda: with_contact_of_run(with_structure_targets(case, folder), folder))
        prepared = on_root(lambda: prepare(case, mesh, folder / "forces.nc", storey_factor(folder)))
    study = run_devices(
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
        files = [folder / "device.nc"]
        with steps.step("stores"):
            write_devices(files[0], study, key)
        with steps.step("tables and figures"):
            files += device_tables(folder, published_values(case))
            files += device_figures(folder)
        return files

    return on_root(write)


def _lacks(case: Case) -> str | None:
    if case.transient is None:
        return "transient"
    return None if case.devices else "devices"


DEVICE = Stage(
    name="device",
    steps=STEPS,
    rooms=DEVICE_ROOMS,
    key=_key,
    store="device.nc",
    run=_run,
    checks=lambda case, folder: device_checks(folder),
    lacks=_lacks,
    needs=lambda case: ("building", "sticks"),
    collective=True,
)
