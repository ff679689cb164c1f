import math

import numpy as np
import pytest

from impactfem.device.beam import Beam
from impactfem.device.body import Body
from impactfem.device.modes import device_modes
from impactfem.device.on_springs import on_springs
from impactfem.device.springs import COMPONENTS, BaseSprings
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


def test_a_stiff_beam_is_a_rigid_body(pump):
    stiff = device_modes(pump(Beam(0.46, 1e14, 1e14, elements=1)))
    rigid = device_modes(pump())
    assert stiff.frequency[:4] == pytest.approx(rigid.frequency, rel=1e-5)
    soft = device_modes(pump(Beam(0.46, 1e8, 1e8, elements=1)))
    assert np.all(soft.frequency[:4] < 0.99 * rigid.frequency)


def test_a_full_stiffness_matrix_turns_with_the_axes():
    """Springs and inertia turned about z by 90 degrees give the same frequencies."""
    k = np.diag([1.0e8, 2.0e8, 5.0e8, 3.0e7, 4.0e7, 2.0e7])
    k[0, 4] = k[4, 0] = 1.0e7
    turn = np.kron(np.eye(2), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    free = np.zeros(6, dtype=bool)
    centre, inertia = np.array([0.1, -0.2, 0.5]), np.diag([10.0, 20.0, 30.0])
    R = turn[:3, :3]
    one = on_springs("a", BaseSprings(k, free), Body(100.0, centre, inertia), 0.02)
    turned = Body(100.0, R @ centre, R @ inertia @ R.T)
    other = on_springs("b", BaseSprings(turn @ k @ turn.T, free), turned, 0.02)
    assert device_modes(one).frequency == pytest.approx(device_modes(other).frequency, rel=1e-10)
    assert one.motions == tuple(f"base {c}" for c in COMPONENTS)


def test_nothing_that_moves_is_refused():
    blocked = BaseSprings.of_directions(**dict.fromkeys(COMPONENTS, math.inf))
    with pytest.raises(ImpactfemError, match="device d: nothing moves"):
        on_springs("d", blocked, Body.at_height(1.0, 0.5, 1.0, 1.0, 1.0), 0.02)


def test_a_point_mass_has_one_mode_a_plane():
    springs = BaseSprings.of_directions(
        x=math.inf, y=2.0e6, z=math.inf, rx=1.0e6, ry=math.inf, rz=math.inf
    )
    point = on_springs("p", springs, Body.at_height(100.0, 0.8, 0.0, 0.0, 0.0), 0.02)
    give = 1.0 / 2.0e6 + 0.8**2 / 1.0e6
    assert device_modes(point).frequency == pytest.approx([1 / (2 * np.pi * np.sqrt(100.0 * give))])
