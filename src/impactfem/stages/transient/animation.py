"""Films of the waves that the main impact sends through floors (figure 17 in motion)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
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
from impactfem.plot.style import BUILDINGS, SETTINGS
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
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import atomic

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
    with open_stores(folder) as opened:
        response, maps = shown(opened("transient.nc")), opened("transient_maps.nc")
        if not maps.sizes.get("frame", 0) or of_kind(response, "line").sizes["probe"] < 2:
            return []
        path = folder / "figures" / f"wave_floor_{wave_floor(response)}.mp4"
        write_film(path, [Filmed(response, maps)])
    return [path]


@dataclass(frozen=True, eq=False)
class Filmed:
    """A floor of a film."""

    response: xr.Dataset  #: what `shown` gives
    maps: xr.Dataset  #: the open `transient_maps.nc`
    shift: Array = field(default_factory=lambda: np.zeros(2))  #: where it is drawn, in plan [m]
    sense: float = 1.0  #: 1 or -1, towards which the distance from its impact edge is drawn


def write_film(path: Path, floors: Sequence[Filmed]) -> None:
    """Film floors at the times of their frames, which are the same; as `wave_animation`."""
    import imageio.v2 as imageio

    path.parent.mkdir(exist_ok=True)
    look: dict[str, Any] = {"codec": "libx264", "pixelformat": "yuv420p", "macro_block_size": 2}
    look["output_params"] = ["-crf", "20", "-movflags", "+faststart"]
    look["fps"] = floors[0].maps.sizes["frame"] / LASTS
    with atomic(path) as temporary, TemporaryDirectory() as work:
        # imageio finds the format by the end of the name.
        whole = Path(work) / path.name
        try:
            film: Any = imageio.get_writer(
                whole, format="FFMPEG", mode="I", ffmpeg_log_level="error", **look
            )
            with film:
                for frame in _frames(floors):
                    film.append_data(frame)
        except RuntimeError as error:  # what imageio raises without ffmpeg
            raise ImpactfemError(f"cannot write {path}: {error}") from error
        temporary.write_bytes(whole.read_bytes())


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


def _frames(floors: Sequence[Filmed]) -> Iterator[Frame]:
    """The pictures of the film in their order, shape (height, width, 3)."""
    response, slabs = floors[0].response, [TopFloor(one.maps) for one in floors]
    times = np.asarray(floors[0].maps["frame"].values, dtype=np.float64)
    direction = response["component"].item()
    values = [
        one.maps["frame_acceleration"].sel(component=direction).values.astype(np.float64)
        for one in floors
    ]
    limits = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
    colours = signed_limits(*limits)
    # The corners of each floor as it is drawn, shape (n, 2, 2).
    boxes = np.array(
        [
            [f(slab.position[:, :2], axis=0) + one.shift for f in (np.min, np.max)]
            for one, slab in zip(floors, slabs, strict=True)
        ]
    )
    extent = boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)
    with mpl.rc_context(SETTINGS):  # type: ignore[arg-type]
        drawn = Figure(figsize=SIZE, dpi=DPI, layout="constrained")
        canvas: Any = FigureCanvasAgg(drawn)
        shape = (2, 1) if extent[0] >= extent[1] else (1, 2)
        plan, line = np.ravel(drawn.subplots(*shape))
        label = f"acceleration $\\ddot u_{direction}$ [m/s²]"
        moving: list[tuple[Any, Sampler, Any, Sampler]] = []
        for one, slab, of_floor, (low, high), colour in zip(
            floors, slabs, values, boxes, BUILDINGS, strict=False
        ):
            mesh, size = slab.split(one.shift), high - low
            count = np.maximum(2, np.rint(RASTER * size / extent.max()).astype(int))
            # In the middle of each pixel, so that the edges of the floor are inside.
            x, y = (low[k] + (np.arange(count[k]) + 0.5) / count[k] * size[k] for k in (0, 1))
            in_plan = Sampler(mesh, np.stack(np.meshgrid(x, y), axis=-1))
            first, last = line_ends(one.response) + one.shift
            # The ends a hair inside, where rounding leaves them in a triangle.
            share = np.clip(np.linspace(0.0, 1.0, LINE_POINTS), 1e-6, 1.0 - 1e-6)
            on_line = Sampler(mesh, first + share[:, None] * (last - first))
            image = plan.imshow(
                in_plan(of_floor[0]),
                extent=(low[0], high[0], low[1], high[1]),
                origin="lower",
                cmap=SIGNED,
                vmin=colours[0],
                vmax=colours[1],
                animated=True,
            )
            distance = one.sense * share * float(np.linalg.norm(last - first))
            name = one.response.attrs["building"] if len(floors) > 1 else None
            (curve,) = line.plot(
                distance, on_line(of_floor[0]), color=colour, label=name, animated=True
            )
            moving.append((image, in_plan, curve, on_line))
        plan_axes(plan, slabs[0])
        if len(floors) > 1:
            beyond = 0.05 * float(extent.max())
            plan.set_xlim(boxes[:, 0, 0].min() - beyond, boxes[:, 1, 0].max() + beyond)
            plan.set_ylim(boxes[:, 0, 1].min() - beyond, boxes[:, 1, 1].max() + beyond)
            for one, box in zip(floors, boxes, strict=True):
                plan.text(*box.mean(axis=0), one.response.attrs["building"], ha="center")
            line.legend(loc="upper right")
        else:
            mark_edge(plan, response, slabs[0])
        colour_bar(drawn, moving[0][0], plan, label)
        line.axhline(0.0, color="0.4", lw=0.8)
        ends = [x for _, _, curve, _ in moving for x in curve.get_xdata()[[0, -1]]]
        line.set_xlim(min(ends), max(ends))
        room = 0.05 * max(limits[1] - limits[0], 1e-12)
        line.set_ylim(limits[0] - room, limits[1] + room)
        line.set_xlabel("distance d from the impact edge [m]")
        line.set_ylabel(label)
        names = [str(one.response.attrs["building"]) for one in floors]
        # The plan of two floors is narrower than the words.
        headed = plan if len(floors) == 1 else line
        title = headed.set_title(
            _title(response, names, times[0]), loc="left", fontsize=10.0, animated=True
        )
        canvas.draw()
        background = canvas.copy_from_bbox(drawn.bbox)
        for k, time in enumerate(times):
            title.set_text(_title(response, names, time))
            canvas.restore_region(background)
            for (image, in_plan, curve, on_line), of_floor in zip(moving, values, strict=True):
                image.set_data(in_plan(of_floor[k]))
                curve.set_ydata(on_line(of_floor[k]))
                plan.draw_artist(image)
                line.draw_artist(curve)
            headed.draw_artist(title)
            pixels = np.asarray(canvas.buffer_rgba())
            # 4:2:0 takes pixels by twos.
            even = [size - size % 2 for size in pixels.shape[:2]]
            yield np.ascontiguousarray(pixels[: even[0], : even[1], :3])


def _title(response: xr.Dataset, buildings: Sequence[str], time: float) -> str:
    """What is seen, the time, and the force at that time."""
    floor, impact = wave_floor(response), main_impact(response)
    text = f"{' and '.join(buildings)}, floor {floor}: t = {time:.4f} s"
    if len(buildings) == 1:
        text = f"Building {text}"
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
