"""The stage `design`: design spectra of the 3D building, of one motion and of an ensemble."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

from impactfem.case import Case
from impactfem.stages.building.factor_of_run import storey_factor
from impactfem.stages.building.stage import building_key
from impactfem.stages.building.targets import with_structure_targets
from impactfem.stages.calibrate.calibrated_contact import with_contact_of_run
from impactfem.stages.design.checks import design_checks
from impactfem.stages.design.device_figures import design_device
from impactfem.stages.design.figures import design_figures
from impactfem.stages.design.products import design_products_of, write_design_products
from impactfem.stages.device.stage import DEVICE, DEVICE_ROOMS, model_key
from impactfem.stages.inputs import inputs_key
from impactfem.stages.open_store import open_store
from impactfem.stages.pounding.stage import STICK_INPUTS, STICKS, stick_inputs_key
from impactfem.stages.stage import Stage
from impactfem.stages.transient.stage import TRANSIENT, basis_key
from impactfem.system.log import Steps
from impactfem.system.parallel import communicator, on_root

if TYPE_CHECKING:
    from impactfem.stages.design.compute import DesignStudy

DESIGN_ROOMS = (*DEVICE_ROOMS, "stages/transient", "stages/design")
STEPS = {
    "inputs": 4.0,
    "sticks": 5.0,
    "matrices": 3.0,
    "basis": 12.0,
    "vertices": 1.0,
    "members": 35.0,
    "stores": 1.0,
    "tables and figures": 8.0,
}


def _carried(case: Case) -> int:
    """Number of members that are carried through the 3D building."""
    return 0 if case.ensemble is None else case.ensemble.structure_motions


def _key(case: Case) -> str:
    keys = [TRANSIENT.key(case), inputs_key(case, (), ("stages/design",))]
    if _carried(case):
        files = tuple(case.ensemble.files()) if case.ensemble is not None else ()
        count = f"{_carried(case)} members"
        keys += [
            count,
            inputs_key(case, ("ensemble",), ("stages/design",), files),
            _members_key(case),
        ]
    return hashlib.sha256("".join(keys).encode()).hexdigest()


def _members_key(case: Case) -> str:
    """Hash of what members depend on beside their motions."""
    sections = (*STICK_INPUTS, "transient", "devices", "device_analysis")
    own = stick_inputs_key(case, tuple(name for name in sections if name != "motions"))
    rooms = inputs_key(case, ("structure",), DESIGN_ROOMS)
    keys = [own, rooms, basis_key(case), building_key(case)]
    if case.devices:
        keys.append(model_key(case))
    return hashlib.sha256("".join(keys).encode()).hexdigest()


def _run(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.stages.design.store import write_design

    study = _study(case, folder, steps)

    def write() -> list[Path]:
        if study is None:
            raise ValueError("rank 0 has the results of the stage")
        files = [folder / "design.nc"]
        with steps.step("stores"):
            write_design(files[0], case, study.own, study.whole, study.carried, key)
        with steps.step("tables and figures"):
            files += _shown(case, folder)
        return files

    return on_root(write)


def _study(case: Case, folder: Path, steps: Steps) -> DesignStudy | None:
    from impactfem.stages.building.compute import mesh_of_run
    from impactfem.stages.design.compute import Keys, run_design
    from impactfem.stages.device.prepared import prepare as prepare_devices
    from impactfem.stages.transient.prepared import prepare

    mesh = mesh_of_run(case, folder)
    forces = folder / "forces.nc"
    members = _carried(case)
    with_devices = bool(members and case.devices)
    with steps.step("inputs"):
        inputs = on_root(lambda: STICKS.key(case))
        keys = on_root(
            lambda: Keys(
                basis=basis_key(case),
                device=model_key(case) if with_devices else "",
                members=_members_key(case) if members else "",
            )
        )
        if members:
            case = on_root(
                lambda: with_contact_of_run(with_structure_targets(case, folder), folder)
            )
        prepared = on_root(lambda: prepare(case, mesh, forces, storey_factor(folder), inputs))
        equipment = None
        if with_devices:
            equipment = on_root(lambda: prepare_devices(case, mesh, forces, storey_factor(folder)))
    return run_design(
        case,
        prepared,
        equipment,
        folder,
        communicator(),
        steps.step,
        keys=keys,
        within=steps.within,
    )


def _shown(case: Case, folder: Path) -> list[Path]:
    """Tables and figures from the store."""
    with open_store(folder / "design.nc") as store:
        products = design_products_of(
            store, folder / "sticks.nc", case.spectra.broadening, case.spectra.clipping
        )
        files = write_design_products(folder, products)
        files += design_figures(folder, products)
        return files + design_device(folder, store)


def _needs(case: Case) -> tuple[str, ...]:
    names = ["building", "sticks", TRANSIENT.name]
    if _carried(case):
        names.append("ensemble")
        names += [DEVICE.name] if case.devices else []
    return tuple(names)


DESIGN = Stage(
    name="design",
    steps=STEPS,
    rooms=DESIGN_ROOMS,
    key=_key,
    store="design.nc",
    run=_run,
    checks=lambda case, folder: design_checks(folder),
    lacks=lambda case: "transient" if case.transient is None else None,
    needs=_needs,
    collective=True,
)
