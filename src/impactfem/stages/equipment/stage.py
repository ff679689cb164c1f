"""The stage `equipment`: the items of an equipment list against their capacities."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.case import BuildingInTime, Case
from impactfem.device.equipment import LIGHT
from impactfem.stages.check import Check, Criterion
from impactfem.stages.device.selection import WITH, WITHOUT
from impactfem.stages.drawing import Figures
from impactfem.stages.equipment import figures
from impactfem.stages.equipment.demand import ItemDemand, both_demands
from impactfem.stages.equipment.figures import EquipmentData
from impactfem.stages.equipment.motion import FloorMotions, stick_motions
from impactfem.stages.equipment.store import demand_table, write_equipment, write_table
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.reduce.stage import REDUCE, model_key
from impactfem.stages.stage import DRAWING, StageOf
from impactfem.stages.stores import open_store
from impactfem.stages.transient.stage import TRANSIENT
from impactfem.stages.verdict import Verdict
from impactfem.system.log import Steps


def _in_3d(case: Case) -> tuple[BuildingInTime, ...]:
    """The buildings with items whose 3D model is computed in time."""
    named = {one.building for one in case.equipment}
    return tuple(one for one in case.in_time if one.name in named)


def _compute(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.stages.equipment.model_motion import model_motions
    from impactfem.stages.reduce.compute import reduced_on_soil
    from impactfem.stages.transient.prepared import prepared_of_run
    from impactfem.stages.transient.reduced_run import ReducedRun

    floors: dict[str, FloorMotions] = {}
    for building in _in_3d(case):
        own, highest = building.folder(folder), building.transient.maximum_frequency
        with steps.step("inputs"):
            basis = reduced_on_soil(own, model_key(building), building).basis
            prepared = prepared_of_run(building, folder, POUNDING.key(case))
        run = ReducedRun(basis, prepared.loads, prepared.damping, case.spectra, highest)
        with open_store(own / "transient.nc") as store:
            end = float(store.attrs["resolved_frequency"])
        floors[building.name] = model_motions(building, prepared.parts.mesh, run, end)
    demands: list[tuple[ItemDemand, ItemDemand]] = []
    with open_store(folder / "pounding.nc") as store, steps.step("items"):
        for name in {one.building for one in case.equipment} - floors.keys():
            floors[name] = stick_motions(store, name)
        for number, item in enumerate(case.equipment, 1):
            demands.append(both_demands(item, floors[item.building], case))
            steps.within("items", number / len(case.equipment))
    write_equipment(folder / "equipment.nc", case, floors, demands, key)
    return [folder / "equipment.nc"]


def _tabulate(case: Case, folder: Path) -> list[Path]:
    with open_store(folder / "equipment.nc") as store:
        return write_table(folder, demand_table(store))


MASS_RATIO = Criterion(
    "equipment.mass_ratio",
    "mass of an item over the mass of its floor",
    "%",
    upper=LIGHT,
    consequence="The item changes the motion of its floor (US NRC SRP 3.7.2, II.3.B), which the "
    "equipment list leaves out",
    remedy="Describe the item in [[devices]], which are part of the 3D model",
    concerns=("equipment.*",),
)


def _checks(folder: Path) -> list[Check]:
    with open_store(folder / "equipment.nc") as store:
        ratio = store["mass_ratio"]
        k = int(ratio.values.argmax())
        return [MASS_RATIO.check(float(ratio[k]), str(store["item"].values[k]))]


KINDS = {
    "interaction": ("interaction of tension and shear in a bolt", "-"),
    "spectrum_ratio": ("floor spectrum / required spectrum", "-"),
    "zpa_ratio": ("zero-period acceleration / its limit", "-"),
}
"""Ratios that a verdict is made of: quantity and unit."""


def _verdicts(case: Case, folder: Path) -> list[Verdict]:
    """Return a verdict for each kind of capacity, that of the item with the largest ratio."""
    with open_store(folder / "equipment.nc") as store:
        return [
            _verdict(store, name, *words)
            for name, words in KINDS.items()
            if store[name].sel(impact=WITH).notnull().any()
        ]


def _verdict(store: xr.Dataset, name: str, quantity: str, unit: str) -> Verdict:
    hit, quiet = (store[name].sel(impact=impact).values for impact in (WITH, WITHOUT))
    k = int(np.nanargmax(hit))
    item = store.isel(item=k)
    count, known = int((hit > 1.0).sum()), int(np.isfinite(hit).sum())
    frequency = None
    if name == "spectrum_ratio":
        frequency = float(item["spectrum_frequency"].sel(impact=WITH))
    return Verdict(
        f"equipment.{name}",
        quantity,
        unit,
        f"{item['item'].item()}, floor {item['item_floor'].item()} of "
        f"{item['item_building'].item()}",
        float(hit[k]),
        1.0,
        "equipment",
        float(quiet[k]),
        frequency=frequency,
        band=(0.0, float(item["resolved"])),
        detail=f"{count} of {known} items exceed it; products/equipment.csv lists all",
    )


EQUIPMENT = StageOf[Case](
    name="equipment",
    title="Equipment list",
    about="Forces on bolts, floor spectra and accelerations of the items of the equipment list.",
    headlines=("{equipment.items} items, {equipment.exceeded} beyond a capacity",),
    steps={"inputs": 2.0, "items": 20.0, DRAWING: 1.0},
    sections=(*POUNDING.sections, "equipment", "device_analysis"),
    stores={"equipment": "equipment.nc"},
    compute=_compute,
    tabulate=_tabulate,
    figures=Figures.of(EquipmentData, figures),
    checks=lambda case, folder: _checks(folder),
    verdicts=_verdicts,
    subjects=lambda case: (case,) if case.equipment else (),
    section="equipment",
    needs=lambda case: (POUNDING, *((REDUCE, TRANSIENT) if _in_3d(case) else ())),
)
