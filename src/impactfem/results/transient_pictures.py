"""Pictures of the response in 3D: where it is looked at (14), and all floors with their peaks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.own_process import in_own_process
from impactfem.results.floor_field import COLOURS
from impactfem.results.scene import beam_grid, plotter, save, screen_axes, shell_grid
from impactfem.results.transient_maps import at_node
from impactfem.results.transient_view import TransientView

Array = NDArray[np.float64]

PROBES = "figure_14_probes.png"
PEAKS = "building_map_floors_pfa.png"
AMPLIFICATION = "building_map_floors_amplification.png"

KINDS = {
    "edge": ("impact edges", "#d55e00"),
    "line": ("line across", "#0072b2"),
    "centre": ("mass centres", "#009e73"),
    "": ("asked for", "#cc79a7"),
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
BAR = 0.16
"""Part of the height of the picture that the scale of colours takes."""
SCALE = {
    "color": "black",
    "n_labels": 5,
    "fmt": "%.3g",
    "title_font_size": 26,
    "label_font_size": 24,
    "vertical": False,
    "position_x": 0.3,
    "position_y": 0.03,
    "height": 0.07,
    "width": 0.4,
}


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
        xr.open_dataset(folder / "building.nc", engine="h5netcdf") as building,
        xr.open_dataset(folder / "transient.nc", engine="h5netcdf") as store,
    ):
        view = TransientView(store)
        files = [_probes(target / PROBES, building, view)]
        if (folder / "transient_maps.nc").is_file():
            with xr.open_dataset(folder / "transient_maps.nc", engine="h5netcdf") as maps:
                files += _floors(target, building, view, maps)
    return files


def _probes(path: Path, building: xr.Dataset, view: TransientView) -> Path:
    """The points where the response is looked at, seen from the side of the impact."""
    scene = plotter()
    scene.enable_depth_peeling(12)
    outline = shell_grid(building).extract_surface(
        nonlinear_subdivision=0, algorithm="dataset_surface"
    )
    scene.add_mesh(outline, color="#c9c9c9", opacity=0.25)
    scene.add_mesh(
        outline.extract_feature_edges(
            feature_angle=30.0, boundary_edges=True, non_manifold_edges=True, manifold_edges=False
        ),
        color="#5a5a5a",
        line_width=1.0,
    )
    columns = beam_grid(building, "column")
    if columns.n_cells:
        scene.add_mesh(columns, color="#9a9a9a", line_width=3.0)
    size = float(np.ptp(building["node_position"].values, axis=0).max())
    legend = []
    for kind, (label, colour) in KINDS.items():
        chosen = [k for k, name in enumerate(view.names) if _kind(view, k, name) == kind]
        if not chosen:
            continue
        radius = size * (0.011 if kind == "edge" else 0.009)
        scene.add_mesh(_balls(view.position[chosen], radius), color=colour)
        legend.append([label, colour])
    named = [k for k, name in enumerate(view.names) if _kind(view, k, name) in ("edge", "")]
    named += [view.line[-1]] if view.line else []
    if len(named) <= MOST_LABELS:
        scene.add_point_labels(
            view.position[named] + np.array([0.0, 0.0, 0.006 * size]),
            [f"{view.names[k]}   " for k in named],
            font_size=22,
            text_color="black",
            shape=None,
            show_points=False,
            always_visible=True,
            justification_horizontal="right",
        )
    scene.add_legend(legend, bcolor=None, face="circle", size=(0.17, 0.14), loc="upper right")
    scene.add_axes(color="black")
    return save(scene, path, view=_from_impact(building), points=building["node_position"].values)


def _kind(view: TransientView, index: int, name: str) -> str:
    families = {"centre": view.centres.values(), "edge": view.edges.values(), "line": view.line}
    return next((kind for kind, known in families.items() if index in known), "")


def _balls(points: Array, radius: float) -> Any:
    import pyvista

    cloud = pyvista.PolyData(points)
    return cloud.glyph(geom=pyvista.Sphere(radius=radius), scale=False, orient=False)


def _from_impact(building: xr.Dataset) -> tuple[float, float, float]:
    """Towards a camera that sees the impact edges, from the side and from above."""
    nodes = building["node_position"].values
    edge = nodes[np.unique(building["edge_line"].values)]
    if not len(edge):
        return (-1.0, -1.35, 0.75)
    out = edge[:, :2].mean(axis=0) - nodes[:, :2].mean(axis=0)
    out = out / np.linalg.norm(out)
    aside = np.array([-out[1], out[0]])
    x, y = 1.0 * out + 0.75 * aside
    return (float(x), float(y), 0.7)


def _floors(
    target: Path, building: xr.Dataset, view: TransientView, maps: xr.Dataset
) -> list[Path]:
    """All floors, drawn farther apart than they are, with peak acceleration and amplification."""
    c = "xyz".index(view.direction)
    pfa = maps["pfa"].values[:, c]
    ratio = np.full_like(pfa, np.nan)
    grids: dict[int, tuple[Any, NDArray[np.int64]]] = {}
    for floor, probe in view.centres.items():
        grid, places = _floor_grid(building, maps, floor)
        if not len(places):
            continue
        grids[floor] = grid, places
        centre = float(pfa[at_node(maps, int(view.store["probe_node"].values[probe]))])
        if centre > 0.0:
            ratio[places] = pfa[places] / centre
    if not grids:
        return []
    kinds = (
        (PEAKS, pfa, f"peak acceleration along {view.direction} [m/s²]\n"),
        (AMPLIFICATION, ratio, "peak acceleration over that of the floor's mass centre\n"),
    )
    return [_stack(target / name, grids, values, label) for name, values, label in kinds]


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


def _stack(
    path: Path,
    grids: dict[int, tuple[Any, NDArray[np.int64]]],
    values: Array,
    label: str,
) -> Path:
    scene = plotter()
    known = np.concatenate([values[places] for _, places in grids.values()])
    known = known[np.isfinite(known)]
    limits = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    sizes = np.array([np.ptp(np.asarray(grid.points), axis=0)[:2] for grid, _ in grids.values()])
    size = sizes.max(axis=0)
    # The long side of the floors goes from left to right.
    view = FROM_SHORT[int(np.argmax(size))]
    right, _ = screen_axes(np.array(view))
    marks, texts, every = [], [], []
    for number, (floor, (grid, places)) in enumerate(grids.items()):
        raised = grid.copy()
        points = np.asarray(raised.points).copy()
        points[:, 2] = 0.0
        column, row = divmod(number, COLUMN)
        points[:, int(np.argmax(size))] += BESIDE * size.max() * column
        points[:, 2] += SPREAD * size.min() * row
        raised.points = points
        raised.point_data[label] = values[places]
        scene.add_mesh(
            raised,
            scalars=label,
            cmap=COLOURS,
            clim=limits,
            show_scalar_bar=number == 0,
            scalar_bar_args=SCALE if number == 0 else None,
            lighting=False,
        )
        scene.add_mesh(
            raised.extract_feature_edges(
                boundary_edges=True, feature_edges=False, manifold_edges=False
            ),
            color="black",
            line_width=1.5,
        )
        every.append(points)
        marks.append(points[np.argmin(points @ right)])
        texts.append(f"floor {floor}  ")
    scene.add_point_labels(
        np.array(marks),
        texts,
        font_size=26,
        text_color="black",
        shape=None,
        show_points=False,
        always_visible=True,
        justification_horizontal="right",
    )
    scene.add_axes(color="black")
    return save(scene, path, view=view, points=np.concatenate(every), below=BAR)
