"""Figures of the 3D building in time: impact forces (11), mass centre (12), across a floor (16)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from impactfem.plot.style import BLUE, RED, figure, floor_colours, letter, ordered_colours
from impactfem.stages.transient.view import TransientView, stick_history, stick_station

Array = NDArray[np.float64]

BEFORE, AFTER = 0.5, 2.0
"""What is shown about the main impact, in parts of how long it lasts."""
SILENT = 1e-3
"""Part of its largest force below which a floor is left out there."""


def focus(view: TransientView) -> tuple[float, float]:
    """Start and end of what is shown of the main impact [s].

    Raises:
        ValueError: There is no impact.
    """
    if view.main_impact is None:
        raise ValueError("there is no impact to look at")
    start, end = view.main_impact
    lasts = max(end - start, view.time_step)
    return max(view.time[0], start - BEFORE * lasts), min(view.time[-1], end + AFTER * lasts)


def forces_figure(path: Path, view: TransientView) -> None:
    """Figure 11: the forces on the edges of the floors, and the main impact."""
    colours = dict(zip(view.loads, floor_colours(len(view.loads)), strict=True))
    order = sorted(view.loads, key=lambda floor: -np.abs(view.force[:, view.loads[floor]]).max())
    main = order[0]
    caption = (
        f"Figure 11: Impact forces on the edges of the floors of building {view.building} over "
        f"time (a), and the main impact, of floor {main}, at the times of the 3D model (b). "
        f"Positive in compression; samples every {1e3 * view.time_step:g} ms, the straight lines "
        "between which are nearest in the mean square to the force of the sticks and keep its "
        "impulses: outside an impact the samples alternate about zero, and away from it fall to "
        "27 % from one to the next."
    )
    with figure(path, (1, 2), (9.0, 3.4), caption) as (_, axes):
        first, last = focus(view)
        shown = (view.time >= first) & (view.time <= last)
        for floor in order:
            force = 1e-6 * view.force[:, view.loads[floor]]
            axes[0].plot(view.time, force, color=colours[floor], label=f"floor {floor}")
            if np.abs(force[shown]).max() > SILENT * np.abs(force).max():
                axes[1].plot(view.time[shown], force[shown], color=colours[floor], marker=".", ms=4)
        axes[0].set_xlim(view.time[0], view.time[-1])
        _focus_axis(axes[1], first, last)
        for panel in axes:
            panel.set_xlabel("time [s]")
            panel.set_ylabel("impact force [MN]")
        handles, labels = axes[0].get_legend_handles_labels()
        by_floor = sorted(zip(labels, handles, strict=True), key=lambda e: -int(e[0].split()[-1]))
        axes[0].legend([h for _, h in by_floor], [name for name, _ in by_floor], loc="upper right")
        letter(axes)


def centre_figure(path: Path, view: TransientView, sticks: xr.Dataset) -> None:
    """Figure 12: displacement and acceleration of the top floor's mass centre, 3D and sticks."""
    d, top = view.direction, view.top
    probe = view.centres[top]
    station = stick_station(sticks, view.building, top)
    impact = view.main_impact is not None
    last = ", and its main impact (c)" if impact else ""
    caption = (
        f"Figure 12: Displacement relative to the ground (a) and absolute acceleration (b) along "
        f"$e_{d}$ of the mass centre of floor {top}{last}: 3D model and sticks."
    )
    both = (
        ("displacement", view.displacement(probe), 1e2, f"displacement $u_{d}$ [cm]"),
        ("acceleration", view.acceleration(probe), 1.0, f"acceleration $\\ddot u_{d}$ [m/s²]"),
    )
    panels = 3 if impact else 2
    with figure(path, (1, panels), (3.6 * panels, 3.2), caption) as (_, axes):
        for panel, (name, values, factor, label) in zip(axes, both, strict=False):
            _with_sticks(panel, view, sticks, station, name, values, factor)
            panel.set_ylabel(label)
            panel.set_xlim(view.time[0], view.time[-1])
        if impact:
            name, values, factor, label = both[1]
            _with_sticks(axes[2], view, sticks, station, name, values, factor)
            _focus_axis(axes[2], *focus(view))
            axes[2].set_ylabel(label)
        for panel in axes:
            panel.set_xlabel("time [s]")
        low, high = axes[0].get_ylim()
        axes[0].set_ylim(low, high + 0.25 * (high - low))
        axes[0].legend(loc="upper right", ncols=2)
        letter(axes)


def _with_sticks(
    panel: Axes,
    view: TransientView,
    sticks: xr.Dataset,
    station: int | None,
    name: str,
    values: Array,
    factor: float,
) -> None:
    """The history of the 3D model on that of the sticks, where they have one."""
    if station is not None:
        other = stick_history(sticks, name, station, view.direction)
        if other is not None:
            panel.plot(
                sticks["time"].values, factor * other, color=RED, lw=0.8, ls="--", label="sticks"
            )
    panel.plot(view.time, factor * values, color=BLUE, lw=0.8, label="3D")


def across_figure(path: Path, view: TransientView) -> None:
    """Figure 16: acceleration at some distances from the impact, and the main impact."""
    impact = view.main_impact is not None
    d = view.direction
    last = ", and the main impact (b)" if impact else ""
    caption = (
        f"Figure 16: Acceleration along $e_{d}$ of floor {view.top} at distances d from its impact "
        f"edge, over time (a){last}. Points of figure 14.{view.forces_note}"
    )
    panels = 2 if impact else 1
    with figure(path, (1, panels), (9.0, 3.6), caption) as (_, axes):
        colours = ordered_colours(len(view.shown_distances))
        for colour, k in zip(colours, view.shown_distances, strict=True):
            values = view.acceleration(view.line[k])
            for panel in axes:
                panel.plot(
                    view.time, values, color=colour, lw=0.8, label=f"d = {view.distance[k]:.1f} m"
                )
        axes[0].set_xlim(view.time[0], view.time[-1])
        if impact:
            first, last_time = focus(view)
            _focus_axis(axes[1], first, last_time)
        for panel in axes:
            panel.set_xlabel("time [s]")
            panel.set_ylabel(f"acceleration $\\ddot u_{d}$ [m/s²]")
        axes[-1].legend(loc="lower right")
        letter(axes)


def _focus_axis(panel: Axes, first: float, last: float) -> None:
    panel.set_xlim(first, last)
    panel.xaxis.set_major_locator(MaxNLocator(5))
    panel.ticklabel_format(axis="x", useOffset=False)
