"""Films of the waves that the main impact sends through floors (figure 17 in motion).

Of one building and, where 3D models pound, of both, whose floors are in a picture, too.
"""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.tri import LinearTriInterpolator, Triangulation
from numpy.typing import NDArray

from impactfem.plot.floor_field import (
    SIGNED,
    TopFloor,
    colour_bar,
    plan_axes,
    plan_layout,
    round_factor,
    signed_limits,
)
from impactfem.plot.style import BUILDINGS, figure, letter, own_style
from impactfem.stages.stores import of_run, open_store, open_stores
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

LASTS = 4.5
"""Time that the film takes, whatever the time that it shows [s]."""
SIZE, DPI = (8.0, 5.6), 120.0
"""Of the film [inch] and its pixels in an inch: 960 by 672."""
RASTER = 360
"""Points of the picture along the longer side of the floor."""
LINE_POINTS = 121
MAPS = "transient_maps.nc"
PICTURE, FILM = "both_main_impact.png", "both_main_impact.mp4"
WIDE = 0.06
"""Gap of the picture of both buildings over the smaller side of a floor, at most."""
CUT = 0.03
"""Part of its values that is drawn in the last colours."""


@dataclass(frozen=True, eq=False)
class Filmed:
    """A floor of a film."""

    response: xr.Dataset  #: what `shown` gives
    maps: xr.Dataset  #: the open `transient_maps.nc`
    shift: Array = field(default_factory=lambda: np.zeros(2))  #: where it is drawn, in plan [m]
    sense: float = 1.0  #: 1 or -1, towards which the distance from its impact edge is drawn


def write_film(path: Path, floors: Sequence[Filmed]) -> None:
    """Film the acceleration of floors at the times of their frames, which are the same.

    H.264, 4:2:0: the floors in plan with one scale of colours, and the lines across them.
    ImpactfemError where the file cannot be written, or there is no encoder.
    """
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


def _frames(floors: Sequence[Filmed]) -> Iterator[NDArray[np.uint8]]:
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
    with own_style():
        drawn = Figure(figsize=SIZE, dpi=DPI, layout="constrained")
        canvas: Any = FigureCanvasAgg(drawn)
        shape = (2, 1) if extent[0] >= extent[1] else (1, 2)
        plan, line = np.ravel(drawn.subplots(*shape))
        label = f"acceleration $\\ddot u_{direction}$ [m/s²]"
        # Of each floor its picture and its curve, and the points that they show.
        moving: list[tuple[Any, Any, Triangulation, list[Array], Array]] = []
        for one, slab, of_floor, (low, high), colour in zip(
            floors, slabs, values, boxes, BUILDINGS, strict=False
        ):
            mesh, size = slab.split(one.shift), high - low
            count = np.maximum(2, np.rint(RASTER * size / extent.max()).astype(int))
            # In the middle of each pixel, so that the edges of the floor are inside.
            x, y = (low[k] + (np.arange(count[k]) + 0.5) / count[k] * size[k] for k in (0, 1))
            in_plan = list(np.meshgrid(x, y))
            first, last = line_ends(one.response) + one.shift
            # The ends a hair inside, where rounding leaves them in a triangle.
            share = np.clip(np.linspace(0.0, 1.0, LINE_POINTS), 1e-6, 1.0 - 1e-6)
            on_line = (first + share[:, None] * (last - first)).T
            field: Any = LinearTriInterpolator(mesh, of_floor[0])
            image = plan.imshow(
                field(*in_plan),
                extent=(low[0], high[0], low[1], high[1]),
                origin="lower",
                cmap=SIGNED,
                vmin=colours[0],
                vmax=colours[1],
                animated=True,
            )
            distance = one.sense * share * float(np.linalg.norm(last - first))
            name = one.response.attrs["building"] if len(floors) > 1 else None
            (curve,) = line.plot(distance, field(*on_line), color=colour, label=name, animated=True)
            moving.append((image, curve, mesh, in_plan, on_line))
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
        ends = [x for _, curve, *_ in moving for x in curve.get_xdata()[[0, -1]]]
        room = 0.05 * max(limits[1] - limits[0], 1e-12)
        line.set(xlim=(min(ends), max(ends)), ylim=(limits[0] - room, limits[1] + room))
        line.set(xlabel="distance d from the impact edge [m]", ylabel=label)
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
            for (image, curve, mesh, in_plan, on_line), v in zip(moving, values, strict=True):
                field = LinearTriInterpolator(mesh, v[k])
                image.set_data(field(*in_plan))
                curve.set_ydata(field(*on_line))
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
    main = main_side(response)
    here = (main["edge_floor"] == floor).values
    if here.any():
        force = main["impact_force"].isel(edge=here).sel(time=time, method="nearest")
        where = "" if force["edge"].item() == f"floor {floor}" else f" on {force['edge'].item()}"
        text += f"; force{where} {1e-6 * force.item():.1f} MN".replace("-", "−")
    return text


def both_figures(folder: Path) -> list[Path]:
    """Draw the floors of both buildings of the main impact into `figures/` of the second one.

    `folder` is that of a building. Nothing is drawn where its neighbour was not computed before it,
    where a stick pounds, where the main impact of one is not that of the other, or where the pair's
    normal is along neither x nor y.
    """
    with ExitStack() as stores:
        found = _pair(folder, stores)
        if found is None:
            return []
        floors, moved, normal, gap = found
        target = folder / "figures"
        target.mkdir(exist_ok=True)
        factor = round_factor(gap, WIDE * float(TopFloor(floors[0].maps).size.min()))
        apart = (factor - 1.0) * gap * normal
        placed = [
            Filmed(one.response, one.maps, one.shift + share * apart, sense)
            for one, share, sense in zip(floors, (0.0, 1.0), (-1.0, 1.0), strict=True)
        ]
        _picture(target / PICTURE, placed, moved, factor)
        write_film(target / FILM, placed)
        return [target / PICTURE, target / FILM]


def _pair(folder: Path, stores: ExitStack) -> tuple[list[Filmed], list[Array], Array, float] | None:
    """Floors of the main impact at rest, their displacements, unit vector from a to b, gap.

    Displacements in plan at the times of the snapshots, relative to the ground under the first
    building. The stores of both stay open until the stack ends; None as of `both_figures`.
    """
    run = of_run(folder, "pounding.nc").parent
    if run == folder or not (folder / MAPS).is_file():
        return None
    with open_store(run / "forces.nc") as forces, open_store(run / "pounding.nc") as pounding:
        hit = pounding["impact_peak_force"]
        if "hat_a" not in forces or not hit.sizes["impact"]:
            return None
        name = pounding["impact_pair"].values[int(hit.values.argmax())]
        line = forces.isel(pair=(forces["line"] == name).values)
        if line.sizes["pair"] < 2:
            return None
        axes = pounding["building_axis"].load()
        ends = [str(line[f"building_{side}"].values[0]) for side in "ab"]
        ground = pounding["ground_apart"].load() if "ground_apart" in pounding else None
        normal = line["normal"].transpose("pair", "axis").values[0, :2]
        gap = float(line["gap"].values.min())
        hats = [line[f"hat_{side}"].values for side in "ab"]
        offsets = [line[f"offset_{side}"].transpose("pair", "axis").values[:, :2] for side in "ab"]
    folders = [folder if name == folder.name else run / name for name in ends]
    folders = [one if (one / MAPS).is_file() else run for one in folders]
    along = int(np.argmin(np.abs(normal)))
    square = float(np.abs(normal).min()) < 1e-9 and gap > 0.0
    if folder not in folders or not square or not all((one / MAPS).is_file() for one in folders):
        return None
    floors, moved = [], []
    for name, place, hat, offset in zip(ends, folders, hats, offsets, strict=True):
        opened = stores.enter_context(open_stores(place))
        response, maps = shown(opened("transient.nc")), opened(MAPS)
        usable = response.attrs["building"] == name and np.isfinite(hat).all()
        if not usable or of_kind(response, "line").sizes["probe"] < 2 or not maps.sizes["frame"]:
            return None
        slab = TopFloor(maps).position[:, :2]
        # The middle of the first hat is at its offset from the axis; a hat is counted from the
        # corner where its side begins.
        middle = hat.mean(axis=1)
        forwards = (middle[-1] - middle[0]) * (offset[-1, along] - offset[0, along]) > 0.0
        here = np.empty(2)
        here[along] = slab[:, along].min() + middle[0]
        if not forwards:
            here[along] = slab[:, along].max() - middle[0]
        here[1 - along] = line_ends(response)[0, 1 - along]
        floors.append(Filmed(response, maps, axes.sel(building=name).values + offset[0] - here))
        moved.append(maps["wave_displacement"].values[..., :2])
        if ground is not None:
            under = ground.sel(building=name).interp(time=maps["snapshot"].values)
            moved[-1] = moved[-1] + under.transpose("time", "axis").values[:, None, :2]
    a, b = (one.maps["frame"].values for one in floors)
    return (floors, moved, normal, gap) if np.array_equal(a, b) else None


def _picture(path: Path, floors: list[Filmed], moved: list[Array], factor: float) -> None:
    """The floors of both buildings at the times of the snapshots, as they stand to each other."""
    response = floors[0].response
    d, times = response["component"].item(), floors[0].maps["snapshot"].values
    slabs = [TopFloor(one.maps) for one in floors]
    # What both do together is left out.
    middle = 0.5 * sum(one.mean(axis=1, keepdims=True) for one in moved)
    values = [one.maps["wave_acceleration"].sel(component=d).values for one in floors]
    every = np.abs(np.concatenate(values, axis=1))
    # The struck edges at the first contact would take the colours for themselves.
    low, high = signed_limits(float(np.quantile(every, 1.0 - CUT)))
    names = " and ".join(str(one.response.attrs["building"]) for one in floors)
    impact = main_impact(response)
    start = 0.0 if impact is None else impact[0]
    caption = (
        f"Acceleration along $e_{d}$ of floor {wave_floor(response)} of {names} in the main "
        f"impact, {', '.join(f'{1e3 * (t - start):.1f}' for t in times)} ms after it began. "
        f"Displacements in plan and gap amplified by {factor:g}, without what both do together. "
        f"Largest value: {every.max():.3g} m/s²."
    )
    label = f"acceleration $\\ddot u_{d}$ [m/s²]"
    wide = slabs[0].wide
    colours: dict[str, Any] = {"cmap": SIGNED, "vmin": low, "vmax": high}
    layout, size = ((1, len(times)), (9.0, 2.8)) if wide else ((len(times), 1), (6.5, 9.0))
    with figure(path, layout, size, caption) as (drawn, axes):
        plan_layout(drawn)
        for k, panel in enumerate(axes):
            for one, slab, u, v in zip(floors, slabs, moved, values, strict=True):
                mesh = slab.split(one.shift + factor * (u[k] - middle[k]))
                mappable = panel.tripcolor(mesh, v[k], shading="gouraud", **colours)
                panel.text(mesh.x.mean(), mesh.y.mean(), one.response.attrs["building"])
            panel.set_title(f"{1e3 * (times[k] - start):.1f} ms", fontsize=9.0, loc="right")
            panel.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
            panel.grid(False)
        colour_bar(drawn, mappable, axes, label)
        letter(axes)
