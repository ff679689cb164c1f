"""Off-screen scenes of a building from its store, without an X server."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.files import atomic

Array = NDArray[np.float64]

# Else VTK looks for a display, or kills the process where there is none.
os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

FAMILIES = {
    "floor": ("slabs", "#c9c9c9"),
    "storey": ("walls", "#8fb4d9"),
    "beam": ("beams", "#d55e00"),
    "column": ("columns", "#009e73"),
}
"""Label and colour of each family of parts; told apart with any colour vision."""

WINDOW = (1800, 1200)
VIEW = (-1.0, -1.35, 0.75)
"""From where the building is seen: the corner that is farthest from the other building."""
MARGIN = 0.08
"""Part of the width or height of a picture that stays free on each side."""


def shell_grid(store: xr.Dataset, family: str | None = None) -> Any:
    """Shells of a family of parts, or all, as quadratic triangles with all nodes of the mesh."""
    import pyvista

    chosen = _chosen(store, "shell_part_name", "triangle_part", family)
    cells = store["triangle_node"].values[chosen]
    return pyvista.UnstructuredGrid(
        {pyvista.CellType.QUADRATIC_TRIANGLE: cells}, store["node_position"].values
    )


def beam_grid(store: xr.Dataset, family: str | None = None) -> Any:
    """Beams of a family of parts, or all, as straight lines with all nodes of the mesh."""
    import pyvista

    chosen = _chosen(store, "beam_part_name", "line_part", family)
    cells = store["line_node"].values[chosen][:, :2]
    return pyvista.UnstructuredGrid({pyvista.CellType.LINE: cells}, store["node_position"].values)


def plotter() -> Any:
    """An off-screen plotter on white."""
    import pyvista

    made = pyvista.Plotter(off_screen=True, window_size=list(WINDOW))
    made.set_background("white")
    return made


def save(
    made: Any,
    path: Path,
    *,
    view: tuple[float, float, float] = VIEW,
    points: Array | None = None,
    below: float = 0.0,
) -> Path:
    """Look from a direction, write the picture and close the plotter.

    Args:
        made: The plotter.
        path: The picture (PNG).
        view: Direction from the building to the camera.
        points: What is to fill the picture, shape (n, 3) [m]; all that is drawn when None.
        below: Part of the height that is left free below them.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    made.enable_parallel_projection()
    made.view_vector(view, viewup=(0.0, 0.0, 1.0))
    if points is not None:
        _fill(made, points, np.asarray(view, dtype=np.float64), below)
    made.enable_anti_aliasing("ssaa")
    image = made.screenshot(return_img=True)
    made.close()
    with atomic(path) as temporary:
        _write_png(temporary, image)
    return path


def screen_axes(view: Array) -> tuple[Array, Array]:
    """Unit vectors to the right and upwards in a picture that is seen from a direction."""
    right = np.cross(-view, [0.0, 0.0, 1.0])
    up = np.cross(right, -view)
    return right / np.linalg.norm(right), up / np.linalg.norm(up)


def _fill(made: Any, points: Array, view: Array, below: float) -> None:
    """Centre and scale the picture so that points fill it but for a margin."""
    right, up = screen_axes(view)
    x, y = points @ right, points @ up
    width, height = np.ptp(x) / (1.0 - 2.0 * MARGIN), np.ptp(y) / (1.0 - 2.0 * MARGIN - below)
    half = 0.5 * max(height, width * WINDOW[1] / WINDOW[0], 1e-6)
    away = view / np.linalg.norm(view)
    centre = 0.5 * (x.min() + x.max()) * right + (0.5 * (y.min() + y.max()) - below * half) * up
    # The part of the centre along the view is that of the points: they stay between the planes.
    centre = centre + (points @ away).mean() * away
    far = 4.0 * max(float(np.ptp(points, axis=0).max()), half)
    made.camera.focal_point = tuple(centre)
    made.camera.position = tuple(centre + far * away)
    made.camera.parallel_scale = half
    made.renderer.reset_camera_clipping_range()


def _write_png(path: Path, image: Any) -> None:
    from matplotlib.image import imsave

    imsave(path, image, format="png", dpi=150)


def _chosen(store: xr.Dataset, names: str, part: str, family: str | None) -> NDArray[np.int64]:
    wanted = np.array(
        [family is None or str(name).split("_")[0] == family for name in store[names].values],
        dtype=bool,
    )
    return np.flatnonzero(wanted[store[part].values])
