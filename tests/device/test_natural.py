import numpy as np
import pytest

from impactfem.device.natural import natural_modes


def test_against_the_plain_eigenvalue_problem():
    rng = np.random.default_rng(2)
    A, B = rng.standard_normal((2, 5, 5))
    M, K = A @ A.T + np.eye(5), B @ B.T + np.eye(5)
    omega, shape = natural_modes(M, K)
    assert omega**2 == pytest.approx(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real))
    assert shape.T @ M @ shape == pytest.approx(np.eye(5), abs=1e-10)
    assert shape.T @ K @ shape == pytest.approx(np.diag(omega**2), abs=1e-9 * omega[-1] ** 2)


def test_motions_without_mass_drop_out():
    # A mass behind two springs in series.
    K = np.array([[3.0, -2.0], [-2.0, 2.0]])
    omega, shape = natural_modes(np.diag([0.0, 4.0]), K)
    assert omega == pytest.approx([np.sqrt((1.0 * 2.0 / 3.0) / 4.0)])
    assert shape[0, 0] / shape[1, 0] == pytest.approx(2.0 / 3.0)
    assert natural_modes(np.diag([1.0, 4.0]), K)[0].size == 2


def test_equal_parts_that_do_not_couple_stay_apart():
    K = np.kron(np.eye(2), np.array([[3.0, -1.0], [-1.0, 2.0]]))
    omega, shape = natural_modes(np.eye(4), K)
    assert omega[0] == pytest.approx(omega[1], rel=1e-12)
    for column in shape.T:
        assert not column[:2].any() or not column[2:].any()
    K[0, 3] = K[3, 0] = 1e-3
    mixed = natural_modes(np.eye(4), K)[1]
    assert np.all(np.abs(mixed).min(axis=0) > 0.0)
