"""The room of dolfinx's versions: the cache of compiled forms, and when dolfinx is loaded."""

import atexit
import errno
import fcntl
import os
import subprocess
import sys
import tempfile

import dolfinx
import numpy as np
import pytest
import scipy.sparse
import ufl

from impactfem import _fenicsx
from impactfem.system.errors import ImpactfemError

TRIANGLE = np.array([[0, 1, 2]]), np.array([[0.0, 0, 0], [2.0, 0, 0], [0, 3.0, 0]])


@pytest.fixture
def cache(monkeypatch, tmp_path):
    """An empty cache of forms."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "impactfem"


def cache_folder():
    with _fenicsx._cache() as folder:
        return folder


def total(factor=1.0):
    """∫ factor · 1 · 1 over the first component of a triangle of 3 m2."""
    mesh = _fenicsx.local_mesh(*TRIANGLE, "triangle").mesh
    space = _fenicsx.blocked_space(mesh, 6, 2)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    mass = _fenicsx.constant(mesh, factor) * ufl.inner(u, v) * ufl.dx(mesh)
    matrix = _fenicsx.assembled(_fenicsx.compiled(mass))
    indptr, indices, values = matrix.getValuesCSR()
    rows = np.repeat(np.arange(len(indptr) - 1), np.diff(indptr))
    return values[(rows % 6 == 0) & (indices % 6 == 0)].sum()


def test_second_derivatives_on_a_triangle_in_space():
    """Σ of the squares of all second derivatives of x² + 3 x y − y²: 4 + 2 · 9 + 4, on 3 m2.

    FFCx of dolfinx 0.5 takes others' tables, or none, on a surface in space.
    """
    mesh = _fenicsx.local_mesh(*TRIANGLE, "triangle").mesh
    space = _fenicsx.blocked_space(mesh, 6, 2)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    second = ufl.inner(ufl.grad(ufl.grad(u)), ufl.grad(ufl.grad(v))) * ufl.dx(mesh)
    indptr, indices, entries = _fenicsx.assembled(_fenicsx.compiled(second)).getValuesCSR()
    matrix = scipy.sparse.csr_matrix((entries, indices, indptr))
    x, y, _ = _fenicsx.node_coordinates(space).T
    given = np.zeros((len(x), 6))
    given[:, 4] = x**2 + 3.0 * x * y - y**2
    assert given.ravel() @ matrix @ given.ravel() == pytest.approx(26.0 * 3.0)


def test_forms_are_compiled_once(cache):
    assert total() == pytest.approx(3.0)
    compiled = {path: path.stat().st_mtime_ns for path in cache.glob("*/*.so")}
    assert compiled
    # Another value of a constant is no other form.
    assert total(2.0) == pytest.approx(6.0)
    assert {path: path.stat().st_mtime_ns for path in cache.glob("*/*.so")} == compiled


def test_what_a_killed_compilation_left_is_thrown_away(cache):
    """A `.c` without its mark: FFCx would wait for a process that is no more, and then give up."""
    assert total() == pytest.approx(3.0)
    libraries = list(cache.glob("*/*.so"))
    for library in libraries:
        name = library.name.split(".")[0]
        library.unlink()
        library.with_name(f"{name}.c.cached").unlink()
        library.with_name(f"{name}.c").write_text("half a source")
    assert total() == pytest.approx(3.0)
    assert sorted(cache.glob("*/*.so")) == sorted(libraries)


def test_finished_forms_stay(cache):
    folder = cache_folder()
    for name in ("done.c", "done.c.cached", "half.c"):
        (folder / name).touch()
    with _fenicsx._cache() as found:
        assert found == folder
    assert sorted(path.name for path in folder.glob("*.c*")) == ["done.c", "done.c.cached"]


LOCK = """
import fcntl, sys
try:
    fcntl.flock(open(sys.argv[1], "w"), fcntl.LOCK_EX | fcntl.LOCK_NB)
except BlockingIOError:
    print("taken")
"""


def test_the_cache_is_locked_while_a_form_is_compiled(cache):
    def asked_by_another_process(folder):
        command = [sys.executable, "-I", "-c", LOCK, folder / "lock"]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    with _fenicsx._cache() as folder:
        assert asked_by_another_process(folder) == "taken"
    assert asked_by_another_process(folder) == ""


@pytest.mark.parametrize("code", [errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP])
def test_a_cache_on_a_file_system_without_locks(cache, monkeypatch, caplog, code):
    """Each process compiles for itself, in a folder that goes with it, and says so once."""
    shared = cache_folder()

    def flock(file, how):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(fcntl, "flock", flock)
    at_exit = []
    monkeypatch.setattr(atexit, "register", at_exit.append)
    _fenicsx._separate_folder.cache_clear()
    (shared / "half.c").touch()  # of another process that compiles just now
    with _fenicsx._cache() as folder, _fenicsx._cache() as again:
        assert folder == again and folder != shared and folder.is_dir()
    assert total() == pytest.approx(3.0)
    assert list(folder.glob("*.so")) and (shared / "half.c").exists()
    assert caplog.text.count("warning: ") == 1 and str(shared) in caplog.text
    at_exit[0]()
    assert not folder.exists()
    _fenicsx._separate_folder.cache_clear()


def test_another_failure_of_a_lock_is_an_error(cache, monkeypatch):
    def flock(file, how):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(fcntl, "flock", flock)
    with pytest.raises(OSError, match=os.strerror(errno.EIO)), _fenicsx._cache():
        pass


def test_a_cache_that_cannot_be_written(monkeypatch, tmp_path):
    """A file stands where the folder should be: the next place is taken, if there is one."""
    blocked = tmp_path / "blocked"
    blocked.touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(blocked))
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(tmp_path))
    folder = cache_folder()
    assert folder.parent.parent == tmp_path / f"impactfem-{os.getuid()}"
    assert total() == pytest.approx(3.0)
    assert list(folder.glob("*.so"))
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(blocked))
    with pytest.raises(ImpactfemError, match=r"compiled code .*blocked"):
        cache_folder()


def test_the_cache_belongs_to_versions(cache):
    name = cache_folder().name
    assert name == f"forms-{dolfinx.__version__}-{sys.version_info.minor}"


def test_values_go_to_their_cells():
    """A value on each cell of a mesh whose cells dolfinx may have put in another order."""
    x = np.arange(9.0)
    cells = np.column_stack([np.arange(8), np.arange(1, 9)])[::-1]
    made = _fenicsx.local_mesh(cells, np.outer(x, [1.0, 2.0, 2.0]), "interval")
    # The middle of a cell's ends: its place, which the integral of a product with x shows.
    values = np.random.default_rng(5).random((8, 2))
    function = _fenicsx.cellwise(made.mesh, values[made.cells])
    s = ufl.SpatialCoordinate(made.mesh)[0]
    space = _fenicsx.blocked_space(made.mesh, 1, 2)
    test = ufl.TestFunction(space)[0] * ufl.TrialFunction(space)[0]
    for k in (0, 1):
        matrix = _fenicsx.assembled(_fenicsx.compiled(function[k] * s * test * ufl.dx(made.mesh)))
        # Cell i, from x to x + 1 with ds = 3 dx: ∫ s ds = 3 (x + ½).
        exact = 3.0 * values[:, k] @ (cells[:, 0] + 0.5)
        assert matrix.getValuesCSR()[2].sum() == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize(
    ("module", "heavy"),
    [
        *(
            (name, False)
            for name in ("cli", "case", "stages.pounding.stage", "study", "motion.from_case")
        ),
        ("building.model", True),
    ],
)
def test_what_is_loaded(module, heavy):
    """In a process of its own: dolfinx and PETSc are there after `building.model` alone."""
    script = (
        f"import sys, impactfem.{module}\n"
        "print({'dolfinx', 'petsc4py', 'slepc4py', 'ufl'} & set(sys.modules) or '')"
    )
    ended = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert bool(ended.stdout.strip()) is heavy, ended.stdout
