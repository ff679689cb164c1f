"""A side of the 3D building in elevation: its walls with their openings, beams and columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from numpy.typing import NDArray

from impactfem.plot.scene import FAMILIES

Array = NDArray[np.float64]

FLAT = 1e-6
"""How far the nodes of a side may be from its plane [m]."""


@dataclass(frozen=True, eq=False)
class Side:
    """What of a building lies in a vertical plane that bounds it.

    Args:
        axis: The direction across the plane, "x" or "y".
        at: Where it is along it [m].
        walls: Corners of the walls' elements, along the plane and upwards, shape (n, 3, 2) [m].
        lines: Ends of beams and columns, shape (m, 2, 2) [m].
        opened: Area between the walls, over their height and length [m2].
    """

    axis: str
    at: float
    walls: Array
    lines: Array
    opened: float


def open_side(store: xr.Dataset) -> Side | None:
    """The side with the largest area of openings; None where none has a wall.

    Args:
        store: The open `building.nc`.
    """
    nodes = np.asarray(store["node_position"].values, dtype=np.float64)
    sides = []
    for axis in (0, 1):
        for at in (nodes[:, axis].min(), nodes[:, axis].max()):
            found = _side(store, nodes, axis, float(at))
            if found is not None:
                sides.append(found)
    return max(sides, key=lambda side: side.opened, default=None)


def side_panel(panel: Axes, side: Side) -> None:
    """Draw a side to scale."""
    label, colour = FAMILIES["storey"]
    panel.add_collection(
        PolyCollection(
            list(side.walls), facecolors=colour, edgecolors="0.35", linewidths=0.25, label=label
        )
    )
    if len(side.lines):
        panel.add_collection(
            LineCollection(list(side.lines), colors=FAMILIES["column"][1], linewidths=1.5)
        )
    corners = np.concatenate([side.walls.reshape(-1, 2), side.lines.reshape(-1, 2)])
    low, high = corners.min(axis=0), corners.max(axis=0)
    beyond = 0.03 * float((high - low).max())
    panel.set_xlim(low[0] - beyond, high[0] + beyond)
    panel.set_ylim(low[1] - beyond, high[1] + beyond)
    panel.set_aspect("equal")
    panel.set_xlabel(f"{'y' if side.axis == 'x' else 'x'} [m]")
    panel.set_ylabel("z [m]")
    panel.grid(False)


def _side(store: xr.Dataset, nodes: Array, axis: int, at: float) -> Side | None:
    near = np.abs(nodes[:, axis] - at) < FLAT
    names = [str(name) for name in store["shell_part_name"].values]
    storey = np.array([name.split("_")[0] == "storey" for name in names], dtype=bool)
    cells = store["triangle_node"].values[storey[store["triangle_part"].values]][:, :3]
    cells = cells[np.all(near[cells], axis=1)]
    if not len(cells):
        return None
    plane = nodes[:, [1 - axis, 2]]
    walls = plane[cells]
    a, b = walls[:, 1] - walls[:, 0], walls[:, 2] - walls[:, 0]
    area = 0.5 * float(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())
    ends = store["line_node"].values[:, :2]
    extent = np.ptp(walls.reshape(-1, 2), axis=0)
    return Side(
        axis="xy"[axis],
        at=at,
        walls=walls,
        lines=plane[ends[np.all(near[ends], axis=1)]],
        # Rounding must not make an opening of a closed wall.
        opened=max(0.0, round(float(extent.prod()) - area, 6)),
    )
