import numpy as np
import pytest
import scipy.linalg
from numpy.polynomial import legendre

from impactfem.verify.shells import nafems


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
    assert np.array(nafems.FREE_PLATE) == pytest.approx(4.0 * np.sqrt(values), rel=1e-4)


def test_a_thicker_plate_is_seen(altered, failed):
    altered(nafems, thickness=1.03)
    rows = nafems.free_plate()
    assert len(failed(rows[:6])) >= 3
    assert len(failed(rows[6:])) == 6


def test_a_stiffer_membrane_is_seen(altered, failed):
    altered(nafems, E=1.01)
    assert len(failed(nafems.tapered_membrane())) == 6
