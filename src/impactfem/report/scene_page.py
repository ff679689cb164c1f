"""A page with the building in 3D that one can turn: it needs neither a network nor other files."""

import html
import io
import json
import re
import zipfile
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from jinja2 import Environment
from matplotlib.colors import to_hex

from impactfem.plot.figure import figure
from impactfem.plot.floor_field import COLOURS
from impactfem.plot.scene import (
    FAMILIES,
    OUTLINE,
    balls,
    beam_grid,
    corners,
    impact_view,
    plotter,
    segments,
    shell_grid,
    shell_nodes,
    surface,
)
from impactfem.plot.style import BLUE, GREEN, RED
from impactfem.report.run_files import SCENE
from impactfem.stages.device.model_figures import device_size
from impactfem.stages.device.pictures import standing
from impactfem.stages.device.selection import anchor_of
from impactfem.stages.stores import names_of, open_store, open_stores
from impactfem.system.executor import in_own_process
from impactfem.system.files import atomic

WALL, OPACITY = "#8fb4d9", 0.25
STEPS = 12
"""Colours of the scale between which it is straight."""
FLAT = 1e-6
"""How far vertices of a slab may differ in height [m]."""
BALL = 0.02
"""Radius of what marks a device over the size of the building."""
FAVICONS = re.compile(r"`https?://[^`]*favicon[^`]*`")
"""What the viewer would fetch: its icons."""


@dataclass
class Notes:
    """Notes next to the building."""

    title: str  #: of the page
    entries: list[tuple[str, str]] = field(default_factory=list)  #: label and colour of each part
    #: Label of the scale of colours, and its first and last value; None for one colour.
    scale: tuple[str, float, float] | None = None


@figure("building_scene", "The building in 3D", "The building in 3D", ending="html", in_3d=True)
def write_scene(folder: Path) -> list[Path]:
    """Write `figures/building_scene.html` of a run's folder, in a separate process.

    Slabs have the colours of their peak acceleration where `transient_maps.nc` has it. Impact edges
    are marked, and the devices of `device.nc`. None without `building.nc`. ImpactfemError where the
    file cannot be written, or the process that draws crashed, as it does where OpenGL is missing
    (Debian's libegl1 and libgl1).
    """
    return in_own_process(draw, folder) if (folder / "building.nc").is_file() else []


def draw(folder: Path) -> list[Path]:
    """As `write_scene`, in this process."""
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    scene = plotter()
    with open_store(folder / "building.nc") as building:
        notes = Notes(f"Building {building.attrs.get('building', '')}".strip())
        _slabs(scene, notes, building, folder)
        # Walls that are seen through, the outlines of all shells, beams and columns.
        walls = shell_grid(building, "storey")
        if walls.n_cells:
            scene.add_mesh(_light(surface(walls)), color=WALL, opacity=OPACITY, lighting=False)
            notes.entries.append(("walls", WALL))
        shells = surface(shell_grid(building))
        if shells.n_cells:
            scene.add_mesh(_light(corners(shells)), color=OUTLINE, line_width=1.0)
        for family, colour, width in (("beam", OUTLINE, 1.5), ("column", GREEN, 4.0)):
            lines = beam_grid(building, family)
            if lines.n_cells:
                scene.add_mesh(_light(surface(lines)), color=colour, line_width=width)
                notes.entries.append((FAMILIES[family][0], colour))
        ends = building["node_position"].values[building["edge_line"].values[:, :2]]
        if len(ends):
            scene.add_mesh(_light(segments(ends.reshape(-1, 3))), color=RED, line_width=5.0)
            notes.entries.append(("impact edges", RED))
        if (folder / "device.nc").is_file():
            with open_store(folder / "device.nc") as store:
                # Each device to scale on its anchor, in a ball that is seen from afar.
                size = float(np.ptp(building["node_position"].values, axis=0).max())
                for name in names_of(store, "device"):
                    point, floor, _ = anchor_of(store, name)
                    radius, height = device_size(store, name)
                    scene.add_mesh(_light(standing(point, radius, height)), color=BLUE)
                    ball = balls(point[None] + [0.0, 0.0, 0.5 * height], BALL * size)
                    scene.add_mesh(_light(ball), color=BLUE, opacity=0.4)
                    notes.entries.append((f"{name}, floor {floor}", BLUE))
        scene.view_vector(impact_view(building), viewup=(0.0, 0.0, 1.0))
        scene.reset_camera()
    with atomic(target / SCENE) as temporary:
        temporary.write_text(_page(scene, notes), encoding="utf-8")
    scene.close()
    return [target / SCENE]


def _slabs(scene: Any, notes: Notes, building: xr.Dataset, folder: Path) -> None:
    """The floors, in the colours of their peak acceleration if it is known."""
    grid = shell_grid(building, "floor")
    if not grid.n_cells:
        return
    look: dict[str, Any] = {"color": FAMILIES["floor"][1]}
    if not (folder / "transient_maps.nc").is_file():
        notes.entries.append(FAMILIES["floor"])
    else:
        with open_stores(folder) as opened:
            maps = opened("transient_maps.nc")
            direction = str(opened("transient.nc").attrs["shown_direction"])
            peak = np.full(building.sizes["node"], np.nan)  # off the floors
            peak[maps["node_number"].values] = maps["pfa"].sel(component=direction).values
        grid.point_data["peak"] = peak.astype(np.float32)
        # Of the level triangles, not of a parapet; of all where none is level.
        cells = shell_nodes(building, "floor")[:, :3]
        level = np.ptp(building["node_position"].values[cells, 2], axis=1) < FLAT
        shown = peak[np.unique(cells[level] if level.any() else cells)]
        low, high = float(shown.min()), float(shown.max())
        notes.scale = (f"slabs: peak acceleration along {direction} [m/s²]", low, high)
        look = {"scalars": "peak", "cmap": COLOURS, "clim": (low, high), "show_scalar_bar": False}
    scene.add_mesh(_light(surface(grid)), lighting=False, **look)


def _light(mesh: Any) -> Any:
    """A mesh with nothing but what is shown: less to embed."""
    made = mesh.copy()
    for data in (made.point_data, made.cell_data):
        for name in [name for name in data if name != "peak"]:
            del data[name]
    made.points = np.asarray(made.points, dtype=np.float32)
    return made


def _page(scene: Any, notes: Notes) -> str:
    """The page: the viewer with the scene in it, and the meaning of its colours."""
    # The viewer reads a zip file with a description and all arrays in base64. Not by the plotter's
    # own `export_html`: that starts a web server, and fetches from a network.
    from trame_vtk.modules.vtk.serializers import (
        SynchronizationContext,
        extract_array_hash,
        initialize_serializers,
        reference_id,
        serialize,
    )
    from trame_vtk.tools.vtksz2html import write_html

    initialize_serializers()
    window, camera = scene.render_window, scene.renderer.GetActiveCamera()
    context = SynchronizationContext()
    context.set_ignore_last_dependencies(True)
    described = serialize(None, window, reference_id(window), context, 1)
    described["extra"] = {
        "vtkRefId": reference_id(window),
        "centerOfRotation": camera.GetFocalPoint(),
        "camera": reference_id(camera),
    }
    arrays = {
        entry["hash"]: {**entry, "content": context.get_cached_data_array(entry["hash"], False)}
        for entry in extract_array_hash(described)
    }
    whole, stream = io.BytesIO(), io.StringIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("index.json", json.dumps({"hashes": arrays, "scene": described}))
    write_html(whole.getvalue(), stream)
    text = FAVICONS.sub("`data:,`", stream.getvalue())
    title = f"<title>{html.escape(notes.title)}</title>"
    text = re.sub(r"<title>.*?</title>", lambda _: title, text, count=1)
    # The viewer empties what it draws into: the whole body, unless something is of class content.
    place = '<div class="content" style="position:absolute;inset:0"></div>'
    # Title, legend and scale, over the lower left of the scene.
    template = (files("impactfem.report") / "templates" / "scene.html").read_text("utf-8")
    colours = [to_hex(one) for one in mpl.colormaps[COLOURS](np.linspace(0.0, 1.0, STEPS))]
    environment = Environment(autoescape=True, trim_blocks=True)
    overlay = environment.from_string(template).render(notes=notes, colours=colours)
    return text.replace("</body>", f"{place}\n{overlay}\n</body>", 1)
