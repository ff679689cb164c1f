"""The film of the main impact: buildings in 3D, deformed, coloured by their acceleration.

A building with a 3D model is drawn with its floors, walls and columns; a neighbour without one as
the floors of its stick. Displacements and gap have one factor, so that buildings touch in the film
when they touch in the computation. Between floors, displacements of walls and columns are linear in
height: only floors are recorded.
"""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial import cKDTree

from impactfem.plot.floor_field import round_factor
from impactfem.plot.scene import shell_nodes
from impactfem.stages.stores import of_run, open_store, open_stores
from impactfem.stages.transient.film_frames import (
    COLOURS,
    CONTACT,
    SIZE,
    Actor,
    Film,
    Moving,
    Touch,
    draw_frames,
)
from impactfem.stages.transient.selection import main_impact
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import atomic

NAME = "main_impact"
LASTS = 4.0
"""Duration of the film, whatever the time that it shows [s]."""
WIDE = 0.12
"""Largest displacement of a building in the film, over its height."""
INKS = 160
"""Colours of the GIF in addition to those of the scale and of the contacts."""
SLAB = 0.3
"""Thickness of the floors of a stick [m]."""


def draw_film(folder: Path) -> list[Path]:
    """Draw the main impact of a building and its neighbours as mp4 and GIF into `figures/`.

    Run it in a separate process, as `draw_pictures`. Nothing is drawn without an impact on the
    building, or if a neighbour with a 3D model comes later in the run.

    Args:
        folder: The folder of the building, with `transient_maps.nc`.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    run = of_run(folder, "pounding.nc").parent
    if not (run / "forces.nc").is_file():  # forces of another program
        return []
    with open_stores(folder) as opened:
        response = opened("transient.nc")
        impact = main_impact(response)
        if impact is None or not (folder / "transient_maps.nc").is_file():
            return []
        maps, pounding, forces = (
            opened(f"{name}.nc") for name in ("transient_maps", "pounding", "forces")
        )
        own, times = str(response.attrs["building"]), maps["frame"].values
        pairs = _pairs_of(forces, own)
        if not pairs.sizes["pair"] or not times.size:
            return []
        neighbours = _neighbours(pairs, own)
        other_models = {
            name: place
            for name in neighbours
            if pounding["building_model"].sel(building=name) == "structure"
            if (place := _folder_of(run, name)) is not None
        }
        waiting = (pounding["building_model"] == "structure").sum() > 1 + len(other_models)
        if waiting:
            return []
        shown = pounding["station_building"].isin([own, *neighbours]).values
        stations = pounding.isel(station=shown).sel(time=times, method="nearest")
        height = float(stations["elevation"].max() - pounding["building_base"].min())
        moved = float(np.linalg.norm(maps["frame_displacement"].values, axis=-1).max())
        moved = max(moved, float(abs(stations["displacement"]).max()))
        factor = max(1.0, round_factor(moved, WIDE * height))
        actors = [_model(opened("building.nc"), maps, pounding, pairs, own, factor)]
        for name in neighbours:
            if name in other_models:
                with open_stores(other_models[name]) as theirs:
                    stores = theirs("building.nc"), theirs("transient_maps.nc")
                    actors.append(_model(*stores, pounding, pairs, name, factor))
            else:
                actors.append(_stick(pounding, pairs, name, times, actors[0], factor))
        film = Film(
            actors,
            _plates(pairs, actors[0], factor),
            _touches(pairs, pounding, own, times),
            times,
            impact[0],
            factor,
            str(response.attrs["shown_direction"]),
        )
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    frames = list(draw_frames(film))
    files = [target / f"{NAME}.mp4", target / f"{NAME}.gif"]
    _write_mp4(files[0], frames)
    _write_gif(files[1], frames)
    return files


def _pairs_of(forces: xr.Dataset, own: str) -> xr.Dataset:
    """Return the pairs between a building and others; the attribute `own` is its name."""
    here = (forces["building_a"] == own) | (forces["building_b"] == own)
    return forces.isel(pair=here.values).assign_attrs(own=own)


def _neighbours(pairs: xr.Dataset, own: str) -> list[str]:
    names = [*pairs["building_a"].values.tolist(), *pairs["building_b"].values.tolist()]
    return [name for name in dict.fromkeys(names) if name not in (own, "")]


def _folder_of(run: Path, building: str) -> Path | None:
    """The folder with the response of a 3D model; None if it has not been computed."""
    for folder in (run, run / building):
        if (folder / "transient_maps.nc").is_file():
            with open_store(folder / "transient.nc") as store:
                if store.attrs["building"] == building:
                    return folder
    return None


def _sides(pairs: xr.Dataset, name: str) -> tuple[Array, Array]:
    """Contact points of a building relative to its axis, (n, 3), and normals away from it."""
    found, normals = [], []
    for side, sense in (("a", 1.0), ("b", -1.0)):
        here = (pairs[f"building_{side}"] == name).values
        found.append(pairs[f"offset_{side}"].transpose("pair", "axis").values[here])
        normals.append(sense * pairs["normal"].transpose("pair", "axis").values[here])
    return np.concatenate(found), np.concatenate(normals)


def _apart(pairs: xr.Dataset, name: str, factor: float) -> Array:
    """Shift of a building by which its gap to the first one has the factor, shape (3,) [m]."""
    if name == pairs.attrs["own"]:
        return np.zeros(3)
    _, normals = _sides(pairs, name)
    own = (pairs["building_a"] == name).values | (pairs["building_b"] == name).values
    gap = float(pairs["gap"].values[own].min()) if own.any() else 0.0
    shift: Array = -(factor - 1.0) * gap * normals[0]
    return shift


def _model(
    building: xr.Dataset,
    maps: xr.Dataset,
    pounding: xr.Dataset,
    pairs: xr.Dataset,
    name: str,
    factor: float,
) -> Actor:
    """A building with a 3D model."""
    nodes = maps["node_position"].values
    # The contact points are on the façade of the mesh: this places the axis of the building in it.
    offsets, normals = _sides(pairs, name)
    normal = normals[0]
    middle = 0.5 * (nodes.min(axis=0) + nodes.max(axis=0))
    axis = middle - offsets.mean(axis=0)
    axis += normal * ((nodes @ normal).max() - (axis + offsets[0]) @ normal)
    shift = np.append(pounding["building_axis"].sel(building=name).values - axis[:2], 0.0)
    shift += _apart(pairs, name, factor)
    u = maps["frame_displacement"].values.astype(np.float64)

    def between(cells: Index) -> Moving:
        used, places = np.unique(cells, return_inverse=True)
        points = building["node_position"].values[used]
        moved = _between_floors(points, nodes, u)
        return Moving(points + shift, places.reshape(cells.shape), moved)

    walls = shell_nodes(building, "storey")[:, :3]
    return Actor(
        name,
        Moving(nodes + shift, maps["floor_triangle_node"].values, u),
        between(walls),
        between(building["line_node"].values[:, :2]),
        maps["frame_acceleration"].values,
    )


def _between_floors(points: Array, nodes: Array, u: Array) -> Array:
    """Displacement of points, linear in height between the nearest nodes of the floors."""
    levels = np.unique(np.round(nodes[:, 2], 6))
    kept = levels[np.diff(levels, prepend=-np.inf) > 0.05]
    base = float(points[:, 2].min(initial=kept[0]))
    below = [np.zeros((len(u), len(points), 3))]
    for level in kept:
        on = np.flatnonzero(abs(nodes[:, 2] - level) < 0.05)
        below.append(u[:, on[cKDTree(nodes[on, :2]).query(points[:, :2])[1]]])
    heights = np.array([base, *kept])
    upper = np.clip(np.searchsorted(heights, points[:, 2] - 1e-6), 1, len(kept))
    span = heights[upper] - heights[upper - 1]
    share = np.clip((points[:, 2] - heights[upper - 1]) / np.where(span > 0.0, span, 1.0), 0.0, 1.0)
    every, at = np.stack(below), np.arange(len(points))
    low, high = every[upper - 1, :, at], every[upper, :, at]
    moved: Array = low + share[:, None, None] * (high - low)
    return moved.transpose(1, 0, 2)


def _stick(
    pounding: xr.Dataset,
    pairs: xr.Dataset,
    name: str,
    times: Array,
    first: Actor,
    factor: float,
) -> Actor:
    """A neighbour as the floors of its stick, as wide as its contact points and the building."""
    own = pounding.isel(station=(pounding["station_building"] == name).values)
    offsets, normals = _sides(pairs, name)
    normal, depth = normals[0], float(abs(offsets @ normals[0]).max())
    across = np.array([-normal[1], normal[0], 0.0])
    points = first.floors.points @ across
    half = 0.5 * float(np.ptp(points))
    axis = np.append(pounding["building_axis"].sel(building=name).values, 0.0)
    axis += _apart(pairs, name, factor)
    # Its façade is opposite to that of the building.
    lateral = 0.5 * (points.min() + points.max()) - axis @ across
    plan = [
        axis + sense * depth * normal + (lateral + side * half) * across
        for sense, side in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    history = own.sel(time=times, method="nearest").transpose("time", "station", ...)
    along = {"x": 0, "y": 1, "z": 2}
    u = np.zeros((len(times), own.sizes["station"], 3))
    a = np.zeros(u.shape[:2])
    direction = str(pounding.attrs["shown_direction"])
    for component in history["component"].values:
        if component in along:
            u[..., along[component]] = history["displacement"].sel(component=component)
        if component == direction:
            a = history["acceleration"].sel(component=component).values
    slabs, faces, columns, u_f, u_c, a_f = [], [], [], [], [], []
    base = float(pounding["building_base"].sel(building=name))
    levels = [base, *own["elevation"].values.tolist()]
    box = np.array(
        [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    )
    ground = np.zeros((len(times), 4, 3))
    for k, level in enumerate(levels[1:]):
        slabs += [[*corner[:2], level + z] for z in (-SLAB, 0.0) for corner in plan]
        faces.append(box + 8 * k)
        columns += [[*corner[:2], z] for corner in plan for z in (levels[k], level)]
        u_f.append(np.repeat(u[:, k, None], 8, axis=1))
        a_f.append(np.repeat(a[:, k, None], 8, axis=1))
        low = ground if k == 0 else np.repeat(u[:, k - 1, None], 4, axis=1)
        high = np.repeat(u[:, k, None], 4, axis=1)
        u_c.append(np.stack([low, high], axis=2).reshape(len(times), 8, 3))
    bars = np.arange(len(columns)).reshape(-1, 2)
    return Actor(
        name,
        Moving(np.array(slabs), np.concatenate(faces), np.concatenate(u_f, axis=1)),
        Moving(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64), np.zeros((len(times), 0, 3))),
        Moving(np.array(columns), bars, np.concatenate(u_c, axis=1)),
        np.concatenate(a_f, axis=1),
    )


def _plates(pairs: xr.Dataset, first: Actor, factor: float) -> list[Array]:
    """Return the corners of the rigid walls next to the building, shape (4, 3) each [m]."""
    walls = pairs.isel(pair=(pairs["building_b"] == "").values)
    normals, gaps = walls["normal"].transpose("pair", "axis").values, walls["gap"].values
    points = np.concatenate([first.floors.points, first.bars.points, first.walls.points])
    low, high = points[:, 2].min(), first.floors.points[:, 2].max()
    plates = []
    for normal in np.unique(np.round(normals, 9), axis=0):
        gap = float(gaps[(abs(normals - normal) < 1e-8).all(axis=1)].min())
        across = np.array([-normal[1], normal[0], 0.0])
        away = float((first.floors.points @ normal).max()) + factor * gap
        ends = [(first.floors.points @ across).min(), (first.floors.points @ across).max()]
        foot, head = np.array([0.0, 0.0, low]), np.array([0.0, 0.0, high])
        plan = [away * normal + end * across for end in ends]
        plates.append(np.array([*(p + foot for p in plan), *(p + head for p in plan[::-1])]))
    return plates


def _touches(pairs: xr.Dataset, pounding: xr.Dataset, own: str, times: Array) -> list[Touch]:
    """Return the contact points of the building with their largest forces of each frame."""
    steps = np.searchsorted(pairs["time"].values, times - 1e-9)
    steps = np.minimum(steps, pairs.sizes["time"] - 1)
    force = pairs["force"].transpose("pair", "time").values
    starts = np.minimum(np.append(steps[:1], steps[:-1] + 1), steps)
    levels = pounding.isel(station=(pounding["station_building"] == own).values)
    numbers, heights = levels["station_floor"].values, levels["elevation"].values
    below, above = levels["rigid_below"].values, levels["rigid_above"].values
    base = float(pounding["building_base"].sel(building=own))
    touches = []
    for k in range(pairs.sizes["pair"]):
        pair = pairs.isel(pair=k)
        side = "a" if pair["building_a"].item() == own else "b"
        floor = int(np.flatnonzero(numbers == pair[f"floor_{side}"].item())[0])
        z, share = float(heights[floor]), float(pair[f"relative_height_{side}"])
        if np.isfinite(share):  # on a storey
            # Heights count in the flexible part of the storey, between its rigid ends.
            low = float(heights[floor - 1] + above[floor - 1]) if floor else base
            z = low + share * (z - float(below[floor]) - low)
        axis = np.append(pounding["building_axis"].sel(building=own).values, z)
        largest = [force[k, i : j + 1].max() for i, j in zip(starts, steps, strict=True)]
        touches.append(Touch(axis + pair[f"offset_{side}"].values, np.array(largest), 0))
    return touches


def _write_mp4(path: Path, frames: Sequence[NDArray[np.uint8]]) -> None:
    import imageio.v2 as imageio

    look: dict[str, Any] = {"format": "FFMPEG", "codec": "libx264", "macro_block_size": 2}
    look |= {"fps": max(1.0, len(frames) / LASTS), "pixelformat": "yuv420p"}
    look |= {"ffmpeg_log_level": "error"}
    look["output_params"] = ["-crf", "23", "-movflags", "+faststart"]
    with atomic(path) as temporary, TemporaryDirectory() as work:
        whole = Path(work) / path.name  # imageio finds the format by the end of the name
        try:
            imageio.mimwrite(whole, list(frames), **look)
        except RuntimeError as error:  # what imageio raises without ffmpeg
            raise ImpactfemError(f"cannot write {path}: {error}") from error
        temporary.write_bytes(whole.read_bytes())


def _write_gif(path: Path, frames: Sequence[NDArray[np.uint8]]) -> None:
    """Write frames of half the size, with the same few colours in all of them."""
    half = (SIZE[0] // 2, SIZE[1] // 2)
    small = [Image.fromarray(frame).resize(half, Image.Resampling.BOX) for frame in frames]
    sheet = np.concatenate([np.asarray(frame) for frame in small[:: max(1, len(small) // 8)]])
    fixed = [*mpl.colormaps[COLOURS](np.linspace(0.0, 1.0, 64)), mpl.colors.to_rgba(CONTACT)]
    colours = [round(255.0 * part) for colour in fixed for part in colour[:3]]
    inks = Image.new("P", (1, 1))
    scene = Image.fromarray(sheet).quantize(INKS).getpalette() or []
    inks.putpalette(scene[: 3 * INKS] + colours)
    first, *others = (frame.quantize(palette=inks, dither=Image.Dither.NONE) for frame in small)
    lasts = round(1e3 * LASTS / len(frames))
    look: dict[str, Any] = {"save_all": True, "append_images": others, "loop": 0}
    with atomic(path) as temporary:
        first.save(temporary, format="GIF", duration=lasts, **look)
