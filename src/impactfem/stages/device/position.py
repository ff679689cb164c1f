"""Figure 23: where a device stands on its floor, and the nodes that it is anchored to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import NDArray

from impactfem.building.mesh import Part, parse_group
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, figure, letter
from impactfem.stages.device.selection import anchor_of

Array = NDArray[np.float64]
Index = NDArray[np.int64]

FLAT = 1e-6
"""How far vertices of a slab may differ in height [m]."""
MARGIN = 0.06
GREY = "0.35"
SIDES = ((0, 1), (1, 2), (2, 0))


class Floor:
    """A floor of `building.nc` in plan.

    Args:
        building: The open store.
        number: Number of the floor.
    """

    def __init__(self, building: xr.Dataset, number: int) -> None:
        self._building = building
        self._number = number
        self.nodes: Array = np.asarray(building["node_position"].values, dtype=np.float64)
        slab = self._of("shell_part", "triangle", "floor")
        level = np.ptp(self.nodes[slab[:, :3], 2], axis=1) < FLAT
        # Not what stands on the slab, such as an acroterion.
        self.cells: Index = slab[level]

    def outline(self) -> Array:
        """Sides of one triangle only: the outline and the bays, shape (n, 2, 2) [m]."""
        sides = np.sort(np.concatenate([self.cells[:, side] for side in SIDES]), axis=1)
        found, count = np.unique(sides, axis=0, return_counts=True)
        return self._plan(found[count == 1])

    def mesh(self) -> Array:
        """All sides of the elements, shape (n, 2, 2) [m]."""
        sides = np.sort(np.concatenate([self.cells[:, side] for side in SIDES]), axis=1)
        return self._plan(np.unique(sides, axis=0))

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

    def size(self) -> tuple[Array, Array]:
        """Lowest and highest x and y [m]."""
        plan = self.nodes[np.unique(self.cells), :2]
        return plan.min(axis=0), plan.max(axis=0)

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


def position_figure(path: Path, store: xr.Dataset, device: str, building: xr.Dataset) -> None:
    """Figure 23: plan of the floor (a) and the base plate between the anchor and the mesh (b)."""
    point, number, count = anchor_of(store, device)
    floor = Floor(building, number)
    low, high = floor.size()
    caption = (
        f"Figure 23: Position of {device} on floor {number} of building {store.attrs['building']} "
        f"at ({point[0]:g}, {point[1]:g}, {point[2]:g}) m (a), and its rigid connection to "
        f"{count} node{'s' * (count > 1)} of the mesh (b)."
    )
    with figure(path, (1, 2), (9.0, 3.7), caption) as (drawn, axes):
        grid = axes[0].get_gridspec()
        if grid is not None:
            grid.set_width_ratios((1.7, 1.0))
        _plan(axes[0], floor, point, device)
        _base_plate(axes[1], floor, point, count)
        beyond = MARGIN * float((high - low).max())
        axes[0].set_xlim(low[0] - beyond, high[0] + beyond)
        axes[0].set_ylim(low[1] - beyond, high[1] + beyond)
        for panel in axes:
            panel.set_aspect("equal")
            panel.set_xlabel("x [m]")
            panel.set_ylabel("y [m]")
            panel.grid(False)
        labelled = dict(zip(*reversed(axes[0].get_legend_handles_labels()), strict=True))
        labelled |= dict(zip(*reversed(axes[1].get_legend_handles_labels()), strict=True))
        drawn.legend(list(labelled.values()), list(labelled), loc="outside upper center", ncols=5)
        letter(axes)


def _plan(panel: Axes, floor: Floor, point: Array, name: str) -> None:
    _lines(panel, floor.walls(), "0.7", 6.0, "walls below")
    _lines(panel, floor.beams(), ORANGE, 1.6, "beams")
    _lines(panel, floor.outline(), "black", 1.0, "slab")
    _lines(panel, floor.impact_edge(), BLUE, 3.0, "edge that may be hit")
    columns = floor.columns()
    if len(columns):
        panel.plot(columns[:, 0], columns[:, 1], "s", color=GREY, ms=3.5, label="columns below")
    panel.plot(point[0], point[1], "o", color=RED, ms=6, label=f"anchor of {name}")


def _base_plate(panel: Axes, floor: Floor, point: Array, count: int) -> None:
    nodes = floor.anchor_nodes(point, count)
    spokes = np.stack([np.broadcast_to(point[:2], nodes.shape), nodes], axis=1)
    _lines(panel, floor.mesh(), "0.75", 0.8, "mesh")
    _lines(panel, floor.beams(), ORANGE, 1.6, "beams")
    _lines(panel, spokes, GREEN, 2.0, "rigid links")
    panel.plot(nodes[:, 0], nodes[:, 1], "s", color=BLUE, ms=5, label="nodes")
    panel.plot(point[0], point[1], "o", color=RED, ms=6)
    reach = float(np.linalg.norm(nodes - point[:2], axis=1).max())
    cell = float(np.ptp(floor.nodes[floor.cells[:, :3]], axis=1).max())
    half = max(2.0 * reach, 1.5 * cell)
    panel.set_xlim(point[0] - half, point[0] + half)
    panel.set_ylim(point[1] - half, point[1] + half)


def _lines(panel: Axes, lines: Array, colour: str, width: float, label: str) -> None:
    if len(lines):
        panel.add_collection(
            LineCollection(
                list(lines), colors=colour, linewidths=width, label=label, capstyle="round"
            )
        )
