from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from impactfem.verify.waves import bar_impact
from impactfem.verify.waves.bar_impact import LENGTH
from impactfem.verify.waves.shell_motion import MovingModel
from impactfem.verify.waves.waves import PLATE


def test_the_displacement_is_the_integral_of_the_velocity():
    time = 1e-5 * np.arange(2000)
    velocity = cumulative_trapezoid(bar_impact._half_sine(time), time, initial=0.0)
    assert bar_impact._integral(time) == pytest.approx(velocity, abs=1e-8)


def test_a_wave_crosses_more_than_once_in_a_pulse():
    """Waves meet: the edges' velocities are more than a sequence of single pulses."""
    assert 1.0 < bar_impact.PULSE / (LENGTH / PLATE.speed) < 2.0


def test_a_wrong_speed_is_seen(altered, failed):
    altered(bar_impact, E=1.02)
    found = failed(bar_impact.strip_impact())
    assert "largest difference of the velocity over its peak, far edge, full" in found
    assert "largest difference of the displacement over its peak, far edge, reduced" in found


def test_a_held_far_edge_reflects_otherwise(monkeypatch, failed):
    """A spring on the far edge, so stiff that it hardly moves."""
    right = MovingModel.__init__

    def stiff(self, model, loads, probes):
        K = model.K.tolil()
        K[probes[1], probes[1]] += 1e12
        right(self, replace(model, K=K.tocsr()), loads, probes)

    monkeypatch.setattr(MovingModel, "__init__", stiff)
    found = failed(bar_impact.strip_impact())
    assert "first peak of the velocity, far edge over the wave's, full" in found
    assert "displacement of the far edge at the end, reduced" in found


def test_numbers_of_the_bar_by_hand():
    """Siconos's example: 5188.745 m/s, 1270.83 N and 0.385450 ms make 0.489840 N s."""
    c = np.sqrt(210e9 / 7800.0)
    assert c == pytest.approx(5188.745, abs=5e-4)
    assert 7800.0 * c * 3.14e-4 * 0.1 == pytest.approx(1270.83, abs=5e-3)
    assert 2.0 / c == pytest.approx(0.385450e-3, abs=5e-10)
    impulse = 1270.83 * 0.385450e-3
    assert impulse == pytest.approx(0.489840, abs=5e-6)


def test_a_bar_that_is_too_stiff_leaves_the_wall(altered, failed):
    altered(bar_impact, E=1.05)
    found = failed(bar_impact.bar_against_wall())
    assert "largest distance of that end from the wall over v₀ 2L/c" in found
    assert "impulse" not in found
