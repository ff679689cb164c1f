"""The stage `device`: devices in the 3D model and by response spectra, for every damping case."""

import math
from dataclasses import replace
from pathlib import Path

import xarray as xr

from impactfem.case import BuildingInTime
from impactfem.case.devices import NODES
from impactfem.case.transient import transient_files
from impactfem.stages.building.targets import with_structure_sticks
from impactfem.stages.calibrate.selection import (
    calibrated_laws,
    calibrated_restitutions,
    with_contact_of_run,
)
from impactfem.stages.calibrate.stage import CALIBRATE
from impactfem.stages.check import PROGRAM_FAULT, Check, Criterion
from impactfem.stages.device import figures, floor_map, model_figures, pictures
from impactfem.stages.device.capacity import device_verdicts
from impactfem.stages.device.figures import DeviceData
from impactfem.stages.device.selection import (
    DETAILED,
    LOADS,
    Load,
    anchor_of,
    direction,
    loaded,
    restitution,
)
from impactfem.stages.device.tables import device_tables
from impactfem.stages.device.verdict import causes
from impactfem.stages.drawing import Figures
from impactfem.stages.inputs import published_values
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.reduce.stage import REDUCE, model_key, models_of_run
from impactfem.stages.stage import DRAWING, StageOf
from impactfem.stages.stores import names_of, of_run, open_store
from impactfem.system.log import Steps
from impactfem.system.parallel import on_root

IMBALANCE = 1e-8
"""Largest difference of action and reaction at an anchor, of the largest force."""
BASIS = 0.005
"""Largest error of the transfer functions of the reduced basis."""


def _compute(building: BuildingInTime, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.stages.device.compute import prepare_devices, run_devices
    from impactfem.stages.device.store import write_devices
    from impactfem.stages.reduce.compute import reduced_on_root
    from impactfem.stages.transient.prepared import contact_limit, prepared_of_run

    case, run = building.case, building.run_folder(folder)
    with steps.step("inputs"):
        laws, inputs = calibrated_laws(case), on_root(lambda: POUNDING.key(case))
        case = on_root(lambda: with_contact_of_run(with_structure_sticks(case, run), run))
        building = replace(building, case=case)
        prepared = on_root(
            lambda: prepare_devices(
                prepared_of_run(building, run, inputs),
                laws,
                calibrated_restitutions(case, run),
            )
        )
        if case.damping_cases:
            models = on_root(lambda: models_of_run(case, run))
            prepared = replace(prepared, models=models)
        reduced = reduced_on_root(folder, on_root(lambda: model_key(building)), building)
    model = None if reduced is None else reduced.complete
    study = run_devices(prepared, steps, model=model)

    def write() -> list[Path]:
        if study is None:
            return []
        with steps.step("stores"):
            contact = contact_limit(study.prepared, of_run(folder, "pounding.nc"))
            write_devices(folder / "device.nc", study, key, contact)
        return [folder / "device.nc"]

    return on_root(write)


FORCE = Criterion("device.force", "force on the floor")
RSA = Criterion(
    "device.rsa_error", "(detailed - RSA) / detailed, RSA = response spectrum analysis", "%"
)
ANCHOR_NODES = Criterion(
    "device.anchor_nodes",
    "nodes of the mesh under the base plate",
    lower=NODES,
    consequence="Fewer nodes do not spread the anchor force over the slab: local accelerations and "
    "forces are too large",
    remedy="Raise devices.radius, or reduce buildings.structure.mesh.floor_size",
    concerns=("device.*",),
)
NET_TENSION = Criterion(
    "device.net_tension",
    "net tension of the most highly loaded anchor, with any damping",
    "kN/n",
    upper=0.0,
    consequence="The weight does not hold the equipment down: it needs anchors in tension",
    remedy="Set devices.anchors: the report then compares the bolts with their capacity",
)
IMBALANCE_AT_ANCHOR = Criterion(
    "device.imbalance",
    "relative difference of action and reaction at the anchor",
    upper=IMBALANCE,
    severity="invalid",
    consequence="The forces on the anchors are wrong",
    remedy=PROGRAM_FAULT,
    concerns=("device.*",),
)
BASIS_ERROR = Criterion(
    "device.basis_error",
    "error of the reduced basis",
    "%",
    upper=BASIS,
    consequence="Forces on the anchors may be wrong by this error",
    remedy="Raise transient.largest_basis, or lower transient.tolerance",
    concerns=("device.*",),
)
IMPACT = Criterion(
    "device.impact_force",
    "largest impact force at the steps of the 3D model",
    "MN",
    lower=1e-6,
    consequence="No impact happens: the results with and without impact are the same",
    remedy="Check gaps and motions, or remove [[contacts]]",
)
ASSUMPTION = Criterion("device.assumption", "assumption of response spectrum analysis")


def device_checks(folder: Path) -> list[Check]:
    """Return the checks of the stage, from `device.nc` of a run's folder."""
    with open_store(folder / "device.nc") as opened:
        store = loaded(opened)
        checks = [check for name in names_of(store, "device") for check in _checks_of(store, name)]
        vectors = f"{int(store['basis_vectors'])} vectors"
        checks.append(BASIS_ERROR.check(float(store["basis_error"]), vectors))
        for case in names_of(store, "case"):
            epsilon, source = restitution(store, case)
            which = "restitution of the contact laws"
            if epsilon is not None:
                which = f"ε = {epsilon:.3g}, {source}"
            peak = 1e-6 * float(store["impact_force"].sel(case=case))
            checks.append(IMPACT.check(peak, f"damping {case}", which))
        # What the response spectrum analyses assumed.
        checks += [ASSUMPTION.check(detail=str(note)) for note in store["note"].values]
    return checks


def _checks_of(store: xr.Dataset, name: str) -> list[Check]:
    """Checks of a device with the building's own damping, and of its anchor with any damping."""
    demand = ", ".join(
        f"{1e-3 * Load(store, name, impact).detailed:.4g} kN {words}"
        for impact, words in LOADS.items()
    )
    checks = [FORCE.check(place=f"F{direction(store)} of {name}", detail=demand)]
    loads = [Load(store, name, impact) for impact in LOADS]
    for load in loads:
        parts = [f"{cause} {100.0 * part:.3g} %" for cause, part in causes(load).items()]
        place = f"F{direction(store)} of {name}, {LOADS[load.impact]}"
        reason = f"parts of the difference: {', '.join(parts)}" if parts else ""
        checks.append(RSA.check(load.difference(), place, reason))
    _, floor, nodes = anchor_of(store, name)
    checks.append(ANCHOR_NODES.check(nodes, f"{name} on floor {floor}"))
    # With any damping.
    pulled = [
        f"{LOADS[load.impact]} {1e-3 * load.tension():.3g} kN/n, net uplift "
        f"{1e-3 * load.uplift():.3g} kN, weight {1e-3 * load.weight:.3g} kN"
        for load in loads
        if math.isfinite(load.weight)
    ]
    if pulled:
        tension = float(store["net_tension"].sel(device=name, analysis=DETAILED).max())
        checks.append(NET_TENSION.check(1e-3 * tension, name, "; ".join(pulled)))
    else:
        checks.append(NET_TENSION.check(place=name, detail="the weight of the device is not known"))
    imbalance = store["imbalance"].sel(device=name)
    if not imbalance.notnull().any():
        detail = "the device has no free spring"
        return [*checks, IMBALANCE_AT_ANCHOR.check(place=name, detail=detail)]
    largest = imbalance.isel(imbalance.argmax(...))
    where = f"{name}, damping {largest['case'].item()}, {LOADS[largest['impact'].item()]}"
    return [*checks, IMBALANCE_AT_ANCHOR.check(float(largest), where)]


DEVICE = StageOf[BuildingInTime](
    name="device",
    title="Devices",
    about="Forces on the anchors in the 3D model and by response spectrum analysis.",
    headlines=(
        "first device with impacts F? {device.f?.detailed.impact}",
        "without impact F? {device.f?.detailed.no_impact}",
        "by spectrum with impacts F? {device.f?.rsa.impact}",
    ),
    steps={
        "inputs": 4.0,
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
    files=lambda building: transient_files(building.transient),
    stores={"device": "device.nc"},
    compute=_compute,
    tabulate=lambda building, folder: device_tables(folder, published_values(building)),
    figures=Figures.of(DeviceData, figures, floor_map, model_figures, pictures),
    checks=lambda building, folder: device_checks(folder),
    verdicts=device_verdicts,
    subjects=lambda case: tuple(one for one in case.in_time if one.devices),
    section="devices",
    # The impact on the wall gives the restitution of each damping case.
    needs=lambda building: (
        REDUCE,
        *((CALIBRATE,) if building.case.at_wall else ()),
        POUNDING,
    ),
    collective=True,
)
