import numpy as np
import pytest

from impactfem.verify.shells import mindlin_plate
from impactfem.verify.shells.mindlin_plate import LENGTH, SHEAR, STEEL, exact


def test_the_thin_limit_is_kirchhoffs():
    t = 1e-4 * LENGTH
    D = STEEL.E * t**3 / (12.0 * (1.0 - STEEL.nu**2))
    k2 = np.array([2, 5, 5, 8, 10, 10]) * (np.pi / LENGTH) ** 2
    thin = k2 * np.sqrt(D / (STEEL.rho * t)) / (2.0 * np.pi)
    assert exact(t) == pytest.approx(thin, rel=1e-6)


def test_the_exact_frequencies_solve_the_equations_of_motion():
    """Amplitudes of w and of the slope along the wave: two equations, singular at ω."""
    t = 0.3 * LENGTH
    D, S = STEEL.E * t**3 / (12.0 * (1.0 - STEEL.nu**2)), SHEAR * STEEL.G * t
    k = np.sqrt(2.0) * np.pi / LENGTH
    K = np.array([[S * k**2, S * k], [S * k, D * k**2 + S]])
    M = STEEL.rho * t * np.diag([1.0, t**2 / 12.0])
    lowest = np.sqrt(np.linalg.eigvals(np.linalg.solve(M, K)).real.min()) / (2.0 * np.pi)
    assert exact(t)[0] == pytest.approx(lowest, rel=1e-12)


def test_another_shear_factor_is_seen_in_a_thick_plate_only(monkeypatch):
    monkeypatch.setattr(mindlin_plate, "SHEAR", 1.0)
    rows = mindlin_plate.simply_supported()
    thick = [row for row in rows if "t/L = 0.1" in row.name]
    assert len(thick) == 7 and not any(row.passed for row in thick)
    assert all(row.passed for row in rows if "t/L = 0.001" in row.name)


@pytest.mark.usefixtures("partly_reduced")
def test_locking_is_seen(monkeypatch):
    monkeypatch.setattr(mindlin_plate, "RATIOS", (0.001,))
    rows = mindlin_plate.simply_supported()
    frequencies = [row for row in rows if "Hz" in row.unit]
    assert not any(row.passed for row in frequencies)
    assert all(row.computed > row.reference for row in frequencies)
