"""Pictures of the mesh and of the modes, from a small building that no solver made."""

import numpy as np
import pytest
import xarray as xr
from PIL import Image

from impactfem.stages.building.pictures import open_side
from impactfem.stages.building.stage import BUILDING
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_netcdf

from ..figure_file import draw_all


def house(*, walls=True, lines=True, modes=2):
    """A slab of 4 by 2 m at a height of 3 m on two walls of 2 m and a column.

    The wall at x = 0 has an opening of 1 by 3 m in its middle; that at x = 4 m has none.
    """
    quads = [("floor_1", [[0, 0, 3], [4, 0, 3], [4, 2, 3], [0, 2, 3]])]
    if walls:
        quads += [
            ("storey_1", [[0, y, 0], [0, y + 0.5, 0], [0, y + 0.5, 3], [0, y, 3]])
            for y in (0.0, 1.5)
        ]
        quads.append(("storey_1", [[4, 0, 0], [4, 2, 0], [4, 2, 3], [4, 0, 3]]))
    nodes = []

    def number(point):
        point = [float(x) for x in point]
        if point not in nodes:
            nodes.append(point)
        return nodes.index(point)

    def middle(a, b):
        return number(np.mean([nodes[a], nodes[b]], axis=0))

    names = ["floor_1", "storey_1"]
    triangles, parts = [], []
    for name, corners in quads:
        a, b, c, d = (number(corner) for corner in corners)
        for p, q, r in ((a, b, c), (a, c, d)):
            triangles.append([p, q, r, middle(p, q), middle(q, r), middle(r, p)])
            parts.append(names.index(name))
    foot, head = number([2, 0, 0]), number([2, 0, 3])
    column = [[foot, head, middle(foot, head)]] if lines else np.zeros((0, 3), dtype=int)
    position = np.array(nodes)
    shape = np.zeros((modes, len(nodes), 3))
    shape[:, :, 1] = position[:, 2] * (1.0 + np.arange(modes)[:, None])
    return xr.Dataset(
        {
            "node_position": (("node", "xyz"), position),
            "triangle_node": (("triangle", "triangle_corner"), np.array(triangles)),
            "triangle_part": ("triangle", np.array(parts)),
            "shell_part_name": ("shell_part", names),
            "line_node": (("line", "line_corner"), np.array(column)),
            "line_part": ("line", np.zeros(len(column), dtype=int)),
            "beam_part_name": ("beam_part", ["column_1"]),
            "edge_line": (("edge", "line_corner"), np.zeros((0, 3), dtype=int)),
            "edge_floor": ("edge", np.zeros(0, dtype=int)),
            "shape": (("mode", "node", "xyz"), shape),
            "frequency": ("mode", 2.0 + np.arange(modes)),
            "bending_mode": ("bending", 1 + np.arange(modes)),
        },
        coords={"mode": 1 + np.arange(modes)},
        attrs={"building": "A", "bending_direction": "y"},
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wanted", "names"),
    [
        ({}, ["bending_mode-1.png", "bending_mode-2.png", "mesh.png"]),
        ({"walls": False, "lines": False, "modes": 0}, ["mesh.png"]),
    ],
)
def test_pictures(tmp_path, wanted, names):
    write_netcdf(tmp_path / "building.nc", house(**wanted))
    drawn = draw_all(BUILDING.figures, tmp_path, in_3d=True)
    assert drawn == [tmp_path / "figures" / name for name in names]
    for path in drawn:
        with Image.open(path) as picture:
            assert picture.width > 600 and picture.height > 400
            assert len(picture.convert("RGB").getcolors(maxcolors=10**7)) > 50


def test_no_store(tmp_path):
    with pytest.raises(ImpactfemError, match=r"building\.nc"):
        draw_all(BUILDING.figures, tmp_path, in_3d=True)


def test_the_side_with_most_openings():
    side = open_side(house())
    assert (side.axis, side.at) == ("x", 0.0)
    assert len(side.walls) == 4 and side.opened == pytest.approx(3.0)
    assert side.walls[..., 0].max() == 2.0 and side.walls[..., 1].max() == 3.0
    assert len(side.lines) == 0


def test_a_closed_side_has_no_opening():
    store = house()
    closed = store["node_position"].values[store["triangle_node"].values[:, :3], 0].min(axis=1) > 3
    floor = store["triangle_part"].values == 0
    side = open_side(store.isel(triangle=np.flatnonzero(closed | floor)))
    assert (side.axis, side.at, side.opened) == ("x", 4.0, 0.0)


def test_no_walls():
    assert open_side(house(walls=False)) is None
