from itertools import product as every

import numpy as np
import pytest
import scipy.linalg
from scipy.optimize import nnls

from impactfem.coupling import complementarity
from impactfem.coupling.complementarity import Complementarity
from impactfem.system.errors import SolutionError

# All rows of the wrong sign at once: from no active row on, this never ends.
ENDLESS = np.array([[22, 11, 4, -10], [11, 15, -9, 5], [4, -9, 21, -17], [-10, 5, -17, 17]], float)
ENDLESS_Q = np.array([-3.0, -2.0, 3.0, -1.0])


def matrix(rng, m, condition=1e3):
    Q, _ = np.linalg.qr(rng.standard_normal((m, m)))
    W = Q @ np.diag(np.geomspace(1.0, condition, m)) @ Q.T
    return 0.5 * (W + W.T)


def enumerated(W, q):
    """p by trying all sets of active rows."""
    found = []
    for choice in every([False, True], repeat=len(q)):
        A, p = np.array(choice), np.zeros(len(q))
        p[A] = np.linalg.solve(W[np.ix_(A, A)], -q[A])
        if np.all(p >= 0.0) and np.all((W @ p + q)[~A] >= 0.0):
            found.append(p)
    assert len(found) == 1
    return found[0]


def is_solution(W, q, found, tolerance=1e-11):
    size = np.abs(q).max() + np.abs(W).max() * np.abs(found.p).max()
    assert np.all(found.p >= 0.0) and np.all(found.w >= -tolerance * size)
    assert np.all(found.p * found.w == 0.0)
    assert np.abs(found.w - W @ found.p - q).max() <= tolerance * size
    return True


@pytest.mark.parametrize("seed", range(20))
def test_against_all_sets(seed):
    rng = np.random.default_rng(seed)
    W, q = matrix(rng, 6), rng.standard_normal(6)
    found = Complementarity(W).solve(q)
    assert found.p == pytest.approx(enumerated(W, q), rel=1e-11, abs=1e-14)
    assert np.array_equal(found.active, found.p > 0.0) and is_solution(W, q, found)


@pytest.mark.parametrize("m", [1, 2, 17, 60, 150, 300])
def test_against_least_squares(m):
    rng = np.random.default_rng(m)
    W = matrix(rng, m)
    problem, U = Complementarity(W), np.linalg.cholesky(W).T
    assert len(problem) == m
    for _ in range(3):
        q = rng.standard_normal(m)
        # With W = Uᵀ U p minimises ‖U p + U⁻ᵀ q‖ over p ≥ 0.
        p, _ = nnls(U, -scipy.linalg.solve_triangular(U, q, trans=1), maxiter=100 * m)
        found = problem.solve(q)
        assert np.abs(found.p - p).max() <= 1e-9 * max(np.abs(p).max(), 1e-12)
        assert is_solution(W, q, found)
    # Another problem has another solution.
    assert np.abs(problem.solve(-q).p - p).max() > 1e-3 * np.abs(p).max()


def test_the_guess_does_not_matter():
    rng = np.random.default_rng(3)
    W, q = matrix(rng, 40), rng.standard_normal(40)
    problem = Complementarity(W)
    cold = problem.solve(q)
    for guess in (cold.active, ~cold.active, np.ones(40, bool), rng.random(40) < 0.5):
        kept = guess.copy()
        warm = problem.solve(q, active=guess)
        assert np.array_equal(warm.active, cold.active) and np.array_equal(guess, kept)
        assert warm.p == pytest.approx(cold.p, rel=1e-11)


def test_a_good_guess_is_quick(monkeypatch):
    rng = np.random.default_rng(4)
    W, q = matrix(rng, 80), rng.standard_normal(80)
    problem, tried = Complementarity(W), []
    right = Complementarity._try
    monkeypatch.setattr(
        Complementarity, "_try", lambda self, A, q: tried.append(A) or right(self, A, q)
    )
    found = problem.solve(q)
    cold = len(tried)
    problem.solve(1.0001 * q, active=found.active)
    assert cold > 2 and len(tried) == cold + 1


def test_only_some_rows():
    rng = np.random.default_rng(5)
    W, q = matrix(rng, 12), -np.abs(rng.standard_normal(12))
    part = np.arange(12) % 3 != 0
    found = Complementarity(W).solve(q, active=np.ones(12, bool), among=part)
    alone = Complementarity(W[np.ix_(part, part)]).solve(q[part])
    assert found.p[part] == pytest.approx(alone.p, rel=1e-11)
    assert np.all(found.p[~part] == 0.0) and not np.any(found.active[~part])
    assert np.min(found.w[~part]) < 0.0
    nothing = Complementarity(W).solve(q, among=np.zeros(12, bool))
    assert np.all(nothing.p == 0.0)
    assert nothing.w == pytest.approx(q, rel=1e-14)  # scaled, and scaled back


def test_rows_of_any_unit():
    """Rows in other units: p and w change with them, and nothing else."""
    rng = np.random.default_rng(6)
    W, q = matrix(rng, 15), rng.standard_normal(15)
    unit = np.geomspace(1e-6, 1e6, 15)
    one, other = (
        Complementarity(W).solve(q),
        Complementarity(W * np.outer(unit, unit)).solve(unit * q),
    )
    assert np.array_equal(one.active, other.active)
    assert unit * other.p == pytest.approx(one.p, rel=1e-9)
    assert other.w / unit == pytest.approx(one.w, rel=1e-9)


def test_ties():
    problem = Complementarity(np.array([[2.0, 1.0], [1.0, 2.0]]))
    for q in ([0.0, 0.0], [0.0, 1.0], [1.0, 2.0]):
        for guess in every([False, True], repeat=2):
            found = problem.solve(np.array(q), active=np.array(guess))
            assert np.all(found.p == 0.0) and found.w == pytest.approx(np.array(q))
    # p = (1, 0), and w = 0 on both rows.
    found = problem.solve(np.array([-2.0, -1.0]))
    assert found.p == pytest.approx([1.0, 0.0], abs=1e-15)
    assert np.all(found.w == pytest.approx(0.0, abs=1e-15))


def test_it_ends(monkeypatch):
    found = Complementarity(ENDLESS).solve(ENDLESS_Q)
    assert found.p == pytest.approx(enumerated(ENDLESS, ENDLESS_Q), rel=1e-12)
    # Without Murty's rule it does not; with nothing else it does, too.
    monkeypatch.setattr(complementarity, "PATIENCE", 10**9)
    with pytest.raises(SolutionError, match="close to singular"):
        Complementarity(ENDLESS).solve(ENDLESS_Q)
    monkeypatch.setattr(complementarity, "PATIENCE", 0)
    rng = np.random.default_rng(7)
    for m in (4, 9, 25):
        W, q = matrix(rng, m), rng.standard_normal(m)
        assert is_solution(W, q, Complementarity(W).solve(q))
    assert Complementarity(ENDLESS).solve(ENDLESS_Q).p == pytest.approx(found.p, rel=1e-12)


@pytest.mark.parametrize(
    ("W", "words"),
    [
        (np.ones((2, 3)), r"W of a complementarity problem has the shape \(2, 3\)"),
        (np.ones(3), r"has the shape \(3,\)"),
        ([[1.0, np.nan], [np.nan, 1.0]], "W has entries that are not numbers"),
        ([[1.0, 0.2], [0.0, 1.0]], r"W is not symmetric: .* up to 2\.0e-01 of the diagonal"),
        ([[1.0, 0.0], [0.0, 0.0]], "not positive definite: entry 1 of its diagonal is 0"),
        ([[-2.0, 0.0], [0.0, 1.0]], "not positive definite: entry 0 of its diagonal is -2"),
        ([[1.0, 2.0], [2.0, 1.0]], "W is not positive definite: row 1 of 2"),
        (np.outer([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]), "W is not positive definite: row 1 of 3"),
    ],
)
def test_what_is_refused(W, words):
    with pytest.raises(SolutionError, match=words):
        Complementarity(np.array(W), name="W")


def test_nearly_dependent_rows():
    """The last of three rows is the sum of the others but for 1e-5, and then for 1e-8."""
    G = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 1e-5]])
    assert is_solution(G.T @ G, -np.ones(3), Complementarity(G.T @ G).solve(-np.ones(3)), 1e-9)
    G[2, 2] = 1e-8
    with pytest.raises(SolutionError, match="row 2 of 3 is"):
        Complementarity(G.T @ G)


@pytest.mark.parametrize("q", [[np.nan, 0.0], [0.0, -np.inf], [1.0, 2.0, 3.0], 1.0])
def test_right_sides_that_are_refused(q):
    with pytest.raises(SolutionError, match="not 2 finite numbers"):
        Complementarity(np.eye(2)).solve(np.array(q))
