"""Figures of the position of a device, on the plan of its floor and in the 3D model."""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from impactfem.building.mesh import Part, parse_group
from impactfem.plot.figure import figure
from impactfem.plot.scene import (
    GHOST,
    OUTLINE,
    SHADING,
    VIEW,
    Picture,
    add_ghost,
    balls,
    corners,
    impact_view,
    keys,
    note,
    plotter,
    render,
    segments,
    show,
)
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, letter, sheet
from impactfem.stages.device.model_figures import device_size
from impactfem.stages.device.selection import ALL, anchor_of
from impactfem.system.arrays import Array, Index

FLAT = 1e-6
"""How far vertices of a slab may differ in height [m]."""
MARGIN = 0.06
GREY = "0.35"
BEAMS = ORANGE, 1.6, "beams"
SIDES = ((0, 1), (1, 2), (2, 0))
AROUND = 2.2
"""Half of the side of the piece of floor that is shown, over the size of the device."""
LIFT = 0.01
"""How far lines are above the slab, so that it does not hide them, over that half side."""


class Floor:
    """A floor of `building.nc`, by its number, in plan."""

    def __init__(self, building: xr.Dataset, number: int) -> None:
        self._building = building
        self._number = number
        self.nodes: Array = np.asarray(building["node_position"].values, dtype=np.float64)
        slab = self._of("shell_part", "triangle", "floor")
        level = np.ptp(self.nodes[slab[:, :3], 2], axis=1) < FLAT
        # Not what stands on the slab, such as a parapet.
        self.cells: Index = slab[level]
        sides = np.sort(np.concatenate([self.cells[:, side] for side in SIDES]), axis=1)
        self._sides, self._shared = np.unique(sides, axis=0, return_counts=True)

    def outline(self) -> Array:
        """Sides of one triangle only: the outline and the bays, shape (n, 2, 2) [m]."""
        return self._plan(self._sides[self._shared == 1])

    def mesh(self) -> Array:
        """All sides of the elements, shape (n, 2, 2) [m]."""
        return self._plan(self._sides)

    def walls(self) -> Array:
        """Upper edges of the walls below, shape (n, 2, 2) [m]."""
        walls = self._of("shell_part", "triangle", "storey")
        sides = np.concatenate([walls[:, side] for side in SIDES])
        return self._plan(np.unique(np.sort(self._upper(sides), axis=1), axis=0))

    def beams(self) -> Array:
        """Beams under the slab, shape (n, 2, 2) [m]."""
        return self._plan(self._of("beam_part", "line", "beam")[:, :2])

    def columns(self) -> Array:
        """Upper ends of the columns below, shape (n, 2) [m]."""
        ends = self._of("beam_part", "line", "column")[:, :2].reshape(-1, 1)
        return np.asarray(self.nodes[np.unique(self._upper(ends)), :2])

    def impact_edge(self) -> Array:
        """The edge that may be hit, shape (n, 2, 2) [m]."""
        edges = np.asarray(self._building["edge_line"].values, dtype=np.int64)
        return self._plan(edges[self._building["edge_floor"].values == self._number, :2])

    def anchor_nodes(self, point: Array, count: int) -> Array:
        """The nodes of the slab that are nearest to a point, shape (count, 2) [m]."""
        nodes = self.nodes[np.unique(self.cells), :2]
        away = np.linalg.norm(nodes - point[:2], axis=1)
        return np.asarray(nodes[np.argsort(away, kind="stable")[:count]])

    def _plan(self, lines: Index) -> Array:
        return np.asarray(self.nodes[lines][:, :, :2], dtype=np.float64)

    def _of(self, parts: str, cells: str, family: str) -> Index:
        """Nodes of the cells of this floor's parts of a family."""
        names = [parse_group(str(name)) for name in self._building[f"{parts}_name"].values]
        wanted = [
            isinstance(part, Part) and (part.family, part.level) == (family, self._number)
            for part in names
        ]
        found = np.asarray(self._building[f"{cells}_node"].values, dtype=np.int64)
        part = self._building[f"{cells}_part"].values
        return np.asarray(found[np.asarray(wanted, dtype=bool)[part]], dtype=np.int64)

    def _upper(self, lines: Index) -> Index:
        """Those of them that are in the plane of the slab."""
        level = self.nodes[self.cells[0, 0], 2]
        inside = np.abs(self.nodes[lines, 2] - level) < FLAT
        return np.asarray(lines[np.all(inside, axis=1)], dtype=np.int64)


@figure("device_on_floor", ALL, "Position of the device in plan", each="device", default=False)
def position_figure(path: Path, store: xr.Dataset, device: str, building: xr.Dataset) -> None:
    """Draw the plan of the floor (a), and the base plate between the anchor and the mesh (b)."""
    point, number, count = anchor_of(store, device)
    floor = Floor(building, number)
    plan = floor.nodes[np.unique(floor.cells), :2]
    (x, y), (width, depth) = plan.min(axis=0), np.ptp(plan, axis=0)
    caption = (
        f"Position of {device} on floor {number} of building {store.attrs['building']} "
        f"at ({point[0]:g}, {point[1]:g}, {point[2]:g}) m (a), and its rigid connection to "
        f"{count} node{'s' * (count > 1)} of the mesh (b)."
    )
    seen = (
        f"Plan of floor {number}, {width:.3g} m by {depth:.3g} m, with {device} at x = "
        f"{point[0]:.4g} m, y = {point[1]:.4g} m; and the mesh around it with {count} rigid "
        f"link{'s' * (count > 1)}."
    )
    with sheet(path, (1, 2), (9.0, 3.7), caption, seen) as (drawn, axes):
        grid = axes[0].get_gridspec()
        if grid is not None:
            grid.set_width_ratios((1.7, 1.0))
        left, right = axes
        _lines(left, floor.walls(), "0.7", 6.0, "walls below")
        _lines(left, floor.beams(), *BEAMS)
        _lines(left, floor.outline(), "black", 1.0, "slab")
        _lines(left, floor.impact_edge(), BLUE, 3.0, "edge that may be hit")
        columns = floor.columns()
        if len(columns):
            left.plot(*columns.T, "s", color=GREY, ms=3.5, label="columns below")
        left.plot(*point[:2], "o", color=RED, ms=6, label=f"anchor of {device}")
        beyond = MARGIN * float(max(width, depth))
        left.set(xlim=(x - beyond, x + width + beyond), ylim=(y - beyond, y + depth + beyond))
        nodes = floor.anchor_nodes(point, count)
        spokes = np.stack([np.broadcast_to(point[:2], nodes.shape), nodes], axis=1)
        reach = float(np.linalg.norm(nodes - point[:2], axis=1).max())
        cell = float(np.ptp(floor.nodes[floor.cells[:, :3]], axis=1).max())
        half = max(2.0 * reach, 1.5 * cell)
        for lines, look in ((floor.mesh(), ("0.75", 0.8, "mesh")), (floor.beams(), BEAMS)):
            near = np.abs(lines - point[:2]).min(axis=1).max(axis=1) < half + cell
            _lines(right, lines[near], *look)
        _lines(right, spokes, GREEN, 2.0, "rigid links")
        right.plot(*nodes.T, "s", color=BLUE, ms=5, label="nodes")
        right.plot(*point[:2], "o", color=RED, ms=6)
        (x0, y0), (x1, y1) = point[:2] - half, point[:2] + half
        right.set(xlim=(x0, x1), ylim=(y0, y1))
        for panel in axes:
            panel.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
            panel.grid(False)
        labelled: dict[str, Any] = {}
        for panel in axes:
            labelled |= dict(zip(*reversed(panel.get_legend_handles_labels()), strict=True))
        drawn.legend(list(labelled.values()), list(labelled), loc="outside upper center", ncols=5)
        letter(axes)


def _lines(panel: Axes, lines: Array, colour: str, width: float, label: str) -> None:
    if len(lines):
        look: dict[str, Any] = {"colors": colour, "linewidths": width, "capstyle": "round"}
        panel.add_collection(LineCollection(list(lines), label=label, **look))


@figure(
    "device_in_building",
    ALL,
    "Position of the device in the 3D model",
    each="device",
    ending="png",
    in_3d=True,
)
def device_in_building(path: Path, store: xr.Dataset, device: str, building: xr.Dataset) -> None:
    """Draw the building with the device (a), and the device on a piece of its floor (b)."""
    nodes = building["node_position"].values
    point, number, count = anchor_of(store, device)
    caption = (
        f"Position of {device} in the 3D model of building {store.attrs['building']} (a), and its "
        f"connection by rigid links to {count} node{'s' * (count > 1)} of floor {number} (b)."
    )
    legend = [
        ("slab", GHOST, "face"),
        ("beams", ORANGE, "line"),
        ("rigid links", GREEN, "line"),
        ("nodes", BLUE, "ball"),
        (device, RED, "face"),
    ]
    scene = plotter()
    add_ghost(scene, building)
    ball = balls(point[None], 0.015 * float(np.ptp(nodes, axis=0).max()))
    scene.add_mesh(ball, color=RED)
    whole = render(scene, nodes, impact_view(building))
    near = _near(Floor(building, number), point, count, *device_size(store, device))
    seen = (
        f"The building, with {device} as a ball on floor {number}; and its body on the "
        f"slab, with {count} rigid link{'s' * (count > 1)} and the beams around it."
    )
    with sheet(path, (1, 2), (9.0, 4.0), caption, seen) as (page, axes):
        show(axes[0], whole)
        note(axes[0], whole, point, device)
        show(axes[1], near)
        page.legend(handles=keys(legend), loc="outside upper center", ncols=len(legend))
        letter(axes)


def _near(floor: Floor, point: Array, count: int, radius: float, height: float) -> Picture:
    import pyvista

    links = floor.anchor_nodes(point, count)
    reach = max(radius, 0.5 * height, float(np.linalg.norm(links - point[:2], axis=1).max()))
    half = AROUND * reach
    scene = plotter()
    # The floor in a square around the point: its slab, the edges of its mesh and its beams.
    cells = np.insert(floor.cells[:, :3], 0, 3, axis=1)
    slab = _square(pyvista.PolyData(floor.nodes, cells.ravel()).clean(), point, half)
    scene.add_mesh(slab, color=GHOST, **SHADING)
    above = point[2] + 0.5 * LIFT * half
    for plan, colour, width in ((floor.mesh(), OUTLINE, 1.5), (floor.beams(), ORANGE, 6.0)):
        ends = np.insert(plan.reshape(-1, 2), 2, above, axis=1)
        lines = _square(segments(ends), point, half)
        if lines.n_points:
            scene.add_mesh(lines, color=colour, line_width=width)
    z = point[2] + LIFT * half
    spokes = np.zeros((count, 2, 3))
    spokes[:, 0], spokes[:, 1, :2], spokes[..., 2] = point, links, z
    scene.add_mesh(segments(spokes.reshape(-1, 3)), color=GREEN, line_width=6.0)
    scene.add_mesh(balls(spokes[:, 1], 0.02 * half), color=BLUE, **SHADING)
    scene.enable_depth_peeling(12)
    # Without its ends: the lower one would fight with the slab.
    body = standing(point, radius, height, capping=False)
    scene.add_mesh(body, color=RED, opacity=0.3, **SHADING)
    scene.add_mesh(corners(body), color=RED, line_width=3.0)
    seen = np.concatenate([np.asarray(slab.points), np.asarray(body.points)])
    return render(scene, seen, VIEW)


def standing(point: Array, radius: float, height: float, *, capping: bool = True) -> Any:
    """A cylinder that stands on a point; lengths in m."""
    import pyvista

    middle = point + np.array([0.0, 0.0, 0.5 * height])
    return pyvista.Cylinder(
        center=tuple(middle),
        direction=(0.0, 0.0, 1.0),
        radius=radius,
        height=height,
        resolution=48,
        capping=capping,
    )


def _square(mesh: Any, point: Array, half: float) -> Any:
    """What of a mesh is in a square around a point."""
    for normal in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)):
        if mesh.n_points:
            mesh = mesh.clip(normal=normal, origin=point + half * np.array(normal))
    return mesh
