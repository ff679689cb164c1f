"""Figures of the floor with the line in plan: waves, peaks and spectra over the floor."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from impactfem.plot.figure import figure
from impactfem.plot.floor_field import (
    COLOURS,
    SIGNED,
    TopFloor,
    colour_bar,
    colour_scale,
    plain_ticks,
    plan_axes,
    plan_layout,
    round_factor,
    signed_limits,
)
from impactfem.plot.style import BLUE, GREEN, HANDLE, ORANGE, RED, letter, sheet
from impactfem.plot.words import spoken
from impactfem.spectra import sampling_loss
from impactfem.stages.transient.curve_figures import HISTORIES, MAPS, focus
from impactfem.stages.transient.physics import HALF, line_arrivals
from impactfem.stages.transient.selection import (
    at_floor,
    at_frequencies,
    floors_of,
    line_ends,
    main_impact,
    of_kind,
    wave_floor,
)
from impactfem.system.arrays import Array

DEFORMED = 0.06
"""Largest deformation in a picture over the smaller side of the floor."""
CUT = 0.002
"""Part of the elements whose values may lie beyond either end of the colours."""
LINE_POINTS = 121
STYLES = ((BLUE, "-"), (RED, "--"), (GREEN, "-."), (ORANGE, ":"))
LINES = 8
"""Lines of equal values in a picture, about."""
SPEEDS = (
    ("loaded_wave_speed", "slab with its masses", "-"),
    ("wave_speed", "shear waves", "--"),
    ("plate_wave_speed", "bare plate", ":"),
)
"""Scalar of a wave speed, its name, and its dashes."""


def _on_line(response: xr.Dataset) -> bool:
    return of_kind(response, "line").sizes["probe"] > 1


@figure(
    "wave_snapshots",
    HISTORIES,
    "Waves in the top floor at some times",
    when=lambda response, maps: maps.sizes["snapshot"] and _on_line(response),
    default=False,
    ending="png",
)
def snapshots_figure(path: Path, response: xr.Dataset, maps: xr.Dataset) -> None:
    """Draw the acceleration of the top floor at some times, and along the line across it."""
    floor = TopFloor(maps)
    d, times = response["component"].item(), maps["snapshot"].values
    values = maps["wave_acceleration"].sel(component=d).values
    shapes = [floor.deformation(u) for u in maps["wave_displacement"].values]
    largest = max(float(np.linalg.norm(shape, axis=1).max()) for shape in shapes)
    factor = round_factor(largest, DEFORMED * float(floor.size.min()))
    ends = float(values.min()), float(values.max())
    low, high = signed_limits(*ends)
    # Levels are multiples of a round number, so that 0 is one of them.
    apart = round_factor(1.0, (ends[1] - ends[0]) / LINES)
    levels = apart * np.arange(math.ceil(ends[0] / apart), math.floor(ends[1] / apart) + 1)
    widths = np.where(levels == 0.0, 1.1, 0.5)
    dashes = np.where(levels < 0.0, "dashed", "solid").tolist()
    label = f"acceleration $\\ddot u_{d}$ [m/s²]"
    caption = (
        f"Acceleration along $e_{d}$ of floor {wave_floor(response)} at "
        f"{_letters(times)}, and along the line across it ({chr(97 + len(times))}). Lines every "
        f"{apart:g} m/s², thick: 0. Deformation in plan amplified by {factor:g}."
    )

    def plan(panel: Axes, k: int) -> Any:
        mesh = floor.split(factor * shapes[k])
        look: dict[str, Any] = {"colors": "black", "linewidths": widths, "linestyles": dashes}
        panel.tricontour(mesh, values[k], levels=levels, **look)
        return panel.tripcolor(mesh, values[k], shading="gouraud", cmap=SIGNED, vmin=low, vmax=high)

    def over_distance(panel: Axes) -> None:
        first, last = line_ends(response)
        share = np.linspace(0.0, 1.0, LINE_POINTS)
        points = first + share[:, None] * (last - first)
        distance = share * float(np.linalg.norm(last - first))
        for k, time in enumerate(times):
            colour, dash = STYLES[k % len(STYLES)]
            curve = floor.along(values[k], points)
            panel.plot(distance, curve, color=colour, ls=dash, label=f"t = {time:.4g} s")
        panel.set(
            xlabel="distance d from the impact edge [m]", xlim=(0.0, distance[-1]), ylabel=label
        )
        bottom, top = panel.get_ylim()
        panel.set_ylim(bottom, top + (0.25 if floor.wide else 0.35) * (top - bottom))
        panel.legend(loc="upper center", ncols=3 if floor.wide else 1)

    k, n = np.unravel_index(np.abs(values).argmax(), values.shape)
    seen = _seen(times, label, values[k, n], times[k], floor.position[n])
    _plans(path, response, floor, times, (caption, seen), label, plan, over_distance)


@figure(
    "membrane_force",
    HISTORIES,
    "Normal force in the slab of the top floor",
    when=lambda response, maps: maps.sizes["snapshot"] and _on_line(response),
    default=False,
    ending="png",
)
def membrane_figure(path: Path, response: xr.Dataset, maps: xr.Dataset) -> None:
    """Draw the normal force in the slab of the top floor at some times."""
    floor, times = TopFloor(maps), maps["snapshot"].values
    force = 1e-6 * maps["membrane_force"].values
    # A few elements at corners and columns would take the colours for themselves.
    low, high = signed_limits(*np.quantile(force, (CUT, 1.0 - CUT)))
    ends = " to ".join(f"{end:.3g}".replace("-", "−") for end in (force.min(), force.max()))
    caption = (
        f"Normal force $F_y$ in the slab of floor {wave_floor(response)} along $e_y$ "
        f"for each metre across it, positive in tension, at {_letters(times)}. All values: "
        f"{ends} MN/m."
    )
    mesh = floor.elements()

    def plan(panel: Axes, k: int) -> Any:
        return panel.tripcolor(mesh, facecolors=force[k], cmap=SIGNED, vmin=low, vmax=high)

    label = "normal force $F_y$ [MN/m]"
    k, n = np.unravel_index(np.abs(force).argmax(), force.shape)
    place = floor.position[floor.cells[n, :3]].mean(axis=0)
    seen = _seen(times, label, force[k, n], times[k], place)
    _plans(path, response, floor, times, (caption, seen), label, plan)


def _seen(times: Array, label: str, value: Any, time: Any, place: Array) -> str:
    return (
        f"{len(times)} plans of the floor coloured by {spoken(label)}; the largest value is "
        f"{value:.4g} at {time:.4g} s, x = {place[0]:.3g} m, y = {place[1]:.3g} m."
    )


def _plans(
    path: Path,
    response: xr.Dataset,
    floor: TopFloor,
    times: Array,
    words: tuple[str, str],
    label: str,
    plan: Callable[[Axes, int], Any],
    beside: Callable[[Axes], None] | None = None,
) -> None:
    """A plan for each time with one scale of colours, and one panel more where `beside` draws."""
    count = len(times) + (beside is not None)
    long, short = max(floor.size), min(floor.size)
    across = 2 if count > 3 else 1
    rows = math.ceil(count / across)
    if floor.wide:
        height = min(3.6, max(2.0, 4.2 * short / long + 0.7))
        panels, size = (rows, across), (4.8 * across + 0.8, height * rows)
    else:
        width = min(3.6, max(2.2, 4.2 * short / long + 0.9))
        panels, size = (across, rows), (width * rows + 1.0, 4.2 * across)
    with sheet(path, panels, size, *words) as (drawn, axes):
        plan_layout(drawn)
        for k, time in enumerate(times):
            mappable = plan(axes[k], k)
            mark_edge(axes[k], response, floor)
            axes[k].set_title(f"t = {time:.4g} s", fontsize=9.0)
            plan_axes(axes[k], floor)
        colour_bar(drawn, mappable, axes[: len(times)], label)
        if beside is not None:
            beside(axes[len(times)])
        for spare in axes[count:]:
            spare.set_axis_off()
        letter(axes[:count])


@figure(
    "wave_map",
    HISTORIES,
    "Wave across the top floor",
    when=lambda response: main_impact(response) is not None and _on_line(response),
    default=False,
    ending="png",
)
def wave_map(path: Path, response: xr.Dataset) -> None:
    """Draw the acceleration over distance and time, with arrivals and speeds of the wave.

    The thick lines pass through the middle of the peaks, so that slopes can be compared.
    """
    impact, times = main_impact(response), focus(response)
    if impact is None or times is None:
        raise ValueError("there is no impact to look at")
    start, line = impact[0], of_kind(response, "line").sel(time=times)
    d, distance = response["component"].item(), line["distance"].values
    time = 1e3 * (line["time"].values - start)
    values = line["acceleration"].transpose("probe", "time").values
    caption = (
        f"Acceleration along $e_{d}$ of floor {wave_floor(response)} over distance d and time "
        f"since the main impact at {start:.4g} s. Dots: peak of the wave; circles: "
        f"{100 * HALF:g} % of the peak. Lines: wave speeds of the legend."
    )
    low, high = signed_limits(float(values.min()), float(values.max()))
    halo = [withStroke(linewidth=3.0, foreground="white")]
    i, j = np.unravel_index(np.abs(values).argmax(), values.shape)
    seen = (
        "Acceleration by colour over time and distance from the impact edge; the largest value is "
        f"{values[i, j]:.4g} m/s² at {distance[i]:.3g} m, {time[j]:.3g} ms after the first sample."
    )
    with sheet(path, (1, 1), (6.5, 4.0), caption, seen) as (drawn, axes):
        panel = axes[0]
        mappable = panel.pcolormesh(
            time, distance, values, shading="gouraud", cmap=SIGNED, vmin=low, vmax=high
        )
        if float(values.min()) < 0.0 < float(values.max()):
            panel.contour(time, distance, values, [0.0], colors="black", linewidths=0.5)
        arrival = line_arrivals(response)
        first, middle = 0.0, 0.0
        if arrival is not None and np.isfinite(arrival.peak).any():
            half, peak = (1e3 * (one - start) for one in (arrival.half, arrival.peak))
            look: dict[str, Any] = {"clip_on": False, "zorder": 4}
            panel.plot(half, distance, "o", color="white", mec="black", ms=4.5, **look)
            panel.plot(peak, distance, "o", color="black", mec="white", ms=6.0, **look)
            # Lines of the speeds go through the middle of the peaks.
            reached = np.isfinite(peak)
            first, middle = peak[reached].mean(), distance[reached].mean()
        ends = np.array([0.0, distance[-1]])
        for name, kind, dash in SPEEDS:
            if name in response:
                c, look = float(response[name]), {"color": "black", "ls": dash, "lw": 1.6}
                look |= {"path_effects": halo, "label": f"{kind}, {c:.0f} m/s"}
                panel.plot(first + 1e3 * (ends - middle) / c, ends, **look)
        panel.set(xlim=(time[0], time[-1]), ylim=(0.0, distance[-1]))
        panel.set_xlabel("time since the first sample of the main impact [ms]")
        panel.set_ylabel("distance d from the impact edge [m]")
        panel.grid(False)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(loc="upper right", handlelength=HANDLE)
        colour_bar(drawn, mappable, panel, f"acceleration $\\ddot u_{d}$ [m/s²]")


@figure(
    "top_floor_pfa",
    MAPS,
    "Peak accelerations over the top floor",
    when=lambda fields: "pfa" in fields,
    default=False,
    ending="png",
)
def floor_peaks(path: Path, response: xr.Dataset, maps: xr.Dataset) -> None:
    """Draw the peak acceleration over the top floor."""
    floor_map(path, response, maps)


@figure(
    "top_floor_psa",
    MAPS,
    "Pseudo-acceleration over the top floor",
    each="frequency",
    default=False,
    ending="png",
)
def floor_spectra(path: Path, response: xr.Dataset, maps: xr.Dataset, frequency: str) -> None:
    """Draw the pseudo-acceleration over the top floor at a frequency."""
    floor_map(path, response, maps, float(frequency.removesuffix("hz").replace("p", ".")))


def floor_map(
    path: Path, response: xr.Dataset, maps: xr.Dataset, frequency: float | None = None
) -> None:
    """Draw peak acceleration over the top floor, or its pseudo-acceleration at a frequency [Hz].

    The frequency is one that was computed, or between such.
    """
    d, top = response["component"].item(), wave_floor(response)
    what, label, loss = "Peak absolute acceleration", "peak acceleration [m/s²]", ""
    maps = maps.set_coords("node_number").swap_dims(node="node_number")
    values = maps["pfa"].sel(component=d)
    if frequency is not None:
        psa = at_frequencies(maps["psa"].sel(component=d), np.array([frequency]))[:, 0]
        values = values.copy(data=psa)
        points = float(maps.attrs["points_per_cycle"]) * maps["frequency"].values[-1] / frequency
        damping = f"{100 * float(maps.attrs['damping']):g} % damping"
        what = f"Pseudo-acceleration at {frequency:g} Hz ({damping})"
        label = f"PSa at {frequency:g} Hz [m/s²]"
        missing = 100.0 * float(sampling_loss(points))
        loss = f" Sampling error of a peak: up to {missing:.2g} %."
    floor = TopFloor(maps)
    mass_centre = at_floor(response, "centre", top)
    centre = float(values.sel(node_number=mass_centre["probe_node"].item()))
    on_floor = values.sel(node_number=floor.vertex_number).values
    # Where nothing moves along this direction all is as at the mass centre.
    ratio = on_floor / centre if centre > 0.0 else np.ones_like(on_floor)
    cross = {"color": "white", "ms": 9, "mew": 1.6, "path_effects": _halo(3.2)}
    marks: list[tuple[xr.Dataset, str, dict[str, Any]]] = [(mass_centre, "+", cross)]
    dot = ""
    if top in floors_of(response, "edge"):
        dot = "; dot: middle of the impact edge"
        dotted = {"color": RED, "ms": 6, "clip_on": False, "zorder": 5}
        marks.append((at_floor(response, "edge", top), "o", dotted))
    caption = (
        f"{what} along $e_{d}$ of floor {top} (a), relative to the mass centre (b). Cross: "
        f"mass centre; white line: its value{dot}.{loss}"
    )
    long, short = max(floor.size), min(floor.size)
    panels, size = (1, 2), (2.0 * (4.5 * short / long + 1.5), 4.6)
    if floor.wide:
        panels, size = (2, 1), (7.2, 2.0 * (6.0 * short / long + 0.7))
    mesh = floor.elements()
    n, most = int(on_floor.argmax()), float(on_floor.max())
    x, y = mesh.x[n], mesh.y[n]
    seen = (
        f"Plan of floor {top} coloured by {label}, and over the value of its mass centre: largest, "
        f"{most:.4g}, at x = {x:.3g} m, y = {y:.3g} m, {ratio.max():.3g} times the mass centre."
    )
    with sheet(path, panels, size, caption, seen) as (drawn, axes):
        plan_layout(drawn)
        both = ((on_floor, label), (ratio, "over the mass centre"))
        for panel, (one, name) in zip(axes, both, strict=True):
            look: dict[str, Any] = {"shading": "gouraud", "cmap": COLOURS}
            scale = colour_scale(one)
            colours = panel.tripcolor(mesh, one, norm=scale, **look)
            plain_ticks(colour_bar(drawn, colours, panel, name), scale)
            for probe, marker, style in marks:
                x, y, _ = probe["probe_position"].values
                panel.plot(x, y, marker, **style)
        if ratio.min() < 1.0 < ratio.max():
            line = axes[1].tricontour(mesh, ratio, levels=[1.0], colors="white", linewidths=1.0)
            line.set(path_effects=_halo(2.2))
        for panel in axes:
            plan_axes(panel, floor, margin=0.02)
        letter(axes)


def _halo(width: float) -> list[Any]:
    return [withStroke(linewidth=width, foreground="black")]


def _letters(times: Array) -> str:
    """The times with the letters of their panels."""
    return ", ".join(f"{time:.4g} s ({chr(97 + k)})" for k, time in enumerate(times))


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
