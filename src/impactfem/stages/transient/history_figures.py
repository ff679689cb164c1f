"""Figures of the 3D building in time: impact forces (11), mass centre (12), across a floor (16)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from impactfem.plot.style import BLUE, RED, figure, floor_colours, letter, ordered_colours
from impactfem.stages.stores import time_step
from impactfem.stages.transient.selection import (
    at_floor,
    forces_note,
    main_impact,
    of_sticks,
    shown_line,
    wave_floor,
)

Array = NDArray[np.float64]

BEFORE, AFTER = 0.5, 2.0
"""What is shown about the main impact, in parts of how long it lasts."""
SILENT = 1e-3
"""Part of its largest force below which a floor is left out there."""


def focus(response: xr.Dataset) -> tuple[float, float]:
    """Start and end of what is shown of the main impact [s].

    Raises:
        ValueError: There is no impact.
    """
    impact = main_impact(response)
    if impact is None:
        raise ValueError("there is no impact to look at")
    start, end = impact
    lasts, time = max(end - start, time_step(response)), response["time"].values
    return max(time[0], start - BEFORE * lasts), min(time[-1], end + AFTER * lasts)


def forces_figure(path: Path, response: xr.Dataset) -> None:
    """Figure 11: the forces on the edges of the floors, and the main impact."""
    time, force = response["time"].values, 1e-6 * response["edge_force"]
    floors = force["edge_floor"].values.tolist()
    colours = dict(zip(floors, floor_colours(len(floors)), strict=True))
    largest = abs(force).max("time")
    order = largest.argsort().values[::-1]
    main = floors[order[0]]
    caption = (
        "Figure 11: Impact forces on the edges of the floors of building "
        f"{response.attrs['building']} over time (a), and the main impact, of floor {main}, at the "
        "times of the 3D model (b). Positive in compression; samples every "
        f"{1e3 * time_step(response):g} ms, the straight lines between which are nearest in the "
        "mean square to the force of the sticks and keep its impulses: outside an impact the "
        "samples alternate about zero, and away from it fall to 27 % from one to the next."
    )
    with figure(path, (1, 2), (9.0, 3.4), caption) as (_, axes):
        first, last = focus(response)
        shown = (time >= first) & (time <= last)
        for k in order:
            floor, values = floors[k], force.isel(edge=k).values
            axes[0].plot(time, values, color=colours[floor], label=f"floor {floor}")
            if np.abs(values[shown]).max() > SILENT * float(largest[k]):
                axes[1].plot(time[shown], values[shown], color=colours[floor], marker=".", ms=4)
        axes[0].set_xlim(time[0], time[-1])
        _focus_axis(axes[1], first, last)
        for panel in axes:
            panel.set_xlabel("time [s]")
            panel.set_ylabel("impact force [MN]")
        handles, labels = axes[0].get_legend_handles_labels()
        by_floor = sorted(zip(labels, handles, strict=True), key=lambda e: -int(e[0].split()[-1]))
        axes[0].legend([h for _, h in by_floor], [name for name, _ in by_floor], loc="upper right")
        letter(axes)


def centre_figure(path: Path, response: xr.Dataset, sticks: xr.Dataset) -> None:
    """Figure 12: displacement and acceleration of the top floor's mass centre, 3D and sticks."""
    d, top = response["component"].item(), wave_floor(response)
    centre = at_floor(response, "centre", top)
    impact = main_impact(response) is not None
    last = ", and its main impact (c)" if impact else ""
    caption = (
        f"Figure 12: Displacement relative to the ground (a) and absolute acceleration (b) along "
        f"$e_{d}$ of the mass centre of floor {top}{last}: 3D model and sticks."
    )
    both = (
        ("displacement", 1e2, f"displacement $u_{d}$ [cm]"),
        ("acceleration", 1.0, f"acceleration $\\ddot u_{d}$ [m/s²]"),
    )
    panels = 3 if impact else 2
    with figure(path, (1, panels), (3.6 * panels, 3.2), caption) as (_, axes):
        for panel, (name, factor, label) in zip(axes, both, strict=False):
            _with_sticks(panel, factor * centre[name], of_sticks(sticks, name, response), factor)
            panel.set_ylabel(label)
            panel.set_xlim(*centre["time"].values[[0, -1]])
        if impact:
            name, factor, label = both[1]
            _with_sticks(axes[2], centre[name], of_sticks(sticks, name, response), factor)
            _focus_axis(axes[2], *focus(response))
            axes[2].set_ylabel(label)
        for panel in axes:
            panel.set_xlabel("time [s]")
        low, high = axes[0].get_ylim()
        axes[0].set_ylim(low, high + 0.25 * (high - low))
        axes[0].legend(loc="upper right", ncols=2)
        letter(axes)


def _with_sticks(
    panel: Axes, history: xr.DataArray, other: xr.DataArray | None, factor: float
) -> None:
    """The history of the 3D model on that of the sticks, where they have one."""
    if other is not None:
        panel.plot(other["time"], factor * other, color=RED, lw=0.8, ls="--", label="sticks")
    panel.plot(history["time"], history, color=BLUE, lw=0.8, label="3D")


def across_figure(path: Path, response: xr.Dataset) -> None:
    """Figure 16: acceleration at some distances from the impact, and the main impact."""
    impact = main_impact(response) is not None
    d, time = response["component"].item(), response["time"].values
    last = ", and the main impact (b)" if impact else ""
    caption = (
        f"Figure 16: Acceleration along $e_{d}$ of floor {wave_floor(response)} at distances d "
        f"from its impact edge, over time (a){last}. Points of figure 14.{forces_note(response)}"
    )
    panels = 2 if impact else 1
    histories = shown_line(response)["acceleration"].transpose("probe", "time")
    with figure(path, (1, panels), (9.0, 3.6), caption) as (_, axes):
        colours = ordered_colours(len(histories))
        for colour, values in zip(colours, histories, strict=True):
            label = f"d = {values['distance'].item():.1f} m"
            for panel in axes:
                panel.plot(time, values, color=colour, lw=0.8, label=label)
        axes[0].set_xlim(time[0], time[-1])
        if impact:
            _focus_axis(axes[1], *focus(response))
        for panel in axes:
            panel.set_xlabel("time [s]")
            panel.set_ylabel(f"acceleration $\\ddot u_{d}$ [m/s²]")
        axes[-1].legend(loc="lower right")
        letter(axes)


def _focus_axis(panel: Axes, first: float, last: float) -> None:
    panel.set_xlim(first, last)
    panel.xaxis.set_major_locator(MaxNLocator(5))
    panel.ticklabel_format(axis="x", useOffset=False)
