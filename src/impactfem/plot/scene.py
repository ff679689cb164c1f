"""Off-screen scenes of a building from its store, without an X server, and figures made of them."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from impactfem.system.arrays import Array, Index

# Else VTK looks for a display, or kills the process where there is none.
os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

FAMILIES = {
    "floor": ("slabs", "#c9c9c9"),
    "storey": ("walls", "#8fb4d9"),
    "beam": ("beams", "#d55e00"),
    "column": ("columns", "#009e73"),
}
"""Label and colour of each family of parts; told apart with any colour vision."""
GHOST, OUTLINE = "#c9c9c9", "#5a5a5a"
"""Of a building that others stand in."""

PIXELS = (1300, 900)
"""Largest width and height of a picture."""
VIEW = (-1.0, -1.35, 0.75)
"""From where the building is seen: the corner that is farthest from the other building."""
MARGIN = 0.03
"""Part of the width and height of a picture that stays free on each side."""
TRIAD = 0.09
"""Length of the axes that are drawn in a corner, in parts of the height of the picture."""
SHADING = {"ambient": 0.6, "diffuse": 0.4, "specular": 0.0}
"""So little shade that colours are those of their scale."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A scene as it is seen in parallel projection."""

    image: NDArray[np.uint8]  #: its pixels, shape (height, width, 3)
    right: Array  #: unit vector to the right in it, shape (3,)
    up: Array  #: unit vector upwards in it, shape (3,)
    corner: tuple[float, float]  #: its upper left corner along both [m]
    scale: float  #: pixels in a metre

    def place(self, points: Array) -> Array:
        """Where points are in it, shape (n, 2): to the right and downwards [pixel]."""
        x = self.scale * (points @ self.right - self.corner[0])
        y = self.scale * (self.corner[1] - points @ self.up)
        return np.stack([x, y], axis=-1)


def shell_nodes(store: xr.Dataset, family: str | None = None) -> Index:
    """Nodes of the shells of a family of parts, or of all, shape (n, 6): vertices, then middles."""
    return _nodes(store, family, "shell_part_name", "triangle")


def beam_nodes(store: xr.Dataset, family: str | None = None) -> Index:
    """Ends of the beams of a family of parts, or of all, shape (n, 2)."""
    return _nodes(store, family, "beam_part_name", "line")[:, :2]


def shell_grid(store: xr.Dataset, family: str | None = None) -> Any:
    """The same shells as quadratic triangles with all nodes of the mesh."""
    return _grid(store, "QUADRATIC_TRIANGLE", shell_nodes(store, family))


def beam_grid(store: xr.Dataset, family: str | None = None) -> Any:
    """Beams of a family of parts, or all, as straight lines with all nodes of the mesh."""
    return _grid(store, "LINE", beam_nodes(store, family))


def _nodes(store: xr.Dataset, family: str | None, names: str, cell: str) -> Index:
    chosen = [family in (None, str(name).split("_")[0]) for name in store[names].values]
    shown = np.array(chosen, dtype=bool)[store[f"{cell}_part"].values]
    return np.asarray(store[f"{cell}_node"].values[shown])


def _grid(store: xr.Dataset, kind: str, cells: Index) -> Any:
    import pyvista

    return pyvista.UnstructuredGrid({pyvista.CellType[kind]: cells}, store["node_position"].values)


def surface(grid: Any) -> Any:
    """The cells of a grid as flat polygons."""
    return grid.extract_surface(nonlinear_subdivision=0, algorithm="dataset_surface")


def corners(flat: Any) -> Any:
    """Lines of a surface where it ends, folds or branches."""
    return flat.extract_feature_edges(
        feature_angle=30.0, boundary_edges=True, non_manifold_edges=True, manifold_edges=False
    )


def plotter() -> Any:
    """An off-screen plotter on white."""
    import pyvista

    made = pyvista.Plotter(off_screen=True, window_size=list(PIXELS))
    made.set_background("white")
    return made


def add_ghost(made: Any, building: xr.Dataset) -> None:
    """Draw a building that others are seen through: its shells, their outlines and its columns."""
    made.enable_depth_peeling(12)
    flat = surface(shell_grid(building))
    if flat.n_cells:
        made.add_mesh(flat, color=GHOST, opacity=0.25)
        made.add_mesh(corners(flat), color=OUTLINE, line_width=1.0)
    columns = beam_grid(building, "column")
    if columns.n_cells:
        made.add_mesh(columns, color="#9a9a9a", line_width=3.0)


def balls(points: Array, radius: float) -> Any:
    """Balls of a radius [m] around points."""
    import pyvista

    cloud = pyvista.PolyData(np.asarray(points, dtype=np.float64))
    return cloud.glyph(geom=pyvista.Sphere(radius=radius), scale=False, orient=False)


def segments(ends: Array) -> Any:
    """Straight lines between points 0 and 1, 2 and 3, ..., shape (2 n, 3)."""
    import pyvista

    return pyvista.line_segments_from_points(np.asarray(ends, dtype=np.float64))


def render(made: Any, points: Array, view: Sequence[float] = VIEW) -> Picture:
    """Look from a direction so that points, shape (n, 3) [m], fill the picture; close the plotter.

    `view` points from the building to the camera.
    """
    direction = np.asarray(view, dtype=np.float64)
    right, up = screen_axes(direction)
    x, y = points @ right, points @ up
    free = 1.0 - 2.0 * MARGIN
    width, height = max(np.ptp(x), 1e-6) / free, max(np.ptp(y), 1e-6) / free
    scale = min(PIXELS[0] / width, PIXELS[1] / height)
    size = [max(2, round(scale * width)), max(2, round(scale * height))]
    made.window_size = size
    made.enable_parallel_projection()
    away = direction / np.linalg.norm(direction)
    middle = 0.5 * (x.min() + x.max()), 0.5 * (y.min() + y.max())
    # The part of the centre along the view is that of the points: they stay between the planes.
    centre = middle[0] * right + middle[1] * up + (points @ away).mean() * away
    far = 4.0 * max(float(np.ptp(points, axis=0).max()), height)
    made.camera.up = (0.0, 0.0, 1.0)
    made.camera.focal_point = tuple(centre)
    made.camera.position = tuple(centre + far * away)
    made.camera.parallel_scale = 0.5 * size[1] / scale
    made.renderer.reset_camera_clipping_range()
    made.enable_anti_aliasing("ssaa")
    image = np.asarray(made.screenshot(return_img=True), dtype=np.uint8)
    made.close()
    corner = (middle[0] - 0.5 * size[0] / scale, middle[1] + 0.5 * size[1] / scale)
    return Picture(image, right, up, corner, scale)


def show(panel: Axes, picture: Picture, *, triad: bool = True) -> None:
    """Draw a picture into a panel, with the directions of the axes where less is drawn below."""
    panel.imshow(picture.image)
    panel.set_axis_off()
    panel.set_anchor("C")
    if not triad:
        return
    height, width = picture.image.shape[:2]
    length = TRIAD * height
    ends = np.column_stack([picture.right, -picture.up]) * length
    low, high = np.minimum(0.0, ends.min(axis=0)), np.maximum(0.0, ends.max(axis=0))
    beyond = 0.5 * length
    box = (high - low + 2.0 * beyond).astype(int)
    below = picture.image[-box[1] :].mean(axis=2)
    left = below[:, : box[0]].mean() >= below[:, -box[0] :].mean()
    side = beyond - low[0] if left else width - beyond - high[0]
    start = np.array([side, height - beyond - high[1]])
    arrow = {"arrowstyle": "->", "color": "black", "shrinkA": 0, "shrinkB": 0}
    for name, end in zip("xyz", ends, strict=True):
        panel.annotate("", tuple(start + end), xytext=tuple(start), arrowprops=arrow)
        # A direction that is seen from its end has no arrow, and no room for its name there.
        reach = end * (1.0 + 0.35 * length / max(float(np.linalg.norm(end)), 0.25 * length))
        x, y = start + reach
        panel.text(x, y, name, ha="center", va="center", fontsize=8.0)


def note(panel: Axes, picture: Picture, point: Array, text: str) -> None:
    """Write a text beside a point of a picture, on a white edge."""
    x, y = picture.place(np.asarray(point, dtype=np.float64)[None])[0]
    panel.annotate(
        text,
        (x, y),
        xytext=(-7, 0),
        textcoords="offset points",
        ha="right",
        va="center",
        fontsize=7.5,
        path_effects=[withStroke(linewidth=2.5, foreground="white")],
    )


def keys(entries: Sequence[tuple[str, str, str]]) -> list[Any]:
    """Entries of a legend: label, colour and kind ("face", "line" or "ball") of each."""
    made: list[Any] = []
    for label, colour, kind in entries:
        if kind == "face":
            made.append(Patch(facecolor=colour, edgecolor="0.4", lw=0.5, label=label))
        elif kind == "line":
            made.append(Line2D([], [], color=colour, lw=2.5, label=label))
        else:
            made.append(Line2D([], [], color=colour, marker="o", ls="", ms=6, label=label))
    return made


def screen_axes(view: Array) -> tuple[Array, Array]:
    """Unit vectors to the right and upwards in a picture that is seen from a direction."""
    right = np.cross(-view, [0.0, 0.0, 1.0])
    up = np.cross(right, -view)
    return right / np.linalg.norm(right), up / np.linalg.norm(up)


def impact_view(building: xr.Dataset) -> tuple[float, float, float]:
    """Towards a camera that sees the impact edges, from the side and from above."""
    nodes = building["node_position"].values
    edge = nodes[np.unique(building["edge_line"].values)]
    if not len(edge):
        return VIEW
    out = edge[:, :2].mean(axis=0) - nodes[:, :2].mean(axis=0)
    out = out / np.linalg.norm(out)
    aside = np.array([-out[1], out[0]])
    x, y = 1.0 * out + 0.75 * aside
    return (float(x), float(y), 0.7)
