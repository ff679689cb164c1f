import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.verify.shells import STEEL
from impactfem.verify.shells.plates import LENGTH
from impactfem.verify.waves import plate_step
from impactfem.verify.waves.shell_motion import peak


def test_one_term_of_the_series_is_the_published_solution():
    time = 1e-3 * np.arange(401)
    at, highest = peak(time, plate_step.series(time, 1))
    assert highest == pytest.approx(3.523e-3, abs=1.1e-6)
    assert at == pytest.approx(0.210, abs=0.5e-3)
    assert plate_step.series(np.inf, 1) == pytest.approx(1.817e-3, abs=0.5e-6)


def test_all_terms_are_the_plate_of_the_books():
    """Timoshenko: 0.00406 q a⁴/D under a uniform load."""
    D = STEEL.E * plate_step.THICKNESS**3 / (12.0 * (1.0 - STEEL.nu**2))
    found = plate_step.series(np.inf) * D / (plate_step.PRESSURE * LENGTH**4)
    assert found == pytest.approx(0.0040624, abs=1e-7)
    assert plate_step.series(np.array([200.0]))[0] == pytest.approx(plate_step.series(np.inf))
    assert plate_step.series(np.array([0.0]))[0] == pytest.approx(0.0, abs=1e-12)


def test_a_wrong_modulus_is_seen(altered, failed):
    altered(plate_step, E=1.01)
    assert {f"peak, {s}" for s in ("full", "reduced, newmark", "reduced, exact")} <= failed(
        plate_step.step_pressure()
    )


def test_a_wrong_damping_is_seen(monkeypatch, failed):
    """In the model alone: the static deflection stays."""
    series = plate_step.series
    right = {count: series(1e-3 * np.arange(401), count) for count in (1, 60)}
    monkeypatch.setattr(plate_step, "RAYLEIGH", Rayleigh(alpha=0.45, beta=1.339e-3))
    monkeypatch.setattr(
        plate_step, "series", lambda t, n=60: right[n] if np.ndim(t) else series(t, n)
    )
    found = failed(plate_step.step_pressure())
    assert {"peak, full", "peak, part in the first mode, full"} <= found
    assert "static" not in found
