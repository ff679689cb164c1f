"""The results file of the stage, `equipment.nc`, and its table as CSV and workbook."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from impactfem.case import Case
from impactfem.plot.table import FACTORS, Cell, Table, cell, declared
from impactfem.stages.device.selection import WITH, WITHOUT
from impactfem.stages.equipment.demand import ItemDemand
from impactfem.stages.equipment.motion import FloorMotions
from impactfem.stages.results import outputs, values
from impactfem.stages.stores import Output, dataset
from impactfem.system.files import atomic, write_netcdf
from impactfem.system.scalar import Scalar

OUTPUTS = {
    "item": Output("item", "", "tag"),
    "impact": Output("impact", "", "with impacts or without"),
    "item_building": Output("item", "", "building", label=True),
    "item_floor": Output("item", "", "floor", label=True),
    "item_model": Output("item", "", "model of the floor, stick or structure", label=True),
    "mass": Output("item", "kg", "mass"),
    "mass_ratio": Output("item", "-", "mass of the item over that of its floor", shown="%"),
    "resolved": Output("item", "Hz", "end of the resolved band"),
    **outputs(ItemDemand, "item impact"),
}
TABLE = "equipment"
"""Name of the table and of the workbook."""
COMPARED = ("zpa", "shear_force", "moment", "uplift", "bolt_tension", "bolt_shear")
RATIOS = ("interaction", "spectrum_ratio", "zpa_ratio", "ratio")
"""Columns of the table, with impacts; the ratios without impacts as well."""

Demands = Sequence[tuple[ItemDemand, ItemDemand]]


def write_equipment(
    path: Path, case: Case, floors: Mapping[str, FloorMotions], demands: Demands, key: str
) -> None:
    """Write the results file.

    Args:
        path: The file.
        case: The case.
        floors: The motions of the floors by building.
        demands: Of each item, without and with impacts.
        key: Hash of the inputs of the stage.
    """
    items = case.equipment
    places = [floors[one.building] for one in items]
    found = {
        "item": [one.tag for one in items],
        "impact": [WITHOUT, WITH],
        "item_building": [one.building for one in items],
        "item_floor": [one.floor for one in items],
        "item_model": [one.model for one in places],
        "mass": [one.mass for one in items],
        "mass_ratio": [
            one.mass / place.mass[one.floor] for one, place in zip(items, places, strict=True)
        ],
        "resolved": [one.end for one in places],
        **values(ItemDemand, [list(pair) for pair in demands]),
    }
    ratios = np.array([hit.ratio for _, hit in demands])
    exceeded = float((ratios > 1.0).sum())
    scalars = [
        Scalar("equipment.items", float(len(items)), "-", "items of the equipment list"),
        Scalar("equipment.exceeded", exceeded, "-", "items beyond a capacity"),
    ]
    attributes = {"title": case.title, "inputs": key}
    write_netcdf(path, dataset(OUTPUTS, found, attributes=attributes, scalars=scalars))


def demand_table(store: xr.Dataset) -> Table:
    """Return demand against capacity, a row for each item, the largest ratio first."""
    hit, quiet = store.sel(impact=WITH), store.sel(impact=WITHOUT)
    columns: list[tuple[str, str, list[Cell]]] = [
        ("tag", "", store["item"].values.tolist()),
        ("building", "", store["item_building"].values.tolist()),
        ("floor", "", store["item_floor"].values.tolist()),
        ("model of the floor", "", store["item_model"].values.tolist()),
        _column(store, "mass_ratio"),
        *(_column(hit, name) for name in (*COMPARED, *RATIOS)),
        *(_column(quiet, name, " without impact") for name in RATIOS),
    ]
    verdicts: list[Cell] = [
        None if np.isnan(one) else "exceeded" if one > 1.0 else "passed"
        for one in hit["ratio"].values
    ]
    columns.append(("verdict", "", verdicts))
    # Items without a capacity are last.
    order = np.argsort(-np.nan_to_num(hit["ratio"].values, nan=-1.0), kind="stable")
    rows = tuple(tuple(values[k] for _, _, values in columns) for k in order)
    heads = tuple((name, unit) for name, unit, _ in columns)
    return Table(TABLE, "Equipment: demand against capacity", heads, rows)


def _column(store: xr.Dataset, name: str, words: str = "") -> tuple[str, str, list[Cell]]:
    heading, unit = declared(store[name])
    factor = FACTORS.get(unit, 1.0)
    return f"{heading}{words}", unit, [cell(factor * one) for one in store[name].values]


def write_table(folder: Path, table: Table) -> list[Path]:
    """Write the table as CSV and as workbook into `products/` of a run's folder."""
    target = folder / "products"
    target.mkdir(exist_ok=True)
    book = target / f"{TABLE}.xlsx"
    with atomic(book) as temporary, pd.ExcelWriter(temporary, engine="openpyxl") as writer:
        table.frame.to_excel(writer, sheet_name=TABLE, index=False, freeze_panes=(1, 1))
    return [table.write_csv(target), book]
