"""Pictures of the response in 3D: where it is looked at (14), and all floors with their peaks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import LogNorm, Normalize
from numpy.typing import NDArray

from impactfem.plot.floor_field import COLOURS
from impactfem.plot.scene import (
    SHADING,
    Picture,
    add_ghost,
    balls,
    corners,
    impact_view,
    keys,
    note,
    plotter,
    render,
    screen_axes,
    show,
    surface,
)
from impactfem.plot.style import RED, figure
from impactfem.stages.stores import open_store
from impactfem.stages.transient.map_figures import at_node
from impactfem.stages.transient.selection import of_kind, shown
from impactfem.system.own_process import in_own_process

Array = NDArray[np.float64]
Grids = dict[int, tuple[Any, NDArray[np.int64]]]
"""Triangles of each floor, and where their nodes are in the maps."""

PROBES = "figure_14_probes.png"
PEAKS = "building_map_floors_pfa.png"
AMPLIFICATION = "building_map_floors_amplification.png"

KINDS = {
    "edge": ("impact edges", "#d55e00"),
    "line": ("line across", "#0072b2"),
    "centre": ("mass centres", "#009e73"),
    "point": ("points of the case", "#cc79a7"),
}
"""Label and colour of each family of probes; told apart with any colour vision."""
MOST_LABELS = 30
"""Names of more probes than these would hide one another."""
SPREAD = 0.95
"""Distance of two floors in the picture over the depth of the plan."""
COLUMN = 4
"""Floors above one another in the picture."""
WIDE = 10.0
"""Ratio of the largest value to the least from which colours go by its logarithm."""
BESIDE = 1.3
"""Distance of two columns of floors over the length of the plan."""
FROM_SHORT = ((-0.12, -1.35, 1.0), (1.35, -0.12, 1.0))
"""From where floors are seen that are longest along x, or along y."""


def transient_pictures(folder: Path) -> list[Path]:
    """Draw figure 14 and the floors into `figures/`, in a process of their own.

    Args:
        folder: The run's folder, with `building.nc`, `transient.nc` and, for the floors,
            `transient_maps.nc`.

    Returns:
        The files.

    Raises:
        ImpactfemError: A file cannot be written, or the process that draws crashed, as it does
            where OpenGL is missing (Debian's libegl1 and libgl1).
    """
    return in_own_process(draw, folder)


def draw(folder: Path) -> list[Path]:
    """Draw what `transient_pictures` gives, in this process."""
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    with (
        open_store(folder / "building.nc") as building,
        open_store(folder / "transient.nc") as store,
    ):
        response = shown(store)
        files = [_probes(target / PROBES, building, response)]
        if (folder / "transient_maps.nc").is_file():
            with open_store(folder / "transient_maps.nc") as maps:
                files += _floors(target, building, response, maps)
    return files


def _probes(path: Path, building: xr.Dataset, response: xr.Dataset) -> Path:
    """The points where the response is looked at, seen from the side of the impact."""
    scene = plotter()
    add_ghost(scene, building)
    size = float(np.ptp(building["node_position"].values, axis=0).max())
    legend = []
    for kind, (label, colour) in KINDS.items():
        chosen = of_kind(response, kind)
        if not chosen.sizes["probe"]:
            continue
        radius = size * (0.011 if kind == "edge" else 0.009)
        scene.add_mesh(balls(chosen["probe_position"].values, radius), color=colour, **SHADING)
        legend.append((label, colour, "ball"))
    picture = render(scene, building["node_position"].values, impact_view(building))
    named = [of_kind(response, kind) for kind in ("edge", "point")]
    named.append(of_kind(response, "line").isel(probe=slice(-1, None)))
    labelled = xr.concat([one["probe_position"] for one in named], "probe")
    caption = (
        f"Figure 14: Points of building {response.attrs['building']} where the response in 3D is "
        f"looked at: {response.sizes['probe']} nodes of the mesh nearest to them."
    )
    with figure(path, (1, 1), (6.5, 4.9), caption) as (drawn, axes):
        show(axes[0], picture)
        if len(labelled) <= MOST_LABELS:
            for position in labelled:
                note(axes[0], picture, position.values, position["probe"].item())
        drawn.legend(handles=keys(legend), loc="outside upper center", ncols=len(legend))
    return path


def _floors(
    target: Path, building: xr.Dataset, response: xr.Dataset, maps: xr.Dataset
) -> list[Path]:
    """All floors, drawn farther apart than they are, with peak acceleration and amplification."""
    d = response["component"].item()
    pfa = maps["pfa"].sel(component=d).values
    ratio = np.full_like(pfa, np.nan)
    grids: Grids = {}
    for node in of_kind(response, "centre")["probe_node"]:
        floor = node["probe_floor"].item()
        grid, places = _floor_grid(building, maps, floor)
        if not len(places):
            continue
        grids[floor] = grid, places
        centre = float(pfa[at_node(maps, node.item())])
        if centre > 0.0:
            ratio[places] = pfa[places] / centre
    if not grids:
        return []
    kinds = (
        (PEAKS, pfa, f"peak acceleration along $e_{d}$ [m/s²]"),
        (AMPLIFICATION, ratio, "peak acceleration over that of the mass centre [-]"),
    )
    what = f"Peak absolute acceleration along $e_{d}$ of building {response.attrs['building']}"
    captions = (
        f"{what}, over its floors.",
        f"{what}, over its floors, each over that of the floor's mass centre.",
    )
    return [
        _stack(target / name, grids, _impact_edges(building), values, label, caption)
        for (name, values, label), caption in zip(kinds, captions, strict=True)
    ]


def _impact_edges(building: xr.Dataset) -> dict[int, Array]:
    """Ends of the lines of the impact edge of each floor, shape (n, 2, 3) [m]."""
    floors = building["edge_floor"].values
    ends = building["node_position"].values[building["edge_line"].values[:, :2]]
    return {int(floor): ends[floors == floor] for floor in np.unique(floors)}


def _floor_grid(
    building: xr.Dataset, maps: xr.Dataset, floor: int
) -> tuple[Any, NDArray[np.int64]]:
    """The flat slab of a floor as triangles, and where its nodes are in the maps."""
    import pyvista

    names = [str(name) for name in building["shell_part_name"].values]
    mine = np.array([name.split("_")[:2] == ["floor", str(floor)] for name in names])
    cells = building["triangle_node"].values[mine[building["triangle_part"].values]][:, :3]
    points = building["node_position"].values
    flat = np.ptp(points[cells][..., 2], axis=1) < 1e-6
    nodes, corners = np.unique(cells[flat], return_inverse=True)
    grid = pyvista.UnstructuredGrid(
        {pyvista.CellType.TRIANGLE: corners.reshape(-1, 3)}, points[nodes]
    )
    places = np.searchsorted(maps["node_number"].values, nodes)
    return grid, np.asarray(places, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class _Layout:
    """Where floors are drawn: above one another, in columns along their long side.

    Args:
        size: Largest extent of the floors along x and y, shape (2,) [m].
    """

    size: Array

    @classmethod
    def of(cls, grids: Grids) -> _Layout:
        sizes = [np.ptp(np.asarray(grid.points), axis=0)[:2] for grid, _ in grids.values()]
        return cls(np.array(sizes).max(axis=0))

    @property
    def long(self) -> int:
        """Direction of the long side; it goes from left to right."""
        return int(np.argmax(self.size))

    @property
    def view(self) -> tuple[float, float, float]:
        return FROM_SHORT[self.long]

    def shift(self, number: int, height: float) -> Array:
        """From the place of a floor at a height [m] to that in the picture, shape (3,) [m]."""
        column, row = divmod(number, COLUMN)
        shift = np.array([0.0, 0.0, SPREAD * self.size.min() * row - height])
        shift[self.long] = BESIDE * self.size.max() * column
        return shift


def _stack(
    path: Path, grids: Grids, edges: dict[int, Array], values: Array, label: str, caption: str
) -> Path:
    """Values at the nodes of the maps over all floors."""
    scale = colour_scale(np.concatenate([values[places] for _, places in grids.values()]))
    layout = _Layout.of(grids)
    picture, marks, impacts = _rendered(grids, edges, values, scale, layout)
    height, width = picture.image.shape[:2]
    shape = (8.2, 7.0 * height / width + 0.9)
    caption += f" {'xy'[layout.long]} to the right; heights not to scale"
    caption += "; the impact edges are marked" if edges else ""
    caption += "; colours by the logarithm." if isinstance(scale, LogNorm) else "."
    with figure(path, (1, 1), shape, caption) as (drawn, axes):
        show(axes[0], picture, triad=False)
        for ends in impacts:
            lines = picture.place(ends)
            axes[0].add_collection(LineCollection(list(lines), colors=RED, linewidths=1.2))
        for floor, mark in zip(grids, marks, strict=True):
            note(axes[0], picture, mark, f"floor {floor}")
        bar = drawn.colorbar(
            ScalarMappable(scale, COLOURS),
            ax=axes[0],
            location="bottom",
            shrink=0.5,
            aspect=30,
            pad=0.02,
        )
        if isinstance(scale, LogNorm):
            bar.set_ticks(round_numbers(*bar.mappable.get_clim()))
            bar.ax.xaxis.set_major_formatter("{x:g}")
            bar.ax.minorticks_off()
        bar.set_label(label)
    return path


def colour_scale(values: Array) -> Normalize:
    """From values to colours, by the logarithm where the largest is many times the least.

    Floors that are hit may be so far above the others that a straight scale leaves these in one
    colour.

    Args:
        values: All that are shown; nan where there is none.
    """
    known = values[np.isfinite(values)]
    if not known.size:
        return Normalize(0.0, 1.0)
    low, high = float(known.min()), float(known.max())
    return LogNorm(low, high) if 0.0 < low * WIDE < high else Normalize(low, high)


def round_numbers(low: float, high: float) -> list[float]:
    """1, 2 and 5 times the powers of ten between two positive values."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    every = (k * 10.0**power for power in powers for k in (1.0, 2.0, 5.0))
    return [value for value in every if low <= value <= high]


def _rendered(
    grids: Grids,
    edges: dict[int, Array],
    values: Array,
    scale: Normalize,
    layout: _Layout,
) -> tuple[Picture, list[Array], list[Array]]:
    """The floors in their places, the leftmost point of each, and the impact edges there."""
    scene = plotter()
    right, _ = screen_axes(np.array(layout.view))
    marks, every, impacts = [], [], []
    for number, (floor, (grid, places)) in enumerate(grids.items()):
        raised = grid.copy()
        points = np.asarray(raised.points).copy()
        shift = layout.shift(number, points[0, 2])
        points += shift
        raised.points = points
        # A masked array, where a node has no value.
        shares: Any = scale(values[places])
        raised.point_data["value"] = shares.filled(np.nan)
        scene.add_mesh(
            raised,
            scalars="value",
            cmap=COLOURS,
            clim=(0.0, 1.0),
            show_scalar_bar=False,
            lighting=False,
        )
        scene.add_mesh(corners(surface(raised)), color="black", line_width=1.5)
        if floor in edges:
            impacts.append(edges[floor] + shift)
        every.append(points)
        marks.append(points[np.argmin(points @ right)])
    return render(scene, np.concatenate(every), layout.view), marks, impacts
