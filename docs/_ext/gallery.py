"""The thumbnails of docs/gallery.md: the buildings of each shipped case, from its geometry.

python docs/_ext/gallery.py               # all cases
python docs/_ext/gallery.py tower_pair    # one of them

Nothing is computed. A building with a 3D model is drawn by a coarse mesh, any other one as the
floors of its stick.
"""

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image

from impactfem.building.from_case import geometry_of
from impactfem.building.generate import generate
from impactfem.building.read_mesh import read_mesh
from impactfem.case import Building3D, Case
from impactfem.case.buildings import Building, GeneratedMesh
from impactfem.run.editable_case import EditableCase
from impactfem.system.arrays import Array, Index

ROOT = Path(__file__).parents[2]
CASES = ROOT / "geometry"
PICTURES = ROOT / "docs" / "figures" / "gallery"
NO_CASES = ("_fit", "_report")
"""Ends of the names of files that are no cases."""
WIDTH, HEIGHT = 320, 220
SCALE = 3
"""Pixels of the scene in a pixel of the thumbnail."""
COLOURS = 64
SHELLS, LINE = ("#9fb8d1", "#e6c38f", "#a8cfa6"), "#404040"
"""Colours of the buildings in order, and of edges, beams and columns."""
SOIL = "#c8b08a"
VIEW = (-1.0, -0.45, 0.5)


@dataclass(frozen=True, eq=False)
class Body:
    """A building at its place."""

    points: Array  #: shape (n, 3) [m]
    triangles: Index  #: of shells, shape (m, 3)
    lines: Index  #: of beams and columns, shape (l, 2)
    slabs: tuple[Array, ...]  #: centre and size of boxes, shape (2, 3) [m]
    soil: bool  #: whether its base is a raft on soil


def case_files() -> list[Path]:
    """Return the shipped cases."""
    return [path for path in sorted(CASES.glob("*.toml")) if not path.stem.endswith(NO_CASES)]


def bodies(path: Path) -> list[Body]:
    """Return the buildings of a case."""
    case = EditableCase(path).check()
    drawn = []
    for building in case.buildings:
        modelled = case.modelled.get(building.name)
        drawn.append(_mesh(modelled) if modelled else _stick(case, building))
    return drawn


def _mesh(modelled: Building3D) -> Body:
    building, structure = modelled.entry, modelled.structure
    with TemporaryDirectory() as folder:
        if isinstance(structure.mesh, GeneratedMesh):
            size = {"size": 1.5, "floor_size": None, "storey_size": None}
            size |= {"beam_size": None, "column_size": None}
            coarse = structure.mesh.model_copy(update=size)
            structure = structure.model_copy(update={"mesh": coarse})
            path = Path(folder) / "building.msh"
            generate(geometry_of(replace(modelled, structure=structure)), path)
        else:
            path = structure.mesh.file
        mesh = read_mesh(path)
    low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
    shift = np.array([*building.axis, 0.0]) - 0.5 * (low + high) * [1.0, 1.0, 0.0]
    soil = building.soil is not None
    return Body(mesh.nodes + shift, mesh.triangles[:, :3], mesh.lines[:, :2], (), soil)


def _stick(case: Case, building: Building) -> Body:
    """Return floors as large as the plan, else as the contacts or masses of the building."""
    length, width = building.length, building.width
    if length is None or width is None:
        floor = building.floors[-1]
        a, b = 12.0 * floor.Jy / floor.mass, 12.0 * floor.Jx / floor.mass
        length, width = a**0.5, b**0.5
    x, y = building.axis
    boxes = tuple(np.array([[x, y, z - 0.15], [length, width, 0.3]]) for z in building.elevations)
    plan = [
        (x + 0.5 * i * length, y + 0.5 * j * width) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    points = [(*p, z) for p in plan for z in (building.base, building.elevations[-1])]
    lines = np.arange(8).reshape(-1, 2)
    empty = np.zeros((0, 3), dtype=np.int64)
    return Body(np.array(points), empty, lines, boxes, building.soil is not None)


def draw(drawn: list[Body], path: Path) -> None:
    """Draw buildings as a thumbnail. The process must not have loaded dolfinx."""
    import pyvista

    from impactfem.plot.scene import corners, screen_axes

    size = (SCALE * WIDTH, SCALE * HEIGHT)
    scene = pyvista.Plotter(off_screen=True, window_size=list(size))
    scene.set_background("white")
    every = []
    for k, body in enumerate(drawn):
        colour = SHELLS[k % len(SHELLS)]
        every.append(body.points)
        if len(body.triangles):
            shells = pyvista.PolyData.from_regular_faces(body.points, body.triangles)
            scene.add_mesh(shells, color=colour, ambient=0.5, diffuse=0.5)
            scene.add_mesh(corners(shells), color=LINE, line_width=1.5)
        for centre, extent in body.slabs:
            lengths = dict(zip(("x_length", "y_length", "z_length"), extent, strict=True))
            box = pyvista.Cube(center=centre, **lengths)
            scene.add_mesh(box, color=colour, ambient=0.5, diffuse=0.5, show_edges=True)
        if len(body.lines):
            cells = np.insert(body.lines, 0, 2, axis=1).ravel()
            scene.add_mesh(pyvista.PolyData(body.points, lines=cells), color=LINE, line_width=3.0)
        low, high = body.points.min(axis=0), body.points.max(axis=0)
        if body.soil:
            middle, extent = 0.5 * (low + high), high - low
            place = (middle[0], middle[1], low[2] - 1.0)
            reach = {"x_length": extent[0] + 3.0, "y_length": extent[1] + 3.0, "z_length": 2.0}
            scene.add_mesh(pyvista.Cube(center=place, **reach), color=SOIL)
            every.append(np.array([[*low[:2] - 1.5, low[2] - 2.0], [*high[:2] + 1.5, low[2]]]))
    points = np.concatenate(every)
    view = np.array(VIEW)
    right, up = screen_axes(view)
    x, y = points @ right, points @ up
    scale = min(0.94 * size[0] / np.ptp(x), 0.94 * size[1] / np.ptp(y))
    away = view / np.linalg.norm(view)
    centre = 0.5 * (x.min() + x.max()) * right + 0.5 * (y.min() + y.max()) * up
    centre = centre + (points @ away).mean() * away
    scene.enable_parallel_projection()
    scene.camera.up = (0.0, 0.0, 1.0)
    scene.camera.focal_point = tuple(centre)
    scene.camera.position = tuple(centre + 4.0 * np.ptp(points, axis=0).max() * away)
    scene.camera.parallel_scale = 0.5 * size[1] / scale
    scene.renderer.reset_camera_clipping_range()
    picture = Image.fromarray(np.asarray(scene.screenshot(return_img=True), dtype=np.uint8))
    scene.close()
    small = picture.resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)
    small.quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def main(names: list[str]) -> None:
    """Draw the thumbnails of cases; of all without names."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    for path in case_files():
        if not names or path.stem in names:
            draw(bodies(path), PICTURES / f"{path.stem}.png")


if __name__ == "__main__":
    main(sys.argv[1:])
