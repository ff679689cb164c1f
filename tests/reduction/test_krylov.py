import errno
import os
import tracemalloc
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import psutil
import pytest
import scipy.sparse

from impactfem.reduction import orthonormal
from impactfem.reduction.krylov import AT_ONCE, KrylovBasis
from impactfem.reduction.orthonormal import CHUNK, DEPENDENT, Orthonormal
from impactfem.system import memory
from impactfem.system.errors import SolutionError

SCRIPT = Path(__file__).with_name("krylov_on_ranks.py")
SHIFT = (2.0 * np.pi * 60.0) ** 2


@pytest.fixture
def basis(membrane, petsc):
    """Make a basis of the membrane with some loads."""

    def make(loads, model=None):
        model = model or membrane()
        made = KrylovBasis(petsc(model.K), petsc(model.M), SHIFT)
        if loads is not None:
            made.add(np.array(loads))
        return made

    return make


def image(model, X):
    """A X."""
    return np.linalg.solve(model.K + SHIFT * model.M, model.M @ X)


def relation(model, made):
    """Largest violation of A V = V T + Q S over the largest entry of A V."""
    AV = image(model, made.V)
    return np.abs(AV - made.V @ made.T - made.Q @ made.S).max() / np.abs(AV).max()


def test_relations(membrane, basis):
    model = membrane()
    made = basis(model.loads)
    assert made.grow(25) == 75
    assert made.size == 78 > CHUNK  # more than one piece of memory
    assert made.sizes == tuple(range(3, 79, 3))
    V, Q = made.V, made.Q
    assert V.shape == (168, 78) and Q.shape == (168, 3)
    both = np.hstack([V, Q])
    assert np.abs(both.T @ model.M @ both - np.eye(81)).max() < 1e-12
    assert relation(model, made) < 1e-13
    assert pytest.approx(V.T @ model.M @ image(model, V), rel=1e-10, abs=1e-18) == made.T
    start = np.linalg.solve(model.K + SHIFT * model.M, model.loads)
    assert pytest.approx(start, rel=1e-10, abs=1e-12 * np.abs(start).max()) == V @ made.R
    # Without the tail the relation does not hold.
    assert np.abs(image(model, V) - V @ made.T).max() > 1e-6 * np.abs(image(model, V)).max()


@pytest.mark.parametrize(
    ("threads", "rounding", "loss"),
    [(1, 1e-10, 0.0), (2, 1e-10, 0.0), (1, -1.0, 0.0), (1, 1e-10, 1e-12), (1, 1e-10, np.inf)],
)
def test_threads_and_rounding(membrane, basis, monkeypatch, threads, rounding, loss):
    """With a second thread that solves at the same time; made orthogonal again at every step.

    Or where rounding has grown; or never, and then it is orthogonal no more.
    """
    monkeypatch.setenv("OMP_NUM_THREADS", str(threads))
    monkeypatch.setattr("impactfem.reduction.krylov.ROUNDING", rounding)
    monkeypatch.setattr("impactfem.reduction.krylov.LOSS", loss)
    settled, combination = [], Orthonormal.combination
    monkeypatch.setattr(
        Orthonormal, "combination", lambda V, c: settled.append(len(c)) or combination(V, c)
    )
    model = membrane()
    made = basis(model.loads)
    made.grow(20)
    both = np.hstack([made.V, made.Q])
    apart = np.abs(both.T @ model.M @ both - np.eye(both.shape[1])).max()
    assert apart > 1e-6 if np.isinf(loss) else apart < 1e-12
    assert relation(model, made) < 1e-13
    steps = len(made.sizes)
    least, most = {0.0: (steps, steps), 1e-12: (2, steps // 2), np.inf: (0, 0)}[loss]
    assert least <= len(settled) <= most


def test_solutions_in_parts(membrane, basis):
    model = membrane()
    made = basis(model.loads)
    F = np.random.default_rng(3).standard_normal((168, 2 * AT_ONCE + 5))
    X = np.hstack([part for _, part in made.solutions(F)])
    exact = np.linalg.solve(model.K + SHIFT * model.M, F)
    assert pytest.approx(exact, rel=1e-9, abs=1e-12 * np.abs(exact).max()) == X
    assert [part for part, _ in made.solutions(F[:, :3])] == [slice(0, AT_ONCE)]
    assert not list(made.solutions(F[:, :0]))


def test_rows_and_norms(membrane, basis):
    model = membrane()
    made = basis(model.loads)
    made.grow(25)
    index = np.array([[3, 0], [167, 50], [3, 4]])
    assert np.array_equal(made.rows(index), made.V[index])
    shifted = model.K + SHIFT * model.M
    assert made.shifted_tail() == pytest.approx(shifted @ made.Q, rel=1e-10, abs=1e-9)
    squares = np.diag(model.loads.T @ np.linalg.solve(shifted, model.loads))
    assert made.dual_norm(model.loads) == pytest.approx(np.sqrt(squares), rel=1e-12)


def test_before_the_first_load(basis):
    made = basis(None)
    assert made.grow(3) == 0 and made.size == 0 and made.sizes == ()
    assert made.V.shape == (168, 0) and made.rows(np.arange(4)).shape == (4, 0)


def test_dependent_loads_bring_nothing_in(membrane, basis):
    model = membrane()
    f, g, _ = model.loads.T
    alone = basis(model.loads[:, :2])
    loads = np.column_stack([f, f, np.zeros_like(f), g, 3.0 * f - 0.1 * g, f])
    made = basis(loads)
    assert made.size == alone.size == 2 and made.Q.shape[1] == 2
    made.grow(10)
    alone.grow(10)
    assert made.size == alone.size == 22
    start = np.linalg.solve(model.K + SHIFT * model.M, loads)
    assert made.R.shape == (22, 6) and np.all(made.R[:, 2] == 0.0)
    assert pytest.approx(start, rel=1e-9, abs=1e-12 * np.abs(start).max()) == made.V @ made.R
    assert relation(model, made) < 1e-13
    nothing = basis(np.zeros((168, 2)))
    assert nothing.size == 0 and nothing.R.shape == (0, 2) and nothing.grow(2) == 0


@pytest.mark.parametrize("apart", [1e-4, 1e-7, 1e-8])
def test_nearly_dependent_loads_count(membrane, basis, apart):
    model = membrane()
    f, g, _ = model.loads.T
    loads = np.column_stack([f, f + apart * g])
    made = basis(loads)
    assert made.size == 2
    made.grow(10)
    both = np.hstack([made.V, made.Q])
    assert np.abs(both.T @ model.M @ both - np.eye(both.shape[1])).max() < 1e-12
    # What they differ by is there with the digits that it has.
    difference = made.V @ (made.R[:, 1] - made.R[:, 0]) / apart
    exact = np.linalg.solve(model.K + SHIFT * model.M, g)
    assert np.abs(difference - exact).max() < 1e-12 / apart * np.abs(exact).max()


def test_many_nearly_dependent_loads(membrane, basis):
    """Smooth answers to many point loads: what one of them adds to the others is tiny."""
    model = membrane()
    n = len(model.K)
    loads = np.eye(n)[:, :: n // 80]
    smooth = np.linalg.matrix_power(np.linalg.solve(model.K, model.M), 2) @ loads
    made = basis(smooth)
    made.grow(4)
    both = np.hstack([made.V, made.Q])
    assert both.shape[1] <= n
    assert np.abs(both.T @ model.M @ both - np.eye(both.shape[1])).max() < 1e-12
    assert np.linalg.eigvalsh(made.T).min() > -1e-12 * np.linalg.eigvalsh(made.T).max()


@pytest.mark.parametrize("apart", [1.0, 1e-2, 1e-6])
def test_blocks_of_columns_near_each_other(membrane, petsc, monkeypatch, apart):
    """All at once where a Gram matrix has digits enough for it, else one by one: X = V c."""
    model, one_by_one = membrane(), []
    slow = orthonormal._one_by_one

    def counted(*given):
        one_by_one.append(apart)
        return slow(*given)

    monkeypatch.setattr(orthonormal, "_one_by_one", counted)
    rng = np.random.default_rng(3)
    V = orthonormal.Orthonormal(petsc(model.M))
    V.append(np.asfortranarray(rng.standard_normal((len(model.M), 4))))
    X = rng.standard_normal((len(model.M), 1)) + apart * rng.standard_normal((len(model.M), 5))
    coordinates, MV = V.append(np.array(X, order="F"))
    both = V.columns(0, V.count)
    assert both.shape[1] == 9
    assert np.abs(both.T @ model.M @ both - np.eye(9)).max() < 1e-13
    assert np.abs(both @ coordinates - X).max() < 1e-13 * np.abs(X).max()
    assert np.abs(MV - model.M @ both[:, 4:]).max() < 1e-12 * np.abs(MV).max()
    assert bool(one_by_one) == (apart < 1e-3)


@pytest.mark.parametrize("apart", [1.0, 1e-12])
def test_a_block_is_taken_in_with_one_more_of_its_size(petsc, apart):
    """M X, and no third one: at the end of a large reduction there is no room for it."""
    n, k = 5000, 16
    rng, M = np.random.default_rng(5), petsc(scipy.sparse.diags(np.linspace(1.0, 2.0, n)))
    V = Orthonormal(M)
    V.append(np.asfortranarray(rng.standard_normal((n, 4))))
    X = np.asfortranarray(rng.standard_normal((n, k)))
    X[:, 1::2] = X[:, ::2] + apart * X[:, 1::2]
    tracemalloc.start()
    V.append(X)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert V.count == 4 + (k if apart > DEPENDENT else k // 2)
    assert most < 1.5 * X.nbytes


def test_an_exhausted_space(membrane, basis):
    model = membrane()
    # Even along the free side: only the nx shapes that do not vary along it answer.
    f = np.zeros(168)
    f[-12:] = 1.0
    f[[-12, -1]] = 0.5
    made = basis(f[:, None])
    assert made.grow(9) == 9
    assert made.grow(30) == model.nx - 10
    assert made.size == model.nx and made.Q.shape[1] == 0 and made.S.shape == (0, model.nx)
    assert made.grow(1) == 0 and made.sizes == tuple(range(1, model.nx + 1))
    assert relation(model, made) < DEPENDENT  # rounding was left out
    # A load that it can hold, and one that it cannot.
    made.add(-model.M @ np.ones((168, 1)))
    assert made.size == model.nx and made.R.shape == (model.nx, 2)
    made.add(model.loads[:, 1:2])
    assert made.size == model.nx + 1 and made.grow(2) == 2
    assert relation(model, made) < DEPENDENT


def test_loads_that_come_later(membrane, basis):
    model = membrane()
    made = basis(model.loads[:, :2])
    made.grow(6)
    before = made.V.copy()
    assert made.sizes == (2, 4, 6, 8, 10, 12, 14)
    start = np.linalg.solve(model.K + SHIFT * model.M, model.loads)

    def left(V, x):
        """Part of x outside the span of V."""
        rest = x - V @ (V.T @ (model.M @ x))
        return np.sqrt((rest @ model.M @ rest) / (x @ model.M @ x))

    assert left(before, start[:, 2]) > 1e-6  # not there by chance
    made.add(model.loads[:, 2:])
    assert made.size == 17 and made.sizes[-1] == 17  # the tail of two, and the new one
    assert np.array_equal(made.V[:, :14], before)
    made.grow(5)
    assert made.R.shape == (32, 3)
    assert np.all(made.R[14:, :2] == 0.0)
    for k in range(3):
        assert left(made.V, start[:, k]) < 1e-10
    assert pytest.approx(start, rel=1e-9, abs=1e-12 * np.abs(start).max()) == made.V @ made.R
    assert relation(model, made) < 1e-13
    assert np.abs(made.V.T @ model.M @ made.V - np.eye(32)).max() < 1e-12


def test_later_loads_keep_the_image_of_the_tail(membrane, basis, monkeypatch):
    """It has no rounding in it any more, and took a solve: one load takes its own two alone."""
    model = membrane()
    made = basis(model.loads[:, :2])
    made.grow(3)
    solved, solve = [], made.solve
    monkeypatch.setattr(made, "solve", lambda F: solved.append(F.shape[1]) or solve(F))
    made.add(model.loads[:, 2:])
    assert solved == [1, 1, 3]  # of the load, of its vector and of the next tail
    assert relation(model, made) < 1e-13


def test_refused(membrane, petsc, basis):
    model = membrane()
    bad = model.loads
    bad[3, 1] = np.nan
    with pytest.raises(SolutionError, match="are not numbers"):
        basis(bad)
    with pytest.raises(SolutionError, match="not positive def"):
        KrylovBasis(petsc(model.K), petsc(model.M), -1.1 * model.eigenvalue[0])
    with KrylovBasis(petsc(model.K), petsc(model.M), 0.0) as made:
        made.add(model.loads)
    assert made.V.shape == (168, 3)  # outlives the factorisation


@pytest.fixture(scope="module")
def of_ranks(membrane, on_ranks):
    model = membrane()
    return on_ranks(SCRIPT, K=model.K, M=model.M, F=model.loads, shift=SHIFT)


def test_same_on_ranks(of_ranks):
    one, many = of_ranks(1), of_ranks(3)
    assert len(many["rows"]) == 3 and 0 in many["rows"]
    assert many["sizes"] == one["sizes"]
    assert many["orthonormal"] < 1e-12
    for name in ("transfer", "residual", "norm"):
        found, expected = many[name], one[name]
        assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max() > 0.0, name
    assert "are not numbers" in many["refused"]


@pytest.fixture
def machine(monkeypatch, tmp_path):
    """Set what the machine has left [kB], and a folder for files."""

    def make(available):
        left = SimpleNamespace(available=1024 * available)
        monkeypatch.setattr(psutil, "virtual_memory", lambda: left)
        monkeypatch.setattr(memory, "GROUP", tmp_path / "nowhere")
        monkeypatch.setenv("TMPDIR", str(tmp_path))

    return make


@pytest.mark.parametrize(("processes", "file"), [(1, False), (2, True)])
def test_memory_first(machine, tmp_path, processes, file):
    """8 kB, and four times as much to spare: 40 kB for one process, 80 for two."""
    machine(40)
    found = orthonormal.room(1000, 1, processes)
    assert (found.pages is not None) is file
    assert found.array.shape == (1000, 1) and found.array.flags.f_contiguous
    found.array[:] = 1.0
    assert found.fetch().sum() == 1000.0
    # No name is left behind, also of a process that is killed.
    assert sorted(path.name for path in tmp_path.iterdir()) == []


def test_nothing_needs_no_file(machine):
    machine(0)
    assert orthonormal.room(0, 64).array.shape == (0, 64)


def test_no_room_at_all(machine, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    machine(0)
    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(SolutionError, match=r"8e-06 GB .*space.*TMPDIR"):
        orthonormal.room(1000, 1)
    monkeypatch.setenv("TMPDIR", "/nowhere/at/all")
    with pytest.raises(SolutionError, match=r"/nowhere/at/all \(No such"):
        orthonormal.room(1000, 1)


def test_a_basis_in_files_is_that_in_memory(machine, membrane, petsc, monkeypatch):
    model, found = membrane(), []
    monkeypatch.setattr(orthonormal, "CHUNK", 8)
    for available in (10**9, 0):
        machine(available)
        basis = KrylovBasis(petsc(model.K), petsc(model.M), 1e5)
        basis.add(model.loads)
        basis.grow(8)
        chunks = basis.vectors._chunks
        assert len(chunks) > 3
        assert all((one.pages is not None) is (available == 0) for one in chunks)
        found.append(basis.V)
    assert np.array_equal(*found)
