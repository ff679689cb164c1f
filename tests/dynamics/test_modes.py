import numpy as np
import pytest
import scipy.linalg

from impactfem.dynamics import modes as room
from impactfem.dynamics.factorisation import SingularMatrixError
from impactfem.dynamics.modes import modes
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
    # The first of the largest entries is positive: for these shapes the first crest.
    assert found.shapes == pytest.approx(exact, abs=1e-10)
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
    with pytest.raises(SolutionError, match=r"modes were computed for 4.* Sturm count says"):
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
    with pytest.raises(SolutionError, match=f"{count} modes cannot be computed for 10 degrees"):
        modes(petsc(chain(10)), petsc(np.eye(10)), count)


def test_a_mechanism(petsc, chain):
    free = petsc(chain(10, first=False, last=False))
    with pytest.raises(SingularMatrixError, match="the stiffness matrix is singular"):
        modes(free, petsc(np.eye(10)), 2)
