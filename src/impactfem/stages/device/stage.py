"""The stage `device`: devices in the 3D model and by response spectra, for every damping case."""

from dataclasses import replace
from pathlib import Path

import xarray as xr

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
from impactfem.stages.check import Check, limited
from impactfem.stages.device.figures import device_figures
from impactfem.stages.device.selection import LOADS, Load, anchor_of, direction, loaded, restitution
from impactfem.stages.device.tables import device_tables
from impactfem.stages.device.verdict import anchors, pounding, shortfall
from impactfem.stages.inputs import published_values
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.reduce.stage import REDUCE, model_key, models_of_run
from impactfem.stages.stage import DRAWING, Stage
from impactfem.stages.stores import names_of, of_run, open_store
from impactfem.system.log import Steps
from impactfem.system.parallel import on_root
from impactfem.system.scalar import values_of

IMBALANCE = 1e-8
"""Largest difference of action and reaction at an anchor, of the largest force."""
BASIS = 0.005
"""Largest error of the transfer functions of the reduced basis."""
NODES = 3
"""Least number of floor nodes that spread an anchor; fewer hold it at a point or along a line."""


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
        laws, inputs = calibrated_laws(case), on_root(lambda: POUNDING.key(case))
        case = on_root(lambda: with_contact_of_run(with_structure_targets(case, folder), folder))
        forces = of_run(folder, "forces.nc")
        prepared = on_root(
            lambda: prepare_devices(
                case,
                prepare(
                    case, mesh, forces, storey_factor(folder), inputs, impulses_of_run(case, folder)
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


def device_checks(folder: Path) -> list[Check]:
    """The checks of the stage, from `device.nc` of a run's folder."""
    with open_store(folder / "device.nc") as opened:
        store = loaded(opened)
        lines = [line for name in names_of(store, "device") for line in _checks_of(store, name)]
        values = values_of(store)
        error, vectors = values["device.basis_error"], values["device.basis_vectors"]
        basis = f"error of the reduced basis of {vectors:.0f} vectors"
        lines.append(limited(basis, error, BASIS, "%"))
        for case in names_of(store, "case"):
            epsilon, source = restitution(store, case)
            which = "the restitution of the contact laws"
            if epsilon is not None:
                which = f"ε = {epsilon:.3g}, {source}"
            peak = float(store["impact_force"].sel(case=case))
            happens = f"largest impact force {1e-6 * peak:.4g} MN at the steps of the 3D model"
            # Without an impact there is nothing to compare.
            if not peak > 0.0:
                happens = "no impact happens, both loads are the same"
            lines.append((None if peak > 0.0 else False, f"damping {case}: {which}; {happens}"))
        # What the response spectrum analyses assumed.
        lines += [(None, str(note)) for note in store["note"].values]
    return [(good, f"device: {text}") for good, text in lines]


def _checks_of(store: xr.Dataset, name: str) -> list[Check]:
    """What holds with the building's own damping in words, and of its anchor with any damping."""
    demand = ", ".join(
        f"{1e-3 * Load(store, name, impact).detailed:.4g} kN {words}"
        for impact, words in LOADS.items()
    )
    lines: list[Check] = [(None, f"F{direction(store)} of {name} on the floor: {demand}")]
    lines += [
        (None, f"{name}: {text}") for text in (*shortfall(store, name), pounding(store, name))
    ]

    _, floor, nodes = anchor_of(store, name)
    text = f"{name} on floor {floor}: nodes that it is anchored to"
    met, text = limited(text, nodes, NODES, least=True)
    more = "; fewer do not spread it over the slab: refine the mesh around its anchor"
    lines.append((met, text if met else text + more))

    # Whether the weight holds the device down, with any damping; else it needs its anchors.
    if (pulled := anchors(store, name)) is None:
        lines.append((None, f"the weight of {name} is not known, nor its tension"))
    else:
        held = not bool((store["net_tension"].sel(device=name) > 0.0).any())
        words = "its weight holds it down" if held else "it needs anchors in tension"
        lines.append((held, f"{name}: {words}; net tension at the anchor: {pulled}"))

    imbalance = store["imbalance"].sel(device=name)
    if not imbalance.notnull().any():
        lines.append((None, f"{name} has no free spring, its base forces cannot be compared"))
        return lines
    largest = imbalance.isel(imbalance.argmax(...))
    worst = float(largest)
    text = f"{name}: difference of action and reaction at the anchor"
    met, text = limited(text, worst, IMBALANCE)
    where = f", damping {largest['case'].item()}, {LOADS[largest['impact'].item()]}"
    lines.append((met, text if met else text + where))
    return lines


DEVICE = Stage(
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
