"""Pictures of the response in 3D: points with results, and all floors with their peaks."""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import LogNorm

from impactfem.plot.figure import figure
from impactfem.plot.floor_field import COLOURS, colour_scale, plain_ticks
from impactfem.plot.scene import (
    GHOST,
    OUTLINE,
    SHADING,
    Picture,
    add_ghost,
    balls,
    beam_grid,
    corners,
    impact_view,
    keys,
    note,
    plotter,
    render,
    screen_axes,
    shell_grid,
    show,
    surface,
)
from impactfem.plot.style import RED, sheet
from impactfem.plot.words import spoken
from impactfem.stages.stores import open_stores
from impactfem.stages.transient.curve_figures import MAPS, SPECTRA
from impactfem.stages.transient.selection import of_kind
from impactfem.system.arrays import Array

Grids = dict[int, Any]
"""Triangles of each floor, with the values of both pictures at their nodes."""

PEAKS, AMPLIFICATION = "peak", "amplification"
"""Values at the nodes of `Grids`."""

KINDS = {
    "edge": ("impact edges", "#d55e00"),
    "line": ("line across", "#0072b2"),
    "centre": ("mass centres", "#009e73"),
    "point": ("user-defined points", "#cc79a7"),
}
"""Label and colour of each family of probes; told apart with any colour vision."""
MOST_LABELS = 30
"""Names of more probes than these would hide one another."""
SPREAD = 0.95
"""Distance of two floors in the picture over the depth of the plan."""
COLUMN = 4
"""Floors above one another in the picture."""
BESIDE = 1.3
"""Distance of two columns of floors over the length of the plan."""
FROM_SHORT = ((-0.12, -1.35, 1.0), (1.35, -0.12, 1.0))
"""From where floors are seen that are longest along x, or along y."""


def field_picture(folder: Path, values: Array) -> Picture:
    """Return the building with its floors coloured by values; see-through walls and columns.

    Run it in a process of its own, as `draw_pictures`.

    Args:
        folder: The folder with `building.nc` and `transient_maps.nc`.
        values: Values from 0 to 1 at the vertices of the floors, shape (n,) [-]; nan for none.
    """
    import pyvista

    with open_stores(folder) as opened:
        building, maps = opened("building.nc"), opened("transient_maps.nc")
        points = maps["node_position"].values
        floors = pyvista.PolyData.from_regular_faces(points, maps["floor_triangle_node"].values)
        floors.point_data["value"] = values
        scene = plotter()
        scene.enable_depth_peeling(12)
        # Without the slabs of the mesh, which would be grey on the colours.
        walls = surface(shell_grid(building, "storey"))
        if walls.n_cells:
            scene.add_mesh(walls, color=GHOST, opacity=0.35)
        columns = beam_grid(building, "column")
        if columns.n_cells:
            scene.add_mesh(columns, color=OUTLINE, line_width=2.0)
        look = {"scalars": "value", "cmap": COLOURS, "clim": (0.0, 1.0), "lighting": False}
        scene.add_mesh(floors, show_scalar_bar=False, **look)
        scene.add_mesh(corners(floors), color=OUTLINE, line_width=1.0)
        return render(scene, building["node_position"].values, impact_view(building))


@figure("probes", SPECTRA, "Points of the 3D model with results", ending="png", in_3d=True)
def probes(path: Path, building: xr.Dataset, response: xr.Dataset) -> None:
    """Draw the points with recorded results, seen from the side of the impact."""
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
        f"Points of building {response.attrs['building']} where the response in 3D is "
        f"recorded: {response.sizes['probe']} nodes of the mesh nearest to them."
    )
    counts = (f"{of_kind(response, k).sizes['probe']} {label}" for k, (label, _) in KINDS.items())
    listed = ", ".join(one for one in counts if not one.startswith("0 "))
    seen = f"The building, seen through, with balls at its points: {listed}."
    with sheet(path, (1, 1), (6.5, 4.9), caption, seen) as (drawn, axes):
        show(axes[0], picture)
        if len(labelled) <= MOST_LABELS:
            for position in labelled:
                note(axes[0], picture, position.values, position["probe"].item().replace("_", " "))
        drawn.legend(handles=keys(legend), loc="outside upper center", ncols=len(legend))


def _grids(response: xr.Dataset, maps: xr.Dataset) -> Grids:
    """The floors with their peak accelerations, and these over that of the mass centre."""
    import pyvista

    pfa = maps["pfa"].sel(component=response["component"].item()).values
    floors = maps["floor_triangle_floor"].values
    grids: Grids = {}
    for centre in of_kind(response, "centre")["probe_node"]:
        cells = maps["floor_triangle_node"].values[floors == centre["probe_floor"].item()]
        if not len(cells):
            continue
        nodes, vertices = np.unique(cells, return_inverse=True)
        kinds = {pyvista.CellType.TRIANGLE: vertices.reshape(-1, 3)}
        grid = pyvista.UnstructuredGrid(kinds, maps["node_position"].values[nodes])
        at_centre = float(pfa[maps["node_number"].values == centre.item()].max(initial=0.0))
        grid.point_data[PEAKS] = pfa[nodes]
        ratio = pfa[nodes] / at_centre if at_centre > 0.0 else np.full(len(nodes), np.nan)
        grid.point_data[AMPLIFICATION] = ratio
        grids[centre["probe_floor"].item()] = grid
    return grids


def _has_floors(maps: xr.Dataset) -> bool:
    return bool(maps.sizes["floor_triangle"])


@figure(
    "floor_peaks",
    MAPS,
    "Peak accelerations over all floors",
    when=_has_floors,
    default=False,
    ending="png",
    in_3d=True,
)
def floor_peaks(path: Path, building: xr.Dataset, response: xr.Dataset, maps: xr.Dataset) -> None:
    """Draw all floors above one another, coloured by their peak acceleration."""
    label = f"peak acceleration along $e_{response['component'].item()}$ [m/s²]"
    caption = f"Floors of building {response.attrs['building']} coloured by peak acceleration."
    _stack(path, building, _grids(response, maps), PEAKS, (label, caption))


@figure(
    "floor_amplification",
    MAPS,
    "Peak accelerations relative to the mass centre of each floor",
    when=_has_floors,
    default=False,
    ending="png",
    in_3d=True,
)
def floor_amplification(
    path: Path, building: xr.Dataset, response: xr.Dataset, maps: xr.Dataset
) -> None:
    """Draw all floors, coloured by their peak acceleration over that of the mass centre."""
    label = "peak acceleration over that of the mass centre [-]"
    caption = f"Floors of building {response.attrs['building']} coloured by the {label}."
    _stack(path, building, _grids(response, maps), AMPLIFICATION, (label, caption))


def _stack(
    path: Path, building: xr.Dataset, grids: Grids, name: str, words: tuple[str, str]
) -> None:
    """Draw values over all floors, above one another in columns along the long side.

    `words` are the label of the colours, and the caption.
    """
    label, caption = words
    lines = building["node_position"].values[building["edge_line"].values[:, :2]]
    edges = {floor: lines[building["edge_floor"].values == floor] for floor in grids}
    scale = colour_scale(np.concatenate([grid.point_data[name] for grid in grids.values()]))
    size = np.array([np.ptp(grid.points, axis=0)[:2] for grid in grids.values()]).max(axis=0)
    long = int(np.argmax(size))
    scene, view = plotter(), FROM_SHORT[long]
    right, _ = screen_axes(np.array(view))
    marks, every, impacts = [], [], []
    for number, (floor, grid) in enumerate(grids.items()):
        column, row = divmod(number, COLUMN)
        shift = np.array([0.0, 0.0, SPREAD * size.min() * row - grid.points[0, 2]])
        shift[long] = BESIDE * size.max() * column
        raised = grid.copy()
        raised.points = points = np.asarray(grid.points) + shift
        # A masked array, where a node has no value.
        shares: Any = scale(grid.point_data[name])
        raised.point_data["value"] = shares.filled(np.nan)
        look = {"scalars": "value", "cmap": COLOURS, "clim": (0.0, 1.0), "lighting": False}
        scene.add_mesh(raised, show_scalar_bar=False, **look)
        scene.add_mesh(corners(surface(raised)), color="black", line_width=1.5)
        impacts.append(edges[floor] + shift)
        every.append(points)
        marks.append(points[np.argmin(points @ right)])
    picture = render(scene, np.concatenate(every), view)
    height, width = picture.image.shape[:2]
    caption += f" {'xy'[long]} to the right; heights not to scale"
    caption += "; the impact edges are marked" if any(map(len, impacts)) else ""
    caption += "; colours by the logarithm." if isinstance(scale, LogNorm) else "."
    largest = {f: float(np.nanmax(grid.point_data[name])) for f, grid in grids.items()}
    most = max(largest, key=lambda floor: largest[floor])
    seen = (
        f"{len(grids)} slabs above one another, coloured by {spoken(label)}: largest on floor "
        f"{most}, {largest[most]:.4g}."
    )
    with sheet(path, (1, 1), (8.2, 7.0 * height / width + 0.9), caption, seen) as (drawn, axes):
        show(axes[0], picture, triad=False)
        for ends in impacts:
            axes[0].add_collection(
                LineCollection(list(picture.place(ends)), colors=RED, linewidths=1.2)
            )
        for floor, mark in zip(grids, marks, strict=True):
            note(axes[0], picture, mark, f"floor {floor}")
        place: dict[str, Any] = {"location": "bottom", "shrink": 0.5, "aspect": 30, "pad": 0.02}
        bar = drawn.colorbar(ScalarMappable(scale, COLOURS), ax=axes[0], **place)
        plain_ticks(bar, scale)
        bar.set_label(label)
