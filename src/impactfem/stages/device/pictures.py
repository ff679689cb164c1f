"""Pictures of devices in the 3D model: where each stands in the building, and on its floor (23)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

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
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, figure, letter
from impactfem.stages.device.position import Floor
from impactfem.stages.device.selection import anchor_of, drawing_of, file_stem
from impactfem.stages.stores import names_of, open_store
from impactfem.system.own_process import in_own_process

Array = NDArray[np.float64]

STEM = "figure_23_model"
AROUND = 2.2
"""Half of the side of the piece of floor that is shown, over the size of the device."""
LIFT = 0.01
"""How far lines are above the slab, so that it does not hide them, over that half side."""
UNKNOWN = 0.25
"""Radius of a device of unknown size over its height."""


def device_pictures(folder: Path) -> list[Path]:
    """Draw each device in the building into `figures/`, in a process of their own.

    Args:
        folder: The run's folder, with `device.nc`.

    Returns:
        The files; none without `building.nc`.

    Raises:
        ImpactfemError: A file cannot be written, or the process that draws crashed, as it does
            where OpenGL is missing (Debian's libegl1 and libgl1).
    """
    return in_own_process(draw, folder) if (folder / "building.nc").is_file() else []


def draw(folder: Path) -> list[Path]:
    """Draw what `device_pictures` gives, in this process."""
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    with (
        open_store(folder / "building.nc") as building,
        open_store(folder / "device.nc") as store,
    ):
        return [
            _model(target / f"{file_stem(store, STEM, device)}.png", building, store, device)
            for device in names_of(store, "device")
        ]


def _model(path: Path, building: xr.Dataset, store: xr.Dataset, device: str) -> Path:
    point, number, count = anchor_of(store, device)
    caption = (
        f"Figure 23: Position of {device} in the 3D model of building {store.attrs['building']} "
        f"(a), and its connection by rigid links to {count} node{'s' * (count > 1)} of floor "
        f"{number} (b)."
    )
    legend = [
        ("slab", GHOST, "face"),
        ("beams", ORANGE, "line"),
        ("rigid links", GREEN, "line"),
        ("nodes", BLUE, "ball"),
        (device, RED, "face"),
    ]
    whole = _whole(building, point)
    near = _near(building, store, device)
    with figure(path, (1, 2), (9.0, 4.0), caption) as (drawn, axes):
        show(axes[0], whole)
        note(axes[0], whole, point, device)
        show(axes[1], near)
        drawn.legend(handles=keys(legend), loc="outside upper center", ncols=len(legend))
        letter(axes)
    return path


def _whole(building: xr.Dataset, point: Array) -> Picture:
    scene = plotter()
    add_ghost(scene, building)
    nodes = building["node_position"].values
    scene.add_mesh(balls(point[None], 0.015 * float(np.ptp(nodes, axis=0).max())), color=RED)
    return render(scene, nodes, impact_view(building))


def _near(building: xr.Dataset, store: xr.Dataset, device: str) -> Picture:
    """The device on a piece of its floor."""
    point, number, count = anchor_of(store, device)
    floor = Floor(building, number)
    radius, height = device_size(store, device)
    links = floor.anchor_nodes(point, count)
    reach = max(radius, 0.5 * height, float(np.linalg.norm(links - point[:2], axis=1).max()))
    half = AROUND * reach
    scene = plotter()
    slab, edges, beams = _piece(floor, point, half)
    scene.add_mesh(slab, color=GHOST, **SHADING)
    for lines, colour, width in ((edges, OUTLINE, 1.5), (beams, ORANGE, 6.0)):
        if len(lines):
            scene.add_mesh(segments(lines.reshape(-1, 3)), color=colour, line_width=width)
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


def device_size(store: xr.Dataset, device: str) -> tuple[float, float]:
    """Radius and height of the cylinder that shows a device [m]; of its body where that is known.

    A device that is made of modes is shown 1 m high.
    """
    drawing = drawing_of(store, device)
    if drawing is None:
        return UNKNOWN, 1.0
    height = float(np.nanmax([drawing.length, drawing.height, drawing.beam_length]))
    return (UNKNOWN * height if np.isnan(drawing.radius) else drawing.radius), height


def _piece(floor: Floor, point: Array, half: float) -> tuple[Any, Array, Array]:
    """The floor in a square around a point: its slab, the edges of its mesh and its beams.

    Lines are cut at the square, shape (n, 2, 3) [m].
    """
    import pyvista

    cells = floor.cells[:, :3]
    faces = np.column_stack([np.full(len(cells), 3), cells])
    slab = pyvista.PolyData(floor.nodes, faces.ravel()).clean()
    x, y = point[:2]
    for normal, origin in (
        ((1, 0, 0), (x + half, y, 0)),
        ((-1, 0, 0), (x - half, y, 0)),
        ((0, 1, 0), (x, y + half, 0)),
        ((0, -1, 0), (x, y - half, 0)),
    ):
        slab = slab.clip(normal=normal, origin=origin)
    z = point[2] + 0.5 * LIFT * half
    return slab, _cut(floor.mesh(), point, half, z), _cut(floor.beams(), point, half, z)


def _cut(lines: Array, point: Array, half: float, z: float) -> Array:
    """The parts of lines (n, 2, 2) in a square around a point, at a height, shape (m, 2, 3) [m].

    A point of a line is a + s (b − a); s goes from the last entry into the four half planes to the
    first exit out of them.
    """
    a, along = lines[:, 0] - point[:2], lines[:, 1] - lines[:, 0]
    first: Array = np.zeros(len(lines))
    last: Array = np.ones(len(lines))
    for axis in (0, 1):
        for sign in (1.0, -1.0):
            # Inside where there + s · rate <= 0.
            there, rate = sign * a[:, axis] - half, sign * along[:, axis]
            with np.errstate(divide="ignore", invalid="ignore"):
                s = -there / rate
            first = np.where(rate < 0.0, np.maximum(first, s), first)
            last = np.where(rate > 0.0, np.minimum(last, s), last)
            last = np.where((rate == 0.0) & (there > 0.0), -1.0, last)
    kept = first < last
    ends = np.stack([first[kept], last[kept]], axis=1)
    plan = lines[kept, 0][:, None] + ends[..., None] * along[kept][:, None]
    return np.asarray(np.concatenate([plan, np.full((*plan.shape[:2], 1), z)], axis=2))
