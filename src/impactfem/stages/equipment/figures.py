"""The figure of the stage: the items with the largest ratios of demand to capacity."""

from functools import cached_property

import numpy as np
import xarray as xr

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.figure import figure
from impactfem.plot.style import BLUE, ORANGE, RED
from impactfem.stages.device.selection import WITH, WITHOUT
from impactfem.stages.drawing import FigureData


class EquipmentData(FigureData):
    """The data of the figure."""

    @cached_property
    def store(self) -> xr.Dataset:
        """`equipment.nc`."""
        return self.opened("equipment.nc")


@figure(
    "equipment_ratios",
    "Equipment list",
    "Demand over capacity of the items",
    when=lambda store: bool(store["ratio"].notnull().any()),
)
def equipment_ratios(store: xr.Dataset) -> CurveFigure:
    """Draw the governing ratio of all items in descending order, with and without impacts."""
    hit = store["ratio"].sel(impact=WITH).dropna("item")
    order = np.argsort(-hit.values, kind="stable")
    quiet = store["ratio"].sel(impact=WITHOUT, item=hit["item"].values[order]).values
    rank = np.arange(1.0, order.size + 1.0)
    exceeded = int((hit.values > 1.0).sum())
    curves = [
        Curve(rank, hit.values[order], "with impacts", BLUE, marker="o"),
        Curve(rank, quiet, "without impact", ORANGE, "", marker="s"),
        Curve(np.array([0.5, rank[-1] + 0.5]), np.ones(2), "capacity", RED, "--"),
    ]
    worst = hit["item"].values[order[0]]
    caption = (
        f"Governing ratio of demand to capacity of {order.size} item{'s' * (order.size > 1)}, the "
        f"largest first: {worst}. "
        f"{exceeded} exceed a capacity with impacts, {int((quiet > 1.0).sum())} without. "
        "products/equipment.csv lists all items."
    )
    panel = Panel("rank of the item", "demand / capacity [-]", curves, bottom=0.0)
    return CurveFigure(caption, [panel], columns=1, size=(6.5, 3.4))
