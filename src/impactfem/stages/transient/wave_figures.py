"""Figures of the waves that the main impact sends through the top floor: 17 and 18."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from impactfem.plot.floor_field import (
    SIGNED,
    TopFloor,
    colour_bar,
    plan_axes,
    plan_layout,
    round_factor,
    signed_limits,
)
from impactfem.plot.style import BLUE, GREEN, HANDLE, ORANGE, RED, figure, letter
from impactfem.stages.stores import time_step
from impactfem.stages.transient.physics import HALF, line_arrivals
from impactfem.stages.transient.selection import (
    forces_note,
    line_ends,
    main_impact,
    of_kind,
    wave_floor,
)
from impactfem.system.scalar import values_of

Array = NDArray[np.float64]

DEFORMED = 0.06
"""Largest deformation in a picture over the smaller side of the floor."""
CUT = 0.002
"""Part of the elements whose values may lie beyond either end of the colours."""
LINE_POINTS = 121
STYLES = ((BLUE, "-"), (RED, "--"), (GREEN, "-."), (ORANGE, ":"))
BEFORE, AFTER = 0.5, 2.0
"""What the map over time shows about the main impact, in parts of how long it lasts."""
LINES = 8
"""Lines of equal values in a picture, about."""


def snapshots_figure(path: Path, response: xr.Dataset, maps: xr.Dataset) -> None:
    """Figure 17: acceleration of the top floor at some times, and along the line across it."""
    floor = TopFloor(maps)
    d, times = response["component"].item(), maps["snapshot"].values
    values = maps["wave_acceleration"].sel(component=d).values
    shapes = [floor.deformation(u) for u in maps["wave_displacement"].values]
    largest = max(float(np.linalg.norm(shape, axis=1).max()) for shape in shapes)
    factor = round_factor(largest, DEFORMED * float(floor.size.min()))
    ends = float(values.min()), float(values.max())
    limits = signed_limits(*ends)
    apart = round_factor(1.0, (ends[1] - ends[0]) / LINES)
    levels = _levels(ends, apart)
    letters = _letters(times)
    caption = (
        f"Figure 17: Acceleration along $e_{d}$ of floor {wave_floor(response)} at "
        f"{letters}, and along the line across it over the distance d from the impact edge "
        f"({chr(97 + len(times))}). Lines every {apart:g} m/s², the thick one 0, dashed below; "
        f"deformation in plan amplified by {factor:g}, without the motion of the floor as a rigid "
        f"body; the impact edge is marked.{forces_note(response)}"
    )
    panels, size = _layout(floor, len(times) + 1)
    with figure(path, panels, size, caption) as (drawn, axes):
        plan_layout(drawn)
        for panel, time, shape, one in zip(axes, times, shapes, values, strict=False):
            mappable = panel.tripcolor(
                floor.split(factor * shape),
                one,
                shading="gouraud",
                cmap=SIGNED,
                vmin=limits[0],
                vmax=limits[1],
            )
            panel.tricontour(
                floor.split(factor * shape),
                one,
                levels=levels,
                colors="black",
                linewidths=[1.1 if level == 0.0 else 0.5 for level in levels],
                linestyles=["dashed" if level < 0.0 else "solid" for level in levels],
            )
            mark_edge(panel, response, floor)
            panel.set_title(f"t = {time:.4g} s", fontsize=9.0)
            plan_axes(panel, floor)
        label = f"$\\ddot u_{d}$ [m/s²]"
        colour_bar(drawn, mappable, axes[: len(times)], f"acceleration {label}")
        _over_distance(axes[len(times)], response, floor, times, values)
        axes[len(times)].set_ylabel(f"acceleration {label}")
        for spare in axes[len(times) + 1 :]:
            spare.set_axis_off()
        letter(axes[: len(times) + 1])


def _over_distance(
    panel: Axes, response: xr.Dataset, floor: TopFloor, times: Array, values: Array
) -> None:
    first, last = line_ends(response)
    share = np.linspace(0.0, 1.0, LINE_POINTS)
    points = first + share[:, None] * (last - first)
    for number, (time, one) in enumerate(zip(times, values, strict=True)):
        colour, dashes = STYLES[number % len(STYLES)]
        panel.plot(
            share * float(np.linalg.norm(last - first)),
            floor.along(one, points),
            color=colour,
            ls=dashes,
            label=f"t = {time:.4g} s",
        )
    panel.set_xlabel("distance d from the impact edge [m]")
    panel.set_xlim(0.0, float(np.linalg.norm(last - first)))
    low, high = panel.get_ylim()
    panel.set_ylim(low, high + (0.25 if floor.wide else 0.35) * (high - low))
    panel.legend(loc="upper center", ncols=3 if floor.wide else 1)


def wave_map(path: Path, response: xr.Dataset) -> None:
    """The acceleration over distance and time, with the wave's arrivals and its speeds by hand.

    The thick lines pass through the middle of the peaks, so that slopes can be compared.
    """
    impact = main_impact(response)
    if impact is None:
        raise ValueError("there is no impact to look at")
    start, end = impact
    lasts = max(end - start, time_step(response))
    line = of_kind(response, "line").sel(time=slice(start - BEFORE * lasts, end + AFTER * lasts))
    d, distance = response["component"].item(), line["distance"].values
    time = 1e3 * (line["time"].values - start)
    values = line["acceleration"].transpose("probe", "time").values
    caption = (
        f"Figure 17 (e): acceleration along $e_{d}$ of floor {wave_floor(response)} over the "
        f"distance d from the impact edge and the time since the first sample of the main impact's "
        f"force, at {start:.4g} s. White: zero, with the thin line. Dots: peak of the wave; "
        f"circles: {100 * HALF:g} % of it. Lines: speed of the slab with beams and added mass "
        "(solid), shear waves of the material by equation 8 (dashed), the bare plate (dotted)."
        f"{forces_note(response)}"
    )
    limits = signed_limits(float(values.min()), float(values.max()))
    halo = [withStroke(linewidth=3.0, foreground="white")]
    with figure(path, (1, 1), (6.5, 4.0), caption) as (drawn, axes):
        panel = axes[0]
        mappable = panel.pcolormesh(
            time,
            distance,
            values,
            shading="gouraud",
            cmap=SIGNED,
            vmin=limits[0],
            vmax=limits[1],
        )
        if float(values.min()) < 0.0 < float(values.max()):
            panel.contour(time, distance, values, [0.0], colors="black", linewidths=0.5)
        arrival = line_arrivals(response)
        first, middle = 0.0, 0.0
        if arrival is not None and np.isfinite(arrival.peak).any():
            for times, face in ((arrival.half, "white"), (arrival.peak, "black")):
                panel.plot(
                    1e3 * (times - start),
                    distance,
                    "o",
                    color=face,
                    mec="white" if face == "black" else "black",
                    ms=6.0 if face == "black" else 4.5,
                    clip_on=False,
                    zorder=4,
                )
            known = np.isfinite(arrival.peak)
            first = 1e3 * (arrival.peak[known].mean() - start)
            middle = distance[known].mean()
        speeds = (
            ("transient.loaded_wave_speed", "slab with its masses", "-"),
            ("transient.wave_speed", "shear waves", "--"),
            ("transient.plate_wave_speed", "bare plate", ":"),
        )
        for name, kind, dashes in speeds:
            c = values_of(response).get(name)
            if c is not None:
                panel.plot(
                    first + 1e3 * (np.array([0.0, distance[-1]]) - middle) / c,
                    [0.0, distance[-1]],
                    color="black",
                    ls=dashes,
                    lw=1.6,
                    path_effects=halo,
                    label=f"{kind}, {c:.0f} m/s",
                )
        panel.set_xlim(time[0], time[-1])
        panel.set_ylim(0.0, distance[-1])
        panel.set_xlabel("time since the first sample of the main impact [ms]")
        panel.set_ylabel("distance d from the impact edge [m]")
        panel.grid(False)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(loc="upper right", handlelength=HANDLE)
        label = f"acceleration $\\ddot u_{d}$ [m/s²]"
        colour_bar(drawn, mappable, panel, label)


def membrane_figure(path: Path, response: xr.Dataset, maps: xr.Dataset) -> None:
    """Figure 18: the normal force in the slab of the top floor at some times."""
    floor = TopFloor(maps)
    times = maps["snapshot"].values
    force = 1e-6 * maps["membrane_force"].values
    # A few elements at corners and columns would take the colours for themselves.
    limits = signed_limits(*(float(np.quantile(force, share)) for share in (CUT, 1.0 - CUT)))
    caption = (
        f"Figure 18: Normal force $F_y$ in the slab of floor {wave_floor(response)} along $e_y$ "
        f"for each metre across it, positive in tension, at {_letters(times)}. All values: "
        f"{_signed(force.min())} to {_signed(force.max())} MN/m."
    )
    panels, size = _layout(floor, len(times))
    with figure(path, panels, size, caption) as (drawn, axes):
        plan_layout(drawn)
        for panel, time, one in zip(axes, times, force, strict=False):
            mappable = panel.tripcolor(
                floor.elements(),
                facecolors=one,
                cmap=SIGNED,
                vmin=limits[0],
                vmax=limits[1],
            )
            mark_edge(panel, response, floor)
            panel.set_title(f"t = {time:.4g} s", fontsize=9.0)
            plan_axes(panel, floor)
        colour_bar(drawn, mappable, axes[: len(times)], "normal force $F_y$ [MN/m]")
        for spare in axes[len(times) :]:
            spare.set_axis_off()
        letter(axes[: len(times)])


def _levels(limits: tuple[float, float], apart: float) -> Array:
    """Multiples of a step between two values."""
    first, last = math.ceil(limits[0] / apart), math.floor(limits[1] / apart)
    return np.asarray(apart * np.arange(first, last + 1))


def _signed(value: float) -> str:
    """A number with a minus sign rather than a hyphen."""
    return f"{value:.3g}".replace("-", "−")


def _letters(times: Array) -> str:
    """The times with the letters of their panels."""
    return ", ".join(f"{time:.4g} s ({chr(97 + k)})" for k, time in enumerate(times))


def _layout(floor: TopFloor, panels: int) -> tuple[tuple[int, int], tuple[float, float]]:
    """Rows and columns of plans, and the size of the figure [inch]."""
    long, short = max(floor.size), min(floor.size)
    across = 2 if panels > 3 else 1
    rows = math.ceil(panels / across)
    if floor.wide:
        height = min(3.6, max(2.0, 4.2 * short / long + 0.7))
        return (rows, across), (4.8 * across + 0.8, height * rows)
    width = min(3.6, max(2.2, 4.2 * short / long + 0.9))
    return (across, rows), (width * rows + 1.0, 4.2 * across)


def mark_edge(panel: Axes, response: xr.Dataset, floor: TopFloor) -> None:
    """A thick line outside the edge that faces the other building."""
    if of_kind(response, "line").sizes["probe"] < 2:
        return
    first, last = line_ends(response)
    across = int(np.argmax(np.abs(last - first)))
    low, high = floor.position[:, :2].min(axis=0), floor.position[:, :2].max(axis=0)
    out = first[across] - math.copysign(
        0.09 * float(floor.size.min()), last[across] - first[across]
    )
    ends = [low[1 - across], high[1 - across]]
    both = (ends, [out, out]) if across == 1 else ([out, out], ends)
    panel.plot(*both, color="black", lw=2.5, solid_capstyle="butt")
