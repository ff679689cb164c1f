"""Fields drawn with colours that print: over the slab of the top floor, and along edges in time."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.ticker import LogLocator, MaxNLocator, StrMethodFormatter
from matplotlib.tri import LinearTriInterpolator, Triangulation

from impactfem.plot.style import letter, sheet
from impactfem.system.arrays import Array, Index

COLOURS = "viridis"
"""A perceptual scale: lightness grows with the value, in grey and with any colour vision."""
WIDE = 50.0
"""Ratio of the largest value to the least from which on a scale of colours is logarithmic."""
SIGNED = "RdBu_r"
"""For values with a sign: white at zero, blue below and red above, which any colour vision tells
apart; both ends are dark in grey, so that pictures mark where the sign changes."""
MARGIN = 0.14
# Four flat triangles of a six-node one: vertices 0 1 2, mid nodes of 01 12 20.
PARTS = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))


class TopFloor:
    """The slab of the top floor of `transient_maps.nc`, the open store."""

    def __init__(self, maps: xr.Dataset) -> None:
        self.position: Array = np.asarray(maps["wave_node_position"].values, dtype=np.float64)
        self.cells: Index = np.asarray(maps["wave_triangle_node"].values, dtype=np.int64)
        self.node_number: Index = np.asarray(maps["wave_node_number"].values, dtype=np.int64)

    @property
    def size(self) -> Array:
        """Extent along x and y [m]."""
        return np.asarray(np.ptp(self.position[:, :2], axis=0))

    @property
    def wide(self) -> bool:
        """Whether panels go below one another rather than side by side."""
        return bool(self.size[0] >= self.size[1])

    def split(self, shift: Array | None = None) -> Triangulation:
        """All nodes in flat triangles, four of each element, moved by `shift` [m]."""
        x, y = self._plan(shift)
        return Triangulation(x, y, np.concatenate([self.cells[:, part] for part in PARTS]))

    def elements(self) -> Triangulation:
        """The elements without their mid nodes, for values by element or by vertex."""
        x, y = self._plan(None)
        vertices, corners = np.unique(self.cells[:, :3], return_inverse=True)
        return Triangulation(x[vertices], y[vertices], corners.reshape(-1, 3))

    @property
    def vertex_number(self) -> Index:
        """Numbers in the building of the vertices of `elements`, shape (n_vertices,)."""
        return np.asarray(self.node_number[np.unique(self.cells[:, :3])])

    def along(self, values: Array, points: Array) -> Array:
        """Values at nodes interpolated to points (x, y) in the slab; nan outside of it."""
        found: Any = LinearTriInterpolator(self.split(), values)(points[:, 0], points[:, 1])
        return np.asarray(found.filled(np.nan), dtype=np.float64)

    def deformation(self, displacement: Array) -> Array:
        """Displacement in plan without the motion of the floor as a rigid body [m].

        Least squares over the nodes: u − (a + θ e_z × (r − r̄)), shape (n, 2).
        """
        r = self.position[:, :2] - self.position[:, :2].mean(axis=0)
        u = displacement[:, :2] - displacement[:, :2].mean(axis=0)
        turned = np.column_stack([-r[:, 1], r[:, 0]])
        theta = float((turned * u).sum() / (turned**2).sum())
        return np.asarray(u - theta * turned)

    def _plan(self, shift: Array | None) -> tuple[Array, Array]:
        where = self.position[:, :2] if shift is None else self.position[:, :2] + shift
        return where[:, 0], where[:, 1]


def signed_limits(*values: float) -> tuple[float, float]:
    """Ends of a scale of colours with zero in its middle that holds all values."""
    largest = max(abs(value) for value in values)
    return -largest, largest


def round_factor(largest: float, wanted: float) -> float:
    """The number 1, 2 or 5 times a power of ten that brings `largest` nearest below `wanted`."""
    if not largest > 0.0:
        return 1.0
    ratio = wanted / largest
    power = 10.0 ** math.floor(math.log10(ratio))
    return max(k * power for k in (1.0, 2.0, 5.0) if k * power <= ratio * (1.0 + 1e-12))


def plan_axes(panel: Axes, floor: TopFloor, margin: float = MARGIN) -> None:
    """A plan to scale, with a margin in parts of its smaller side."""
    low, high = floor.position[:, :2].min(axis=0), floor.position[:, :2].max(axis=0)
    beyond = margin * float(floor.size.min())
    (x0, y0), (x1, y1) = low - beyond, high + beyond
    panel.set(xlim=(x0, x1), ylim=(y0, y1), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    panel.grid(False)


def plan_layout(drawn: Any) -> None:
    """Leave no room for panels that are less high than wide; before the first scale of colours."""
    drawn.set_layout_engine("compressed")


def colour_bar(drawn: Any, mappable: Any, axes: Any, label: str) -> Any:
    """Draw the scale of the colours at the right of the panels; returns the bar."""
    bar = drawn.colorbar(mappable, ax=axes, location="right", aspect=30, pad=0.02)
    bar.set_label(label)
    return bar


def plain_ticks(bar: Any, scale: Normalize) -> None:
    """Write the values of a logarithmic colour bar at 1, 2 and 5 times powers of ten."""
    if isinstance(scale, LogNorm):
        bar.set_ticks(LogLocator(subs=(1.0, 2.0, 5.0)))
        bar.formatter = StrMethodFormatter("{x:g}")
        bar.update_ticks()
        bar.minorticks_off()


def colour_scale(values: Array) -> Normalize:
    """Return the scale from values to colours, logarithmic if they span a factor of `WIDE`.

    Floors that are hit may be so far above the others that a linear scale leaves these in one
    colour. A missing value is nan.
    """
    known = values[np.isfinite(values)]
    if not known.size:
        return Normalize(0.0, 1.0)
    low, high = float(known.min()), float(known.max())
    return LogNorm(low, high) if 0.0 < low * WIDE < high else Normalize(low, high)


def line_load_maps(
    path: Path,
    caption: str,
    seen: str,
    loads: Mapping[str, tuple[Array, Array, Array]],
    largest: float,
) -> None:
    """Maps of line loads over edge and time, by title: times [ms], distances [m], loads [MN/m].

    The loads, of shape (distances, times), are straight between the points; `largest` is the upper
    end of the colours.
    """
    columns = min(2, len(loads))
    rows = -(-len(loads) // columns)
    size = (3.6 * columns + 1.2, 3.2 * rows)
    with sheet(path, (rows, columns), size, caption, seen) as (drawn, axes):
        for spare in axes[len(loads) :]:
            spare.set_axis_off()
        axes = axes[: len(loads)]
        look: dict[str, Any] = {"shading": "gouraud", "cmap": COLOURS, "vmin": 0.0, "vmax": largest}
        for panel, (title, (time, distance, load)) in zip(axes, loads.items(), strict=True):
            mappable = panel.pcolormesh(time, distance, load, **look)
            panel.set_xlabel("time [ms]")
            panel.xaxis.set_major_locator(MaxNLocator(5))
            panel.grid(False)
            panel.set_title(title, fontsize=9.0)
        for panel in axes[::columns]:
            panel.set_ylabel("distance along the edge [m]")
        bar = drawn.colorbar(mappable, ax=axes, location="right", aspect=30, pad=0.02, extend="max")
        bar.set_label("line load [MN/m]")
        letter(axes)
