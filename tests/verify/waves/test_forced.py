import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from impactfem.dynamics.damping import Rayleigh
from impactfem.verify.waves import forced
from impactfem.verify.waves.forced import (
    CONCRETE,
    DAMPED,
    DEPTH,
    FORCE,
    HALF_WAVES,
    LENGTH,
    RATIO,
)

OMEGA = 5.0


def solved(ratio, load, time, corners):
    """The equation by SciPy, from corner to corner of the load."""

    def change(t, state):
        z, v = state
        return v, load(t) - 2.0 * ratio * OMEGA * v - OMEGA**2 * z

    state, values = (0.0, 0.0), np.zeros(len(time))
    for start, end in pairwise(corners):
        here = (time >= start) & (time <= end)
        middle = solve_ivp(
            change, (start, end), state, method="DOP853", rtol=1e-12, atol=1e-14, dense_output=True
        )
        values[here] = middle.sol(time[here])[0]
        state = middle.y[:, -1]
    return values


@pytest.mark.parametrize("ratio", DAMPED.values())
def test_closed_form_of_the_oscillating_pulse(ratio):
    time = np.linspace(0.0, 6.0, 400)
    drive = RATIO * OMEGA
    end = HALF_WAVES * math.pi / drive
    before = time <= end
    driven = solved(ratio, lambda t: math.sin(drive * t), time[before], [0.0, end])
    found = forced.response(time, OMEGA, ratio)
    assert found[before] == pytest.approx(driven, abs=1e-10)
    both = solved(
        ratio, lambda t: math.sin(drive * t) if t < end else 0.0, time, [0.0, end - 1e-13, 6.0]
    )
    assert found == pytest.approx(both, abs=1e-9)


@pytest.mark.parametrize("ratio", DAMPED.values())
def test_closed_form_of_the_triangular_pulse(ratio):
    time = np.linspace(0.0, 6.0, 400)

    def load(t):
        return max(0.0, 1.0 - abs(t - 0.5) / 0.5)

    found = forced.ramps(time, OMEGA, ratio, 0.5)
    assert found == pytest.approx(solved(ratio, load, time, [0.0, 0.5, 1.0, 6.0]), abs=1e-10)


def test_the_pulse_ends_at_a_zero():
    time, pulse = forced._pulse(OMEGA, 400)
    last = HALF_WAVES * 200
    assert not pulse[last:].any() and pulse[last - 1] > 0.0
    assert time[last] == pytest.approx(HALF_WAVES * math.pi / (RATIO * OMEGA))


def test_another_damping_is_seen(monkeypatch, failed):
    right = forced.response
    monkeypatch.setattr(forced, "response", lambda t, w, ratio: right(t, w, 1.001 * ratio))
    found = failed(forced.modal_equation())
    pulse = "largest difference over the peak, an oscillating pulse, "
    assert found == {pulse + name for name in DAMPED if name != "undamped"}


def test_a_wrong_modulus_or_damping_of_the_strip_is_seen(altered, monkeypatch, failed):
    altered(forced, E=1.01)
    assert "largest deflection, undamped, full" in failed(forced.strip_pulse())
    altered(forced, E=1.0 / 1.01)
    monkeypatch.setattr(forced, "Rayleigh", lambda alpha, beta=0.0: Rayleigh(1.1 * alpha, beta))
    found = failed(forced.strip_pulse())
    assert {"largest deflection, overdamped, full", "largest deflection, overdamped, reduced"} <= (
        found
    )


def test_nodal_forces_keep_force_and_moments():
    x = np.linspace(0.0, 3.0, 7)
    at = np.array([0.0, 0.2, 0.5, 0.99, 1.0, 1.7, 3.0])
    forces = forced.nodal_forces(x, at)
    for power in range(3):
        assert forces @ x**power == pytest.approx(at**power, abs=1e-12)
    assert np.count_nonzero(forces[4]) == 1 and forces[4, 2] == 1.0


def test_a_slow_force_bends_the_beam_as_one_at_rest():
    """P L³/(48 E I) with the force in the middle."""
    speed = 1e-4 * forced._omega(1.0) * LENGTH / np.pi
    static = FORCE * LENGTH**3 / (48.0 * CONCRETE.E * DEPTH**4 / 12.0)
    found = forced.series(0.5 * LENGTH, np.array([0.5 * LENGTH / speed]), speed)
    assert found[0] == pytest.approx(static, rel=1e-3)


def test_resonance_is_the_limit_of_speeds_beside_it():
    speed = forced._omega(1.0) * LENGTH / np.pi
    time = np.linspace(0.0, LENGTH / speed, 50)
    at, beside = (forced.series(7.0, time, f * speed) for f in (1.0, 1.0 + 1e-6))
    assert np.abs(at - beside).max() < 1e-5 * np.abs(at).max()


def test_a_wrong_modulus_is_seen(altered, failed):
    altered(forced, E=1.005)
    rows = forced.travelling_force()
    assert len(failed(rows)) >= 0.8 * len(rows)


def test_a_force_on_the_nearest_node_alone_is_seen(monkeypatch, failed):
    def nearest(x, at):
        forces = np.zeros((len(at), len(x)))
        forces[np.arange(len(at)), np.rint(at / x[1]).astype(int)] = 1.0
        return forces

    monkeypatch.setattr(forced, "ELEMENTS", 4)
    monkeypatch.setattr(forced, "nodal_forces", nearest)
    assert failed(forced.travelling_force())
