"""Pictures of the 3D building: its mesh and its bending modes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.own_process import in_own_process
from impactfem.results.scene import FAMILIES, beam_grid, plotter, save, shell_grid

SHOWN = 3
AMPLITUDE = 0.12
"""Largest displacement in the picture of a mode over the size of the building."""


SCALE = {
    "color": "black",
    "n_labels": 3,
    "fmt": "%.1f",
    "title_font_size": 26,
    "label_font_size": 24,
    "vertical": True,
    "position_x": 0.88,
    "position_y": 0.25,
    "height": 0.5,
    "width": 0.05,
}
OPACITY = {"floor": 0.6, "storey": 0.3}
LINES = {"beam": 3.0, "column": 9.0}


def building_pictures(folder: Path) -> list[Path]:
    """Draw the mesh and the first bending modes into `figures/`, in a process of their own.

    Args:
        folder: The run's folder, with `building.nc`.

    Returns:
        The files.

    Raises:
        ImpactfemError: A file cannot be written, or the process that draws crashed, as it does
            where OpenGL is missing (Debian's libegl1 and libgl1).
    """
    return in_own_process(draw, folder)


def draw(folder: Path) -> list[Path]:
    """Draw what `building_pictures` gives, in this process."""
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    with xr.open_dataset(folder / "building.nc", engine="h5netcdf") as store:
        files = [_mesh(store, target / "building_mesh.png")]
        for number, mode in enumerate(_bending(store)[:SHOWN], start=1):
            files.append(_mode(store, mode, number, target / f"building_mode_{number}.png"))
    return files


def _bending(store: xr.Dataset) -> list[int]:
    return [int(mode) for mode in store["bending_mode"].values]


def _mesh(store: xr.Dataset, path: Path) -> Path:
    """The mesh with its bays; beams and columns are seen through the walls."""
    scene = plotter()
    labels = []
    # The slabs hide what stands below them unless all is drawn from far to near.
    scene.enable_depth_peeling(12)
    for family, (label, colour) in FAMILIES.items():
        if family in ("floor", "storey"):
            grid = shell_grid(store, family)
            if not grid.n_cells:
                continue
            outline = grid.extract_surface(nonlinear_subdivision=0, algorithm="dataset_surface")
            scene.add_mesh(
                outline,
                color=colour,
                opacity=OPACITY[family],
                show_edges=True,
                edge_color="#5a5a5a",
                edge_opacity=0.35,
                line_width=0.5,
            )
        else:
            grid = beam_grid(store, family)
            if not grid.n_cells:
                continue
            scene.add_mesh(grid, color=colour, line_width=LINES[family], render_lines_as_tubes=True)
        labels.append([label, colour])
    scene.add_legend(labels, bcolor=None, face="rectangle", size=(0.14, 0.14), loc="upper right")
    scene.add_axes(color="black")
    return save(scene, path)


def _mode(store: xr.Dataset, mode: int, number: int, path: Path) -> Path:
    """One bending mode, coloured by its displacement."""
    shape = store["shape"].sel(mode=mode).values.astype(np.float64)
    size = float(np.ptp(store["node_position"].values, axis=0).max())
    length = np.linalg.norm(shape, axis=1)
    scene = plotter()
    grid = shell_grid(store)
    grid.point_data["displacement / largest\n"] = length / length.max()
    grid.points = np.asarray(grid.points) + shape * (AMPLITUDE * size / length.max())
    scene.add_mesh(
        grid.extract_surface(nonlinear_subdivision=0, algorithm="dataset_surface"),
        scalars="displacement / largest\n",
        cmap="cividis",
        show_edges=False,
        scalar_bar_args=SCALE,
    )
    frequency = float(store["frequency"].sel(mode=mode))
    scene.add_text(
        f"bending mode {number}: {frequency:.3f} Hz",
        position=(40, 1130),
        color="black",
        font_size=14,
    )
    scene.add_axes(color="black")
    return save(scene, path, view=(-1.0, -0.55, 0.35))
