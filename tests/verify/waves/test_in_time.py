from dataclasses import replace

import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.verify.waves import MovingModel, in_time, peak


def test_one_term_of_the_series_is_the_published_solution():
    time = 1e-3 * np.arange(401)
    at, highest = peak(time, in_time.series(time, 1))
    assert highest == pytest.approx(3.523e-3, abs=1.1e-6)
    assert at == pytest.approx(0.210, abs=0.5e-3)
    assert in_time.series(np.inf, 1) == pytest.approx(1.817e-3, abs=0.5e-6)


def test_a_wrong_damping_is_seen(monkeypatch, failed):
    """In the model alone: the static deflection stays."""
    series = in_time.series
    right = {count: series(1e-3 * np.arange(401), count) for count in (1, 60)}
    monkeypatch.setattr(in_time, "RAYLEIGH", Rayleigh(alpha=0.45, beta=1.339e-3))
    monkeypatch.setattr(in_time, "series", lambda t, n=60: right[n] if np.ndim(t) else series(t, n))
    found = failed(in_time.nafems_13t())
    assert {"peak, full", "peak, part in the first mode, full"} <= found
    assert "static" not in found


def test_another_damping_is_no_second_order(wrong, failed):
    def make(right):
        return lambda self, loads, step, damping: right(
            self, loads, step, Rayleigh(1.001 * damping.alpha, damping.beta)
        )

    wrong(MovingModel, "full", make)
    found = failed(in_time.newmark_order_3d())
    assert "fitted order of the full model's displacement in the step" in found
    assert "displacement, reduced model from the full one, both by Newmark" in found


def test_a_load_between_the_samples_is_seen(wrong, failed):
    def make(right):
        def smooth(parts):
            loads = right(parts)
            loads[1::2] *= 1.0 + 1e-6 * (parts > 1)
            return loads

        return smooth

    wrong(in_time, "_loads", make)
    assert "velocity, exact integration from itself at an eighth of the step" in failed(
        in_time.newmark_order_3d()
    )


def test_a_lost_energy_is_seen(wrong, failed):
    def make(right):
        def lossy(*arguments):
            history = right(*arguments)
            damped = history.energy.damped * (1.0 - 1e-7)
            return replace(history, energy=replace(history.energy, damped=damped))

        return lossy

    wrong(MovingModel, "full", make)
    assert len(failed(in_time.energy_identity_3d())) == 2


def test_an_undamped_strip_is_seen(monkeypatch, failed):
    monkeypatch.setattr(in_time, "STRIP_RAYLEIGH", Rayleigh())
    assert failed(in_time.energy_identity_3d()) == {
        "damped part of the energy at the end, at least a tenth"
    }
