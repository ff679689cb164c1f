"""The stage `design`: design spectra of the 3D building, of one motion and of an ensemble."""

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.case import BuildingInTime, Case
from impactfem.stages.building.targets import with_structure_sticks
from impactfem.stages.calibrate.selection import with_contact_of_run
from impactfem.stages.calibrate.stage import CALIBRATE
from impactfem.stages.check import PROGRAM_FAULT, Check, Criterion
from impactfem.stages.design import figures
from impactfem.stages.design.figures import DesignData
from impactfem.stages.design.products import (
    design_products_of,
    share_reached,
    write_design_products,
)
from impactfem.stages.device.stage import DEVICE
from impactfem.stages.drawing import Figures
from impactfem.stages.ensemble.stage import ENSEMBLE
from impactfem.stages.pounding.stage import POUNDING, motions_key
from impactfem.stages.reduce.stage import REDUCE, model_key, models_of_run
from impactfem.stages.stage import DRAWING, StageOf
from impactfem.stages.stores import names_of, of_run, open_store
from impactfem.stages.transient.stage import TRANSIENT
from impactfem.system.log import Steps
from impactfem.system.parallel import on_root

COVERED = 0.95
"""Part of the envelope of all vertices of a floor that its points must have at every frequency."""
SAME = 1e-9
"""Largest relative difference of a member's impact forces from those of the stage `ensemble`."""


def _carried(case: Case) -> int:
    """Number of members that are carried through the 3D building."""
    return 0 if case.ensemble is None else case.ensemble.structure_motions


def members_key(building: BuildingInTime) -> str:
    """Hash of what members depend on in addition to their motions."""
    sections = ("transient", "devices", "device_analysis", "structure")
    keys = [motions_key(building, sections), REDUCE.key(building)]
    # The impact on the wall spreads forces along the edges, whatever the contact laws take of it.
    if CALIBRATE in TRANSIENT.needs(building):
        keys.append(CALIBRATE.key(building))
    return hashlib.sha256("".join(keys).encode()).hexdigest()


def _compute(building: BuildingInTime, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.stages.design.carrier import DesignInputs
    from impactfem.stages.design.compute import run_design
    from impactfem.stages.device.compute import prepare_devices
    from impactfem.stages.reduce.compute import reduced_on_root
    from impactfem.stages.transient.prepared import prepared_of_run

    case, run, members = building.case, building.run_folder(folder), _carried(building.case)
    equipment, shared = None, ""
    with steps.step("inputs"):
        inputs = on_root(lambda: POUNDING.key(case))
        reduced = reduced_on_root(folder, on_root(lambda: model_key(building)), building)
        if members:
            shared = on_root(lambda: members_key(building))
            case = on_root(lambda: with_contact_of_run(with_structure_sticks(case, run), run))
            building = replace(building, case=case)
        prepared = on_root(lambda: prepared_of_run(building, run, inputs))
        if members and building.devices:
            equipment = on_root(lambda: prepare_devices(prepared))
        models = on_root(lambda: models_of_run(case, run)) if members else None
    given = DesignInputs(prepared, reduced, equipment, models, shared)
    return run_design(given, folder, steps, key)


def _tabulate(building: BuildingInTime, folder: Path) -> list[Path]:
    """Write tables and products from the store."""
    with open_store(folder / "design.nc") as store:
        spectra = building.case.spectra
        products = design_products_of(
            store, of_run(folder, "pounding.nc"), spectra.broadening, spectra.clipping
        )
        return write_design_products(folder, products)


VERTICES = Criterion(
    "design.vertices",
    "vertices of the floors in the envelope",
    lower=1,
    consequence="The design spectra are envelopes of the points alone and may be too low between "
    "them",
    remedy="Set transient.fields or transient.field_frequencies",
    concerns=("design.frs.*",),
)
COVERAGE = Criterion(
    "design.coverage",
    "ordinates of the points relative to the envelope of all vertices of the floor",
    "%",
    lower=COVERED,
    consequence="The points of this floor do not represent it",
    remedy="Use the design spectra, which include the envelope of all vertices",
    concerns=("design.frs.*",),
)
FAILED_MOTIONS = Criterion(
    "design.failed_motions",
    "failed motions of the ensemble in 3D",
    upper=0,
    consequence="Percentiles are those of fewer motions",
    remedy="See run.log for the reason of each failure",
)
FORCE_DIFFERENCE = Criterion(
    "design.force_difference",
    "relative difference of the impact forces from those of the stage ensemble",
    upper=SAME,
    severity="invalid",
    consequence="Spectra of the ensemble in 3D belong to other impacts",
    remedy=PROGRAM_FAULT,
    concerns=("ensemble3d.*",),
)


def design_checks(folder: Path) -> list[Check]:
    """Return the checks of the stage, from `design.nc` of a run's folder."""
    with open_store(folder / "design.nc") as store:
        checks: list[Check] = []
        for direction in names_of(store, "direction"):
            if not store["vertex_count"].sel(direction=direction).any():
                continue
            # From the fields alone: the points are better sampled in the design spectra, which
            # would hide what they lack.
            share = share_reached(store).sel(direction=direction).dropna("station", how="all")
            worst = share.isel(share.argmin(["station", "whole_frequency"]))
            at = float(worst["whole_frequency"])
            where = f"at {at:.3g} Hz" if np.isfinite(at) else "of the peak acceleration"
            low = share["station_floor"].values[(share < COVERED).any("whole_frequency")]
            place = f"along {direction}, floor {worst['station_floor'].item()}, {where}"
            below = f"below the limit on {', '.join(f'floor {k}' for k in low)}" if low.size else ""
            checks.append(COVERAGE.check(float(worst), place, below))
        checks = checks or [VERTICES.check(0)]
        if "motion" in store.dims:
            of = f"of {store.sizes['motion']}"
            checks.append(FAILED_MOTIONS.check(store.sizes["failed"], of))
            checks += _checks_of_forces(of_run(folder, "ensemble.nc"), store)
    return checks


def _checks_of_forces(path: Path, store: xr.Dataset) -> list[Check]:
    """Compare the impact forces of each motion with those of the stage `ensemble`."""
    if not path.is_file():
        return []
    # Stage `pounding` has the forces of floors, not those inside storeys.
    force = store["member_impact_force"].isel(edge=store["edge_storey"].values == 0)
    scalars = [f"pounding.peak_force.floor_{floor}" for floor in force["edge"].values]
    with open_store(path) as ensemble:
        both = [name for name in names_of(store, "motion") if name in names_of(ensemble, "motion")]
        same = ensemble.attrs["studied_building"] == store.attrs["building"]
        if not same or not both or not set(scalars) <= set(names_of(ensemble, "scalar")):
            return []
        known = ensemble["value"].sel(motion=both, scalar=scalars).transpose("motion", ...).values
    differences = np.abs(force.sel(motion=both).values - known) / np.maximum(known, 1.0)
    return [FORCE_DIFFERENCE.check(float(differences.max(initial=0.0)))]


DESIGN = StageOf[BuildingInTime](
    name="design",
    title="Design spectra",
    about="Spectra enveloped over each floor and broadened.",
    headlines=(
        "floor spectra up to {design.frs.largest} below {design.frs.resolved_frequency}",
        "{ensemble3d.members} motions on the 3D model",
    ),
    steps={
        "inputs": 4.0,
        "sticks": 5.0,
        "vertices": 1.0,
        "members": 35.0,
        "stores": 1.0,
        DRAWING: 8.0,
    },
    sections=(),
    further=lambda building: f"{_carried(building.case)} members",
    stores={"design": "design.nc"},
    compute=_compute,
    tabulate=_tabulate,
    figures=Figures.of(DesignData, figures),
    checks=lambda building, folder: design_checks(folder),
    subjects=lambda case: case.in_time,
    section="transient",
    needs=lambda building: (
        REDUCE,
        TRANSIENT,
        *((ENSEMBLE,) if _carried(building.case) else ()),
        *((DEVICE,) if _carried(building.case) and building.devices else ()),
    ),
    collective=True,
)
