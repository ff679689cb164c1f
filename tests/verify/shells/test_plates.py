import numpy as np
import pytest
import scipy.linalg
from numpy.polynomial import legendre

from impactfem.building import section_forces
from impactfem.verify import shells
from impactfem.verify.shells import SHEAR, STEEL, curved, plates
from impactfem.verify.shells.plates import LENGTH, mindlin_frequencies


def test_the_thin_limit_is_kirchhoffs():
    t = 1e-4 * LENGTH
    D = STEEL.E * t**3 / (12.0 * (1.0 - STEEL.nu**2))
    k2 = np.array([2, 5, 5, 8, 10, 10]) * (np.pi / LENGTH) ** 2
    thin = k2 * np.sqrt(D / (STEEL.rho * t)) / (2.0 * np.pi)
    assert mindlin_frequencies(t) == pytest.approx(thin, rel=1e-6)


def test_the_exact_frequencies_solve_the_equations_of_motion():
    """Amplitudes of w and of the slope along the wave: two equations, singular at ω."""
    t = 0.3 * LENGTH
    D, S = STEEL.E * t**3 / (12.0 * (1.0 - STEEL.nu**2)), SHEAR * STEEL.G * t
    k = np.sqrt(2.0) * np.pi / LENGTH
    K = np.array([[S * k**2, S * k], [S * k, D * k**2 + S]])
    M = STEEL.rho * t * np.diag([1.0, t**2 / 12.0])
    lowest = np.sqrt(np.linalg.eigvals(np.linalg.solve(M, K)).real.min()) / (2.0 * np.pi)
    assert mindlin_frequencies(t)[0] == pytest.approx(lowest, rel=1e-12)


def test_another_shear_factor_is_seen_in_a_thick_plate_only(monkeypatch):
    monkeypatch.setattr(shells, "SHEAR", 1.0)
    rows = plates.mindlin_plate()
    thick = [row for row in rows if "t/L = 0.1" in row.name]
    assert len(thick) == 7 and not any(row.passed for row in thick)
    assert all(row.passed for row in rows if "t/L = 0.001" in row.name)


@pytest.mark.usefixtures("partly_reduced")
def test_locking_is_seen(monkeypatch):
    monkeypatch.setattr(plates, "RATIOS", (0.001,))
    rows = plates.mindlin_plate()
    frequencies = [row for row in rows if "Hz" in row.unit]
    assert not any(row.passed for row in frequencies)
    assert all(row.computed > row.reference for row in frequencies)


def test_navier_by_differences():
    """∂j Mij = Qi and ∂i Qi = −1 inside the plate; at its edges moments across are zero."""
    step, place = 1e-3, np.array([0.35, 0.6, 0.0])

    def slope(axis):
        ends = place + np.outer([-step, step], np.eye(3)[axis])
        return np.diff(plates.navier(ends), axis=0)[0] / (2.0 * step)

    (along_x, along_y), here = (slope(0), slope(1)), plates.navier(place[None])[0]
    assert along_x[0] + along_y[2] == pytest.approx(here[3], rel=1e-3)
    assert along_x[2] + along_y[1] == pytest.approx(here[4], rel=1e-3)
    assert along_x[3] + along_y[4] == pytest.approx(-1.0, abs=0.02)
    centre = plates.navier(np.array([[0.5, 0.5]]))[0]
    assert centre[:2] == pytest.approx(0.0479, rel=1e-3)  # Timoshenko and Woinowsky-Krieger


def test_other_forces_are_seen(monkeypatch):
    """The shear 5 % too large."""
    right = section_forces.section_force_vector

    def wrong(w, plane, fields):
        found = right(w, plane, fields)
        return type(found)(*[found[i] if i < 6 else 1.05 * found[i] for i in range(8)])

    monkeypatch.setattr(section_forces, "section_force_vector", wrong)
    monkeypatch.setattr(plates, "RATIOS", (0.1,))
    failed = [row.quantity for row in plates.plate_forces() if not row.passed]
    assert failed and all("shear" in quantity or "Q1" in quantity for quantity in failed)


def test_published_values():
    """Deflection of a clamped Kirchhoff plate by Ritz with ten products of (1 − x²)² x^2i."""
    p = np.polynomial.polynomial
    basis = [p.polymul(p.polypow([1.0, 0.0, -1.0], 2), [0.0] * (2 * i) + [1.0]) for i in range(6)]

    def product(a, b, i, j):
        whole = p.polyint(p.polymul(p.polyder(a, i), p.polyder(b, j)))
        return p.polyval(1.0, whole) - p.polyval(-1.0, whole)

    matrices = {
        k: np.array([[product(a, b, *k) for b in basis] for a in basis])
        for k in ((0, 0), (1, 1), (2, 2))
    }
    one = np.array([product(a, [1.0], 0, 0) for a in basis])
    bending = np.kron(matrices[2, 2], matrices[0, 0])
    twice = np.kron(matrices[1, 1], matrices[1, 1])
    stiffness = bending + np.kron(matrices[0, 0], matrices[2, 2]) + 2.0 * twice
    found = np.linalg.solve(stiffness, np.kron(one, one))
    assert found[0] / 16.0 == pytest.approx(plates.CLAMPED[1e-4], rel=1e-5)


@pytest.mark.usefixtures("partly_reduced")
def test_partly_reduced_shear_is_seen():
    failed = {row.name for row in plates.clamped_plate() if not row.passed}
    assert failed == {f"clamped plate, t/L = {t:g}" for t in (0.01, 1e-3, 1e-4)}
    assert not any(row.passed for row in curved.hyperbolic_paraboloid())


def test_the_free_plate_by_the_method_of_ritz():
    """Products of Legendre polynomials up to degree 14, each side from −1 to 1."""
    nu, degree = 0.3, 14
    s, weights = legendre.leggauss(degree + 2)
    unit = np.eye(degree + 1)
    V = [legendre.legval(s, legendre.legder(unit, m) if m else unit).T for m in range(3)]

    def integral(m, n):
        return (V[m] * weights[:, None]).T @ V[n]

    mass = np.kron(integral(0, 0), integral(0, 0))
    K = np.kron(integral(2, 2), integral(0, 0)) + np.kron(integral(0, 0), integral(2, 2))
    K += nu * (np.kron(integral(2, 0), integral(0, 2)) + np.kron(integral(0, 2), integral(2, 0)))
    K += 2.0 * (1.0 - nu) * np.kron(integral(1, 1), integral(1, 1))
    values = scipy.linalg.eigvalsh(K, mass)[3:9]
    assert np.array(plates.FREE_PLATE) == pytest.approx(4.0 * np.sqrt(values), rel=1e-4)


def test_a_thicker_plate_is_seen(altered, failed):
    altered(plates, thickness=1.03)
    rows = plates.nafems_fv12()
    assert len(failed(rows[:6])) >= 3
    assert len(failed(rows[6:])) == 6


def test_a_stiffer_membrane_is_seen(altered, failed):
    altered(plates, E=1.01)
    assert len(failed(plates.nafems_fv32())) == 6
