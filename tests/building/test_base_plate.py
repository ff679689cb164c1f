from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.building.links import find_base_plate, find_base_plates
from impactfem.building.mesh import rigid_body
from impactfem.building.read_mesh import read_mesh
from impactfem.system.errors import InputError, SolutionError

GEOMETRY = Path(__file__).parents[2] / "geometry"


@pytest.fixture(scope="module")
def mesh():
    """The shipped frame: slabs of 6 m × 4 m at 3 m and 6 m."""
    return read_mesh(GEOMETRY / "frame.msh")


def test_nodes_within_the_radius(mesh):
    point = np.array([2.1, 1.9, 6.0])
    base_plate = find_base_plate(mesh, "pump", tuple(point), 0.7)
    away = np.linalg.norm(mesh.nodes - point, axis=1)
    level = np.abs(mesh.nodes[:, 2] - 6.0) < 1e-6
    assert sorted(base_plate.nodes) == np.flatnonzero((away <= 0.7) & level).tolist()
    assert base_plate.floor == 2 and len(base_plate.nodes) > 2
    assert away[base_plate.master] == away.min()
    assert base_plate.offset == pytest.approx(point - mesh.nodes[base_plate.master])


def test_the_anchor_moves_with_the_plate(mesh):
    base_plate = find_base_plate(mesh, "pump", (2.1, 1.9, 6.02), 0.7)
    master = rigid_body(mesh.nodes[[base_plate.master]], np.zeros(3))
    assert base_plate.carried @ master == pytest.approx(
        rigid_body(base_plate.point[None], np.zeros(3))
    )
    assert np.abs(master - rigid_body(base_plate.point[None], np.zeros(3))).max() > 0.01


def test_one_node_alone(mesh):
    x, y, z = find_base_plate(mesh, "pump", (2.0, 2.0, 3.0), 1.0).point
    node = mesh.nodes[find_base_plate(mesh, "pump", (x, y, z), 1.0).master]
    base_plate = find_base_plate(mesh, "pump", tuple(node), 0.01)
    assert base_plate.followers.size == 0 and np.abs(base_plate.offset).max() == 0.0
    assert base_plate.carried == pytest.approx(np.eye(6))


@pytest.mark.parametrize(
    ("point", "message"),
    [
        (
            (2.0, 1.0, 5.5),
            r"device pump: its anchor at z = 5.5 m is on no floor; .* floor 2, is at 6",
        ),
        ((2.0, 4.1, 6.0), r"at \(2, 4.1\) m stands over a hole of floor 2, or beside its slab"),
    ],
)
def test_beside_the_floor(mesh, point, message):
    with pytest.raises(SolutionError, match=message):
        find_base_plate(mesh, "pump", point, 0.3)


def test_between_the_nodes_of_a_coarse_mesh(mesh):
    corners = mesh.nodes[mesh.triangles[mesh.triangles_of("floor", 2)][0]]
    between = corners.mean(axis=0)
    with pytest.raises(SolutionError, match=r"no node of floor 2 is within 0.001 m .* too coarse"):
        find_base_plate(mesh, "pump", tuple(between), 0.001)


def test_over_a_hole(mesh):
    """Nodes around the hole are within the radius: they do not make a floor below the anchor."""
    centre = np.array([3.0, 2.0, 6.0])
    corners = mesh.nodes[mesh.triangles[:, :3]]
    near = np.linalg.norm(corners.mean(axis=1) - centre, axis=1) < 0.7
    holed = replace(mesh, triangles=mesh.triangles[~near], triangle_part=mesh.triangle_part[~near])
    assert near.sum() > 2 and len(find_base_plate(mesh, "pump", tuple(centre), 1.2).followers) > 2
    with pytest.raises(SolutionError, match=r"device pump: its anchor at \(3, 2\) m stands over a"):
        find_base_plate(holed, "pump", tuple(centre), 1.2)


def wanted(*devices):
    """What a case says of where devices stand: a name and anchors, each a point and a radius."""
    return SimpleNamespace(
        path=Path("case.toml"),
        devices=[
            SimpleNamespace(
                name=name,
                supports=anchors if len(anchors) > 1 else (),
                anchors=[SimpleNamespace(point=p, radius=r) for p, r in anchors],
            )
            for name, *anchors in devices
        ],
    )


def test_every_anchor_of_every_device(mesh):
    pipe = ("pipe", ((1.0, 1.0, 3.0), 0.7), ((1.0, 1.0, 6.0), 0.7))
    found = find_base_plates(wanted(("pump", ((4.0, 2.0, 6.0), 0.7)), pipe), mesh)
    assert [(one.name, one.floor) for one in found] == [
        ("pump", 2),
        ("pipe, support 1", 1),
        ("pipe, support 2", 2),
    ]


def test_all_faults_of_all_anchors(mesh):
    pipe = ("pipe", ((1.0, 1.0, 3.0), 0.7), ((1.0, 9.0, 6.0), 0.7))
    asked = wanted(pipe, ("pump", ((1.2, 1.0, 3.0), 0.7)), ("fan", ((1.0, 1.0, 4.0), 0.7)))
    with pytest.raises(InputError) as caught:
        find_base_plates(asked, mesh)
    faults = {fault.key: fault.expected for fault in caught.value.faults}
    assert set(faults) == {"devices[0].supports[1].point", "devices[1].radius", "devices[2].point"}
    assert (
        "device pipe, support 2: its anchor at (1, 9) m" in faults["devices[0].supports[1].point"]
    )
    assert "pipe, support 1 and pump are 0.2 m apart and tie" in faults["devices[1].radius"]
