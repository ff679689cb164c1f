import pickle

import numpy as np
import pytest
import scipy.linalg
from petsc4py import PETSc

from impactfem.dynamics import factorisation
from impactfem.dynamics.factorisation import BLOCK, Factorisation, SingularMatrixError
from impactfem.system.errors import SolutionError

ORDERING = "impactfem_mat_mumps_icntl_7"
ROOM = "impactfem_mat_mumps_icntl_14"


@pytest.fixture
def options():
    database = PETSc.Options()
    yield database
    for name in (ORDERING, ROOM):
        if database.hasName(name):
            database.delValue(name)


def eigenvalues(n):
    """Of the chain between two walls."""
    return 2.0 - 2.0 * np.cos(np.pi * np.arange(1, n + 1) / (n + 1))


@pytest.mark.parametrize("shift", [0.0, -1.2345])
def test_solve(petsc, chain, shift):
    n = 30
    A = chain(n) + shift * np.eye(n)
    rng = np.random.default_rng(2)
    B = rng.standard_normal((n, 2 * BLOCK + 5))
    with Factorisation(petsc(A), definite=shift == 0.0) as factor:
        columns = factor.solve_block(B)
        b, x = PETSc.Vec().createWithArray(B[:, 3].copy()), PETSc.Vec().createSeq(n)
        factor.solve(b, x)
        assert factor.entries >= 2 * n - 1
        assert factor.operations >= 2 * n - 1
        assert factor.solve_block(np.empty((n, 0))).shape == (n, 0)
    assert columns == pytest.approx(np.linalg.solve(A, B), rel=1e-10, abs=1e-10)
    assert columns.flags.f_contiguous
    assert x.getArray() == pytest.approx(columns[:, 3], rel=1e-12)


def test_blocks_that_are_not_full(petsc, chain):
    """The same factor of a mass in blocks costs what its entries cost."""
    mass = petsc(np.kron(chain(40), np.eye(6)))
    mass.setBlockSize(6)
    ones = np.ones((240, 1))
    with Factorisation(mass) as factor:
        full, expected = factor.entries, factor.solve_block(ones)
    with Factorisation(mass, full_blocks=False) as factor:
        assert factor.solve_block(ones) == pytest.approx(expected, rel=1e-12)
        assert factor.entries < full * 0.75


def test_the_matrix_may_go(petsc, chain):
    A = petsc(chain(10))
    factor = Factorisation(A)
    A.zeroEntries()
    assert factor.solve_block(np.ones((10, 1)))[0, 0] == pytest.approx(5.0)


@pytest.mark.parametrize("below", [0, 1, 7, 12, 20])
def test_inertia_counts_eigenvalues(petsc, chain, below):
    n = 20
    values = np.concatenate([[-1.0], eigenvalues(n), [5.0]])
    sigma = values[below : below + 2].mean()
    with Factorisation(petsc(chain(n) - sigma * np.eye(n)), definite=False) as factor:
        assert factor.inertia() == (below, 0, n - below)


def test_inertia_of_special_matrices(petsc, chain):
    with Factorisation(petsc(chain(5, first=False, last=False)), definite=False) as factor:
        assert factor.inertia() == (0, 1, 4)
    with Factorisation(petsc(chain(5))) as factor:
        assert factor.inertia() == (0, 0, 5)
    # No diagonal entry to begin with.
    with Factorisation(petsc(np.array([[0.0, 1.0], [1.0, 0.0]])), definite=False) as factor:
        assert factor.inertia() == (1, 0, 1)


def rotated_mechanism():
    """One eigenvalue is zero but for rounding, and no entry shows it."""
    rng = np.random.default_rng(4)
    Q = np.linalg.qr(rng.standard_normal((12, 12)))[0]
    A = Q @ np.diag(np.linspace(0.0, 11.0, 12)) @ Q.T
    return 0.5 * (A + A.T)


def test_a_mechanism_is_told(petsc, chain):
    free = chain(30, first=False, last=False)
    with pytest.raises(SingularMatrixError, match="1 of 30 eigenvalues"):
        Factorisation(petsc(free), name="K")
    with pytest.raises(SingularMatrixError, match="2 of 60 eigenvalues"):
        Factorisation(petsc(scipy.linalg.block_diag(free, free)))
    with pytest.raises(SingularMatrixError, match="1 of 12 eigenvalues"):
        Factorisation(petsc(rotated_mechanism()))
    # Nearly one, but not one.
    Factorisation(petsc(free + 1e-8 * np.eye(30))).destroy()


def test_a_mechanism_names_where(petsc, chain):
    A = scipy.linalg.block_diag(1e6 * chain(20), chain(7, first=False, last=False), chain(9))
    with pytest.raises(SingularMatrixError, match=r"row 2[0-6] moves most") as caught:
        Factorisation(petsc(A))
    assert 20 <= caught.value.row <= 26
    again = pickle.loads(pickle.dumps(caught.value))
    assert again.row == caught.value.row and str(again) == str(caught.value)


def test_an_empty_row_is_named(petsc, chain):
    A = chain(9)
    A[4, :] = A[:, 4] = 0.0
    with pytest.raises(SingularMatrixError, match="1 of 9 diagonal entries"):
        Factorisation(petsc(A + np.diag(1e-300 * (np.arange(9) != 4))))


def test_an_indefinite_matrix_is_told(petsc, chain):
    A = chain(40) - 0.5 * (eigenvalues(40)[2] + eigenvalues(40)[3]) * np.eye(40)
    with pytest.raises(SolutionError, match="3 negative eigenvalues of 40") as caught:
        Factorisation(petsc(A), name="S")
    assert not isinstance(caught.value, SingularMatrixError)
    both = scipy.linalg.block_diag(A, chain(5, first=False, last=False))
    with pytest.raises(SingularMatrixError, match="1 and 3 negative of 45"):
        Factorisation(petsc(both))


def test_numbers_that_are_none(petsc, chain):
    A = chain(5)
    A[1, 2] = A[2, 1] = np.nan
    with pytest.raises(SolutionError, match="not numbers"):
        Factorisation(petsc(A), name="K")


def test_options_of_the_user_stay(petsc, chain, options):
    options[ORDERING] = 0
    Factorisation(petsc(chain(5))).destroy()
    assert options.getInt(ORDERING) == 0 and not options.hasName(ROOM)


def test_more_room_is_tried(petsc, chain, monkeypatch, options):
    A = petsc(np.kron(chain(12), np.eye(12)) + np.kron(np.eye(12), chain(12)))
    monkeypatch.setattr(factorisation, "_ROOM", (-99, 20))
    with Factorisation(A) as factor:
        assert factor.solve_block(np.ones((144, 1))).min() > 0.0
    options[ROOM] = -99
    with pytest.raises(SolutionError, match=r"144 rows.*MUMPS error -[89]"):
        Factorisation(A)


def test_what_petsc_refuses_is_an_error():
    """PCSetUp is called without petsc4py, which would raise by itself."""
    pc = PETSc.PC().create(PETSc.COMM_SELF)
    pc.setType("cholesky")
    with pytest.raises(PETSc.Error, match="73"):  # no matrix is set
        factorisation._unlocked("PCSetUp", pc)
    pc.destroy()
