import numpy as np
import pytest

from impactfem.dynamics.columns import inner, product, random_column, row_of_largest


def test_products(petsc):
    rng = np.random.default_rng(1)
    A, X = rng.standard_normal((5, 5)), rng.standard_normal((5, 3))
    assert product(petsc(A), X) == pytest.approx(A @ X, rel=1e-13)
    assert product(petsc(A), np.asfortranarray(X)).flags.f_contiguous
    assert inner(petsc(A), X, X) == pytest.approx(X.T @ X, rel=1e-13)


def test_random_columns_are_the_same_each_time(petsc):
    A = petsc(np.eye(2000))
    first = random_column(A)
    assert np.array_equal(random_column(A), first)
    assert abs(np.mean(first)) < 0.1 and np.std(first) == pytest.approx(1.0, abs=0.1)
    assert abs(np.corrcoef(first, random_column(A, 1))[0, 1]) < 0.1


def test_row_of_largest(petsc):
    A = petsc(np.eye(4))
    assert row_of_largest(A, np.array([0.0, 3.0, 1.0, 2.0])) == 1
    # Nearly the same counts as the same: the first.
    assert row_of_largest(A, np.array([0.0, 3.0, 1.0, 3.0 + 1e-9])) == 1
    assert row_of_largest(A, np.array([0.0, 3.0, 1.0, 3.0 + 1e-3])) == 3
