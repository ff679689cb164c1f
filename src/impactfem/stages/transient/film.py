"""The film of the main impact where both buildings have a 3D model.

Displacements and gap have one factor, so that façades touch in the film when they touch in the
computation. Floors are coloured by their acceleration; walls and columns move linearly in height.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import imageio.v2 as imageio
import numpy as np
import xarray as xr
from scipy.spatial import cKDTree

from impactfem.plot.figure import figure
from impactfem.plot.floor_field import round_factor
from impactfem.plot.scene import OUTLINE, plotter, shell_nodes
from impactfem.stages.stores import of_run, open_store, open_stores
from impactfem.stages.transient.curve_figures import HISTORIES
from impactfem.stages.transient.selection import main_impact
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import atomic

MAPS = "transient_maps.nc"
LASTS = 4.0
"""Duration of the film [s]."""
WIDE = 0.12
"""Largest displacement in the film, over the height of the building."""


class Part(NamedTuple):
    """The floors of a building, or its walls and columns."""

    mesh: Any  #: of pyvista
    points: Array  #: at rest, shape (n, 3) [m]
    displacement: Array  #: shape (n_t, n, 3) [m]
    acceleration: Array | None = None  #: size of that of floors, shape (n_t, n) [m/s2]


@dataclass(frozen=True, eq=False)
class Film:
    """The main impact of a building and its 3D neighbours."""

    parts: list[Part]
    times: Array  #: from the main impact, shape (n_t,) [s]
    factor: float  #: of displacements and gap
    view: tuple[float, ...]  #: from the buildings towards the camera


def film_of(folder: Path) -> Film | None:
    """Read the main impact of the building in a folder and of its 3D neighbours.

    None without an impact, or before the maps of a neighbour are in the run.
    """
    run = of_run(folder, "pounding.nc").parent
    if run == folder or not (folder / MAPS).is_file():
        return None
    with open_stores(folder) as opened:
        response, maps = opened("transient.nc"), opened(MAPS)
        places = dict(_neighbours(run, opened("forces.nc"), str(response.attrs["building"])))
        impact = main_impact(response)
        if impact is None or not places:
            return None
        first, times = _parts(opened("building.nc"), maps), maps["frame"].values - impact[0]
    _, points, u, _ = first[0]
    factor = max(1.0, round_factor(float(np.abs(u).max()), WIDE * float(points[:, 2].max())))
    parts = list(first)
    for place, (normal, gap) in places.items():
        with open_stores(place) as opened:
            theirs = _parts(opened("building.nc"), opened(MAPS))
        # Move it in plan: opposite to the building, at the gap along the normal.
        across, facade = np.array([-normal[1], normal[0], 0.0]), theirs[0].points
        shift = ((points @ normal).max() + factor * gap - (facade @ normal).min()) * normal
        shift += (np.median(points @ across) - np.median(facade @ across)) * across
        parts += [part._replace(points=part.points + shift) for part in theirs]
    return Film(parts, times, factor, (normal[1], -normal[0], 0.35))


@figure("main_impact", HISTORIES, "Film of the main impact", ending="mp4", in_3d=True)
def main_impact_film(path: Path, film: Film) -> None:
    """Write the film; ImpactfemError if it cannot be written."""
    frames = max(1, round(len(film.times) / LASTS))
    with TemporaryDirectory() as work:
        drawn = Path(work) / path.name
        try:
            _write(film, lambda scene: scene.open_movie(drawn, framerate=frames))
        except RuntimeError as error:  # what imageio raises without ffmpeg
            raise ImpactfemError(f"cannot write {path}: {error}") from error
        with atomic(path) as temporary:
            temporary.write_bytes(drawn.read_bytes())


@figure(
    "main_impact_loop",
    HISTORIES,
    "Film of the main impact as GIF",
    default=False,
    ending="gif",
    in_3d=True,
)
def main_impact_loop(path: Path, film: Film) -> None:
    """Write the film as a GIF of half its size; ImpactfemError if it cannot be written."""
    frames: list[Any] = []
    _write(film, keep=lambda scene: frames.append(scene.screenshot(return_img=True)[::2, ::2]))
    with atomic(path) as temporary:
        duration = 1e3 * LASTS / len(film.times)
        imageio.mimwrite(temporary, frames, format="GIF", duration=duration, loop=0)


def _neighbours(
    run: Path, forces: xr.Dataset, own: str
) -> Iterator[tuple[Path, tuple[Array, float]]]:
    """Yield the folder of each 3D neighbour, with the normal towards it and its smallest gap."""
    for pair in np.argsort(-forces["gap"].values, kind="stable"):
        one = forces.isel(pair=pair)
        a, b = one["building_a"].item(), one["building_b"].item()
        if own in (a, b) and "" not in (a, b):
            name, sense = (b, 1.0) if a == own else (a, -1.0)
            place = run / name if (run / name / MAPS).is_file() else run
            with open_store(place / "transient.nc") as store:
                if store.attrs["building"] == name and (place / MAPS).is_file():
                    yield place, (sense * one["normal"].values, float(one["gap"]))


def _parts(building: xr.Dataset, maps: xr.Dataset) -> list[Part]:
    """Return the floors of a building, and its walls and columns."""
    import pyvista

    floors, u = maps["node_position"].values, maps["frame_displacement"].values
    slabs = pyvista.PolyData.from_regular_faces(floors, maps["floor_triangle_node"].values)
    points = building["node_position"].values
    cells = shell_nodes(building, "storey")[:, :3], building["line_node"].values[:, :2]
    faces, lines = (np.insert(rows, 0, rows.shape[1], axis=1).ravel() for rows in cells)
    others = pyvista.PolyData(points, faces=faces if len(faces) else None, lines=lines)
    acceleration = np.abs(maps["frame_acceleration"].values)
    moved = between_floors(points, floors, u)
    return [Part(slabs, floors, u, acceleration), Part(others, points, moved)]


def between_floors(points: Array, floors: Array, u: Array) -> Array:
    """Return displacements of points, shape (n_t, k, 3), linear in height between floors.

    Of each floor the vertex counts that is nearest in plan. Points have the shape (k, 3), the
    lowest is at rest; vertices of floors (n, 3), their displacements `u` (n_t, n, 3).
    """
    levels = np.unique(np.round(floors[:, 2], 6))
    levels = levels[np.diff(levels, prepend=-np.inf) > 0.05]
    heights = np.array([min(points[:, 2].min(), levels[0] - 1e-3), *levels])
    moved = np.zeros((len(u), len(points), 3))
    for level, hat in zip(levels, np.eye(len(heights))[1:], strict=True):
        on = np.flatnonzero(np.abs(floors[:, 2] - level) < 0.05)
        nearest = on[cKDTree(floors[on, :2]).query(points[:, :2])[1]]
        moved += np.interp(points[:, 2], heights, hat)[:, None] * u[:, nearest]
    return moved


def _write(
    film: Film,
    begin: Callable[[Any], None] = lambda scene: None,
    keep: Callable[[Any], None] = lambda scene: scene.write_frame(),
) -> None:
    """Draw all frames; `begin` and `keep` take the plotter before the first and at each frame."""
    scene = plotter()
    scene.window_size = [1280, 960]
    every = np.concatenate(
        [np.ravel(p.acceleration) for p in film.parts if p.acceleration is not None]
    )
    look: dict[str, Any] = {"cmap": "magma_r", "clim": (0.0, float(np.quantile(every, 0.98)))}
    bar = {"title": "absolute acceleration [m/s2]", "color": "black", "n_labels": 2}
    look |= {"scalars": "a", "lighting": False, "copy_mesh": False, "scalar_bar_args": bar}
    for mesh, _, _, a in film.parts:
        if a is None:
            scene.add_mesh(mesh, color=OUTLINE, opacity=0.35, line_width=3.0, copy_mesh=False)
        else:
            mesh.point_data["a"] = a[0]
            scene.add_mesh(mesh, **look)
    begin(scene)
    for k, time in enumerate(film.times):
        for mesh, points, u, a in film.parts:
            mesh.points = points + film.factor * u[k]
            if a is not None:
                mesh.point_data["a"] = a[k]
        if k == 0:
            scene.view_vector(film.view, (0.0, 0.0, 1.0))
            scene.camera.zoom(1.15)
        text = f"{1e3 * time:+.0f} ms from the main impact; displacements and gap x {film.factor:g}"
        scene.add_text(text, font_size=12, color="black", name="time")
        keep(scene)
    scene.close()
