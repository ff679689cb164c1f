"""Patterns and amplitudes of the ground motion and of the impact forces."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import trapezoid

from impactfem.coupling.force_history import ForceHistory
from impactfem.reduction.edge_force import EdgeForce
from impactfem.reduction.loads import make_loads, project

TIME = np.linspace(0.0, 1.0, 101)
HUMP = 1e5 * np.sin(np.pi * TIME) ** 2
MOTION = [(1, 0.1, np.array([0.0, 1.0, -1.0, 0.0]))]


def edge(floor, *direction):
    x, y, z = direction
    return EdgeForce(f"floor {floor}", floor, (x, y, z))


def made(*pairs, steps=50):
    names = tuple(f"pair {k}" for k in range(len(pairs)))
    force = np.array([force for _, force in pairs]).reshape(-1, len(TIME)).T
    history = ForceHistory(TIME, names, force)
    return make_loads(MOTION, history, [((e, 1.0),) for e, _ in pairs], 0.02, steps)


def test_each_edge_is_a_load():
    loads = made((edge(2, 0, -1, 0), HUMP), (edge(1, 0, -1, 0), 2 * HUMP))
    assert loads.names == ("ground y", "floor 2", "floor 1")
    assert loads.amplitudes.shape == (51, 3)
    assert loads.force[:, 1] == pytest.approx(2 * loads.force[:, 0])
    assert loads.amplitudes[:, 0].tolist() == loads.ground[:, 1].tolist()
    assert loads.impulse_error < 1e-13
    assert trapezoid(loads.force, dx=0.02, axis=0) == pytest.approx([5e4, 1e5], rel=1e-6)


def test_ground_motion_between_its_samples_and_after_its_end():
    motions = [(2, 0.1, np.array([0.0, 1.0, -1.0, 0.0])), (0, 0.5, np.array([1.0, 1.0, 1.0]))]
    loads = make_loads(motions, ForceHistory(TIME, (), np.zeros((101, 0))), [], 0.05, 8)
    assert loads.names == ("ground x", "ground z")
    assert loads.ground[:, 2] == pytest.approx([0, 0.5, 1, 0, -1, -0.5, 0, 0, 0], abs=1e-12)
    assert loads.ground[:, 0] == pytest.approx(np.ones(9)) and not loads.ground[:, 1].any()
    assert loads.amplitudes.tolist() == loads.ground[:, [0, 2]].tolist()


def test_ground_that_waves_reach_later():
    """By one and a half steps, the forces at their own times; not by a whole number of them."""
    history = ForceHistory(TIME, (), np.zeros((101, 0)))
    ramp = [(1, 0.1, np.array([0.0, 1.0, 0.0]))]
    loads = make_loads(ramp, history, [], 0.05, 6, delay=0.075)
    assert loads.ground[:, 1] == pytest.approx([0, 0, 0.25, 0.75, 0.75, 0.25, 0])
    assert make_loads(ramp, history, [], 0.05, 6).ground[:3, 1] == pytest.approx([0, 0.5, 1])


def test_pairs_on_one_edge_are_the_same_load():
    up = edge(2, 0, -1, 0)
    three = made((up, HUMP), (edge(1, 0, -1, 0), HUMP), (up, 3 * HUMP))
    assert three.names == ("ground y", "floor 2", "floor 1")
    assert three.force[:, 0] == pytest.approx(4 * three.force[:, 1])


def test_different_patterns_of_one_name_are_refused():
    """Their amplitudes could not be told apart."""
    with pytest.raises(ValueError, match="ground y, floor 2, floor"):
        made((edge(2, 0, -1, 0), HUMP), (edge(2, 1, 0, 0), HUMP))


def test_unused_pairs_have_no_pattern():
    late = np.where(TIME > 0.5, HUMP, 0.0)
    pairs = (edge(1, 0, -1, 0), 0 * HUMP), (edge(2, 0, -1, 0), HUMP), (edge(3, 0, -1, 0), late)
    assert made(*pairs).names == ("ground y", "floor 2", "floor 3")
    # What does not act within the time that is computed does not count.
    assert made(*pairs, steps=25).names == ("ground y", "floor 2")


@pytest.mark.parametrize("pairs", [(), ((edge(1, 0, -1, 0), 0 * HUMP),)])
def test_ground_motion_alone(pairs):
    loads = made(*pairs)
    assert (loads.names, loads.force.shape, loads.impulse_error) == (("ground y",), (51, 0), 0.0)


def test_a_lost_impulse_is_told(monkeypatch):
    """Of a force that the 3D step cannot follow nothing is lost; the check sees what would be."""
    spike = np.where(np.arange(101) == 31, 1e6, 1e3)
    loads = made((edge(1, 0, -1, 0), spike))
    assert loads.impulse_error < 1e-12
    assert trapezoid(loads.force[:, 0], dx=0.02) == pytest.approx(1.099e4, rel=1e-12)

    def interpolated(time, values, step, n):
        return np.interp(step * np.arange(n + 1), time, values[:, 0])[:, None]

    monkeypatch.setattr("impactfem.reduction.loads.project", interpolated)
    assert made((edge(1, 0, -1, 0), spike)).impulse_error == pytest.approx(0.999 / 1.099)


def test_patterns_push_and_turn_as_they_are_asked_to(frame, loads):
    """By virtual work on rigid-body motions about the middle of the edge of floor 2."""
    patterns = loads.patterns(frame.model, frame.parts.mesh)
    assert patterns.shape == (frame.model.ground.shape[0], 3)
    work = frame.model.rigid_body((3.0, 4.0, 6.0)).T @ patterns
    assert work[:, 1] == pytest.approx([0, -1, 0, 0, 0, -0.3], abs=1e-12)
    # Floor 1 is 3 m below: its force turns about x, too.
    assert work[:, 2] == pytest.approx([0, -1, 0, -3, 0, -0.3], abs=1e-12)
    # The clamped base takes part of the mass.
    mass = frame.model.total[1, 1]
    assert 0.95 * mass < -work[1, 0] < mass
    assert np.array_equal(patterns[:, 0], -frame.model.ground[:, 1])


def test_patterns_of_a_floor_without_an_edge(frame, loads):
    other = replace(loads, edges=(loads.edges[0], EdgeForce("floor 7", 7, (0.0, -1.0, 0.0))))
    with pytest.raises(KeyError):
        other.patterns(frame.model, frame.parts.mesh)


# From one grid of times to another: impulse and moment are kept.
GIVEN = 0.25e-3
LAST = 0.1


def pulse(time):
    """An impact of 9 ms, and one of 2 ms."""
    long = np.where(np.abs(time - 0.03) < 4.5e-3, np.cos(np.pi * (time - 0.03) / 9e-3), 0.0)
    short = np.where(np.abs(time - 0.0711) < 1e-3, 1.0, 0.0)
    return np.column_stack([2e6 * long, short])


def moments(time, values, end):
    """∫ f dt and ∫ t f dt up to a time, cell by cell; of a product of straight lines, exactly."""
    inside = np.append(time[time < end], min(end, time[-1]))
    f = np.column_stack([np.interp(inside, time, column) for column in values.T])
    h, t = np.diff(inside)[:, None], inside[:, None]
    impulse = h * (f[1:] + f[:-1]) / 2
    moment = h * (2 * t[1:] * f[1:] + 2 * t[:-1] * f[:-1] + t[1:] * f[:-1] + t[:-1] * f[1:]) / 6
    return np.array([impulse.sum(axis=0), moment.sum(axis=0)])


@pytest.mark.parametrize("step", [GIVEN, GIVEN / 4, 1e-3, 5e-3, 0.37e-3, np.pi * 1e-3])
def test_impulse_and_moment_are_kept(step):
    time = GIVEN * np.arange(round(LAST / GIVEN) + 1)
    n = int(np.ceil(LAST / step))
    found = project(time, pulse(time), step, n)
    assert found.shape == (n + 1, 2)
    grid = step * np.arange(n + 1)
    expected = moments(time, pulse(time), n * step)
    assert moments(grid, found, n * step) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("end", [0.03, 0.0287, 0.0711])
def test_window_that_cuts_an_impulse(end):
    """What is before its end is kept, and nothing of what is behind."""
    time = GIVEN * np.arange(round(LAST / GIVEN) + 1)
    values = pulse(time)
    found = project(time, values, end / 40, 40)
    grid = end / 40 * np.arange(41)
    expected = moments(time, values, end)
    assert expected[0, 0] < 0.99 * moments(time, values, LAST)[0, 0] or end > 0.04
    assert moments(grid, found, end) == pytest.approx(expected, rel=1e-12)
    later = np.where((time > end + GIVEN)[:, None], 1e9, values)
    assert project(time, later, end / 40, 40) == pytest.approx(found, rel=1e-12)


def test_it_is_the_nearest_one():
    """The error is at right angles to all hats: any other function is farther away."""
    rng = np.random.default_rng(2)
    time, values = np.linspace(0.0, 1.0, 31), rng.standard_normal((31, 1))
    found = project(time, values, 0.07, 14)
    fine = np.linspace(0.0, 0.98, 200_001)
    grid = 0.07 * np.arange(15)

    def distance(nodal):
        difference = np.interp(fine, grid, nodal) - np.interp(fine, time, values[:, 0])
        return float(np.mean(difference**2))

    nearest = distance(found[:, 0])
    for k in range(15):
        for change in (-0.05, 0.05):
            other = found[:, 0].copy()
            other[k] += change
            assert distance(other) > nearest


def test_zero_outside_the_given_times():
    """A force that ends with a jump, before the window does."""
    found = project(np.linspace(0.0, 0.4, 5), np.ones((5, 1)), 0.03, 40)
    grid = 0.03 * np.arange(41)
    assert moments(grid, found, 1.2) == pytest.approx(np.array([[0.4], [0.08]]), rel=1e-12)
    assert np.abs(found[25:]).max() < 1e-3


def test_samples_outside_an_impact_alternate_and_fall():
    """As docs/theory/transient.md and the captions of figures 11, 16 and 17 say."""
    time = GIVEN * np.arange(round(LAST / GIVEN) + 1)
    found = project(time, pulse(time)[:, :1], 1e-3, 100)[:, 0]
    # The long pulse is from 25.5 ms to 34.5 ms: samples 25 and 35 are the last outside it.
    before, after = found[15:26][::-1], found[35:46]
    for samples in (before, after):
        assert samples[1:] / samples[:-1] == pytest.approx(np.sqrt(3.0) - 2.0, rel=1e-6)
    assert np.abs(before[0]) > 1e-3 * found.max()
    # Inside they do not.
    assert found[27:33].min() > 0.0
