from pathlib import Path

import numpy as np
import pytest

from impactfem.building.read_mesh import read_mesh
from impactfem.building.rigid_body import rigid_body
from impactfem.equipment.rosette import find_rosette
from impactfem.errors import SolutionError

GEOMETRY = Path(__file__).parents[2] / "geometry"


@pytest.fixture(scope="module")
def mesh():
    """The shipped frame: slabs of 6 m × 4 m at 3 m and 6 m."""
    return read_mesh(GEOMETRY / "frame.msh")


def test_nodes_within_the_radius(mesh):
    point = np.array([2.1, 1.9, 6.0])
    rosette = find_rosette(mesh, "pump", tuple(point), 0.7)
    away = np.linalg.norm(mesh.nodes - point, axis=1)
    level = np.abs(mesh.nodes[:, 2] - 6.0) < 1e-6
    assert sorted(rosette.nodes) == np.flatnonzero((away <= 0.7) & level).tolist()
    assert rosette.floor == 2 and len(rosette.nodes) > 2
    assert away[rosette.master] == away.min()
    assert rosette.offset == pytest.approx(point - mesh.nodes[rosette.master])


def test_the_anchor_moves_with_the_plate(mesh):
    rosette = find_rosette(mesh, "pump", (2.1, 1.9, 6.02), 0.7)
    master = rigid_body(mesh.nodes[[rosette.master]], np.zeros(3))
    assert rosette.carried @ master == pytest.approx(rigid_body(rosette.point[None], np.zeros(3)))
    assert np.abs(master - rigid_body(rosette.point[None], np.zeros(3))).max() > 0.01


def test_one_node_alone(mesh):
    x, y, z = find_rosette(mesh, "pump", (2.0, 2.0, 3.0), 1.0).point
    node = mesh.nodes[find_rosette(mesh, "pump", (x, y, z), 1.0).master]
    rosette = find_rosette(mesh, "pump", tuple(node), 0.01)
    assert rosette.followers.size == 0 and np.abs(rosette.offset).max() == 0.0
    assert rosette.carried == pytest.approx(np.eye(6))


@pytest.mark.parametrize(
    ("point", "message"),
    [
        (
            (2.0, 1.0, 5.5),
            r"device pump: its anchor at z = 5.5 m is on no floor; .* floor 2, is at 6",
        ),
        ((2.0, 4.5, 6.0), r"no node of floor 2 is within 0.3 m .* nearest one, at \(.*, 4, 6\) m"),
        ((2.0, 4.5, 6.0), r"the anchor stands over a hole or beside the slab, or the mesh is too"),
    ],
)
def test_beside_the_floor(mesh, point, message):
    with pytest.raises(SolutionError, match=message):
        find_rosette(mesh, "pump", point, 0.3)
