"""The elevation of the buildings with floor accelerations, gap and impacts: `elevation.svg`."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.patches import Rectangle

from impactfem.plot.figure import figure
from impactfem.plot.style import BLUE, sheet
from impactfem.system.arrays import Array, Index

Point = tuple[float, float, float]
"""Coordinates x, y, z [m]."""
GREY, ARROW = "0.35", "black"
DEVICE = 7
"""Marker of a device: a triangle that stands on its point."""
APART = 0.6
"""Distance between two buildings in the figure, in parts of the mean width: the gap is not to
scale, because it would be thinner than a line."""
SLENDER = 0.35
"""Least width of a building in the figure, in parts of the largest height."""
SLAB = 0.25
"""Thickness of the slabs in the figure, in parts of the lowest storey height."""
LINE = 0.045
"""Height of a line of text in the figure, in parts of the height of the buildings."""


@dataclass(frozen=True)
class Elevation:
    """A building in elevation; its position is that of its axis along the direction [m]."""

    name: str
    centre: float
    base: float
    in_3d: bool  #: whether its 3D model pounds, not its stick
    floors: Array
    below: Array
    above: Array
    numbers: Index

    @property
    def top(self) -> float:
        """Elevation of its upper edge [m]."""
        return float(self.floors[-1] + self.above[-1])


def elevations(sticks: xr.Dataset) -> list[Elevation]:
    """Return the buildings of `pounding.nc`, in order."""
    along = sticks.sel(plan=str(sticks.attrs["elevation_direction"]))
    result = []
    for name in sticks["building"].values:
        one = along.sel(building=name).isel(station=sticks["station_building"] == name)
        parts = ("elevation", "rigid_below", "rigid_above", "station_floor")
        place = float(one["building_axis"]), float(one["building_base"])
        values = [one[part].values for part in parts]
        in_3d = one["building_model"].item() == "structure"
        result.append(Elevation(str(name), *place, in_3d, *values))
    return result


@dataclass(frozen=True)
class _Drawn:
    """A building with its sides in the figure [m]."""

    elevation: Elevation
    left: float
    right: float


@figure("elevation", "Impacts", "Peak floor accelerations, impacts and equipment")
def elevation_figure(
    path: Path,
    sticks: xr.Dataset,
    forces: xr.Dataset,
    equipment: Sequence[tuple[str, str, Point]],
) -> None:
    """Draw the buildings with peak floor accelerations, gaps, devices and largest impacts.

    Args:
        path: The SVG file.
        sticks: `pounding.nc`.
        forces: The pairs of `forces.nc`, one for each line.
        equipment: Building, name and place [m] of each device.
    """
    direction = str(sticks.attrs["shown_direction"])
    along = str(sticks.attrs["elevation_direction"])
    drawn = _placed(sticks, forces)
    peaks = sticks[["pfa", "pfa_free"]].sel(direction=direction)
    scale = Normalize(0.0, float(peaks["pfa"].max()) or 1.0)
    hit = sticks.sizes["impact"] > 0
    caption = (
        f"Peak floor accelerations along {direction}"
        + (", largest force up to 100 Hz and number of impacts of each contact pair" if hit else "")
        + ". In brackets: without impact. Distances between buildings are not to scale."
        + (" Triangles: devices." if equipment else "")
    )
    seen = "; ".join(
        f"{one.elevation.name} with {len(one.elevation.floors)} floors up to "
        f"{one.elevation.top:.4g} m, peak floor acceleration up to "
        f"{float(_of(peaks, one)['pfa'].max()):.3g} m/s²"
        for one in drawn
    )
    with sheet(path, (1, 1), (7.5, 4.8), caption, f"{seen}.") as (whole, (panel,)):
        storeys = [np.diff(one.elevation.floors, prepend=one.elevation.base) for one in drawn]
        thickness = SLAB * float(np.concatenate(storeys).min())
        for one in drawn:
            _draw_building(panel, one, _of(peaks, one), scale, thickness)
            own = [(n, place) for building, n, place in equipment if building == one.elevation.name]
            _draw_devices(panel, one, own, along, thickness)
        walls = _draw_pairs(panel, drawn, sticks, forces)
        low = min(one.elevation.base for one in drawn)
        high = max(one.elevation.top for one in drawn)
        panel.axhline(low, color="black", lw=2.0)
        ends = [drawn[0].left, drawn[-1].right, *walls]
        room = 0.25 * (drawn[-1].right - drawn[0].left) / len(drawn)
        panel.set(xlim=(min(ends) - room, max(ends) + room), ylabel="z [m]")
        panel.set(ylim=(low - 0.11 * (high - low), high + 0.12 * (high - low)), xticks=[])
        panel.grid(False)
        label = f"peak floor acceleration along {direction} [m/s²]"
        whole.colorbar(ScalarMappable(scale, _colours()), ax=panel, label=label, shrink=0.8)


def _colours() -> mpl.colors.Colormap:
    """Return a perceptual colour scale of so few colours that its bar is drawn by lines."""
    return mpl.colormaps["viridis"].resampled(12)


def _of(peaks: xr.Dataset, one: _Drawn) -> xr.Dataset:
    return peaks.isel(station=(peaks["station_building"] == one.elevation.name).values)


def _placed(sticks: xr.Dataset, forces: xr.Dataset) -> list[_Drawn]:
    """Place the buildings from left to right; their widths are those of their contact points."""
    along = str(sticks.attrs["elevation_direction"])
    ordered = sorted(elevations(sticks), key=lambda one: one.centre)
    least = SLENDER * max(one.top - one.base for one in ordered)
    widths = []
    for one in ordered:
        reach = [least / 2.0]
        for side in "ab":
            own = (forces[f"building_{side}"] == one.name).values
            reach += np.abs(forces[f"offset_{side}"].sel(axis=along).values[own]).tolist()
        widths.append(2.0 * max(reach))
    apart, left, drawn = APART * float(np.mean(widths)), 0.0, []
    for one, width in zip(ordered, widths, strict=True):
        drawn.append(_Drawn(one, left, left + width))
        left += width + apart
    return drawn


def _draw_building(
    panel: Axes, drawn: _Drawn, peaks: xr.Dataset, scale: Normalize, thickness: float
) -> None:
    """Draw walls, and slabs in the colour of their peak acceleration, with its value."""
    one, width = drawn.elevation, drawn.right - drawn.left
    for x in (drawn.left, drawn.right):
        panel.plot([x, x], [one.base, one.floors[-1]], color=GREY, lw=1.2)
    colours = _colours()
    values = zip(one.floors, one.numbers, peaks["pfa"], peaks["pfa_free"], strict=True)
    for z, number, pfa, free in values:
        place, colour = (drawn.left, z - thickness / 2.0), colours(scale(float(pfa)))
        slab = Rectangle(place, width, thickness, facecolor=colour, edgecolor=GREY, lw=0.6)
        panel.add_patch(slab)
        text = f"{number}: {float(pfa):.3g} ({float(free):.3g})"
        look: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": 7.0}
        panel.text(drawn.left + width / 2.0, z - 0.7 * thickness, text, **look)
    panel.annotate(
        one.name,
        (drawn.left + width / 2.0, one.top),
        xytext=(0, 10),
        textcoords="offset points",
        ha="center",
        weight="bold",
    )


def _draw_devices(
    panel: Axes,
    drawn: _Drawn,
    devices: Sequence[tuple[str, Point]],
    along: str,
    thickness: float,
) -> None:
    """Mark the devices of a building on their floors; names of one place go into one text."""
    one, middle = drawn.elevation, 0.5 * (drawn.left + drawn.right)
    edge = 0.06 * (drawn.right - drawn.left)
    at: dict[tuple[float, float], list[str]] = {}
    for name, point in devices:
        x = middle + point["xyz".index(along)] - one.centre
        x = min(max(x, drawn.left + edge), drawn.right - edge)
        at.setdefault((round(x, 3), point[2]), []).append(name)
    for (x, z), names in at.items():
        panel.plot(x, z + 0.5 * thickness, marker=DEVICE, ms=7, color=BLUE, clip_on=False, zorder=4)
        look: dict[str, Any] = {"xytext": (7, 2), "textcoords": "offset points", "color": BLUE}
        if x > middle:
            look |= {"xytext": (-7, 2), "ha": "right"}
        look |= {"fontsize": 7.0, "weight": "bold"}
        panel.annotate(", ".join(names), (x, z + 0.5 * thickness), **look)


def _draw_pairs(
    panel: Axes, drawn: list[_Drawn], sticks: xr.Dataset, forces: xr.Dataset
) -> dict[float, float]:
    """Draw an arrow at each contact pair with impacts, and the gaps at rest.

    Returns:
        Heights of the rigid walls by their places [m].
    """
    along = str(sticks.attrs["elevation_direction"])
    by_name = {one.elevation.name: one for one in drawn}
    largest = float(sticks["impact_band_force"].max()) if sticks.sizes["impact"] else 0.0
    low = min(one.elevation.base for one in drawn)
    line = LINE * (max(one.elevation.top for one in drawn) - low)
    walls: dict[float, float] = {}
    gaps: dict[tuple[float, float], list[tuple[float, float]]] = {}
    arrows: dict[tuple[float, float], list[tuple[float, float, int]]] = {}
    for k, name in enumerate(forces["pair"].values):
        pair = forces.isel(pair=k)
        a = by_name[pair["building_a"].item()]
        b = by_name.get(pair["building_b"].item()) or _wall(
            a, float(pair["normal"].sel(axis=along))
        )
        left, right = sorted((a, b), key=lambda one: one.left)
        if b.elevation is a.elevation:
            walls[b.left] = a.elevation.top
        sides = left.right, right.left
        widths = [float(sticks[f"pair_{one}"][k]) for one in ("rest_gap", "required_separation")]
        gaps.setdefault(sides, []).append((1e3 * widths[0], 1e3 * widths[1]))
        hits = sticks["impact_band_force"].values[(sticks["impact_pair"] == name).values]
        if hits.size:
            arrow = (_height(a.elevation, pair), float(hits.max()), hits.size)
            arrows.setdefault(sides, []).append(arrow)
    for sides, impacts in arrows.items():
        middle, free = 0.5 * sum(sides), -np.inf
        for z, force, count in sorted(impacts):
            width = 0.8 + 2.2 * force / largest
            look = {"arrowstyle": "<|-|>", "color": ARROW, "lw": width, "shrinkA": 0, "shrinkB": 0}
            panel.annotate("", (sides[0], z), xytext=(sides[1], z), arrowprops=look)
            # The texts of close pairs go above one another.
            bottom = max(z + 0.25 * line, free)
            free = bottom + line
            text = f"{1e-6 * force:.3g} MN, {count}×"
            back = {"facecolor": "white", "edgecolor": "none", "pad": 0.4}
            over: dict[str, Any] = {"ha": "center", "va": "bottom", "bbox": back, "zorder": 5}
            panel.text(middle, bottom, text, fontsize=7.0, **over)
    for sides, values in gaps.items():
        provided, required = zip(*values, strict=True)
        ends = dict.fromkeys(f"{gap:.3g}" for gap in (min(provided), max(provided)))
        under: dict[str, Any] = {"xytext": (0, -4), "textcoords": "offset points"}
        under |= {"ha": "center", "va": "top", "fontsize": 7.5}
        text = f"gap {' to '.join(ends)} mm\nrequired {max(required):.3g} mm"
        panel.annotate(text, (0.5 * sum(sides), low), **under)
    for x, top in walls.items():
        panel.plot([x, x], [low, top], color="black", lw=4.0)
        above: dict[str, Any] = {"xytext": (0, 4), "textcoords": "offset points", "ha": "center"}
        panel.annotate("rigid wall", (x, top), fontsize=7.5, **above)
    return walls


def _wall(building: _Drawn, normal: float) -> _Drawn:
    """Place a rigid wall on the side of a building to which the normal points."""
    apart = APART * (building.right - building.left)
    x = building.right + apart if normal > 0.0 else building.left - apart
    return _Drawn(building.elevation, x, x)


def _height(building: Elevation, pair: xr.Dataset) -> float:
    """Elevation at which a pair touches its first building [m]."""
    floor = int(np.flatnonzero(building.numbers == int(pair["floor_a"]))[0])
    z, share = float(building.floors[floor]), float(pair["relative_height_a"])
    if np.isfinite(share):
        low = float(building.floors[floor - 1]) if floor else building.base
        z = low + share * (z - low)
    return z + float(pair["offset_a"].sel(axis="z"))
