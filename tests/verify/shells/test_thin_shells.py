import numpy as np
import pytest

from impactfem.verify.shells import thin_shells


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
    assert found[0] / 16.0 == pytest.approx(thin_shells.CLAMPED[1e-4], rel=1e-5)


def test_the_benchmarks_pass():
    for benchmark in (thin_shells.clamped_plates, thin_shells.twisted_strip):
        assert all(row.passed for row in benchmark())


@pytest.mark.usefixtures("partly_reduced")
def test_partly_reduced_shear_is_seen():
    failed = {row.name for row in thin_shells.clamped_plates() if not row.passed}
    assert failed == {f"clamped plate, t/L = {t:g}" for t in (0.01, 1e-3, 1e-4)}
    assert not any(row.passed for row in thin_shells.hyperbolic_paraboloid())


def test_another_thickness_is_seen(altered):
    altered(thin_shells, thickness=1.01)
    rows = [*thin_shells.hyperbolic_paraboloid(), *thin_shells.twisted_strip()]
    assert not any(row.passed for row in rows)
