"""Figures of the 3D building and their data: its mesh and its bending modes."""

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize

from impactfem.building.mesh import areas
from impactfem.plot.figure import figure
from impactfem.plot.floor_field import COLOURS
from impactfem.plot.scene import (
    FAMILIES,
    OUTLINE,
    SHADING,
    Picture,
    beam_grid,
    corners,
    keys,
    plotter,
    render,
    shell_grid,
    shell_nodes,
    show,
    surface,
)
from impactfem.plot.style import letter, sheet
from impactfem.stages.drawing import FigureData
from impactfem.system.arrays import Array

FLAT = 1e-6
"""How far the nodes of a side may be from its plane [m]."""
ORDER = ("First", "Second", "Third")
"""Modes that can be drawn."""
AMPLITUDE = 0.12
"""Largest displacement in the picture of a mode over the size of the building."""
LINES = {"beam": 2.5, "column": 7.0}
MODEL = "Mesh and modes"
"""Section of the report."""
WIDTH, SIDE_WIDTH = 4.4, 2.4
"""Of a picture of the building and of a side of it [inch]."""
MODE_VIEW = (-1.0, -0.55, 0.35)


@dataclass(frozen=True, eq=False)
class Side:
    """What of a building lies in a vertical plane that bounds it."""

    axis: str  #: The direction across the plane, "x" or "y".
    at: float  #: Where it is along it [m].
    #: Corners of the walls' elements, along the plane and upwards, shape (n, 3, 2) [m].
    walls: Array
    lines: Array  #: Ends of beams and columns, shape (m, 2, 2) [m].
    opened: float  #: Area between the walls, over their height and length [m2].


def open_side(store: xr.Dataset) -> Side | None:
    """The side of `building.nc` with the largest area of openings; None where none has a wall."""
    nodes = np.asarray(store["node_position"].values, dtype=np.float64)
    cells = shell_nodes(store, "storey")[:, :3]
    ends = store["line_node"].values[:, :2]
    sides = []
    for axis, outermost in product((0, 1), (np.min, np.max)):
        at = float(outermost(nodes[:, axis]))
        near = np.abs(nodes[:, axis] - at) < FLAT
        of_side = cells[np.all(near[cells], axis=1)]
        if not len(of_side):
            continue
        plane = nodes[:, [1 - axis, 2]]
        walls = plane[of_side]
        extent, area = np.ptp(walls.reshape(-1, 2), axis=0), float(areas(nodes, of_side).sum())
        # Rounding must not make an opening of a closed wall.
        opened = max(0.0, round(float(extent.prod()) - area, 6))
        sides.append(Side("xy"[axis], at, walls, plane[ends[np.all(near[ends], axis=1)]], opened))
    return max(sides, key=lambda side: side.opened, default=None)


class BuildingData(FigureData):
    """The data of the figures of the stage."""

    @cached_property
    def store(self) -> xr.Dataset:
        """`building.nc`."""
        return self.opened("building.nc")

    @property
    def mode(self) -> list[str]:
        """Numbers of the first bending modes."""
        return [str(k + 1) for k in range(min(len(ORDER), self.store["bending_mode"].size))]

    @property
    def first_mode(self) -> list[str]:
        """Number of the first bending mode."""
        return self.mode[:1]


@figure("mesh", MODEL, "Mesh of the 3D model", ending="png", in_3d=True)
def mesh(path: Path, store: xr.Dataset) -> None:
    """Draw the mesh from outside, beams and columns inside, and the side with most openings."""
    side = open_side(store)
    outside, legend = _drawn(store, outside=True)
    pictures = [outside]
    parts = ["3D mesh (a)"]
    if store.sizes["line"]:
        inside, lines = _drawn(store, outside=False)
        pictures.append(inside)
        legend += lines
        parts.append("beams and columns inside the outline of the shells (b)")
    if side is not None:
        parts.append(f"side at {side.axis} = {side.at:.4g} m ({chr(97 + len(pictures))})")
    count = store.sizes["triangle"] + store.sizes["line"]
    area = areas(store["node_position"].values, store["triangle_node"].values).mean()
    size = float(np.sqrt(area * 4.0 / np.sqrt(3.0)))
    caption = (
        f"Building {store.attrs['building']}: {', '.join(parts)}. {count:,} "
        f"elements with {store.sizes['node']:,} nodes; triangles with sides of {size:.2g} m in the "
        "mean."
    )
    if side is not None and side.opened > 0.0:
        caption += f" Openings of the side: {side.opened:.4g} m²."
    widths = [WIDTH] * len(pictures) + [SIDE_WIDTH] * (side is not None)
    names = ", ".join(label for label, _, _ in legend)
    low, high = store["node_position"].min("node").values, store["node_position"].max("node").values
    long, wide, tall = high - low
    seen = f"A building of {long:.3g} m by {wide:.3g} m, {tall:.3g} m high, with {names}"
    seen += (
        "." if side is None else f", and its side at {side.axis} = {side.at:.4g} m in elevation."
    )
    with sheet(path, (1, len(widths)), (sum(widths), 4.1), caption, seen) as (drawn, axes):
        grid = axes[0].get_gridspec()
        if grid is not None:
            grid.set_width_ratios(widths)
        for panel, picture in zip(axes, pictures, strict=False):
            show(panel, picture)
        if side is not None:
            panel, (label, colour) = axes[-1], FAMILIES["storey"]
            look: dict[str, Any] = {"edgecolors": "0.35", "linewidths": 0.25, "label": label}
            panel.add_collection(PolyCollection(list(side.walls), facecolors=colour, **look))
            if len(side.lines):
                colour = FAMILIES["column"][1]
                panel.add_collection(
                    LineCollection(list(side.lines), colors=colour, linewidths=1.5)
                )
            ends = np.concatenate([side.walls.reshape(-1, 2), side.lines.reshape(-1, 2)])
            low, high = ends.min(axis=0), ends.max(axis=0)
            beyond = 0.03 * float((high - low).max())
            (x0, z0), (x1, z1) = low - beyond, high + beyond
            across = "y" if side.axis == "x" else "x"
            panel.set(xlim=(x0, x1), ylim=(z0, z1), aspect="equal")
            panel.set(xlabel=f"{across} [m]", ylabel="z [m]")
            panel.grid(False)
        drawn.legend(handles=keys(legend), loc="outside upper center", ncols=len(legend))
        letter(axes)


def _drawn(store: xr.Dataset, outside: bool) -> tuple[Picture, list[tuple[str, str, str]]]:
    """The building and what its colours mean: its shells, or what is inside their outline."""
    scene = plotter()
    legend = []
    for family in ("floor", "storey") if outside else ():
        label, colour = FAMILIES[family]
        flat = surface(shell_grid(store, family))
        if flat.n_cells:
            scene.add_mesh(flat, color=colour, **SHADING)
            edges = flat.extract_all_edges()
            scene.add_mesh(edges, color=OUTLINE, line_width=1.5, lighting=False)
            scene.add_mesh(corners(flat), color="black", line_width=2.0)
            legend.append((label, colour, "face"))
    if not outside and (shells := surface(shell_grid(store))).n_cells:
        scene.add_mesh(corners(shells), color="#9a9a9a", line_width=1.2)
    for family, width in LINES.items():
        label, colour = FAMILIES[family]
        lines = beam_grid(store, family)
        if lines.n_cells:
            tubes = None if outside else True  # None: as pyvista has it
            scene.add_mesh(lines, color=colour, line_width=width, render_lines_as_tubes=tubes)
            legend += [] if outside else [(label, colour, "line")]
    return render(scene, store["node_position"].values), legend


@figure(
    "bending_mode",
    MODEL,
    "Bending mode of the 3D model",
    each="mode",
    default="first_mode",
    ending="png",
    in_3d=True,
)
def bending_mode(path: Path, store: xr.Dataset, mode: str) -> None:
    """Draw one bending mode, coloured by its displacement, over the building at rest."""
    number = int(store["bending_mode"].values[int(mode) - 1])
    shape = store["shape"].sel(mode=number).values.astype(np.float64)
    rest = store["node_position"].values
    length = np.linalg.norm(shape, axis=1)
    moved = rest + shape * (AMPLITUDE * float(np.ptp(rest, axis=0).max()) / length.max())
    scene = plotter()
    floors = surface(shell_grid(store, "floor"))
    if floors.n_cells:
        scene.add_mesh(corners(floors), color="black", line_width=1.5)
    for grid in (shell_grid(store), beam_grid(store)):
        if grid.n_cells:
            grid.points = moved
            grid.point_data["value"] = length / length.max()
            colours = {"scalars": "value", "cmap": COLOURS, "clim": (0.0, 1.0)}
            look = colours | {"show_scalar_bar": False, "line_width": 2.0}
            scene.add_mesh(surface(grid), **look, **SHADING)
    picture = render(scene, np.concatenate([rest, moved]), MODE_VIEW)
    direction = store.attrs["bending_direction"]
    axis = {"x": "y", "y": "x"}[direction]
    caption = (
        f"{ORDER[int(mode) - 1]} mode of bending along $e_{direction}$, about $e_{axis}$, of "
        f"building {store.attrs['building']}: {float(store['frequency'].sel(mode=number)):.3f} Hz. "
        "Black lines: floors at rest; displacement not to scale."
    )
    least, most = rest[np.argmin(length)], rest[np.argmax(length)]
    seen = (
        f"The deformed building; its displacement is largest at a height of {most[2]:.3g} m and "
        f"least at {least[2]:.3g} m."
    )
    with sheet(path, (1, 1), (6.5, 4.6), caption, seen) as (drawn, axes):
        show(axes[0], picture)
        scale = ScalarMappable(Normalize(0.0, 1.0), COLOURS)
        bar = drawn.colorbar(scale, ax=axes[0], shrink=0.7, aspect=25, pad=0.02)
        bar.set_label("displacement over the largest [-]")
