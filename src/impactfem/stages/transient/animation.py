"""A film of the wave that the main impact sends through a floor (figure 17 in motion)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from impactfem.plot.floor_field import SIGNED, TopFloor, colour_bar, plan_axes, signed_limits
from impactfem.plot.style import BLUE, SETTINGS
from impactfem.stages.stores import open_stores
from impactfem.stages.transient.floor_figures import mark_edge
from impactfem.stages.transient.selection import (
    line_ends,
    main_impact,
    main_side,
    of_kind,
    shown,
    wave_floor,
)
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import atomic

Array = NDArray[np.float64]
Frame = NDArray[np.uint8]

LASTS = 4.5
"""Time that the film takes, whatever the time that it shows [s]."""
SIZE, DPI = (8.0, 5.6), 120.0
"""Of the film [inch] and its pixels in an inch: 960 by 672."""
RASTER = 360
"""Points of the picture along the longer side of the floor."""
LINE_POINTS = 121


def wave_animation(folder: Path) -> list[Path]:
    """Film the acceleration of a floor about the main impact, into `figures/wave_floor_N.mp4`.

    H.264, 4:2:0: each computed time of the frames of `transient_maps.nc` with one scale of colours,
    the floor in plan and the line across it. No file where there are no frames: no impact, no maps,
    or no impact edge; an ImpactfemError where it cannot be written, or there is no encoder.
    """
    if not (folder / "transient_maps.nc").is_file():
        return []
    import imageio.v2 as imageio

    with open_stores(folder) as opened:
        response, maps = shown(opened("transient.nc")), opened("transient_maps.nc")
        if not maps.sizes.get("frame", 0) or of_kind(response, "line").sizes["probe"] < 2:
            return []
        path = folder / "figures" / f"wave_floor_{wave_floor(response)}.mp4"
        path.parent.mkdir(exist_ok=True)
        look: dict[str, Any] = {"codec": "libx264", "pixelformat": "yuv420p", "macro_block_size": 2}
        look["output_params"] = ["-crf", "20", "-movflags", "+faststart"]
        look["fps"] = maps.sizes["frame"] / LASTS
        with atomic(path) as temporary, TemporaryDirectory() as work:
            # imageio tells the format from the end of the name.
            whole = Path(work) / path.name
            try:
                film: Any = imageio.get_writer(
                    whole, format="FFMPEG", mode="I", ffmpeg_log_level="error", **look
                )
                with film:
                    for frame in _frames(response, maps):
                        film.append_data(frame)
            except RuntimeError as error:  # what imageio raises without ffmpeg
                raise ImpactfemError(f"cannot write {path}: {error}") from error
            temporary.write_bytes(whole.read_bytes())
    return [path]


class Sampler:
    """Values at points, shape (..., 2) [m]: linear in the triangle of each, nan outside of all."""

    def __init__(self, mesh: Triangulation, points: Array) -> None:
        x, y = points[..., 0], points[..., 1]
        found = np.asarray(mesh.get_trifinder()(x, y))
        self._outside = found < 0
        self._corners = mesh.triangles[np.where(self._outside, 0, found)]
        (x0, x1, x2), (y0, y1, y2) = (
            np.moveaxis(values[self._corners], -1, 0) for values in (mesh.x, mesh.y)
        )
        twice = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        first = ((x - x0) * (y2 - y0) - (x2 - x0) * (y - y0)) / twice
        second = ((x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)) / twice
        self._weights = np.stack([1.0 - first - second, first, second], axis=-1)

    def __call__(self, values: Array) -> Array:
        """Values at the points, shape of the points without their last axis."""
        found = (self._weights * values[self._corners]).sum(axis=-1)
        return np.where(self._outside, np.nan, found)


def _frames(response: xr.Dataset, maps: xr.Dataset) -> Iterator[Frame]:
    """The pictures of the film in their order, shape (height, width, 3)."""
    floor = TopFloor(maps)
    mesh = floor.split()
    times = np.asarray(maps["frame"].values, dtype=np.float64)
    direction = response["component"].item()
    values = maps["frame_acceleration"].sel(component=direction).values.astype(np.float64)
    limits = float(values.min()), float(values.max())
    colours = signed_limits(*limits)
    low, high = floor.position[:, :2].min(axis=0), floor.position[:, :2].max(axis=0)
    count = np.maximum(2, np.rint(RASTER * floor.size / floor.size.max()).astype(int))
    # In the middle of each pixel, so that the edges of the floor are inside.
    x, y = (low[k] + (np.arange(count[k]) + 0.5) / count[k] * floor.size[k] for k in (0, 1))
    in_plan = Sampler(mesh, np.stack(np.meshgrid(x, y), axis=-1))
    first, last = line_ends(response)
    # The ends a hair inside, where rounding leaves them in a triangle.
    share = np.clip(np.linspace(0.0, 1.0, LINE_POINTS), 1e-6, 1.0 - 1e-6)
    on_line = Sampler(mesh, first + share[:, None] * (last - first))
    with mpl.rc_context(SETTINGS):  # type: ignore[arg-type]
        drawn = Figure(figsize=SIZE, dpi=DPI, layout="constrained")
        canvas: Any = FigureCanvasAgg(drawn)
        shape = (2, 1) if floor.wide else (1, 2)
        plan, line = np.ravel(drawn.subplots(*shape))
        label = f"acceleration $\\ddot u_{direction}$ [m/s²]"
        image = plan.imshow(
            in_plan(values[0]),
            extent=(low[0], high[0], low[1], high[1]),
            origin="lower",
            cmap=SIGNED,
            vmin=colours[0],
            vmax=colours[1],
            animated=True,
        )
        plan_axes(plan, floor)
        mark_edge(plan, response, floor)
        colour_bar(drawn, image, plan, label)
        length = float(np.linalg.norm(last - first))
        (curve,) = line.plot(share * length, on_line(values[0]), color=BLUE, animated=True)
        line.axhline(0.0, color="0.4", lw=0.8)
        line.set_xlim(0.0, length)
        room = 0.05 * max(limits[1] - limits[0], 1e-12)
        line.set_ylim(limits[0] - room, limits[1] + room)
        line.set_xlabel("distance d from the impact edge [m]")
        line.set_ylabel(label)
        title = plan.set_title(_title(response, times[0]), loc="left", fontsize=10.0, animated=True)
        canvas.draw()
        background = canvas.copy_from_bbox(drawn.bbox)
        for time, one in zip(times, values, strict=True):
            image.set_data(in_plan(one))
            curve.set_ydata(on_line(one))
            title.set_text(_title(response, time))
            canvas.restore_region(background)
            for panel, artist in ((plan, image), (plan, title), (line, curve)):
                panel.draw_artist(artist)
            pixels = np.asarray(canvas.buffer_rgba())
            # 4:2:0 takes pixels by twos.
            even = [size - size % 2 for size in pixels.shape[:2]]
            yield np.ascontiguousarray(pixels[: even[0], : even[1], :3])


def _title(response: xr.Dataset, time: float) -> str:
    """What is seen, the time, and the force at that time."""
    floor, impact = wave_floor(response), main_impact(response)
    text = f"Building {response.attrs['building']}, floor {floor}: t = {time:.4f} s"
    if impact is not None:
        since = 1e3 * (time - impact[0])
        text += f", {abs(since):.1f} ms {'after' if since >= 0.0 else 'before'} the impact began"
    main = main_side(response) if response.sizes["edge"] else response
    here = (main["edge_floor"] == floor).values
    if here.any():
        force = main["edge_force"].isel(edge=here).sel(time=time, method="nearest")
        where = "" if force["edge"].item() == f"floor {floor}" else f" on {force['edge'].item()}"
        text += f"; force{where} {1e-6 * force.item():.1f} MN".replace("-", "−")
    return text
