import math
from dataclasses import replace

import numpy as np
import pytest

from impactfem.device.anchor_force import anchor_force
from impactfem.device.models import TableMode, from_matrices, from_modes, on_springs
from impactfem.device.modes import device_modes
from impactfem.device.parts import BaseSprings, Beam, RigidBody
from impactfem.dynamics.damping import Rayleigh
from impactfem.sticks.element import COMPONENTS
from impactfem.system.errors import ImpactfemError


def test_names_and_rigid_mass(pump):
    device = pump(Beam(0.46, 8e7, 8e7, mass=50.0, elements=2))
    assert device.motions[:5] == ("base x", "base y", "base rx", "base ry", "beam 0.23 m x")
    assert len(device.motions) == 4 + 2 * 4
    assert np.diag(device.J)[:3] == pytest.approx(1550.0)
    assert device.J[0, 4] == pytest.approx(1500.0 * 0.46 + 50.0 * 0.23)


def test_what_is_free_follows_the_anchor(pump):
    for device in (pump(z=1e9, rz=1e7), pump(Beam(0.46, 8e7, 8e7, mass=50.0), z=1e9, rz=1e7)):
        assert pytest.approx(device.L, abs=1e-8) == device.M @ device.r
        assert pytest.approx(device.J, abs=1e-8) == device.r.T @ device.L
    blocked = pump()
    assert np.abs(blocked.r.T @ blocked.L - blocked.J).max() > 100.0


def test_a_full_stiffness_matrix_turns_with_the_axes():
    """Springs and inertia turned about z by 90 degrees give the same frequencies."""
    k = np.diag([1.0e8, 2.0e8, 5.0e8, 3.0e7, 4.0e7, 2.0e7])
    k[0, 4] = k[4, 0] = 1.0e7
    turn = np.kron(np.eye(2), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    free = np.zeros(6, dtype=bool)
    centre, inertia = np.array([0.1, -0.2, 0.5]), np.diag([10.0, 20.0, 30.0])
    R = turn[:3, :3]
    one = on_springs("a", BaseSprings(k, free), RigidBody(100.0, centre, inertia), 0.02)
    turned = RigidBody(100.0, R @ centre, R @ inertia @ R.T)
    other = on_springs("b", BaseSprings(turn @ k @ turn.T, free), turned, 0.02)
    assert device_modes(one).frequency == pytest.approx(device_modes(other).frequency, rel=1e-10)
    assert one.motions == tuple(f"base {c}" for c in COMPONENTS)


def test_nothing_that_moves_is_refused():
    blocked = BaseSprings.of_directions(**dict.fromkeys(COMPONENTS, math.inf))
    with pytest.raises(ImpactfemError, match="device d: nothing moves"):
        on_springs("d", blocked, RigidBody.at_height(1.0, 0.5, 1.0, 1.0, 1.0), 0.02)


K = 1e6 * np.array([[1.0, -1.0, 0.0], [-1.0, 3.0, -2.0], [0.0, -2.0, 2.0]])
M = np.array([[5.0, 1.0, 0.0], [1.0, 50.0, 0.0], [0.0, 0.0, 7.0]])


def test_a_mass_between_two_anchors():
    device = from_matrices("d", M, K, {0: 1, 2: 7}, 0.02, anchors=2)
    assert device.r[0, [1, 7]] == pytest.approx([1 / 3, 2 / 3])
    assert device.L[0, [1, 7]] == pytest.approx([50 / 3 + 1.0, 100 / 3])
    between = 1e6 * 1.0 * 2.0 / 3.0
    found = device.anchor_stiffness[np.ix_([1, 7], [1, 7])]
    assert found == pytest.approx(between * np.array([[1.0, -1.0], [-1.0, 1.0]]))
    # All of it moving together weighs what the matrix says.
    together = np.zeros(12)
    together[[1, 7]] = 1.0
    assert together @ device.J @ together == pytest.approx(M.sum())
    assert device_modes(device).frequency == pytest.approx([np.sqrt(3e6 / 50.0) / (2 * np.pi)])


def test_one_anchor_has_no_stiffness_of_its_own():
    device = from_matrices("d", M, K, {0: 1}, 0.02)
    assert not device.anchor_stiffness.any()
    assert device.r[:, 1] == pytest.approx([1.0, 1.0])
    assert device.motions == ("degree of freedom 1", "degree of freedom 2")


LOOSE = np.array([[0.0, 0.0, 0.0], [0.0, 2e6, -2e6], [0.0, -2e6, 2e6]])


@pytest.mark.parametrize(
    ("M", "K", "anchored", "motions", "words"),
    [
        (M[:2], K, {0: 1}, None, "one square shape"),
        (M, K, {0: 1, 2: 1}, None, "each of the 6 components"),
        (M, K, {0: 1, 2: 7}, None, "each of the 6 components"),
        (M, K, {0: 1, 3: 2}, None, "degrees of freedom below 3"),
        (M, K, {0: 1}, ("a",), "2 motions need as many names"),
        (M, LOOSE, {0: 1}, ("a", "b"), "a mechanism.* motion a with b"),
    ],
)
def test_bad_input_is_refused(M, K, anchored, motions, words):
    with pytest.raises(ImpactfemError, match=words):
        from_matrices("d", M, K, anchored, 0.02, motions=motions)


TABLE = (
    TableMode(30.51, "y", 1218.9, 0.65),
    TableMode(82.90, "y", 327.0, -0.28, damping=0.05),
    TableMode(40.0, "z", 800.0),
)
BODY = RigidBody.at_height(1600.0, 0.46, 300.0, 300.0, 190.0)


def test_the_table_comes_back():
    found = device_modes(from_modes("pump", TABLE, 0.02))
    assert found.frequency == pytest.approx([30.51, 40.0, 82.90])
    assert found.effective_mass[1] == pytest.approx([1218.9, 0.0, 327.0])
    assert found.effective_mass[2] == pytest.approx([0.0, 800.0, 0.0])
    assert found.height[[0, 2]] == pytest.approx([0.65, -0.28])
    assert found.damping == pytest.approx([0.02, 0.02, 0.05])
    assert np.diag(found.rigid_mass)[1] == pytest.approx(0.0)
    # What the modes leave of the whole device follows rigidly.
    rest = np.diag(device_modes(from_modes("pump", TABLE, 0.02, BODY)).rigid_mass)
    assert rest[:3] == pytest.approx([1600.0, 1600.0 - 1545.9, 800.0])
    law = Rayleigh.through(0.02, 30.0, 80.0)
    assert device_modes(from_modes("pump", TABLE, law)).damping[1] == pytest.approx(law.ratio(40.0))


def test_a_table_of_all_modes_is_the_device(pump, shaking):
    """Modes of the pump, written into a table, push the anchor as the pump does."""
    device = pump()
    modes = device_modes(device)
    rows = []
    for i in range(modes.frequency.size):
        axis = int(np.argmax(modes.share[:2, i]))
        mass = modes.effective_mass[axis, i]
        rows.append(
            TableMode(modes.frequency[i], "xy"[axis], mass, modes.height[i], modes.damping[i])
        )
    table = from_modes("table", rows, 0.02, RigidBody.at_height(1500.0, 0.46, 220.0, 240.0, 190.0))
    motion = shaking()
    wanted = anchor_force(device, motion, 1e-3).force
    found = anchor_force(table, motion, 1e-3).force
    assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9 * np.abs(wanted).max())


def test_more_than_the_mass_is_refused():
    """The paper: 1545.9 kg in the modes of a device of 1500 kg."""
    body = RigidBody.at_height(1500.0, 0.46, 220.0, 240.0, 190.0)
    with pytest.raises(ImpactfemError, match=r"carry 1545.9 kg along y,"):
        from_modes("pump", TABLE, 0.02, body)


@pytest.mark.parametrize(
    ("height", "inertia", "of_modes", "axis"),
    [
        (1.1, (150.0, 150.0, 40.0), 1.2, ""),
        (0.0011, (150.0, 150.0, 40.0), 1.2, "x"),  # mm
        (1.1, (0.0, 150.0, 40.0), 1.2, "x"),
        (1.1, (150.0, 0.0, 40.0), 1.2, "y"),
        (1.1, (150.0, 150.0, 40.0), 0.0012, "x"),  # mm
        (1.1, (150.0, 150.0, 4.0), 1.2, "z"),
    ],
)
def test_modes_that_leave_a_negative_inertia(height, inertia, of_modes, axis):
    """What is at fault is named, with its value: mass centre, inertia, or the table of modes."""
    rows = [TableMode(10.0, "x", 400.0, 0.9 * of_modes), TableMode(11.0, "y", 400.0, of_modes)]
    rows.append(TableMode(30.0, "rz", 20.0))
    body = RigidBody.at_height(450.0, height, *inertia)
    if not axis:
        assert from_modes("cabinet", rows, 0.04, body).J[0, 0] == 450.0
        return
    direction, at = {"x": ("y", of_modes), "y": ("x", 0.9 * of_modes), "z": ("rz", 0.0)}[axis]
    about = inertia["xyz".index(axis)]
    words = (
        f"its modes of direction {direction}, of height {at:g} to {at:g} m, leave .* it has "
        f"450 kg at {height:g} m and {about:g} kg m2 about {axis}; expected another mass_height"
    )
    with pytest.raises(ImpactfemError, match=words):
        from_modes("cabinet", rows, 0.04, body)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"direction": "w"}, "direction 'w': expected one of"),
        ({"frequency": 0.0}, "frequency 0.0 Hz"),
        ({"effective_mass": -1.0}, "effective mass -1.0 kg"),
        ({"height": float("inf")}, "height inf m"),
        ({"damping": 1.0}, "expected 0 <= ratio < 1"),
    ],
)
def test_bad_rows_are_refused(change, words):
    with pytest.raises(ImpactfemError, match=words):
        from_modes("pump", [replace(TABLE[0], **change)], 0.02)
    with pytest.raises(ImpactfemError, match="holds no mode"):
        from_modes("pump", [], 0.02)
