import numpy as np
import pytest

from impactfem.verify.waves import moving_force
from impactfem.verify.waves.moving_force import CONCRETE, DEPTH, FORCE, LENGTH


def test_nodal_forces_keep_force_and_moments():
    x = np.linspace(0.0, 3.0, 7)
    at = np.array([0.0, 0.2, 0.5, 0.99, 1.0, 1.7, 3.0])
    forces = moving_force.nodal_forces(x, at)
    for power in range(3):
        assert forces @ x**power == pytest.approx(at**power, abs=1e-12)
    assert np.count_nonzero(forces[4]) == 1 and forces[4, 2] == 1.0


def test_a_slow_force_bends_the_beam_as_one_at_rest():
    """P L³/(48 E I) with the force in the middle."""
    speed = 1e-4 * moving_force._omega(1.0) * LENGTH / np.pi
    static = FORCE * LENGTH**3 / (48.0 * CONCRETE.E * DEPTH**4 / 12.0)
    found = moving_force.series(0.5 * LENGTH, np.array([0.5 * LENGTH / speed]), speed)
    assert found[0] == pytest.approx(static, rel=1e-3)


def test_resonance_is_the_limit_of_speeds_beside_it():
    speed = moving_force._omega(1.0) * LENGTH / np.pi
    time = np.linspace(0.0, LENGTH / speed, 50)
    at, beside = (moving_force.series(7.0, time, f * speed) for f in (1.0, 1.0 + 1e-6))
    assert np.abs(at - beside).max() < 1e-5 * np.abs(at).max()


def test_a_wrong_modulus_is_seen(altered, failed):
    altered(moving_force, E=1.005)
    rows = moving_force.travelling_force()
    assert len(failed(rows)) >= 0.8 * len(rows)


def test_a_force_on_the_nearest_node_alone_is_seen(monkeypatch, failed):
    def nearest(x, at):
        forces = np.zeros((len(at), len(x)))
        forces[np.arange(len(at)), np.rint(at / x[1]).astype(int)] = 1.0
        return forces

    monkeypatch.setattr(moving_force, "ELEMENTS", 4)
    monkeypatch.setattr(moving_force, "nodal_forces", nearest)
    assert failed(moving_force.travelling_force())
