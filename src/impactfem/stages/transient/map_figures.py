"""Maps of the floors' response: peak acceleration and spectra over the top floor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from impactfem.plot.floor_field import COLOURS, TopFloor, colour_bar, plan_axes, plan_layout
from impactfem.plot.style import RED, figure, letter
from impactfem.spectra import sampling_loss
from impactfem.stages.transient.selection import at_floor, floors_of, wave_floor

Array = NDArray[np.float64]


def spectrum_at(maps: xr.Dataset, direction: str, frequency: float) -> Array | None:
    """Pseudo-acceleration of all nodes of the maps at a frequency [m/s2].

    Between the two frequencies beside it, linear in the logarithms of both; None outside of the
    frequencies that were computed.

    Args:
        maps: The open `transient_maps.nc`.
        direction: The component, "x", "y" or "z".
        frequency: The frequency [Hz].
    """
    f = maps["frequency"].values
    if not f[0] * (1.0 - 1e-9) <= frequency <= f[-1] * (1.0 + 1e-9):
        return None
    high = int(np.clip(np.searchsorted(f, frequency), 1, len(f) - 1)) if len(f) > 1 else 0
    low = max(high - 1, 0)
    psa = maps["psa"].sel(component=direction).isel(frequency=[low, high])
    both = psa.transpose("node", "frequency").values.astype(np.float64)
    if low == high:
        return np.asarray(both[:, 0])
    share = math.log(frequency / f[low]) / math.log(f[high] / f[low])
    share = min(max(share, 0.0), 1.0)
    return np.asarray(both[:, 0] ** (1.0 - share) * both[:, 1] ** share)


def map_file(frequency: float) -> str:
    """Name of the map of pseudo-acceleration at a frequency [Hz]."""
    number = f"{frequency:g}".replace(".", "p")
    return f"building_map_psa_{number}hz.png"


def peak_map(path: Path, response: xr.Dataset, maps: xr.Dataset) -> None:
    """Peak acceleration over the top floor."""
    values = maps["pfa"].sel(component=response["component"]).values
    caption = (
        f"Peak absolute acceleration along {_where(response)} (a), and over that of its mass "
        f"centre (b). {_mark_note(response)}"
    )
    _draw(path, response, maps, values, "peak acceleration [m/s²]", caption)


def spectrum_map(path: Path, response: xr.Dataset, maps: xr.Dataset, frequency: float) -> None:
    """Pseudo-acceleration at a frequency over the top floor.

    Raises:
        ValueError: The frequency is outside of those that were computed.
    """
    values = spectrum_at(maps, response["component"].item(), frequency)
    if values is None:
        raise ValueError(f"no spectra at {frequency:g} Hz")
    points = float(maps.attrs["points_per_cycle"]) * maps["frequency"].values[-1] / frequency
    loss = float(sampling_loss(points))
    caption = (
        f"Pseudo-acceleration at {frequency:g} Hz ({100 * float(maps.attrs['damping']):g} % "
        f"damping) along {_where(response)} (a), and over that of its mass centre (b). "
        f"{_mark_note(response)} {points:.3g} samples in a cycle: "
        f"up to {100.0 * loss:.2g} % of a peak may be missing."
    )
    label = f"PSa at {frequency:g} Hz [m/s²]"
    _draw(path, response, maps, values, label, caption)


def spectrum_maps(frequencies: Sequence[float], maps: xr.Dataset) -> list[float]:
    """Those of the frequencies at which there are spectra [Hz]."""
    f = maps["frequency"].values
    return [x for x in frequencies if f[0] * (1.0 - 1e-9) <= x <= f[-1] * (1.0 + 1e-9)]


def at_node(maps: xr.Dataset, node: int) -> int:
    """Place of a node of the building in the maps."""
    return int(np.searchsorted(maps["node_number"].values, node))


def _draw(
    path: Path, response: xr.Dataset, maps: xr.Dataset, values: Array, label: str, caption: str
) -> None:
    floor = TopFloor(maps)
    on_floor = values[np.searchsorted(maps["node_number"].values, floor.vertex_number)]
    centre = _at_centre(response, maps, values)
    # Where nothing moves along this direction all is as at the mass centre.
    ratio: Array = np.ones_like(on_floor)
    if centre > 0.0:
        ratio = np.asarray(on_floor / centre, dtype=np.float64)
    long, short = max(floor.size), min(floor.size)
    panels, size = (
        ((2, 1), (7.2, 2.0 * (6.0 * short / long + 0.7)))
        if floor.wide
        else ((1, 2), (2.0 * (4.5 * short / long + 1.5), 4.6))
    )
    mesh = floor.elements()
    with figure(path, panels, size, caption) as (drawn, axes):
        plan_layout(drawn)
        both = ((on_floor, label), (ratio, "over the mass centre"))
        for panel, (one, name) in zip(axes, both, strict=True):
            colours = panel.tripcolor(mesh, one, shading="gouraud", cmap=COLOURS)
            colour_bar(drawn, colours, panel, name)
            _marks(panel, response)
        if _crosses(ratio):
            line = axes[1].tricontour(mesh, ratio, levels=[1.0], colors="white", linewidths=1.0)
            line.set(path_effects=[withStroke(linewidth=2.2, foreground="black")])
        for panel in axes:
            plan_axes(panel, floor, margin=0.02)
        letter(axes)


def _at_centre(response: xr.Dataset, maps: xr.Dataset, values: Array) -> float:
    """The value at the mass centre of the top floor."""
    centre = at_floor(response, "centre", wave_floor(response))
    return float(values[at_node(maps, centre["probe_node"].item())])


def _crosses(ratio: Array) -> bool:
    return bool(ratio.min() < 1.0 < ratio.max())


def _marks(panel: Axes, response: xr.Dataset) -> None:
    top = wave_floor(response)
    x, y, _ = at_floor(response, "centre", top)["probe_position"].values
    edge = [withStroke(linewidth=3.2, foreground="black")]
    panel.plot(x, y, "+", color="white", ms=9, mew=1.6, path_effects=edge)
    if top in floors_of(response, "edge"):
        x, y, _ = at_floor(response, "edge", top)["probe_position"].values
        panel.plot(x, y, "o", color=RED, ms=6, clip_on=False, zorder=5)


def _where(response: xr.Dataset) -> str:
    return f"$e_{response['component'].item()}$ of floor {wave_floor(response)}"


def _mark_note(response: xr.Dataset) -> str:
    hit = wave_floor(response) in floors_of(response, "edge")
    dot = "; dot: middle of the impact edge" if hit else ""
    return f"Cross: mass centre, whose value the white line has{dot}."
