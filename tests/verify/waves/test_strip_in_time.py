from dataclasses import replace

import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.verify.waves import strip_in_time
from impactfem.verify.waves.shell_motion import MovingModel


def test_the_loads_are_the_same_at_all_steps():
    coarse, fine = (strip_in_time._loads(n) for n in (1, 8))
    assert np.array_equal(fine[::8], coarse)
    assert fine[4::8] == pytest.approx(0.5 * (coarse[1:] + coarse[:-1]), abs=1e-12)
    assert coarse.max(axis=0) == pytest.approx([1.0, 1.0])


def test_another_damping_is_no_second_order(monkeypatch, failed):
    right = MovingModel.full

    def wrong(self, loads, step, damping, start=None):
        return right(self, loads, step, Rayleigh(1.001 * damping.alpha, damping.beta), start)

    monkeypatch.setattr(MovingModel, "full", wrong)
    found = failed(strip_in_time.order())
    assert "fitted order of the full model's displacement in the step" in found
    assert "displacement, reduced model from the full one, both by Newmark" in found


def test_a_load_between_the_samples_is_seen(monkeypatch, failed):
    right = strip_in_time._loads

    def smooth(parts):
        loads = right(parts)
        loads[1::2] *= 1.0 + 1e-6 * (parts > 1)
        return loads

    monkeypatch.setattr(strip_in_time, "_loads", smooth)
    assert "velocity, exact integration from itself at an eighth of the step" in failed(
        strip_in_time.order()
    )


def test_a_lost_energy_is_seen(monkeypatch, failed):
    right = MovingModel.full

    def wrong(*arguments):
        history = right(*arguments)
        damped = history.energy.damped * (1.0 - 1e-7)
        return replace(history, energy=replace(history.energy, damped=damped))

    monkeypatch.setattr(MovingModel, "full", wrong)
    assert len(failed(strip_in_time.energy_identity())) == 2


def test_an_undamped_strip_is_seen(monkeypatch, failed):
    monkeypatch.setattr(strip_in_time, "RAYLEIGH", Rayleigh())
    assert failed(strip_in_time.energy_identity()) == {
        "damped part of the energy at the end, at least a tenth"
    }
