"""The figure, table and checks of the stage `sensitivity`: tornado charts of the demands."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from impactfem.plot.figure import figure
from impactfem.plot.style import BLUE, RED, letter, sheet
from impactfem.plot.table import FACTORS, Table, cell, heads
from impactfem.stages.check import Check, Criterion
from impactfem.stages.drawing import FigureData
from impactfem.stages.sensitivity.variations import WORDS
from impactfem.stages.stores import names_of, open_store

PANELS = 9
"""Most panels of the figure: of each verdict the place with the largest demand."""
SHOWN = {"N": "kN", "m": "mm", "m/s2": "m/s²"}
"""Units of the axes."""
UNCHANGED = 5e-4
"""Change up to which a bar has no label."""
NARROW, ROOM = 0.02, 0.25
"""Least change that an axis reaches; part of its length that is left for labels at either end."""
HEIGHT = 0.7
"""Height of the bars of a parameter, over the distance of two parameters."""


class SensitivityData(FigureData):
    """The data of the figure of the stage."""

    @cached_property
    def sensitivity(self) -> xr.Dataset | None:
        """`sensitivity.nc`; None without a variation or a demand that is not zero."""
        store = self.opened("sensitivity.nc")
        return store if shown_demands(store) and store.sizes["variation"] else None


def shown_demands(store: xr.Dataset) -> list[int]:
    """Return the demands of the figure: of each verdict the one with the largest value or ratio."""
    value, capacity = store["value"].values, store["capacity"].values
    size = np.where(np.isfinite(capacity) & (capacity > 0.0), value / capacity, value)
    largest: dict[str, int] = {}
    for k, id in enumerate(store["demand_id"].values.astype(str)):
        if not value[k] > 0.0:
            continue
        if id not in largest or size[k] > size[largest[id]]:
            largest[id] = k
    # Devices come first: they are what the other demands are for.
    order = sorted(largest.values(), key=lambda k: str(store["demand_id"][k].item())[0] != "d")
    return order[:PANELS]


@figure("sensitivity", "uncertainty", "Sensitivity of the demands")
def sensitivity_figure(path: Path, sensitivity: xr.Dataset) -> None:
    """Draw a tornado chart of each verdict: value and change by parameter, the largest first."""
    shown = shown_demands(sensitivity)
    columns = min(2, len(shown))
    rows = -(-len(shown) // columns)
    count = len(set(names_of(sensitivity, "parameter")))
    caption = (
        "Demands with one changed parameter, against those of the run (vertical line): value "
        "below, change above. Parameters with the largest change are at the top. Dashed: capacity."
    )
    size = (4.9 * columns, (0.9 + 0.24 * count) * rows + 0.2)
    seen = "; ".join(_words(sensitivity, k) for k in shown)
    with sheet(path, (rows, columns), size, caption, f"{len(shown)} tornado charts: {seen}.") as (
        _,
        axes,
    ):
        for panel, k in zip(axes, shown, strict=False):
            _tornado(panel, sensitivity.isel(demand=k))
        for panel in axes[len(shown) :]:
            panel.set_axis_off()
        letter(axes[: len(shown)])


def _words(store: xr.Dataset, k: int) -> str:
    """Return the largest change of a demand in words."""
    change = store["change"].isel(demand=k)
    words = f"{store['demand_quantity'][k].item()}, {store['demand_place'][k].item()}"
    if not np.isfinite(change).any():
        return words
    at = change.isel(variation=int(np.nanargmax(np.abs(change.values))))
    return f"{words}: {100.0 * float(at):+.3g} %, {at['variation'].item()}"


def _tornado(panel: Axes, one: xr.Dataset) -> None:
    """Draw the bars of a demand: a row for each parameter, a bar for each setting."""
    unit = str(one["demand_unit"].item())
    drift = str(one["demand_id"].item()).endswith("drift")
    shown = "%" if drift else SHOWN.get(unit, unit)
    factor = FACTORS.get(shown, 1.0)
    base, change = factor * float(one["value"]), one["change"].values
    groups: dict[str, list[int]] = {}
    for k, name in enumerate(one["parameter"].values.astype(str)):
        if np.isfinite(change[k]):
            groups.setdefault(name, []).append(k)
    order = sorted(groups, key=lambda name: np.abs(change[groups[name]]).max())
    for row, name in enumerate(order):
        height = HEIGHT / len(groups[name])
        for place, k in enumerate(groups[name]):
            y = row + 0.5 * HEIGHT - (place + 0.5) * height
            width = base * change[k]
            panel.barh(y, width, left=base, height=height, color=RED if width > 0.0 else BLUE)
            if abs(change[k]) > UNCHANGED:
                side = "left" if width > 0.0 else "right"
                text = f" {one['setting'].values[k]} "
                panel.text(base + width, y, text, ha=side, va="center", fontsize=6.5)
    panel.axvline(base, color="black", lw=0.9)
    known = change[np.isfinite(change)]
    low, high = min(-NARROW, known.min(initial=0.0)), max(NARROW, known.max(initial=0.0))
    room = ROOM * (high - low)
    ends = base * (1.0 + low - room), base * (1.0 + high + room)
    capacity = factor * float(one["capacity"])
    if ends[0] <= capacity <= ends[1]:
        panel.axvline(capacity, color="black", lw=0.9, ls="--")
    panel.set_xlim(*ends)
    panel.set_yticks(range(len(order)), [WORDS[name] for name in order], fontsize=7.5)
    panel.grid(visible=False, axis="y")
    panel.set_xlabel(f"{one['demand_quantity'].item()} [{shown}]", fontsize=7.5)
    panel.set_title(str(one["demand_place"].item()), fontsize=8.0)
    above = panel.secondary_xaxis(
        "top",
        functions=(
            lambda x: 100.0 * (np.asarray(x) / base - 1.0),
            lambda p: base * (1.0 + 0.01 * np.asarray(p)),
        ),
    )
    above.set_xlabel("change [%]", fontsize=7.5)
    for axis in (panel.xaxis, above.xaxis):
        axis.set_major_locator(MaxNLocator(5))
        axis.set_tick_params(labelsize=7.0)


def sensitivity_table(store: xr.Dataset) -> Table:
    """Return the demands of all variations, a row each."""
    rows = []
    for k in range(store.sizes["demand"]):
        one = store.isel(demand=k)
        about = tuple(str(one[f"demand_{name}"].item()) for name in ("quantity", "place", "unit"))
        for v in range(store.sizes["variation"]):
            at = one.isel(variation=v)
            name = str(at["parameter"].item())
            texts = WORDS[name], str(at["setting"].item()), str(at["keys"].item())
            numbers = (cell(float(at[n])) for n in ("value", "varied"))
            rows.append((*about, *texts, *numbers, cell(100.0 * float(at["change"]))))
    columns = "demand; place; unit; parameter; setting; keys; run; variation; change [%]"
    title = "Demands with one changed parameter, in the resolved band of the run"
    return Table("sensitivity", title, heads(columns), tuple(rows))


VERDICTS = Criterion(
    "sensitivity.changed_verdicts",
    "demands within the capacity that exceed it with a changed parameter",
    upper=0,
    consequence="The verdict depends on a parameter that is not exactly known",
    remedy="See tables/sensitivity.csv; determine the parameter, or provide a larger capacity",
)
FAILED = Criterion(
    "sensitivity.failed",
    "variations without a result",
    upper=0,
    consequence="The sensitivity to these parameters is not known",
    remedy="See run.log for the reason, or remove the parameter from sensitivity.parameters",
)
BASIS = Criterion(
    "sensitivity.damping_basis_error",
    "error of the reduced models with the changed damping, largest ordinates in the resolved band",
    "%",
    upper=0.1,
    consequence="The sensitivity to damping may be wrong by this error",
    remedy="Lower transient.tolerance, or add such a damping to [[damping_cases]] and set "
    "transient.serve_damping_cases = true",
)
OMITTED = Criterion("sensitivity.left_out", "impulse that is left out / largest impulse", "%")
UNKNOWN = Criterion("sensitivity.unknown", "sensitivity that is not known")


def sensitivity_checks(folder: Path) -> list[Check]:
    """Return the checks of the stage, from `sensitivity.nc` of a run's folder."""
    with open_store(folder / "sensitivity.nc") as store:
        failed = names_of(store, "failed")
        checks = [FAILED.check(len(failed), f"of {store.sizes['variation']}", ", ".join(failed))]
        within = (store["value"] <= store["capacity"]).values
        if within.any():
            over = (store["varied"] > store["capacity"]).transpose("variation", "demand").values
            changed = np.flatnonzero(within & over.any(axis=0))
            demands = [names_of(store, "demand")[k] for k in changed]
            checks.append(VERDICTS.check(len(changed), f"of {within.sum()}", "; ".join(demands)))
        if np.isfinite(error := float(store["damping_basis_error"])):
            checks.append(BASIS.check(error))
        left_out = store["left_out"].fillna(0.0)
        if (left_out > 0.0).any():
            at = left_out.isel(variation=int(left_out.values.argmax()))
            detail = "a floor is struck that transient.floors does not list"
            checks.append(OMITTED.check(float(at), str(at["variation"].item()), detail))
        unknown = zip(names_of(store, "unknown"), store["unknown_reason"].values, strict=True)
        checks += [UNKNOWN.check(place=WORDS[name], detail=str(why)) for name, why in unknown]
    return checks
