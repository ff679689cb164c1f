"""Forces in the bolts of a base plate: equilibrium, closed forms, critical direction."""

import math
from dataclasses import replace

import numpy as np
import pytest

from impactfem.device.bolts import (
    BoltGroup,
    bolt_demand,
    bolt_forces,
    rectangular_plate,
    rotated,
    round_plate,
)
from impactfem.system.errors import SolutionError

ECCENTRIC = np.array([[0.30, 0.20], [-0.30, 0.25], [-0.35, -0.20], [0.25, -0.30], [0.1, 0.35]])
AREA = 245e-6


@pytest.fixture
def group():
    """Five bolts without symmetry on a rectangular plate."""
    return BoltGroup(
        ECCENTRIC, AREA, rectangular_plate(0.9, 0.8), tension=141e3, shear=94e3, exponent=1.5
    )


def noise(samples=400, seed=3):
    """Forces and moments of which some lift the plate, and some press all of it."""
    scale = np.array([50e3, 50e3, 40e3, 30e3, 30e3, 5e3])[:, None]
    return np.random.default_rng(seed).standard_normal((6, samples)) * scale


def resultant(group, forces):
    """Force and moments that bolts and pressure exert against the device, shape (6, n_t)."""
    (x, y), T, S, P = group.position.T, forces.tension, forces.shear, forces.pressure
    return np.array(
        [
            S[0].sum(axis=0),
            S[1].sum(axis=0),
            T.sum(axis=0) - P[0],
            y @ T - P[1],
            -x @ T - P[2],
            x @ S[1] - y @ S[0],
        ]
    )


@pytest.mark.parametrize("plate", [rectangular_plate(0.9, 0.8), round_plate(0.5)])
def test_forces_and_moments_are_in_equilibrium(group, plate):
    one = replace(group, plate=plate)
    force = noise()
    forces = bolt_forces(one, force)
    off = np.abs(resultant(one, forces) - force).max(axis=1)
    assert (off <= 1e-12 * np.abs(force).max(axis=1)).all()
    assert (forces.tension >= 0.0).all() and (forces.pressure[0] >= 0.0).all()
    # Both sides of the model are at work.
    assert (forces.pressure[0] > 0.0).any() and (forces.tension.min(axis=0) > 0.0).any()


def test_a_wrong_sign_of_a_moment_is_no_equilibrium(group):
    force = noise()
    forces = bolt_forces(group, force * np.array([1, 1, 1, 1, -1, 1])[:, None])
    off = np.abs(resultant(group, forces) - force).max(axis=1)
    assert off[4] > 0.1 * np.abs(force[4]).max()


def test_eccentric_bolts_in_tension_by_the_closed_form(group):
    """Without contact: N / m and the moments about the centroid, with the product of inertia."""
    N, Mx, My = 400e3, 6e3, -4e3
    forces = bolt_forces(group, np.array([[0.0], [0.0], [N], [Mx], [My], [0.0]]))
    cx, cy = ECCENTRIC.mean(axis=0)
    x, y = (ECCENTRIC - (cx, cy)).T
    a, b = Mx - cy * N, My + cx * N
    Ixx, Iyy, Ixy = x @ x, y @ y, x @ y
    det = Ixx * Iyy - Ixy**2
    expected = N / 5 + ((a * Ixx + b * Ixy) * y - (b * Iyy + a * Ixy) * x) / det
    assert forces.tension[:, 0] == pytest.approx(expected, rel=1e-12)
    assert forces.pressure[:, 0] == pytest.approx(np.zeros(3), abs=1e-9)


def test_eccentric_bolts_in_shear_by_the_closed_form(group):
    Fx, Fy, Mz = 30e3, -20e3, 4e3
    forces = bolt_forces(group, np.array([[Fx], [Fy], [-1e5], [0.0], [0.0], [Mz]]))
    cx, cy = ECCENTRIC.mean(axis=0)
    x, y = (ECCENTRIC - (cx, cy)).T
    torsion = Mz - (cx * Fy - cy * Fx)
    J = (x**2 + y**2).sum()
    assert forces.shear[0, :, 0] == pytest.approx(Fx / 5 - torsion * y / J, rel=1e-12)
    assert forces.shear[1, :, 0] == pytest.approx(Fy / 5 + torsion * x / J, rel=1e-12)


@pytest.mark.parametrize("N", [0.0, -30e3, 20e3])
def test_neutral_axis_of_a_rectangular_plate_by_the_closed_form(N):
    """Two rows of two bolts under a moment about x, as a cracked section of reinforced concrete."""
    b, h, d, n = 0.6, 0.8, 0.3, 7.0
    places = np.array([[0.2, d], [-0.2, d], [0.2, -d], [-0.2, -d]])
    group = BoltGroup(places, AREA, rectangular_plate(b, h), n)
    M = 25e3
    forces = bolt_forces(group, np.array([[0.0], [0.0], [N], [M], [0.0], [0.0]]))
    T = forces.tension[:, 0]
    assert T[::2] == pytest.approx(T[1::2], rel=1e-9, abs=1e-6)
    # Equilibrium gives pressure C and the depth c of its triangle, whose centre is at c / 3.
    C = T.sum() - N
    depth = 3.0 * (0.5 * h - (M - 2.0 * (T[0] - T[2]) * d) / C)
    # Strains of the bolts over that of the edge, which is 2 C / (b c), are as their distances.
    edge = 2.0 * C / (b * depth)
    for force, y in ((T[0], d), (T[2], -d)):
        strain = edge * max(0.5 * h + y - depth, 0.0) / depth
        assert force / (n * AREA) == pytest.approx(strain, rel=1e-9, abs=1e-3)
    assert 0.0 < depth < h and T[0] > T[2]
    assert forces.pressure[0, 0] == pytest.approx(C, rel=1e-12)


def test_compression_in_the_kern_pulls_no_bolt():
    group = BoltGroup(0.8 * ECCENTRIC, AREA, rectangular_plate(0.9, 0.6))
    for e, pulled in ((0.099, False), (0.12, True)):  # the kern ends at 0.6 m / 6
        forces = bolt_forces(group, np.array([[0.0], [0.0], [-1e5], [1e5 * e], [0.0], [0.0]]))
        assert (forces.tension.max() > 0.0) == pulled


def test_forces_grow_with_the_load(group):
    force = noise(50)
    one, twice = bolt_forces(group, force), bolt_forces(group, 2.0 * force)
    assert twice.tension == pytest.approx(2.0 * one.tension, rel=1e-9, abs=1e-6)


def test_no_load_is_no_force(group):
    forces = bolt_forces(group, np.zeros((6, 3)))
    assert not forces.tension.any() and not forces.shear.any()


def test_two_bolts_in_a_line_with_contact():
    """A moment about the line of the bolts is carried by pressure against the plate's edge."""
    group = BoltGroup(np.array([[-0.3, 0.0], [0.3, 0.0]]), AREA, rectangular_plate(0.8, 0.4))
    force = np.array([[0.0], [0.0], [10e3], [3e3], [0.0], [0.0]])
    forces = bolt_forces(group, force)
    assert resultant(group, forces) == pytest.approx(force, abs=1e-7)
    assert forces.tension[0, 0] == pytest.approx(forces.tension[1, 0])
    # The lever arm is less than half of the width.
    assert forces.tension.sum() > 10e3 + 3e3 / 0.2


def test_round_plate_has_the_area_of_the_circle():
    x, y = round_plate(0.5).T
    area = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    assert area == pytest.approx(math.pi * 0.25, rel=1e-12)


def test_interaction(group):
    forces = bolt_forces(group, noise(20))
    T, V = forces.tension, np.hypot(*forces.shear)
    expected = (T / 141e3) ** 1.5 + (V / 94e3) ** 1.5
    assert forces.interaction(group) == pytest.approx(expected)


def test_critical_direction_by_the_closed_form(group):
    """Without contact T_i = N / m + g_i · M about the centroid: M is turned along g_i."""
    N, M = 400e3, 5e3
    time = np.linspace(0.0, 1.0, 101)
    force = np.zeros((6, time.size))
    force[2], force[3] = N, M * np.sin(np.pi * time)
    found = bolt_demand(replace(group, shear=1e12), force, time)
    cx, cy = ECCENTRIC.mean(axis=0)
    x, y = (ECCENTRIC - (cx, cy)).T
    Ixx, Iyy, Ixy = x @ x, y @ y, x @ y
    g = np.array([Ixx * y - Ixy * x, Ixy * y - Iyy * x]) / (Ixx * Iyy - Ixy**2)
    largest = N / 5 + g.T @ (-cy * N, cx * N) + M * np.hypot(*g)
    k = int(largest.argmax())
    direction = math.degrees(math.atan2(g[1, k], g[0, k])) % 360.0
    assert abs(found.direction - direction) <= 1.0
    assert (found.bolt, found.time) == (k + 1, pytest.approx(0.5))
    assert found.tension == pytest.approx(largest[k], rel=2e-4)
    assert found.interaction > found.interaction_as_computed


def test_critical_direction_against_all_directions(group):
    force = noise(60, seed=5)
    found = bolt_demand(group, force, np.arange(60) * 0.01)
    every = [bolt_forces(group, rotated(force, k)).interaction(group).max() for k in range(360)]
    assert found.direction == int(np.argmax(every))
    assert found.interaction == pytest.approx(max(every), rel=1e-9)
    assert found.interaction_as_computed == pytest.approx(every[0], rel=1e-9)
    at = bolt_forces(group, rotated(force, found.direction)).interaction(group)
    bolt, instant = np.unravel_index(at.argmax(), at.shape)
    assert (found.bolt, found.time) == (bolt + 1, pytest.approx(0.01 * instant))


def test_direction_of_a_round_pattern_does_not_matter():
    at = 2.0 * math.pi * np.arange(24) / 24
    place = 0.4 * np.stack([np.cos(at), np.sin(at)], axis=1)
    group = BoltGroup(place, AREA, round_plate(0.5), tension=1e5, shear=1e5)
    found = bolt_demand(group, noise(30), np.arange(30) * 0.01)
    assert found.interaction == pytest.approx(found.interaction_as_computed, rel=0.02)


def test_bolts_along_the_edge_of_a_plate_cannot_hold_it():
    """Without plate beyond the bolts nothing balances the moment that lifts the other side."""
    place = np.array([[-0.4, -0.3], [-0.4, 0.3]])
    group = BoltGroup(place, AREA, rectangular_plate(0.8, 0.8))
    with pytest.raises(SolutionError):
        bolt_forces(group, np.array([[0.0], [0.0], [50e3], [0.0], [0.0], [0.0]]))
    # On the other side the plate presses against the floor.
    assert (
        bolt_forces(group, np.array([[0.0], [0.0], [0.0], [0.0], [9e3], [0.0]])).tension.min() > 0
    )
