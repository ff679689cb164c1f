import numpy as np
import pytest
from petsc4py import PETSc
from scipy.sparse import random as random_sparse

from impactfem.building.assembly import Numbering, added, global_matrix, without, without_zeros

NODES = np.array([3, 0, 2])
PLACE = np.array([2, 0, 3, 1])  # of the nodes 0 to 3


@pytest.fixture
def numbering():
    return Numbering(PETSc.COMM_SELF.tompi4py(), PLACE, np.argsort(PLACE))


@pytest.fixture
def local():
    """A matrix of three nodes, as PETSc's and as an array."""

    def make(seed=0):
        full = random_sparse(18, 18, 0.3, "csr", random_state=seed)
        matrix = PETSc.Mat().createAIJ(
            full.shape, bsize=6, csr=(full.indptr, full.indices, full.data), comm=PETSc.COMM_SELF
        )
        matrix.assemble()
        return matrix, full.toarray()

    return make


def expected(values):
    """The blocks of the nodes 3, 0 and 2 at the places 1, 2 and 3; node 1 has the place 0."""
    full = np.zeros((24, 24))
    rows = (6 * np.array([1, 2, 3])[:, None] + np.arange(6)).ravel()
    full[np.ix_(rows, rows)] = values
    return full


def test_blocks_go_to_the_places_of_their_nodes(local, numbering, csr):
    matrix, values = local()
    made = global_matrix(matrix, NODES, numbering)
    assert made.getType() == "seqaij"
    assert csr(made).toarray() == pytest.approx(expected(values), rel=1e-15)


def test_without_cells(numbering, csr):
    made = global_matrix(None, np.empty(0, dtype=np.int64), numbering)
    assert made.getSize() == (24, 24) and csr(made).nnz == 0


def test_a_sum_of_different_patterns(local, numbering, csr):
    (one, first), (two, second) = local(1), local(2)
    made = added([global_matrix(m, NODES, numbering) for m in (one, two)], numbering)
    assert csr(made).toarray() == pytest.approx(expected(first + second), rel=1e-14)


def test_a_sum_of_nothing(numbering, csr):
    made = added([], numbering)
    assert made.getSize() == (24, 24) and not csr(made).toarray().any()


def test_zeros_leave_the_pattern(local, csr):
    matrix, values = local()
    before = csr(matrix).nnz
    row, column = np.argwhere(values)[5]
    matrix.setValue(int(row), int(column), 0.0)
    matrix.assemble()
    values[row, column] = 0.0
    kept = without_zeros(matrix)
    assert kept.getBlockSize() == 6 and csr(kept).nnz == before - 1
    assert csr(kept).toarray().tolist() == values.tolist()


def test_free_rows_and_columns_stay(local, numbering, csr):
    matrix, values = local()
    made = global_matrix(matrix, NODES, numbering)
    free = np.concatenate([np.arange(6), np.arange(12, 24)])
    kept = without(made, free)
    assert kept.getBlockSize() == 6
    assert csr(kept).toarray() == pytest.approx(expected(values)[np.ix_(free, free)], rel=1e-15)
