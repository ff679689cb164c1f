"""The floor of a device at the frequencies of its modes."""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.collections import LineCollection
from matplotlib.patheffects import withStroke
from matplotlib.tri import Triangulation

from impactfem.plot.figure import figure
from impactfem.plot.floor_field import COLOURS, colour_bar, colour_scale, plain_ticks, plan_layout
from impactfem.plot.style import RED, letter, sheet
from impactfem.stages.device.pictures import Floor
from impactfem.stages.device.selection import ALL, anchor_of, direction, shown_modes
from impactfem.stages.transient.selection import at_frequencies
from impactfem.system.arrays import Array

MODES = 2
"""Number of modes in the figure, those with the lowest frequencies."""
SMALL = 0.1
"""Part of the peak without impact from which on an ordinate without impact is in a ratio."""


def _frequencies(store: xr.Dataset, maps: xr.Dataset, device: str) -> Array:
    """Return the frequencies of the first modes along the shown direction within the maps [Hz]."""
    f, ends = shown_modes(store, device)["mode_frequency"].values, maps["frequency"].values
    return np.asarray(f[(f >= ends[0]) & (f <= ends[-1])][:MODES])


@figure(
    "device_map",
    ALL,
    "Acceleration over the floor at the frequencies of the device",
    when=lambda store, maps, device: _frequencies(store, maps, device).size,
    each="device",
    ending="png",
)
def device_map(
    path: Path,
    store: xr.Dataset,
    maps: xr.Dataset,
    building: xr.Dataset,
    resolved_in_maps: float,
    device: str,
) -> None:
    """Draw the spectra of the floor at the modes of a device, and their ratio to no impact."""
    axis, (point, number, _) = direction(store), anchor_of(store, device)
    frequency = _frequencies(store, maps, device)
    cells = maps["floor_triangle_node"].values[maps["floor_triangle_floor"].values == number]
    vertices, corners = np.unique(cells, return_inverse=True)
    place = maps["node_position"].values[vertices, :2]
    mesh = Triangulation(place[:, 0], place[:, 1], corners.reshape(-1, 3))
    own = maps.sel(component=axis).isel(node=vertices)
    hit, free = (at_frequencies(own[name], frequency).T for name in ("psa", "psa_free"))
    # At points that hardly move without impact the ratio has no meaning: it has a lower bound.
    ratio = hit / np.maximum(free, max(SMALL * float(own["pfa_free"].max()), 1e-12))
    count, (width, depth) = len(frequency), np.ptp(place, axis=0)
    fields = [(values, "Sa [m/s²]") for values in hit]
    fields += [(values, "with / without impact [-]") for values in ratio]
    caption = (
        f"Pseudo-acceleration along $e_{axis}$ over floor {number} at the modes of {device}, "
        f"{100.0 * float(maps.attrs['damping']):g} % damping, with impact (first row), and ratio "
        "with / without impact (second row). Cross: anchor. Red: impact edge."
    )
    k = int(hit[0].argmax())
    seen = (
        f"Plans of floor {number}; at {frequency[0]:.3g} Hz the largest value is {hit[0, k]:.3g} "
        f"m/s² at x = {place[k, 0]:.3g} m, y = {place[k, 1]:.3g} m."
    )
    wide = 3.6 if depth > width else 4.6
    size = (wide * count, 2.0 * min(3.6, (wide - 1.2) * depth / width + 0.8))
    with sheet(path, (2, count), size, caption, seen) as (drawn, axes):
        plan_layout(drawn)
        edges = Floor(building, number).impact_edge()
        for panel, (values, label), f in zip(axes, fields, np.tile(frequency, 2), strict=True):
            scale = colour_scale(values)
            look: dict[str, Any] = {"shading": "gouraud", "cmap": COLOURS, "norm": scale}
            bar = colour_bar(drawn, panel.tripcolor(mesh, values, **look), panel, label)
            plain_ticks(bar, scale)
            panel.add_collection(LineCollection(list(edges), colors=RED, linewidths=3.0))
            halo = [withStroke(linewidth=3.2, foreground="black")]
            panel.plot(*point[:2], "+", color="white", ms=9, mew=1.6, path_effects=halo)
            panel.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
            beyond = ", above the resolved band" if f > resolved_in_maps else ""
            panel.set_title(f"{f:.3g} Hz{beyond}", fontsize=9.0)
            panel.grid(False)
        letter(axes)
