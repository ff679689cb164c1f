from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from impactfem import building
from impactfem.building.links import (
    BasePlate,
    Displacements,
    RigidLink,
    carried,
    find_base_plates,
    linked,
)
from impactfem.building.mesh import Part, rigid_body
from impactfem.building.section import BeamSection
from impactfem.case.devices import NODES
from impactfem.system.errors import InputError, SolutionError

E, G = 33e9, 33e9 / 2.4
H, ARM, REACH = 4.0, 0.7, 1.5
COLUMN = BeamSection.column(0.8, 1.2)
BEAM = BeamSection.beam(0.3, 0.5)


@pytest.fixture
def arm(panels, assembled):
    """A column of 4 m, and a beam of 1.5 m along x that starts 0.7 m beside the column's top."""
    panels.line((0, 0, 0), (0, 0, H), 3, Part("column", 1), COLUMN)
    panels.line((ARM, 0, H), (ARM + REACH, 0, H), 2, Part("beam", 1), BEAM)
    parts = panels.parts(base=panels.at((2, 0.0)))
    model = assembled(parts)
    top, start, end = (panels.node(np.array([x, 0.0, H])) for x in (0, ARM, ARM + REACH))
    return model, parts.mesh.nodes, top, start, end


def tip(arm, csr, axis, load=1e6):
    """Displacements of the beam's end under a force there, by the linked model."""
    model, X, top, start, end = arm
    small, T = linked(model, [RigidLink(top, np.array([start]))], X)
    row = small.rows(np.array([end]))[0]
    f = np.zeros(small.n_free)
    f[row + axis] = load
    w = spsolve(csr(small.stiffness()), f)
    return w[row : row + 3], csr(T) @ w


def test_a_force_down_the_column(arm, csr):
    """w = P (H/(E A) + a² H/(E I) + b³/(3 E I_b) + b/(k G A_b)), a the arm of P at the column."""
    w, _ = tip(arm, csr, 2)
    a = ARM + REACH
    exact = 1e6 * (
        H / (E * COLUMN.A)
        + a**2 * H / (E * COLUMN.I2)
        + REACH**3 / (3.0 * E * BEAM.I1)
        + REACH / (BEAM.k2 * G * BEAM.A)
    )
    assert w[2] == pytest.approx(exact, rel=1e-9)
    # The column's top turns by M H/(E I) and moves along x by M H²/(2 E I), with M = −P a.
    assert w[0] == pytest.approx(-1e6 * a * H**2 / (2.0 * E * COLUMN.I2), rel=1e-9)


def test_a_force_on_a_follower_acts_on_its_master(arm):
    model, X, top, start, end = arm
    small, T = linked(model, [RigidLink(top, np.array([start]))], X)
    forces = np.zeros((model.n_free, 2))
    row, last = model.rows(np.array([start, end]))
    forces[row + 2, 0] = 3.0  # upwards on the follower, the arm beside the master
    forces[last : last + 3, 1] = 1.0, 2.0, 3.0  # on a node without a link
    found = carried(T, forces)
    master, free = small.rows(np.array([top, end]))
    assert found[master : master + 6, 0] == pytest.approx([0, 0, 3.0, 0, -3.0 * ARM, 0])
    assert np.count_nonzero(np.abs(found[:, 0]) > 1e-12) == 2
    assert found[free : free + 3, 1] == pytest.approx([1.0, 2.0, 3.0])
    # Without it the force is lost: the small building has no row for it.
    assert small.rows(np.array([start]))[0] < 0


def test_the_follower_moves_with_the_master(arm, csr):
    model, X, top, start, _ = arm
    _, every = tip(arm, csr, 1)
    rows = model.rows(np.array([top, start]))
    master, follower = (every[row : row + 6] for row in rows)
    assert follower[3:] == pytest.approx(master[3:], rel=1e-13)
    expected = master[:3] + np.cross(master[3:], X[start] - X[top])
    assert follower[:3] == pytest.approx(expected, rel=1e-13, abs=1e-18)
    assert np.abs(follower[:3] - master[:3]).max() > 1e-4


@pytest.mark.parametrize("at_once", [5, 32768])
@pytest.mark.parametrize("with_links", [True, False])
def test_displacements_of_any_nodes(arm, csr, with_links, at_once, monkeypatch):
    """Of a follower, its master, a clamped node and another one, in an order of no meaning."""
    monkeypatch.setattr(building.links, "AT_ONCE", at_once)
    model, X, top, start, end = arm
    links = [RigidLink(top, np.array([start]))] if with_links else []
    small, T = linked(model, links, X)
    w = np.random.default_rng(1).standard_normal((small.n_free, 2))
    every = csr(T) @ w
    nodes = np.array([end, start, int(np.argmin(np.linalg.norm(X, axis=1))), top])
    rows = model.rows(nodes)
    assert (rows >= 0).tolist() == [True, True, False, True]
    expected = [every[row : row + 3] if row >= 0 else np.zeros((3, 2)) for row in rows]
    displacements = Displacements(small, nodes, links, X)
    np.testing.assert_allclose(displacements.of(lambda here: w[here]), expected, atol=1e-14)
    np.testing.assert_allclose(
        displacements.columns.T @ w, np.reshape(expected, (-1, 2)), atol=1e-14
    )
    if with_links:
        with pytest.raises(ValueError, match="coordinates"):
            Displacements(small, nodes, links)


def test_what_the_smaller_model_is(arm, csr):
    model, X, top, start, _ = arm
    small, T = linked(model, [RigidLink(top, np.array([start]))], X)
    assert sorted(small.nodes) == sorted(set(model.nodes) - {start})
    assert small.coordinates.tolist() == X[small.nodes].tolist()
    assert small.n_free == model.n_free - 6
    t = csr(T)
    # Rigid-body motions of the kept nodes are those of all, and so are total and ground.
    assert t @ small.rigid_body() == pytest.approx(model.rigid_body(), abs=1e-13)
    assert small.ground == pytest.approx(t.T @ model.ground, abs=1e-9)
    for one, two in ((small.mass, model.mass), (small.stiffness(), model.stiffness())):
        full = (t.T @ csr(two) @ t).toarray()
        assert csr(one).toarray() == pytest.approx(full, rel=1e-12, abs=1e-12 * abs(full).max())


@pytest.mark.parametrize(
    ("links", "message"),
    [
        ([(0, [1]), (2, [1])], "a node follows two masters, one of them 2"),
        ([(0, [1, 1])], "a node follows two masters"),
        ([(0, [1]), (1, [2])], "node 1 follows another one and cannot be a master"),
        ([(0, [0])], "node 0 follows another one and cannot be a master"),
        ([(3, [1])], "node 3 is clamped and cannot be part of a rigid link"),
        ([(0, [3])], "node 3 is clamped"),
    ],
)
def test_what_cannot_be_linked(panels, assembled, links, message):
    for x in range(4):
        panels.node(np.array([float(x), 0.0, 0.0]))
    panels.line((0, 0, 0), (3, 0, 0), 3, Part("beam", 1), BEAM)
    parts = panels.parts(base=[3])
    made = [RigidLink(master, np.array(followers)) for master, followers in links]
    with pytest.raises(SolutionError, match=message):
        linked(assembled(parts), made, parts.mesh.nodes)


def test_nodes_within_the_radius(frame):
    point = np.array([2.1, 1.9, 6.0])
    base_plate = BasePlate.find(frame, "pump", tuple(point), 0.7)
    away = np.linalg.norm(frame.nodes - point, axis=1)
    level = np.abs(frame.nodes[:, 2] - 6.0) < 1e-6
    assert sorted(base_plate.nodes) == np.flatnonzero((away <= 0.7) & level).tolist()
    assert base_plate.floor == 2 and len(base_plate.nodes) > 2
    assert base_plate.least_radius == pytest.approx(np.sort(away[level])[NODES - 1])
    assert base_plate.least_radius < 0.7
    assert away[base_plate.master] == away.min()
    assert base_plate.offset == pytest.approx(point - frame.nodes[base_plate.master])


def test_the_anchor_moves_with_the_plate(frame):
    base_plate = BasePlate.find(frame, "pump", (2.1, 1.9, 6.02), 0.7)
    master = rigid_body(frame.nodes[[base_plate.master]], np.zeros(3))
    assert base_plate.carried @ master == pytest.approx(
        rigid_body(base_plate.point[None], np.zeros(3))
    )
    assert np.abs(master - rigid_body(base_plate.point[None], np.zeros(3))).max() > 0.01


def test_one_node_alone(frame):
    x, y, z = BasePlate.find(frame, "pump", (2.0, 2.0, 3.0), 1.0).point
    node = frame.nodes[BasePlate.find(frame, "pump", (x, y, z), 1.0).master]
    base_plate = BasePlate.find(frame, "pump", tuple(node), 0.01)
    assert base_plate.followers.size == 0 and np.abs(base_plate.offset).max() == 0.0
    assert base_plate.carried == pytest.approx(np.eye(6))


@pytest.mark.parametrize(
    ("point", "radius", "message"),
    [
        ((2.0, 1.0, 5.5), 0.3, r"its anchor at z = 5.5 m is on no floor; .* floor 2, is at 6"),
        (
            (2.0, 4.1, 6.0),
            0.3,
            r"at \(2, 4.1\) m stands over a hole of floor 2, or beside its slab",
        ),
        (None, 0.001, r"no node of floor 2 is within 0.001 m .* type a radius"),
    ],
)
def test_where_no_plate_fits(frame, point, radius, message):
    if point is None:  # between the nodes
        point = frame.nodes[frame.triangles[frame.triangles_of("floor", 2)][0]].mean(axis=0)
    with pytest.raises(SolutionError, match=f"device pump: .*{message}"):
        BasePlate.find(frame, "pump", tuple(point), radius)


def test_over_a_hole(frame):
    """Nodes around the hole are within the radius: they do not make a floor below the anchor."""
    centre = np.array([3.0, 2.0, 6.0])
    corners = frame.nodes[frame.triangles[:, :3]]
    near = np.linalg.norm(corners.mean(axis=1) - centre, axis=1) < 0.7
    holed = replace(
        frame, triangles=frame.triangles[~near], triangle_part=frame.triangle_part[~near]
    )
    assert near.sum() > 2 and len(BasePlate.find(frame, "pump", tuple(centre), 1.2).followers) > 2
    with pytest.raises(SolutionError, match=r"anchor at \(3, 2\) m stands"):
        BasePlate.find(holed, "pump", tuple(centre), 1.2)


def wanted(*devices):
    """What a case says of where devices stand: a name and anchors, each a point and a radius."""
    return SimpleNamespace(
        case=SimpleNamespace(path=Path("case.toml")),
        numbered_devices=[
            (
                index,
                SimpleNamespace(
                    name=name,
                    supports=anchors if len(anchors) > 1 else (),
                    anchor_points=[SimpleNamespace(point=p, radius=r) for p, r in anchors],
                ),
            )
            for index, (name, *anchors) in enumerate(devices)
        ],
    )


def test_every_anchor_of_every_device(frame):
    pipe = ("pipe", ((1.0, 1.0, 3.0), 0.7), ((1.0, 1.0, 6.0), 0.7))
    found = find_base_plates(wanted(("pump", ((4.0, 2.0, 6.0), 0.7)), pipe), frame)
    assert [(one.name, one.floor) for one in found] == [
        ("pump", 2),
        ("pipe, support 1", 1),
        ("pipe, support 2", 2),
    ]


def test_all_faults_of_all_anchors(frame):
    pipe = ("pipe", ((1.0, 1.0, 3.0), 0.7), ((1.0, 9.0, 6.0), 0.7))
    asked = wanted(pipe, ("pump", ((1.2, 1.0, 3.0), 0.7)), ("fan", ((1.0, 1.0, 4.0), 0.7)))
    with pytest.raises(InputError) as caught:
        find_base_plates(asked, frame)
    faults = {fault.key: fault.expected for fault in caught.value.faults}
    assert set(faults) == {"devices[0].supports[1].point", "devices[1].radius", "devices[2].point"}
    assert "2: its anchor at (1, 9) m" in faults["devices[0].supports[1].point"]
    assert "1 and pump are 0.2 m" in faults["devices[1].radius"]
