"""The stage `device`: devices in the 3D model and by response spectra, for every damping case."""

from __future__ import annotations

import hashlib
from pathlib import Path

from impactfem.case import Case
from impactfem.case.transient import transient_files
from impactfem.log import Steps
from impactfem.parallel import communicator, on_root
from impactfem.results.device_checks import device_checks
from impactfem.results.device_figures import device_figures
from impactfem.results.device_tables import device_tables
from impactfem.study.calibrate import CALIBRATE_ROOMS, DAMPINGS, calibrate_key
from impactfem.study.calibrated_contact import calibrated_laws, with_contact_of_run
from impactfem.study.inputs import inputs_key, matrices_key, published_values
from impactfem.study.stage import Stage
from impactfem.study.sticks import STICK_INPUTS, STICK_ROOMS, stick_inputs_key
from impactfem.study.stored import stored
from impactfem.study.storey_factor import storey_factor
from impactfem.study.structure_targets import with_structure_targets

DEVICE_ROOMS = tuple(dict.fromkeys((*CALIBRATE_ROOMS, *STICK_ROOMS, "device", "equipment")))
STEPS = {
    "inputs": 4.0,
    "matrices": 5.0,
    "basis": 90.0,
    "time steps": 0.0,
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


def model_key(case: Case) -> str:
    """Hash of what the reduced model depends on: not on gaps, motions, masses of devices.

    The floors that are hit and the directions of the ground, for which it grows, are added where
    they are known.
    """
    transient, wall = case.transient, case.wall_impact
    if transient is None:
        return ""
    own = transient.model_dump_json(include={"maximum_frequency", "tolerance", "eccentricity"})
    own += (
        "" if wall is None else wall.model_dump_json(include={"floors", "displaced_floor", "pull"})
    )
    placed = {"point", "radius", "supports", "envelope"}
    own += "".join(device.model_dump_json(include=placed) for device in case.devices)
    if any(anchor.envelope for device in case.devices for anchor in device.anchors):
        own += transient.model_dump_json(include={"probes"})
    return matrices_key(case, DEVICE_ROOMS, own, DAMPINGS)


def _run(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.building.stage import mesh_of_run
    from impactfem.equipment.full_run import remove_full_checkpoints
    from impactfem.equipment.prepared import prepare
    from impactfem.equipment.stage import run_devices
    from impactfem.equipment.store import write_devices

    mesh = mesh_of_run(case, folder)
    with steps.step("inputs"):
        laws = calibrated_laws(case)
        case = on_root(lambda: with_contact_of_run(with_structure_targets(case, folder), folder))
        prepared = on_root(
            lambda: prepare(case, mesh, folder / "forces.nc", storey_factor(folder), laws)
        )
    study = run_devices(
        case,
        prepared,
        folder,
        communicator(),
        steps.step,
        model_key=on_root(lambda: model_key(case)),
        key=key,
        within=steps.within,
    )

    files = stored(
        study,
        folder / "device.nc",
        lambda path, found: write_devices(path, found, key),
        lambda: [*device_tables(folder, published_values(case)), *device_figures(folder)],
        steps,
    )
    # Last of all: until here a failure costs no time steps.
    on_root(lambda: remove_full_checkpoints(folder))
    return files


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
