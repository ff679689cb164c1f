"""The stage `device`: devices in the 3D model and by response spectra, for every damping case."""

from dataclasses import replace
from pathlib import Path

from impactfem.case import Case
from impactfem.case.transient import transient_files
from impactfem.stages.building.stage import storey_factor
from impactfem.stages.building.targets import with_structure_targets
from impactfem.stages.calibrate.selection import (
    calibrated_laws,
    calibrated_restitutions,
    impulses_of_run,
    with_contact_of_run,
)
from impactfem.stages.calibrate.stage import CALIBRATE
from impactfem.stages.device.checks import device_checks
from impactfem.stages.device.figures import device_figures
from impactfem.stages.device.tables import device_tables
from impactfem.stages.inputs import published_values
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.reduce.stage import REDUCE, model_key, models_of_run
from impactfem.stages.stage import DRAWING, Stage
from impactfem.stages.stores import of_run
from impactfem.system.log import Steps
from impactfem.system.parallel import on_root


def _compute(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.dynamics.checkpoints import remove_checkpoints
    from impactfem.stages.building.compute import mesh_of_run
    from impactfem.stages.device.compute import prepare_devices, run_devices
    from impactfem.stages.device.full_order import full_checkpoints
    from impactfem.stages.device.store import write_devices
    from impactfem.stages.reduce.compute import reduced_on_root
    from impactfem.stages.transient.prepared import prepare

    mesh = mesh_of_run(case, folder)
    with steps.step("inputs"):
        laws = calibrated_laws(case)
        case = on_root(lambda: with_contact_of_run(with_structure_targets(case, folder), folder))
        forces = of_run(folder, "forces.nc")
        prepared = on_root(
            lambda: prepare_devices(
                case,
                prepare(
                    case, mesh, forces, storey_factor(folder), "", impulses_of_run(case, folder)
                ),
                laws,
                calibrated_restitutions(case, folder),
            )
        )
        if case.damping_cases:
            models = on_root(lambda: models_of_run(case, folder))
            prepared = replace(prepared, models=models)
        reduced = reduced_on_root(folder, on_root(lambda: model_key(case)), case)
    model = None if reduced is None else reduced.complete
    study = run_devices(case, prepared, folder, steps, model=model, key=key)

    def write() -> list[Path]:
        if study is None:
            return []
        with steps.step("stores"):
            write_devices(folder / "device.nc", study, key)
        # Last of all: until here a failure costs no time steps.
        for place in full_checkpoints(folder):
            remove_checkpoints(place)
        return [folder / "device.nc"]

    return on_root(write)


DEVICE = Stage(
    name="device",
    title="Devices",
    about="Forces on the anchors in the 3D model and by response spectrum analysis.",
    headlines=(
        "3D model with impacts {device.f*.detailed.impact}",
        "3D model without impact {device.f*.detailed.no_impact}",
        "spectrum analysis with impacts {device.f*.rsa.impact}",
    ),
    steps={
        "inputs": 4.0,
        "matrices": 0.0,
        "time steps": 0.0,
        "damping cases": 40.0,
        "stores": 3.0,
        DRAWING: 10.0,
    },
    sections=(
        *POUNDING.sections,
        "structure",
        "transient",
        "devices",
        "device_analysis",
        "damping_cases",
    ),
    files=lambda case: transient_files(case.transient) if case.transient is not None else (),
    computed_by=("compute", "store"),
    drawn_by=("figures", "tables"),
    stores={"device": "device.nc"},
    compute=_compute,
    draw=lambda case, folder: [
        *device_tables(folder, published_values(case)),
        *device_figures(folder, published_values(case)),
    ],
    checks=lambda case, folder: device_checks(folder),
    lacks=lambda case: (
        "transient" if case.transient is None else None if case.devices else "devices"
    ),
    # The impact on the wall gives the restitution of each damping case.
    needs=lambda case: (
        REDUCE,
        *((CALIBRATE,) if case.whole.wall_impact is not None else ()),
        POUNDING,
    ),
    collective=True,
    each=True,
)
