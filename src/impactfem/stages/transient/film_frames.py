"""The frames of the film: buildings by pyvista, with texts, colour scale and contacts on top.

The scene is seen in parallel projection, so that a point has one place in all frames. What is
written on a frame is drawn with Pillow: it is sharp, and a contact is visible through the slabs.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import font_manager
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from impactfem.plot.scene import GHOST, OUTLINE, Picture, screen_axes
from impactfem.system.arrays import Array, Index

SIZE = (1280, 960)
"""Width and height of a frame [pixel]; the GIF has half of them."""
COLOURS = "magma_r"
"""Perceptually uniform; light slabs have small accelerations."""
HEAD, FOOT, SIDE = 0.13, 0.13, 0.04
"""Free parts of the frame: above and below the buildings, and at each side."""
CUT = 0.02
"""Part of the accelerations that is drawn in the last colour."""
TURN, RISE = 0.12, 0.35
"""Direction of the view: from along the façades towards the first building, and from above."""
LETTERS = 26
"""Height of the letters [pixel]."""
CONTACT, GROUND = "#0072b2", "#e4e4e4"
DOT = 0.012
"""Radius of the mark of the largest contact force, over the width of the frame."""
LEAST = 0.01
"""Least contact force that is marked, over the largest."""


@dataclass(frozen=True, eq=False)
class Moving:
    """Polygons or lines whose points move."""

    points: Array  #: at rest, shape (n, 3) [m]
    cells: Index  #: numbers of their points: polygons, shape (m, k > 2), or lines, shape (m, 2)
    displacement: Array  #: shape (n_t, n, 3) [m]


@dataclass(frozen=True, eq=False)
class Actor:
    """A building of the film, at its place."""

    name: str
    floors: Moving
    walls: Moving
    bars: Moving  #: beams and columns
    acceleration: Array  #: of the points of the floors along the shown direction, (n_t, n) [m/s2]


@dataclass(frozen=True, eq=False)
class Touch:
    """A contact pair of the film."""

    place: Array  #: its point on the building, at rest, shape (3,) [m]
    force: Array  #: largest since the frame before, shape (n_t,) [N]
    actor: int  #: number of the building with the point


@dataclass(frozen=True, eq=False)
class Film:
    """What the frames show."""

    actors: Sequence[Actor]
    plates: Sequence[Array]  #: corners of rigid walls, shape (4, 3) [m]
    touches: Sequence[Touch]
    times: Array  #: of the frames [s]
    start: float  #: of the main impact [s]
    factor: float  #: on displacements and gap
    direction: str  #: of the accelerations


def draw_frames(film: Film) -> Iterator[NDArray[np.uint8]]:
    """Draw the frames, shape (rows, columns, 3). Run it in a process without dolfinx."""
    import pyvista

    scene = pyvista.Plotter(off_screen=True, window_size=list(SIZE))
    scene.set_background("white")
    every = np.abs(np.concatenate([actor.acceleration.ravel() for actor in film.actors]))
    end = float(np.quantile(every, 1.0 - CUT)) or 1.0
    drawn: list[tuple[Any, Moving]] = []
    for actor in film.actors:
        slabs, walls, bars = (_mesh(part) for part in (actor.floors, actor.walls, actor.bars))
        rims = _rims(actor.floors)
        edges = _mesh(rims)
        slabs.point_data["acceleration"] = np.abs(actor.acceleration[0])
        look = {"scalars": "acceleration", "cmap": COLOURS, "clim": (0.0, end)}
        scene.add_mesh(slabs, show_scalar_bar=False, lighting=False, copy_mesh=False, **look)
        scene.add_mesh(edges, color=OUTLINE, line_width=2.0, copy_mesh=False)
        if len(actor.walls.cells):
            scene.add_mesh(walls, color=GHOST, opacity=0.35, copy_mesh=False)
        if len(actor.bars.cells):
            scene.add_mesh(bars, color=OUTLINE, line_width=3.0, copy_mesh=False)
        parts = (actor.floors, actor.walls, actor.bars, rims)
        drawn += list(zip((slabs, walls, bars, edges), parts, strict=True))
    for corners in (_ground(film), *film.plates):
        plate = pyvista.PolyData.from_regular_faces(corners, np.array([[0, 1, 2, 3]]))
        scene.add_mesh(plate, color=GROUND, lighting=False)
    view = _look_at(scene, film)
    scale = _colour_scale(end, film.direction)
    for k in range(len(film.times)):
        for mesh, part in drawn:
            mesh.points = part.points + film.factor * part.displacement[k]
        for actor, (mesh, _) in zip(film.actors, drawn[::4], strict=True):
            mesh.point_data["acceleration"] = np.abs(actor.acceleration[k])
        scene.render()
        frame = Image.fromarray(np.asarray(scene.screenshot(return_img=True), dtype=np.uint8))
        frame.paste(scale, ((SIZE[0] - scale.width) // 2, SIZE[1] - scale.height))
        _write_on(frame, film, view, k)
        yield np.asarray(frame)
    scene.close()


def _mesh(part: Moving) -> Any:
    import pyvista

    if part.cells.shape[1] > 2:
        return pyvista.PolyData.from_regular_faces(part.points, part.cells)
    lines = np.insert(part.cells, 0, 2, axis=1)
    return pyvista.PolyData(part.points, lines=lines.ravel())


def _rims(floors: Moving) -> Moving:
    """Return the edges of polygons that bound one of them alone."""
    ends = np.stack([floors.cells, np.roll(floors.cells, -1, axis=1)], axis=-1).reshape(-1, 2)
    lines, counts = np.unique(np.sort(ends, axis=1), axis=0, return_counts=True)
    if (counts > 1).all():  # closed bodies: all edges of their faces
        return Moving(floors.points, lines, floors.displacement)
    return Moving(floors.points, lines[counts == 1], floors.displacement)


def _ground(film: Film) -> Array:
    """Return the corners of a plate below the buildings, wider than they are by a tenth."""
    points = np.concatenate([actor.floors.points for actor in film.actors])
    bars = [actor.bars.points for actor in film.actors if actor.bars.points.size]
    base = min(float(part[:, 2].min()) for part in (points, *bars, *film.plates))
    every = np.concatenate([points, *film.plates])[:, :2]
    low, high = every.min(axis=0), every.max(axis=0)
    more = 0.1 * float((high - low).min())
    (x0, y0), (x1, y1) = low - more, high + more
    return np.array([[x0, y0, base], [x1, y0, base], [x1, y1, base], [x0, y1, base]])


def _look_at(scene: Any, film: Film) -> Picture:
    """Look along the façades, from above, so that the buildings are whole in all frames."""
    bodies = [actor.floors.points for actor in film.actors] + list(film.plates)
    way = bodies[-1].mean(axis=0) - bodies[0].mean(axis=0)
    way[2] = 0.0
    way = way / np.linalg.norm(way) if way.any() else np.array([0.0, 1.0, 0.0])
    if way[0] + way[1] < 0.0:  # x or y points to the right
        way = -way
    view = np.array([way[1] - TURN * way[0], -way[0] - TURN * way[1], RISE])
    right, up = screen_axes(view)
    parts = [part for actor in film.actors for part in (actor.floors, actor.walls, actor.bars)]
    moved = [(one.points + film.factor * one.displacement).reshape(-1, 3) for one in parts]
    every = np.concatenate([*moved, _ground(film), *film.plates])
    flat = np.stack([every @ right, every @ up])
    low, high = flat.min(axis=1), flat.max(axis=1)
    room = np.array([1.0 - 2.0 * SIDE, 1.0 - HEAD - FOOT]) * SIZE
    scale = float((room / (high - low)).min())
    middle = 0.5 * (low + high)
    middle[1] += 0.5 * (HEAD - FOOT) * SIZE[1] / scale
    away = view / np.linalg.norm(view)
    centre = middle[0] * right + middle[1] * up + (every @ away).mean() * away
    far = 4.0 * float(np.ptp(every, axis=0).max())
    scene.enable_parallel_projection()
    scene.camera.up = (0.0, 0.0, 1.0)
    scene.camera.focal_point = tuple(centre)
    scene.camera.position = tuple(centre + far * away)
    scene.camera.parallel_scale = 0.5 * SIZE[1] / scale
    scene.renderer.reset_camera_clipping_range()
    scene.enable_anti_aliasing("msaa")
    corner = (middle[0] - 0.5 * SIZE[0] / scale, middle[1] + 0.5 * SIZE[1] / scale)
    return Picture(np.zeros((SIZE[1], SIZE[0], 3), dtype=np.uint8), right, up, corner, scale)


def _colour_scale(end: float, direction: str) -> Image.Image:
    """Draw the colours with their values [m/s2]."""
    width, height = round(0.62 * SIZE[0]), round(0.1 * SIZE[1])
    scale = Image.new("RGB", (width, height), "white")
    pen = ImageDraw.Draw(scale)
    left, right, top, low = 0.06 * width, 0.94 * width, 0.36 * height, 0.58 * height
    colours = mpl.colormaps[COLOURS].resampled(32)
    for k in range(32):
        ends = [left + (right - left) * share / 32.0 for share in (k, k + 1)]
        colour = tuple(round(255.0 * part) for part in colours(k)[:3])
        pen.rectangle((ends[0], top, ends[1], low), fill=colour)
    pen.rectangle((left, top, right, low), outline=OUTLINE)
    for share, text in ((0.0, "0"), (0.5, f"{0.5 * end:.2g}"), (1.0, f"≥ {end:.2g}")):
        place = left + share * (right - left), low + 3
        pen.text(place, text, fill="black", font=_font(LETTERS - 4), anchor="mt")
    title = f"absolute acceleration, direction {direction} [m/s²]"
    pen.text((0.5 * width, top - 4), title, fill="black", font=_font(LETTERS - 2), anchor="mb")
    return scale


def _write_on(frame: Image.Image, film: Film, view: Picture, k: int) -> None:
    """Write the time, the names of the buildings and the contacts on a frame."""
    pen = ImageDraw.Draw(frame)
    moment = film.times[k]
    text = f"t = {moment:.3f} s   {1e3 * (moment - film.start):+.0f} ms from the main impact"
    pen.text((24, 20), text, fill="black", font=_font(LETTERS), anchor="lt")
    text = f"displacements and gap × {film.factor:g}"
    pen.text((24, 28 + LETTERS), text, fill=OUTLINE, font=_font(LETTERS), anchor="lt")
    for actor in film.actors:
        points = actor.floors.points + film.factor * actor.floors.displacement[k]
        top = points[points[:, 2] > points[:, 2].max() - 0.5]
        x = view.place(top.mean(axis=0)[None])[0, 0]
        y = view.place(top)[:, 1].min() - 12
        pen.text((x, y), actor.name, fill="black", font=_font(LETTERS), anchor="mb")
    largest = max((float(touch.force.max()) for touch in film.touches), default=0.0)
    total = sum(float(touch.force[k]) for touch in film.touches)
    if total > LEAST * largest:
        text = f"contact force {1e-6 * total:.1f} MN"
        place = (SIZE[0] - 24, 28 + LETTERS)
        pen.text(place, text, fill=CONTACT, font=_font(LETTERS), anchor="rt")
    for touch in film.touches:
        if touch.force[k] > LEAST * largest:
            floors = film.actors[touch.actor].floors
            near = int(np.argmin(((floors.points - touch.place) ** 2).sum(axis=1)))
            x, y = view.place((touch.place + film.factor * floors.displacement[k, near])[None])[0]
            radius = DOT * SIZE[0] * float(touch.force[k] / largest) ** 0.5
            pen.ellipse((x - radius, y - radius, x + radius, y + radius), fill=CONTACT)


@cache
def _font(size: int) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(font_manager.findfont("DejaVu Sans"), size)
