"""A page with the buildings in 3D: slabs by acceleration, and the spectrum of a chosen point.

The page draws with WebGL and needs neither a network nor other files. Its data are one block:
arrays one after the other, compressed (zlib), in base64.
"""

import base64
import json
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from jinja2 import Environment
from markupsafe import Markup

from impactfem.plot.figure import figure
from impactfem.plot.floor_field import COLOURS
from impactfem.plot.scene import beam_nodes, shell_nodes
from impactfem.report.run_files import SCENE, RunFiles
from impactfem.stages.device.selection import anchor_of, shown_modes
from impactfem.stages.stores import names_of
from impactfem.stages.transient.selection import at_frequencies
from impactfem.system.arrays import Array, Index
from impactfem.system.files import atomic

FREQUENCIES = 60
"""Number of frequencies of the slider, besides the modes of the devices."""
LEVELS = 65535
"""Largest whole number of a coded value; 0 is for no value."""
FOLD = 30.0
"""Angle between two shells from which on their common line is drawn [degrees]."""
SLABS, WALLS = "floor", "storey"
"""Families of parts with colours by acceleration, and seen through."""


@dataclass(frozen=True, eq=False)
class Part:
    """A building in the scene. Spectra have the frequencies of the scene, or a size of 0."""

    name: str
    model: str  #: "3D model" or "stick"
    point: Array  #: points of the slabs, shape (n, 3) [m]
    floor: Index  #: number of the floor of each, shape (n,)
    slab: Index  #: triangles of the slabs, shape (m, 3)
    pfa: Array  #: peak acceleration with and without impact, shape (2, n) [m/s2]; or (2, 0)
    psa: Array  #: pseudo-acceleration with and without impact, shape (2, n, n_frequencies) [m/s2]
    wall: Array  #: corners of walls, three a triangle, shape (k, 3) [m]
    line: Array  #: ends of lines of the outline, shape (l, 3) [m]
    edge: Array  #: ends of lines of the impact edges, shape (l, 3) [m]
    resolved: float | None  #: end of the resolved band of its spectra [Hz]; None without spectra


@figure("building_scene", "The buildings in 3D", "The buildings in 3D", ending="html")
def write_scene(run: RunFiles) -> list[Path]:
    """Write `figures/building_scene.html` of a run; nothing without a 3D model.

    Raises:
        ImpactfemError: A file cannot be read or written.
    """
    models = {name: one for name, one in run.models.items() if one.has("building.nc")}
    if not models:
        return []
    devices = list(_devices(models))
    frequency = _frequencies(models, [f for one in devices for f in one["frequencies"]])
    parts = [_model(one, frequency) for one in models.values()]
    if run.ran("pounding"):
        size = np.ptp(parts[0].point[:, :2], axis=0)
        parts += _sticks(run, set(models), frequency, size)
    target = run.folder / "figures"
    target.mkdir(exist_ok=True)
    with atomic(target / SCENE) as temporary:
        temporary.write_text(_page(run, parts, frequency, devices), encoding="utf-8")
    return [target / SCENE]


def _devices(models: dict[str, RunFiles]) -> Iterator[dict[str, Any]]:
    """Yield name, place, building, floor and frequencies [Hz] of each device."""
    for name, run in models.items():
        if not run.ran("device"):
            continue
        with run.store("device.nc") as store:
            for device in names_of(store, "device"):
                point, floor, _ = anchor_of(store, device)
                yield {
                    "name": device,
                    "building": name,
                    "floor": floor,
                    "point": point.tolist(),
                    "frequencies": shown_modes(store, device)["mode_frequency"].values.tolist(),
                }


def _frequencies(models: dict[str, RunFiles], devices: Sequence[float]) -> Array:
    """Return the frequencies of the scene [Hz]; none without maps."""
    for run in models.values():
        if run.has("transient_maps.nc"):
            with run.store("transient_maps.nc") as maps:
                f = maps["frequency"].values
            own = [one for one in devices if f[0] <= one <= f[-1]]
            every = np.concatenate([np.geomspace(f[0], f[-1], FREQUENCIES), own])
            return np.asarray(np.unique(every))
    return np.zeros(0)


def _model(run: RunFiles, frequency: Array) -> Part:
    """Return a building by its 3D model."""
    with run.store("building.nc") as store:
        nodes, name = store["node_position"].values, str(store.attrs["building"])
        slabs, walls = (shell_nodes(store, family)[:, :3] for family in (SLABS, WALLS))
        lines = [_outline(nodes, shell_nodes(store)[:, :3])]
        lines += [beam_nodes(store, family) for family in ("beam", "column")]
        edge = nodes[store["edge_line"].values[:, :2].ravel()]
        names = [str(name).split("_") for name in store["shell_part_name"].values]
        own = np.array([family == SLABS for family, *_ in names])[store["triangle_part"].values]
        level = np.array([int(number) for _, number, *_ in names])
        floors = level[store["triangle_part"].values[own]]
    numbers, cells = np.unique(slabs, return_inverse=True)
    point = nodes[numbers]
    floor = np.zeros(len(numbers), dtype=np.int64)
    floor[cells.ravel()] = np.repeat(floors, 3)
    pfa, psa, resolved = np.zeros((2, 0)), np.zeros((2, 0, 0)), None
    if run.has("transient_maps.nc"):
        with run.store("transient.nc") as store:
            axis = str(store.attrs["shown_direction"])
            resolved = float(store.attrs["resolved_frequency"])
        with run.store("transient_maps.nc") as maps:
            one = maps.sel(component=axis)
            pfa, psa = np.zeros((2, len(numbers))), np.zeros((2, len(numbers), len(frequency)))
            known = np.asarray(maps["node_number"].values)
            here = np.isin(numbers, known)
            there = np.asarray(np.searchsorted(known, numbers))
            for k, end in enumerate(("", "_free")):
                pfa[k, here] = one[f"pfa{end}"].values[there[here]]
                psa[k, here] = at_frequencies(one[f"psa{end}"], frequency)[there[here]]
    return Part(
        name=name,
        model="3D model",
        point=point,
        floor=floor,
        slab=cells.reshape(-1, 3),
        pfa=pfa,
        psa=psa,
        wall=nodes[walls.ravel()],
        line=np.concatenate([nodes[one.ravel()] for one in lines]),
        edge=edge,
        resolved=resolved,
    )


def _outline(nodes: Array, cells: Index) -> Index:
    """Return the lines of triangles where they end, fold or branch, shape (n, 2)."""
    sides = np.sort(np.concatenate([cells[:, [0, 1]], cells[:, [1, 2]], cells[:, [2, 0]]]), axis=1)
    if not len(sides):
        return sides
    a, b, c = (nodes[cells[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal = np.tile(normal / np.linalg.norm(normal, axis=1, keepdims=True), (3, 1))
    lines, first, line, count = np.unique(
        sides, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    cosine = np.abs((normal * normal[first[line.ravel()]]).sum(axis=1))
    folded = np.zeros(len(lines), dtype=bool)
    np.logical_or.at(folded, line.ravel(), cosine < np.cos(np.radians(FOLD)))
    return np.asarray(lines[(count != 2) | folded])


def _sticks(run: RunFiles, models: set[str], frequency: Array, size: Array) -> Iterator[Part]:
    """Yield the buildings without a 3D model as boxes; `size` is a plan [m] in place of none."""
    buildings = {one["name"]: one for one in run.case["buildings"]}
    with run.store("forces.nc") as forces, run.store("pounding.nc") as store:
        axis = str(store.attrs["shown_direction"])
        # The slabs of a stick are as wide as its contact points, if the case gives no plan.
        for name in (one for one in names_of(store, "building") if one not in models):
            reach = np.zeros(2)
            for side in "ab":
                own = (forces[f"building_{side}"] == name).values
                offset = np.abs(forces[f"offset_{side}"].sel(axis=["x", "y"]).values[own])
                reach = np.maximum(reach, offset.max(axis=0, initial=0.0))
            plan = np.where(reach > 0.0, 2.0 * reach, size)
            given = buildings[name].get("length"), buildings[name].get("width")
            plan = np.array([p if g is None else g for g, p in zip(given, plan, strict=True)])
            centre = store["building_axis"].sel(building=name, plan=["x", "y"]).values
            one = store.isel(station=(store["station_building"] == name).values)
            one = one.isel(damping=0)
            at = one.sel(direction=axis) if axis in names_of(store, "direction") else None
            yield _box(name, _corners(centre, plan), one, at, frequency)


def _corners(centre: Array, plan: Array) -> Array:
    """Return the corners of a rectangle, shape (4, 2) [m]."""
    return np.asarray(centre + 0.5 * plan * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]))


def _box(
    name: str, corners: Array, store: xr.Dataset, at: xr.Dataset | None, frequency: Array
) -> Part:
    """Return a stick as slabs in a box.

    Args:
        name: Its name.
        corners: Of its slabs in plan, shape (4, 2) [m].
        store: Its stations.
        at: The same along the shown direction; None without results along it.
        frequency: Of the scene [Hz].
    """
    heights, base = store["elevation"].values, float(store["building_base"].sel(building=name))
    levels = np.array([base, *heights])
    grid = np.concatenate([np.insert(corners, 2, z, axis=1) for z in levels])
    point, count = grid[4:], len(heights)
    slab = (4 * np.arange(count)[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3)
    around = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
    sides = np.concatenate([4 * k + around for k in range(count + 1)])
    posts = np.array([[4 * k + c, 4 * k + 4 + c] for k in range(count) for c in range(4)])
    top = 4 * count
    faces = [[a, b, top + b, a, top + b, top + a] for a, b in around]
    pfa, psa = np.zeros((2, 0)), np.zeros((2, 0, 0))
    if at is not None and len(frequency):
        pfa = np.stack([np.repeat(at[one].values, 4) for one in ("pfa", "pfa_free")])
        low, high = (float(at["frequency"][k]) for k in (0, -1))
        within = np.clip(frequency, low, high)
        psa = np.stack(
            [np.repeat(at_frequencies(at[one], within), 4, axis=0) for one in ("psa", "psa_free")]
        )
    return Part(
        name=name,
        model="stick",
        point=point,
        floor=np.repeat(store["station_floor"].values, 4),
        slab=slab,
        pfa=pfa,
        psa=psa,
        wall=grid[np.array(faces).ravel()],
        line=grid[np.concatenate([sides, posts]).ravel()],
        edge=np.zeros((0, 3)),
        resolved=float(store.attrs["resolved_frequency"]) if psa.size else None,
    )


def _view(parts: Sequence[Part]) -> list[float]:
    """Return a direction towards the camera in plan: across the first two buildings."""
    along = np.array([1.0, 0.0])
    if len(parts) > 1:
        along = parts[1].point[:, :2].mean(axis=0) - parts[0].point[:, :2].mean(axis=0)
        along = along / max(float(np.linalg.norm(along)), 1e-9)
    return [float(along[1] + 0.35 * along[0]), float(-along[0] + 0.35 * along[1])]


def _joined(
    parts: Sequence[Part], frequency: Array
) -> tuple[dict[str, Array], tuple[float, float]]:
    """Return the arrays of the scene, and the range of the coded values [m/s2]."""
    starts = np.cumsum([0, *(len(one.point) for one in parts)])
    values = []
    for one in parts:
        own = np.zeros((2, len(one.point), 1 + len(frequency)))
        if one.pfa.size:
            own[..., 0], own[..., 1:] = one.pfa, one.psa
        values.append(own)
    every = np.concatenate(values, axis=1)
    known = every[every > 0.0]
    low, high = (float(known.min()), float(known.max())) if known.size else (1.0, 2.0)
    low = max(low, 1e-6 * high)
    share = np.log(np.maximum(every, low) / low) / np.log(high / low if high > low else 2.0)
    coded = np.where(every > 0.0, 1.0 + np.rint((LEVELS - 1) * share), 0.0)
    arrays = {
        "point": np.concatenate([one.point for one in parts]).astype("<f4"),
        "floor": np.concatenate([one.floor for one in parts]).astype("<u2"),
        "part": np.repeat(np.arange(len(parts)), np.diff(starts)).astype("<u2"),
        "slab": np.concatenate(
            [one.slab + start for one, start in zip(parts, starts, strict=False)]
        ).astype("<u4"),
        "wall": np.concatenate([one.wall for one in parts]).astype("<f4"),
        "line": np.concatenate([one.line for one in parts]).astype("<f4"),
        "edge": np.concatenate([one.edge for one in parts]).astype("<f4"),
        "value": coded.astype("<u2"),
        "colour": (255 * mpl.colormaps[COLOURS](np.linspace(0.0, 1.0, 256))).astype("u1"),
    }
    return arrays, (low, high)


def _page(
    run: RunFiles,
    parts: Sequence[Part],
    frequency: Array,
    devices: Sequence[dict[str, Any]],
) -> str:
    """Return the page with its data."""
    arrays, ends = _joined(parts, frequency)
    listed, content = [], b""
    for name, array in arrays.items():
        content += b"\0" * (-len(content) % 4)
        listed.append({"name": name, "type": array.dtype.str[1:], "start": len(content)})
        listed[-1]["size"] = int(array.size)
        content += array.tobytes()
    axis, damping = "", 0.0
    for one in run.models.values():
        if one.has("transient_maps.nc"):
            with one.store("transient.nc") as store:
                axis, damping = str(store.attrs["shown_direction"]), float(store["damping"][0])
    header = {
        "arrays": listed,
        "frequency": [round(float(f), 4) for f in frequency],
        "range": ends,
        "parts": [{k: getattr(one, k) for k in ("name", "model", "resolved")} for one in parts],
        "devices": list(devices),
        "direction": axis,
        "damping": damping,
        "view": _view(parts),
    }
    folder = files("impactfem.report") / "templates"
    environment = Environment(autoescape=True, trim_blocks=True)
    return environment.from_string((folder / "scene.html").read_text("utf-8")).render(
        title=" and ".join(one.name for one in parts),
        axis=axis,
        has_maps=bool(len(frequency)),
        # Nothing in the data can end the element.
        header=Markup(json.dumps(header).replace("<", "\\u003c")),
        data=base64.b64encode(zlib.compress(content, 9)).decode(),
        script=Markup((folder / "scene.js").read_text("utf-8")),
    )
