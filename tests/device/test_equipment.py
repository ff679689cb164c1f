"""Items of an equipment list: oscillators, forces on the floor, and the bolts that govern."""

import math

import numpy as np
import pytest

from impactfem.device.bolts import BoltGroup, bolt_demand, rectangular_plate
from impactfem.device.equipment import (
    STEP,
    G,
    absolute_acceleration,
    force_on_floor,
    governing_instants,
    item_bolt_demand,
)

DT = 1e-3
TIME = DT * np.arange(4000)
GROUP = BoltGroup(
    position=np.array([[-0.4, -0.3], [0.4, -0.3], [0.4, 0.3], [-0.4, 0.3]]),
    area=157e-6,
    plate=rectangular_plate(0.8, 0.6),
    tension=90e3,
    shear=60e3,
)


@pytest.fixture
def motion():
    """Return a floor motion, shape (3, n_t) [m/s2]."""
    random = np.random.default_rng(3)
    pulse = np.exp(-(((TIME - 2.0) / 0.5) ** 2))
    return np.cumsum(random.normal(size=(3, TIME.size)), axis=1) * 0.3 * pulse


def test_harmonic_response():
    # Steady state: |a / a_0|² = (1 + 4 ξ² r²) / ((1 - r²)² + 4 ξ² r²), r = ω / ω_n.
    f, xi, r = 5.0, 0.05, 0.8
    time = 1e-3 * np.arange(20_000)
    floor = np.zeros((3, time.size))
    floor[0] = np.sin(2.0 * np.pi * r * f * time)
    found = absolute_acceleration(floor, 1e-3, (f, math.inf, math.inf), xi)
    peak = np.abs(found[0, -5000:]).max()
    exact = math.sqrt((1 + 4 * xi**2 * r**2) / ((1 - r**2) ** 2 + 4 * xi**2 * r**2))
    assert peak == pytest.approx(exact, rel=2e-3)
    assert np.array_equal(found[1:], floor[1:])
    # Negative twin: another damping has another peak.
    other = absolute_acceleration(floor, 1e-3, (f, math.inf, math.inf), 2 * xi)
    assert np.abs(other[0, -5000:]).max() < 0.95 * peak


def test_start_with_a_jump():
    # A constant acceleration from the first sample on: a = 1 - cos ωt without damping.
    floor = np.ones((3, 1000))
    found = absolute_acceleration(floor, 1e-3, (2.0, 2.0, 2.0), 1e-9)
    exact = 1.0 - np.cos(4.0 * np.pi * 1e-3 * np.arange(1000))
    assert np.abs(found - exact).max() < 1e-6


def test_forces_by_hand():
    force = force_on_floor(np.array([[2.0], [3.0], [1.0]]), mass=100.0, height=0.5)
    assert force[:, 0] == pytest.approx([-200, -300, -100 * (1.0 + G), 150, -100, 0])


@pytest.mark.parametrize("height", [0.3, 1.0, 2.5])
def test_governing_instants_have_the_largest_demand(motion, height):
    force = force_on_floor(motion, 600.0, height)
    kept, vertical = governing_instants(force)
    assert kept.size < 0.1 * TIME.size
    assert (vertical >= force[2, kept]).all()
    every, few = bolt_demand(GROUP, force, TIME), item_bolt_demand(GROUP, force, TIME)
    # On the safe side, by the step of the vertical force at most.
    excess = 600.0 * G * (1.0 + np.abs(motion[2]).max() / G) * STEP
    for name in ("interaction", "tension", "shear"):
        assert getattr(few, name) >= getattr(every, name) * (1.0 - 1e-9)
    assert few.tension - every.tension <= excess
    assert few.shear == pytest.approx(every.shear, rel=1e-9)
    # Negative twin: without the governing instants the demand is lower.
    others = np.setdiff1d(np.arange(TIME.size), kept)
    assert bolt_demand(GROUP, force[:, others], TIME[others]).interaction < every.interaction
