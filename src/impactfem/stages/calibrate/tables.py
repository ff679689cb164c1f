"""Tables of the stage `calibrate`: the paper's values beside ours, impacts, damping cases."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.plot.table import (
    FACTORS,
    Cell,
    Table,
    beside_published,
    columns_of,
    write_tables,
)
from impactfem.stages.calibrate.impact import WallImpact
from impactfem.stages.calibrate.selection import MODEL, STICK, damping_ratios, half_wave, impacts_of
from impactfem.stages.results import item_cells
from impactfem.stages.stores import open_store
from impactfem.system.scalar import scalars_of

PRINTED = "printed"
"""End of the names of published restitutions in the order in which the paper prints them."""


def wall_tables(folder: Path, published: Mapping[str, float]) -> list[Path]:
    """Write the tables of `calibrate.nc`, with published values by the name of the result."""
    with open_store(folder / "calibrate.nc") as store:
        # Figures 6 and 7 and table 5 of the paper: the stage's scalars, published ones first.
        shown = sorted(scalars_of(store), key=lambda scalar: scalar.name not in published)
        title = f"Impact of building {store.attrs['building']} on a rigid wall"
        values = beside_published("wall_calibration", title, shown, published)
        tables = [values, _impacts(store), _dampings(store, published)]
    return write_tables(folder, tables)


def _impacts(store: xr.Dataset) -> Table:
    """All impacts by floor; a floor without an impact has a row with its smallest distance."""
    heads, _ = item_cells(WallImpact, (), FACTORS)
    rows: list[tuple[Cell, ...]] = []
    for kind, which in (("3D", MODEL), ("stick", STICK)):
        for floor in reversed(impacts_of(store, which)):
            _, cells = item_cells(WallImpact, floor.impacts, FACTORS)
            for number, row in enumerate(cells or [(None,) * len(heads)], start=1):
                impact = number if floor.impacts else 0
                rows.append((kind, floor.floor, impact, 1e3 * floor.closest, *row))
    places = (("model", ""), ("floor", ""), ("impact", ""), ("nearest", "mm"))
    title = f"Impacts of the floors of building {store.attrs['building']} on the rigid wall"
    return Table("wall_impacts", title, (*places, *heads), tuple(rows))


def _dampings(store: xr.Dataset, published: Mapping[str, float]) -> Table:
    """Table 8 of the paper, whose restitutions are printed in one order and described in the other.

    The text says that ε grows as damping falls; the printed row falls with it.
    """
    frequency = half_wave(store)
    others = [str(case) for case in store["case"].values[1:]]
    described = [published.get("calibration.epsilon", np.nan)]
    # The middle one is the building's own, and the same in both orders.
    printed = [*described]
    for case in others:
        described.append(published.get(f"calibration.epsilon.{case}", np.nan))
        printed.append(published.get(f"calibration.epsilon.{case}.{PRINTED}", np.nan))
    top = int(store["floor"][-1])
    return columns_of(
        store.assign(
            ratio=damping_ratios(store, frequency),
            described=("case", described),
            printed=("case", printed),
        ),
        "wall_damping",
        f"First impact of floor {top} of building {store.attrs['building']} on the rigid wall by "
        "the damping of the building",
        [
            ("case", "damping", ""),
            ("mass_coefficient", "alpha", "1/s"),
            ("stiffness_coefficient", "beta", "s"),
            ("ratio", f"xi at {frequency:.3g} Hz", "%"),
            ("epsilon", "epsilon", "-"),
            ("described", "by the text", "-"),
            ("printed", "as printed", "-"),
            ("xi_c", "xi_c", "-"),
            ("K_Ceq", "K_Ceq", "N/m"),
            ("impact_time", "start", "s"),
            ("impact_duration", "duration", "ms"),
            ("impulse", "impulse", "kN s"),
            ("approach_velocity", "approach", "m/s"),
        ],
    ).comparing(
        {"by the text", "as printed"},
        "; beside the published values in the order that the text describes and as printed",
    )
