"""The stage `transient`: ground motion and impacts on the 3D building."""

from __future__ import annotations

import hashlib
from pathlib import Path

import xarray as xr

from impactfem.case import Case
from impactfem.case.transient import transient_files
from impactfem.log import Steps
from impactfem.parallel import communicator, on_root
from impactfem.results.transient_checks import log_transient_checks
from impactfem.scalar import from_json
from impactfem.study.building import BUILDING_ROOMS, building_key
from impactfem.study.inputs import inputs_key
from impactfem.study.stage import Stage
from impactfem.study.sticks import STICK_INPUTS, STICK_ROOMS, STICKS, stick_inputs_key

TRANSIENT_ROOMS = (*BUILDING_ROOMS, *STICK_ROOMS, "transient")
STEPS = {
    "inputs": 2.0,
    "matrices": 5.0,
    "basis": 60.0,
    "time steps": 0.0,
    "spectra": 3.0,
    "maps": 15.0,
    "stores": 3.0,
}


def _key(case: Case) -> str:
    files = transient_files(case.transient) if case.transient is not None else ()
    own = stick_inputs_key(case, (*STICK_INPUTS, "transient"), files)
    rooms = inputs_key(case, ("structure",), TRANSIENT_ROOMS)
    return hashlib.sha256(f"{own}{rooms}{building_key(case)}".encode()).hexdigest()


def _basis_key(case: Case) -> str:
    """Hash of what the reduced basis depends on: not on motions, gaps or forces."""
    asked = case.transient
    if asked is None:
        return ""
    own = asked.model_dump_json(
        include={"maximum_frequency", "tolerance", "shift", "eccentricity", "probes"}
    )
    rooms = inputs_key(case, ("structure", "damping", "buildings"), TRANSIENT_ROOMS)
    return hashlib.sha256(f"{own}{rooms}{building_key(case)}".encode()).hexdigest()


def _run(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.building.stage import mesh_of_run
    from impactfem.transient.checkpoints import remove_checkpoints
    from impactfem.transient.stage import CHECKPOINTS, prepare, run_transient
    from impactfem.transient.store import write_maps, write_transient

    mesh = mesh_of_run(case, folder)
    with steps.step("inputs"):
        prepared = on_root(
            lambda: prepare(
                case, mesh, folder / "forces.nc", _storey_factor(folder), STICKS.key(case)
            )
        )
    study = run_transient(
        case,
        prepared,
        folder,
        communicator(),
        steps.step,
        basis_key=on_root(lambda: _basis_key(case)),
        key=key,
        within=steps.within,
    )

    def write() -> list[Path]:
        if study is None:
            return []
        files = [folder / "transient.nc"]
        maps = folder / "transient_maps.nc"
        # Those of a run before would go with other results.
        maps.unlink(missing_ok=True)
        with steps.step("stores"):
            write_transient(files[0], study, key)
            if study.maps is not None:
                files.append(maps)
                write_maps(maps, study, study.maps, key)
        remove_checkpoints(folder / CHECKPOINTS)
        return files

    return on_root(write)


def _storey_factor(folder: Path) -> float:
    """The factor that the stage `building` gave or fitted."""
    with xr.open_dataset(folder / "building.nc", engine="h5netcdf") as store:
        scalars = {s.name: s.value for s in from_json(store.attrs["scalars"])}
    return float(scalars["building.storey_stiffness_factor"] or 1.0)


TRANSIENT = Stage(
    name="transient",
    steps=STEPS,
    rooms=TRANSIENT_ROOMS,
    key=_key,
    store="transient.nc",
    run=_run,
    checks=lambda case, folder: log_transient_checks(folder),
    lacks=lambda case: "transient" if case.transient is None else None,
    needs=lambda case: ("building", "sticks"),
    collective=True,
)
