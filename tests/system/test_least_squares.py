"""Least squares between bounds, and what data say about unknowns, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import rosen

from impactfem.system.errors import SolutionError
from impactfem.system.least_squares import (
    BLIND,
    Identification,
    Minimum,
    minima,
    solutions,
    starts_within,
)

LOW, HIGH = np.zeros(3), np.ones(3)


def linear(seed=0, m=12):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((m, 3)), np.array([0.2, 0.5, 0.7])


@pytest.mark.parametrize("total", [None, (np.array([1.0, 1.0, 1.0]), 1.4)])
def test_a_linear_problem(total):
    """With the condition that the truth meets, too."""
    J, x = linear()
    (found,) = minima(lambda u: J @ (u - x), [0.5 * HIGH], LOW, HIGH, total=total)
    assert found.x == pytest.approx(x, abs=1e-5)
    assert found.met


def test_the_best_of_several_starts():
    """(x² − 1/4)² has its minima at ±1/2; a slope makes one of them the lower one."""

    def residuals(x):
        return np.array([(x[0] ** 2 - 0.25) * 20.0, x[0] - 1.0])

    found = minima(residuals, [np.array([-0.5]), np.array([0.5])], -np.ones(1), np.ones(1))
    assert found[0].x[0] == pytest.approx(0.5, abs=0.01)
    assert found[1].x[0] == pytest.approx(-0.5, abs=0.02)
    assert found[0].cost < found[1].cost


def test_rosenbrock():
    def residuals(x):
        return np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])

    (found,) = minima(residuals, [np.array([-1.2, 1.0])], np.full(2, -2.0), np.full(2, 2.0))
    assert found.x == pytest.approx([1.0, 1.0], abs=1e-6)
    assert found.cost == pytest.approx(0.5 * rosen(found.x), abs=1e-12)


def test_starts():
    first = np.array([0.1, 0.2, 0.3])
    found = starts_within(first, LOW, HIGH, 4, 5)
    assert found[0] is first and len(found) == 4
    assert np.all((np.array(found) >= LOW) & (np.array(found) <= HIGH))
    assert np.array_equal(found[1:], starts_within(first, LOW, HIGH, 4, 5)[1:])


def test_no_result():
    with pytest.raises(SolutionError, match="result from 1 starts"):
        minima(lambda u: u, [HIGH], LOW, HIGH, total=(np.ones(3), 9.0))


def test_deviations():
    """C = (Jᵀ J)⁻¹, with a prior as a row more."""
    J, _ = linear()
    found = Identification.of(J, np.array([[0.0, 0.0, 2.0]]))
    C = np.linalg.inv(J.T @ J + np.diag([0.0, 0.0, 4.0]))
    assert found.deviation == pytest.approx(np.sqrt(np.diag(C)))
    assert found.correlation[0, 1] == pytest.approx(C[0, 1] / np.sqrt(C[0, 0] * C[1, 1]))
    assert found.singular_values == pytest.approx(np.linalg.svd(J)[1])


def test_all_within_the_bounds_together():
    """Of 4,000 linear fits to data with errors 95 % and a little more; one σ is not enough."""
    J, x = linear()
    found = Identification.of(J, np.empty((0, 3)))
    errors = np.random.default_rng(1).standard_normal((4000, len(J)))
    fitted = np.linalg.lstsq(J, (J @ x)[:, None] + errors.T, rcond=None)[0].T
    away = np.abs(fitted - x)
    assert 0.94 < np.mean(np.all(away < found.bound, axis=1)) < 0.97
    assert np.mean(np.all(away < found.deviation, axis=1)) < 0.5


def test_what_is_not_seen():
    """The second unknown moves nothing; the third and fourth only their difference."""
    J = np.zeros((5, 4))
    J[:, 0], J[1, 2], J[1, 3] = 10.0, 30.0, -30.0
    found = Identification.of(J, np.empty((0, 4)))
    assert found.unseen == [1]
    assert [parts for _, parts in found.mixed] == [[2, 3]]
    assert np.isinf(found.deviation[[1, 2, 3]]).all() and np.isfinite(found.deviation[0])
    # A prior determines the second one; it does not make the data see it.
    known = Identification.of(J, np.array([[0.0, 5.0, 0.0, 0.0]]))
    assert known.unseen == [1] and known.deviation[1] == pytest.approx(0.2)


@pytest.mark.parametrize("seed", range(5))
def test_a_group_is_named_once(seed):
    """Directions with one singular value may be rotated among themselves: here at random."""
    J = np.zeros((6, 6))
    J[0, [0, 1]], J[1, [2, 3]], J[2, 5] = (10.0, -10.0), (20.0, 30.0), 40.0  # 4 is not seen
    found = Identification.of(J, np.empty((0, 6)))
    blind = found.singular_values < BLIND
    turned = found.directions.copy()
    random = np.random.default_rng(seed).standard_normal((3, 3))
    turned[blind] = np.linalg.qr(random)[0] @ turned[blind]
    groups = replace(found, directions=turned).mixed
    assert [parts for _, parts in groups] == [[0, 1], [2, 3]]
    assert [value for value, _ in groups] == pytest.approx([0.0, 0.0], abs=1e-12)
    # One combination of the two is enough to tell them apart.
    J[3, 0] = 10.0
    assert [parts for _, parts in Identification.of(J, np.empty((0, 6))).mixed] == [[2, 3]]


def test_what_is_told_apart_hardly():
    J = np.array([[10.0, 9.0], [10.0, 9.9], [10.0, 9.5]])
    found = Identification.of(J, np.empty((0, 2)))
    assert [pair[:2] for pair in found.alike] == [(0, 1)]
    assert Identification.of(np.diag([10.0, 9.0]), np.empty((0, 2))).alike == []


def test_solutions():
    """Two places that fit alike, one that fits worse, and a valley that the data do not see."""
    J = np.array([[10.0, 0.0], [0.0, 0.0]])
    places = [((0.2, 0.1), 0.5), ((0.21, 0.9), 0.5), ((0.8, 0.1), 1.0), ((0.5, 0.5), 9.0)]
    found = [Minimum(np.array(x), cost, True) for x, cost in places]
    assert [[one.cost for one in group] for group in solutions(found, J)] == [[0.5, 0.5], [1.0]]
    # A prior on the second unknown, or a slope, makes a place along the valley another one.
    J[1, 1] = 10.0
    assert [len(group) for group in solutions(found, J)] == [1, 1, 1]
    assert len(solutions(found[:1], J)) == 1
