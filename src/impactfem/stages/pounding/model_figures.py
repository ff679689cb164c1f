"""Figures of the models: the case, a stick with its first mode, and the contact pairs."""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from impactfem.plot.curves import Curve, Panel
from impactfem.plot.figure import figure
from impactfem.plot.style import BLUE, BUILDINGS, GREEN, ORANGE, RED, letter, sheet
from impactfem.stages.pounding.elevation import Elevation, elevations
from impactfem.system.arrays import Array

GREY = "0.35"
Point = tuple[float, float]
MOST_ROOM = 4.0
"""Of a pair of points in the figure of the contact [m]."""
HALF_WIDTH = 0.35
"""Of a 3D model there; buildings are 2 apart."""


@figure("case", "Models and damping", "Buildings and ground motion")
def case_figure(path: Path, motion: xr.Dataset, sticks: xr.Dataset, forces: xr.Dataset) -> None:
    """Draw the buildings, the ground acceleration, and its response spectrum."""
    direction = str(sticks.attrs["shown_direction"])
    shown = motion.isel(motion=int((motion["direction"] == direction).argmax("motion")))
    record, spectra = shown.dropna("sample"), shown.drop_vars("target").dropna("oscillator")
    t, a = record["time"].values, record["acceleration"].values
    f, psa = spectra["frequency"].values, spectra["spectrum"].values
    pga, top = [int(np.argmax(np.abs(a)))], [int(np.argmax(psa))]
    caption = (
        f"Configuration of the case (a), ground acceleration along $e_{direction}$ (b), "
        "and its pseudo-acceleration response spectrum at "
        f"{100 * float(shown['damping']):g} % damping (c)."
    )
    history = [Curve(t, a, width=0.6), Curve(t[pga], a[pga], "", RED, "", marker="o")]
    spectrum = [Curve(f, psa, "motion")]
    target = shown.dropna("oscillator", subset=["target"])
    if target.sizes["oscillator"]:
        label = "design spectrum"
        known = target["frequency"].values, target["target"].values
        spectrum.append(Curve(*known, label, ORANGE, "--"))
    label = f"{psa[top[0]]:.2f} m/s² at {f[top[0]]:.2f} Hz"
    spectrum.append(Curve(f[top], psa[top], label, RED, "", marker="o"))
    with sheet(path, (2, 2), (9.0, 5.0), caption) as (_, (left, above, spare, below)):
        # The buildings have the left side.
        grid, axes = left.get_gridspec(), [left, above, below]
        spare.remove()
        left.set_subplotspec(grid[:, 0]) if grid is not None else None
        _draw_buildings(axes[0], sticks, forces)
        Panel("time [s]", "ground acceleration [m/s²]", history).draw(axes[1])
        axes[1].annotate(
            f"{abs(a[pga[0]]):.2f} m/s² at {t[pga[0]]:.2f} s",
            (t[pga[0]], a[pga[0]]),
            xytext=(8, 0),
            textcoords="offset points",
            va="center",
        )
        quantities = ("frequency [Hz]", "pseudo-acceleration [m/s²]")
        Panel(*quantities, spectrum, log="x", bottom=0.0, room=0.45).draw(axes[2])
        letter(axes)


def _draw_buildings(panel: Axes, sticks: xr.Dataset, forces: xr.Dataset) -> None:
    """Elevation to scale."""
    drawn = elevations(sticks)
    along = str(sticks.attrs["elevation_direction"])
    gap = float(sticks["pair_rest_gap"].values.min()) if sticks.sizes["pair"] else 0.0
    # Points of contact are on the faces of a building. One without such points is as wide as the
    # distance to the next building lets it be.
    usual = 0.5 * float(drawn[0].floors[-1])
    spacing = min(np.diff(sorted(building.centre for building in drawn)), default=usual)
    usual = spacing - gap if spacing > gap else usual
    widths = {}
    for building in drawn:
        reach = 0.0
        for side in "ab":
            mine = (forces[f"building_{side}"] == building.name).values
            offsets = np.abs(forces[f"offset_{side}"].sel(axis=along).values[mine])
            reach = max(reach, float(offsets.max(initial=0.0)))
        widths[building.name] = 2.0 * reach if reach > 0.0 else usual
    for k, building in enumerate(drawn):
        width, height = widths[building.name], building.top - building.base
        left, colour = building.centre - width / 2.0, BUILDINGS[k % len(BUILDINGS)]
        panel.add_patch(Rectangle((left, building.base), width, height, fill=False, ec=colour))
        for z, number in zip(building.floors, building.numbers, strict=True):
            panel.plot([left, left + width], [z, z], color=colour, lw=1.5)
            small: dict[str, Any] = {"fontsize": 6.5, "color": GREY, "va": "top"}
            panel.text(left + 0.03 * width, z - 0.25, f"{number}", **small)
        panel.text(building.centre, building.top + 0.8, building.name, ha="center", color=colour)
    low, high = min(one.base for one in drawn), max(one.top for one in drawn)
    # Where the points of each pair are, at the face of a building or of a rigid wall.
    named, faces, walls = {building.name: building for building in drawn}, [], list[float]()
    for k in range(forces.sizes["pair"]):
        names = [str(forces[f"building_{side}"].values[k]) for side in "ab"]
        a, b = named[names[0]], named.get(names[1])
        way = np.sign(
            forces["normal"].sel(axis=along).values[k] if b is None else b.centre - a.centre
        )
        face = a.centre + 0.5 * way * widths[a.name]
        rest = way * float(sticks["pair_rest_gap"].values[k])
        walls += [face + rest] if b is None else []
        faces.append((face, face + rest if b is None else b.centre - 0.5 * way * widths[b.name]))
    for place in set(walls):
        panel.plot([place, place], [low, high], color="black", lw=3.0)
        panel.text(place, low - 0.2, "rigid wall", ha="center", va="top")
    if faces and gap > 0.0:
        between = 0.5 * sum(faces[int(sticks["pair_rest_gap"].argmin("pair"))])
        panel.annotate(
            f"gap {100 * gap:g} cm",
            (between, high),
            xytext=(between, high + 4.6),
            ha="center",
            arrowprops={"arrowstyle": "->", "color": GREY},
        )
    panel.axhline(low, color="black", lw=2.0)
    left = min(one.centre - 0.65 * widths[one.name] for one in drawn)
    right = max(one.centre + 0.65 * widths[one.name] for one in drawn)
    margin = 0.35 * max(widths.values())
    ends = [x + way * margin for x in walls for way in (-1.0, 1.0)]
    panel.set(xlim=(min([left, *ends]), max([right, *ends])), ylim=(low - 1.0, high + 6.5))
    panel.set(aspect="equal", xlabel=f"{along} [m]", ylabel="z [m]")
    panel.grid(False)


@figure(
    "stick_model",
    "Models and damping",
    "Stick model and its first bending mode",
    when=lambda sticks: (sticks["building_model"] != "structure").any(),
    default=False,
)
def stick_figure(path: Path, sticks: xr.Dataset) -> None:
    """Draw the first stick that pounds, and its first bending mode."""
    building = next(one for one in elevations(sticks) if not one.in_3d)
    direction = str(sticks.attrs["shown_direction"])
    if direction not in "xy":
        direction = str(sticks.attrs["elevation_direction"])
    modes = sticks.sel(building=building.name)
    modes = modes.isel(
        station=modes["station_building"] == building.name, mode=modes["mode_family"] == direction
    )
    axis = {"x": "y", "y": "x"}[direction]
    caption = (
        f"Stick model of {building.name} with rigid zones, mass centres and Timoshenko storeys "
        f"(a), and its first bending mode along $e_{direction}$, about $e_{axis}$, on a clamped "
        "base (b)."
    )
    seen = (
        f"A vertical line with {len(building.floors)} floors between heights of "
        f"{building.base:.4g} m and {building.top:.4g} m, straight and bent to one side."
    )
    with sheet(path, (1, 2), (6.5, 4.6), caption, seen) as (_, axes):
        _draw_stick(axes[0], building)
        for z, number in zip(building.floors, building.numbers, strict=True):
            axes[0].text(0.12, z, f"floor {number}", va="center", fontsize=7.5)
        if modes.sizes["mode"]:
            mode = modes.isel(mode=0)
            shape = mode["mode_shape"].sel(mode_component=direction).values
            shape = 0.7 * shape / np.abs(shape).max() * np.sign(shape[-1])
            axes[1].plot([0.0, 0.0], [building.base, building.floors[-1]], ":", color=GREY)
            _draw_stick(axes[1], building, shift=shape)
            text = f"f = {float(mode['mode_frequency']):.2f} Hz"
            axes[1].text(0.03, 0.97, text, transform=axes[1].transAxes, va="top")
        axes[0].set_xlim(-0.4, 1.4)
        axes[1].set_xlim(-0.6, 0.9)
        axes[0].legend(loc="center right")
        for panel in axes:
            panel.set(xticks=[], ylabel="z [m]")
            panel.grid(False)
        letter(axes)


def _draw_stick(
    panel: Axes, building: Elevation, origin: float = 0.0, shift: Array | float = 0.0
) -> None:
    """A stick on its base at `origin`, its floors shifted sideways."""
    low, high = building.floors - building.below, building.floors + building.above
    x = origin + shift + np.zeros_like(low)
    starts, ends = np.append(origin, x[:-1]), np.append(building.base, high[:-1])
    look: dict[str, Any] = {"color": GREEN, "lw": 4.0, "solid_capstyle": "butt"}
    for k in range(len(x)):
        storey, rigid = ("storey", "rigid floor") if k == 0 else (None, None)
        panel.plot([starts[k], x[k]], [ends[k], low[k]], color=BLUE, label=storey)
        panel.plot([x[k], x[k]], [low[k], high[k]], label=rigid, **look)
    panel.plot(x, building.floors, "o", color=RED, ms=4, label="mass centre")
    panel.plot([origin - 0.15, origin + 0.15], [building.base] * 2, color="black", lw=3.0)


@figure(
    "contact_pairs",
    "Models and damping",
    "Contact pairs",
    when=lambda sticks: sticks.sizes["pair"],
    default=False,
)
def contact_figure(path: Path, sticks: xr.Dataset, forces: xr.Dataset) -> None:
    """Draw the points or edges that can touch, and the contact law between them."""
    drawn = {building.name: building for building in elevations(sticks)}
    names = list(drawn)
    laws = list(dict.fromkeys(str(name) for name in sticks["pair_law"].values))
    rigid = laws == ["unilateral"]
    caption = (
        "Pairs of points that may touch. Each pair k carries a gap g and, in contact, a "
        "stiffness K and a dashpot C; the force is zero while the gap is open."
    )
    if rigid:
        caption = (
            "Floors whose edges may touch along a line. They do not penetrate: there is "
            "no stiffness and no dashpot between them."
        )
    elif np.any(sticks["pair_stiffness_unit"].values != "N/m"):
        caption += f" Laws: {' and '.join(laws)}."
    seen = (
        f"Buildings {', '.join(names)}, with {forces.sizes['pair']} pairs between them, each "
        f"{'' if rigid else 'a spring above a dashpot and '}a gap."
    )
    along = forces["normal"].sel(axis=str(sticks.attrs["elevation_direction"])).values
    with sheet(path, (1, 1), (6.5, 4.6), caption, seen) as (_, axes):
        panel = axes[0]
        for position, name in enumerate(names):
            building = drawn[name]
            draw = _draw_slabs if building.in_3d else _draw_stick
            draw(panel, building, 2.0 * position)
            panel.text(2.0 * position, building.top + 0.8, name, ha="center")
        # The pairs: ends from left to right, and number. A rigid wall stands beyond all buildings.
        pairs, beyond = [], {1.0: 2.0 * len(names), -1.0: -2.0}
        for k in range(forces.sizes["pair"]):
            ends: list[Point] = []
            pair = [str(forces[f"building_{side}"].values[k]) for side in "ab"]
            wall = beyond[float(np.sign(along[k]) or 1.0)]
            at = [2.0 * names.index(name) if name in drawn else wall for name in pair]
            for side, x in zip("ab", at, strict=True):
                name, floor_number, s, offset = (
                    forces[f"{of}_{side}"].values[k]
                    for of in ("building", "floor", "relative_height", "offset")
                )
                if name not in drawn:
                    ends.append((x, ends[0][1]))
                    continue
                one = drawn[name]
                floor = int(np.flatnonzero(one.numbers == floor_number)[0])
                z = float(one.floors[floor])
                if not np.isnan(s):
                    low = float(one.floors[floor - 1]) if floor else one.base
                    z = low + float(s) * (z - low)
                # To the right of what is on the left.
                out = HALF_WIDTH * one.in_3d * (1.0 if x == min(at) else -1.0)
                ends.append((x + out, z + float(offset[2])))
            pairs.append((min(ends), max(ends), k + 1))
        # Rounded: pairs side by side at one height need no room above each other.
        heights = np.unique(np.round([0.5 * (left[1] + right[1]) for left, right, _ in pairs], 6))
        room = float(np.diff(heights).min(initial=MOST_ROOM))
        for left, right, number in pairs:
            _draw_pair(panel, left, right, f"{number}", room, rigid)
        places = [x for ends in pairs for x, _ in ends[:2]]
        for x in {*places} & {*beyond.values()}:
            panel.axvline(x, color="black", lw=3.0)
            panel.annotate("rigid wall", (x, 1.02), xycoords=("data", "axes fraction"), ha="center")
        panel.set_xlim(min([0.0, *places]) - 0.6, max([2.0 * (len(names) - 1), *places]) + 0.6)
        panel.set_ylim(top=panel.get_ylim()[1] + 1.5)
        panel.set(xticks=[], ylabel="z [m]")
        panel.grid(False)


def _draw_slabs(panel: Axes, building: Elevation, origin: float = 0.0) -> None:
    """The slabs and outer walls of a 3D model about `origin`."""
    sides = np.array([origin - HALF_WIDTH, origin + HALF_WIDTH])
    for z in building.floors:
        panel.plot(sides, [z, z], color=BLUE, lw=2.5)
    for x in sides:
        panel.plot([x, x], [building.base, building.floors[-1]], color=BLUE)
    panel.plot(sides, [building.base] * 2, color="black", lw=3.0)


def _draw_pair(
    panel: Axes, left: Point, right: Point, label: str, room: float, rigid: bool
) -> None:
    """A spring K above a dashpot C unless `rigid`, and a gap g, with `room` [m] to the next pair.

    Between two ends (x, z) at unequal heights they are drawn in the middle.
    """
    (x0, z0), (x1, z1) = left, right
    z, u = 0.5 * (z0 + z1), 0.25 * room
    if rigid:
        middle = 0.5 * (x0 + x1)
        for x, outer, height in ((middle - 0.07, x0, z0), (middle + 0.07, x1, z1)):
            panel.plot([outer, x], [height, z], color=GREY, lw=0.8)
            panel.plot([x, x], [z - 0.8 * u, z + 0.8 * u], color=GREY, lw=1.5)
        panel.text(middle, z + 0.9 * u, "g", ha="center", va="bottom", fontsize=7.0)
        panel.text(0.5 * (x0 + middle), z + 0.3 * u, label, ha="center", va="bottom", fontsize=7.5)
        return
    w = 0.5 * (x1 - x0)
    start, end = x0 + 0.45 * w, x0 + 1.2 * w
    middle = 0.5 * (start + end)
    panel.plot([x0, start], [z0, z], color=GREY, lw=0.8)
    for x in (start, end):
        panel.plot([x, x], [z - u, z + u], color=GREY, lw=0.8)
    coils = np.array([0, 0, 1, -1, 1, -1, 1, -1, 1, -1, 0, 0])
    panel.plot(np.linspace(start, end, coils.size), z + u * (1.0 + 0.5 * coils), color=ORANGE)
    panel.plot([start, middle - 0.02], [z - u] * 2, color=ORANGE)
    panel.plot([middle - 0.02] * 2, [z - 1.4 * u, z - 0.6 * u], color=ORANGE, lw=2.0)
    cup = np.array([-0.7, -0.7, 0.06, 0.06, -0.7, -0.7]) + 0.64
    edge = np.array([-0.5, -0.5, -0.5, -1.5, -1.5, -1.5])
    panel.plot(middle + 0.1 * (cup - 0.7), z + u * edge, color=ORANGE)
    panel.plot([middle, end], [z - u] * 2, color=ORANGE)
    panel.plot([end, end + 0.15 * w], [z, z], color=GREY, lw=0.8)
    for x in (end + 0.15 * w, end + 0.3 * w):
        panel.plot([x, x], [z - 0.8 * u, z + 0.8 * u], color=GREY, lw=1.5)
    panel.plot([end + 0.3 * w, x1], [z, z1], color=GREY, lw=0.8)
    panel.text(x0 + 0.22 * w, z + 0.3 * u, label, ha="center", va="bottom", fontsize=7.5)
    for x, height, name in ((start - 0.05, z + u, "K"), (start - 0.05, z - u, "C")):
        panel.text(x, height, name, ha="center", va="center", fontsize=7.0)
    panel.text(end + 0.225 * w, z + 0.9 * u, "g", ha="center", va="bottom", fontsize=7.0)
