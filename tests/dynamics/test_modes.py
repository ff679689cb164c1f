import numpy as np
import pytest
import scipy.linalg

from impactfem.dynamics import modes as room
from impactfem.dynamics.factorisation import SingularMatrixError
from impactfem.dynamics.modes import modes
from impactfem.dynamics.orientation import TIE, fields, signs
from impactfem.system.errors import SolutionError


def chain_frequency(n, mass=1.0):
    return np.sqrt((2.0 - 2.0 * np.cos(np.pi * np.arange(1, n + 1) / (n + 1))) / mass) / (2 * np.pi)


def same_space(V, W):
    """Whether the columns of V span those of W."""
    return np.linalg.matrix_rank(np.hstack([V, W]), tol=1e-7) == V.shape[1]


def test_chain(petsc, chain):
    n, mass = 80, 3.0
    found = modes(petsc(chain(n)), petsc(mass * np.eye(n)), 6)
    assert found.frequency == pytest.approx(chain_frequency(n, mass)[:6], rel=1e-12)
    j, i = np.arange(1, 7), np.arange(1, n + 1)[:, None]
    exact = np.sin(np.pi * i * j / (n + 1)) * np.sqrt(2.0 / (n + 1) / mass)
    ones = np.sign(np.sum(found.shapes * exact, axis=0))  # the signs are another test
    assert found.shapes * ones == pytest.approx(exact, abs=1e-10)
    assert np.all(found.residual < 1e-10) and found.residual.shape == (6,)


def test_double_frequencies_are_complete(petsc, chain):
    """Square grid of masses: λ_ij = λ_i + λ_j, double for i ≠ j."""
    n = 15
    K = np.kron(chain(n), np.eye(n)) + np.kron(np.eye(n), chain(n))
    single = (2.0 * np.pi * chain_frequency(n)) ** 2
    exact = np.sort(np.add.outer(single, single).ravel())[:11]
    found = modes(petsc(K), petsc(np.eye(n * n)), 11)
    assert (2.0 * np.pi * found.frequency) ** 2 == pytest.approx(exact, rel=1e-11)
    # 11 ends in the middle of no pair: the space is that of the exact modes.
    assert exact[10] < 0.999 * np.sort(np.add.outer(single, single).ravel())[11]
    assert same_space(found.shapes, np.linalg.eigh(K)[1][:, :11])


@pytest.mark.parametrize("copies", [2, 3])
def test_equal_parts_that_nothing_joins(petsc, chain, copies):
    """From one start vector a Krylov space holds one vector of each multiple frequency."""
    n = 25
    K = scipy.linalg.block_diag(*[chain(n)] * copies)
    found = modes(petsc(K), petsc(np.eye(copies * n)), 3 * copies)
    assert found.frequency == pytest.approx(np.repeat(chain_frequency(n)[:3], copies), rel=1e-11)
    assert found.shapes.T @ found.shapes == pytest.approx(np.eye(3 * copies), abs=1e-11)


def test_a_mode_that_is_missed_is_looked_for(petsc, chain, monkeypatch):
    lossy, turns = room._krylov_schur, []

    def second_missing(*arguments):
        turns.append(arguments)
        vectors = lossy(*arguments)
        return np.delete(vectors, 1, axis=1) if len(turns) == 1 else vectors

    monkeypatch.setattr(room, "_krylov_schur", second_missing)
    found = modes(petsc(chain(50)), petsc(np.eye(50)), 4)
    assert found.frequency == pytest.approx(chain_frequency(50)[:4], rel=1e-11)
    assert len(turns) > 1


def test_a_mode_that_stays_missing_is_an_error(petsc, chain, monkeypatch):
    counted = room.number_below
    monkeypatch.setattr(room, "number_below", lambda *arguments: counted(*arguments) + 1)
    with pytest.raises(SolutionError, match=r"4.* Sturm count says"):
        modes(petsc(chain(50)), petsc(np.eye(50)), 4)


@pytest.mark.parametrize(("n", "count"), [(1, 1), (2, 1), (2, 2), (5, 4), (7, 7)])
def test_small_matrices(petsc, chain, n, count):
    found = modes(petsc(chain(n)), petsc(np.eye(n)), count)
    assert found.frequency == pytest.approx(chain_frequency(n)[:count], rel=1e-12)


def test_the_same_from_run_to_run(petsc, chain):
    K, M = petsc(chain(200)), petsc(np.eye(200))
    first, second = modes(K, M, 5), modes(K, M, 5)
    assert np.array_equal(first.frequency, second.frequency)
    assert np.array_equal(first.shapes, second.shapes)


@pytest.mark.parametrize("count", [0, 11])
def test_a_count_that_cannot_be(petsc, chain, count):
    with pytest.raises(SolutionError, match=f"{count} modes cannot"):
        modes(petsc(chain(10)), petsc(np.eye(10)), count)


def test_a_mechanism(petsc, chain):
    free = petsc(chain(10, first=False, last=False))
    with pytest.raises(SingularMatrixError, match="stiffness matrix"):
        modes(free, petsc(np.eye(10)), 2)


def test_signs_do_not_depend_on_the_order_of_the_rows(petsc, chain):
    """A membrane that is symmetric about four axes, numbered otherwise, as on other ranks.

    By the largest entry half of its modes would be ties: of equal entries of both signs.
    """
    n = 9
    K = np.kron(chain(n), np.eye(n)) + 1.3 * np.kron(np.eye(n), chain(n))
    x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
    field = fields(points, np.zeros(3), np.full(3, n - 1.0))[:, 2]
    found = modes(petsc(K), petsc(np.eye(n * n)), 12, fields=field).shapes
    assert np.sum(np.isclose(found.max(axis=0), -found.min(axis=0), rtol=1e-9)) >= 5
    for seed in range(4):
        order = np.random.default_rng(seed).permutation(n * n)
        again = modes(petsc(K[np.ix_(order, order)]), petsc(np.eye(n * n)), 12, fields=field[order])
        assert again.shapes == pytest.approx(found[order], abs=1e-8)


def test_the_next_field_decides_ties_of_the_first():
    norms = np.array([2.0, 1.0, 1.0])
    products = np.array([[0.5, -1.0, 1.0], [-1e-9, 0.3, -1.0], [0.5 * TIE, -1e-9, -0.1]])
    assert signs(products, norms).tolist() == [1.0, 1.0, -1.0]
    assert signs(-products, norms).tolist() == [-1.0, -1.0, 1.0]
