import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from impactfem.dynamics.damping import Rayleigh
from impactfem.verify.waves import oscillating_pulse
from impactfem.verify.waves.oscillating_pulse import DAMPED, HALF_WAVES, RATIO

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
    forced = solved(ratio, lambda t: math.sin(drive * t), time[before], [0.0, end])
    found = oscillating_pulse.response(time, OMEGA, ratio)
    assert found[before] == pytest.approx(forced, abs=1e-10)
    both = solved(
        ratio, lambda t: math.sin(drive * t) if t < end else 0.0, time, [0.0, end - 1e-13, 6.0]
    )
    assert found == pytest.approx(both, abs=1e-9)


@pytest.mark.parametrize("ratio", DAMPED.values())
def test_closed_form_of_the_triangular_pulse(ratio):
    time = np.linspace(0.0, 6.0, 400)

    def load(t):
        return max(0.0, 1.0 - abs(t - 0.5) / 0.5)

    found = oscillating_pulse.ramps(time, OMEGA, ratio, 0.5)
    assert found == pytest.approx(solved(ratio, load, time, [0.0, 0.5, 1.0, 6.0]), abs=1e-10)


def test_the_pulse_ends_at_a_zero():
    time, pulse = oscillating_pulse._pulse(OMEGA, 400)
    last = HALF_WAVES * 200
    assert not pulse[last:].any() and pulse[last - 1] > 0.0
    assert time[last] == pytest.approx(HALF_WAVES * math.pi / (RATIO * OMEGA))


def test_another_damping_is_seen(monkeypatch, failed):
    right = oscillating_pulse.response
    monkeypatch.setattr(
        oscillating_pulse, "response", lambda t, w, ratio: right(t, w, 1.001 * ratio)
    )
    found = failed(oscillating_pulse.modal_equation())
    pulse = "largest difference over the peak, an oscillating pulse, "
    assert found == {pulse + name for name in DAMPED if name != "undamped"}


def test_a_wrong_modulus_or_damping_of_the_strip_is_seen(altered, monkeypatch, failed):
    altered(oscillating_pulse, E=1.01)
    assert "largest deflection, undamped, full" in failed(oscillating_pulse.strip_pulse())
    altered(oscillating_pulse, E=1.0 / 1.01)
    monkeypatch.setattr(
        oscillating_pulse, "Rayleigh", lambda alpha, beta=0.0: Rayleigh(1.1 * alpha, beta)
    )
    found = failed(oscillating_pulse.strip_pulse())
    assert {"largest deflection, overdamped, full", "largest deflection, overdamped, reduced"} <= (
        found
    )
