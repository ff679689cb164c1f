"""All that impactfem knows about versions of dolfinx: 0.5 (Debian 12) to 0.11 (Debian unstable).

Every mesh lives on one rank (its communicator is COMM_SELF). Generations: up to 0.6 function
spaces are made by classes and elements come from ufl; from 0.7 on by functions and from basix.ufl.
"""

import atexit
import fcntl
import inspect
import logging
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from mpi4py import MPI

from impactfem.system.arrays import Array, Index
from impactfem.system.cache import cache_folder
from impactfem.system.files import NO_LOCKS
from impactfem.system.log import LOGGER, root_logger_kept

with root_logger_kept():  # FFCx gives it a handler for every message of every library
    import dolfinx
    import dolfinx.fem.petsc
    import dolfinx.jit
    import ffcx
    import ufl
    from dolfinx import fem, mesh

_BASIX = not hasattr(ufl, "VectorElement")  # elements moved from ufl to basix.ufl in 0.7
_CORNERS = {"triangle": 3, "interval": 2}

for _name in ("FFCx", "ffcx", "UFL", "ufl"):
    logging.getLogger(_name).setLevel(logging.WARNING)

# Options in files of the working folder could name any command as the compiler: what reads them
# gives none. A version in which it has neither of these names (the second up to 0.5) stops here.
for _module in (dolfinx.jit, ffcx.options if hasattr(ffcx, "options") else ffcx.parameters):
    _reader = next(name for name in ("_load_options", "_load_parameters") if hasattr(_module, name))
    setattr(_module, _reader, lambda: ({}, {}))

if not _BASIX:
    # Up to 0.6 FFCx counts derivatives along the axes of space, three, where Basix's tables have
    # those of the cell: on a triangle in space second derivatives are others, or out of bounds.
    import ffcx.ir.elementtables

    _table_values = ffcx.ir.elementtables.get_ffcx_table_values

    def _cell_table_values(points: Any, cell: Any, *others: Any) -> Any:
        *given, derivatives, component = others
        along_cell = derivatives[: cell.topological_dimension()]
        return _table_values(points, cell, *given, along_cell, component)

    ffcx.ir.elementtables.get_ffcx_table_values = _cell_table_values


@dataclass(frozen=True)
class LocalMesh:
    """A mesh of one rank's cells, with straight edges, in three dimensions."""

    mesh: Any  #: dolfinx's mesh
    cells: Index  #: the input's index of each of its cells, shape (n,)
    corners: Index  #: the input's vertex of each corner of each of its cells, shape (n, corners)


def local_mesh(cells: Index, vertices: Array, shape: str) -> LocalMesh:
    """Make a mesh of this rank's cells. Not collective.

    Args:
        cells: Vertices of each cell, shape (n, 3) or (n, 2), n > 0.
        vertices: Coordinates, each used by a cell, shape (m, 3) [m].
        shape: "triangle" or "interval".
    """
    if _BASIX:
        import basix.ufl

        element = basix.ufl.element("Lagrange", shape, 1, shape=(3,))
    else:
        element = ufl.VectorElement("Lagrange", ufl.Cell(shape, geometric_dimension=3), 1)
    # The arguments have another order from 0.10 on, and the element another name from 0.8 on.
    names = inspect.signature(mesh.create_mesh).parameters
    made = mesh.create_mesh(
        MPI.COMM_SELF,
        cells=np.ascontiguousarray(cells, dtype=np.int64),
        x=vertices,
        **{"e" if "e" in names else "domain": ufl.Mesh(element)},
    )
    tables = getattr(made.geometry, "dofmaps", None)  # from 0.11 on, one for each shape of cell
    dofmap = tables[0] if isinstance(tables, list) else made.geometry.dofmap
    given = np.asarray(made.geometry.input_global_indices, dtype=np.int64)
    return LocalMesh(
        mesh=made,
        cells=np.asarray(made.topology.original_cell_index, dtype=np.int64),
        corners=given[_rows(dofmap, _CORNERS[shape])],
    )


def _rows(table: Any, width: int) -> Index:
    """A table with rows of equal length: an adjacency list before 0.7, an array since."""
    return np.asarray(getattr(table, "array", table), dtype=np.int64).reshape(-1, width)


def blocked_space(mesh: Any, size: int, degree: int) -> Any:
    """Lagrange space with `size` components at each node, all of one block."""
    return _space(mesh, "Lagrange", degree, size)


def _space(mesh: Any, family: str, degree: int, size: int | None) -> Any:
    if _BASIX:
        import basix.ufl

        shape = None if size is None else (size,)
        return fem.functionspace(
            mesh, basix.ufl.element(family, mesh.basix_cell(), degree, shape=shape)
        )
    if size is None:
        element = ufl.FiniteElement(family, mesh.ufl_cell(), degree)
    else:
        element = ufl.VectorElement(family, mesh.ufl_cell(), degree, dim=size)
    with _cache() as folder:  # before 0.7 the tables of an element are compiled, too
        return fem.FunctionSpace(mesh, element, **_options(fem.FunctionSpace, folder))


def cell_nodes(space: Any) -> Index:
    """The space's node numbers of each cell, shape (n_cells, nodes of a cell)."""
    dofmap = space.dofmap
    return _rows(dofmap.list, dofmap.dof_layout.num_dofs)


def node_coordinates(space: Any) -> Array:
    """Coordinates of the space's nodes, shape (n_nodes, 3) [m]."""
    return np.asarray(space.tabulate_dof_coordinates(), dtype=np.float64)


def cellwise(mesh: Any, values: Array) -> Any:
    """A function that is constant on each cell.

    Args:
        mesh: dolfinx's mesh.
        values: One number or one vector for each cell of the mesh, shape (n_cells,) or
            (n_cells, size).
    """
    values = np.asarray(values, dtype=np.float64)
    size = values.shape[1] if values.ndim == 2 else None
    function = fem.Function(_space(mesh, "DG", 0, size))
    # A cell's own degree of freedom need not carry the cell's number.
    nodes = cell_nodes(function.function_space)[:, 0]
    ordered = np.empty_like(values)
    ordered[nodes] = values
    function.x.array[:] = ordered.ravel()
    return function


def function(space: Any) -> Any:
    """A function of a space, zero."""
    return fem.Function(space)


def evaluator(expression: Any, mesh: Any, points: Array) -> Callable[[], Array]:
    """Compile an expression for points of the reference cell; call it for the values as they are.

    Args:
        expression: A vector in UFL, of functions and constants that may change between calls.
        mesh: dolfinx's mesh.
        points: Shape (n_points, 2).

    Returns:
        A function without arguments: the values, shape (n_cells, n_points, size).
    """
    with _cache() as folder:
        made = fem.Expression(expression, points, **_options(fem.Expression, folder))
    cells = np.arange(mesh.topology.index_map(mesh.topology.dim).size_local, dtype=np.int32)

    def values() -> Array:
        found = made.eval(mesh, cells) if _BASIX else made.eval(cells)
        return np.asarray(found, dtype=np.float64).reshape(len(cells), len(points), -1)

    return values


def constant(mesh: Any, value: float) -> Any:
    """A number in a form that may change without a new compilation."""
    return fem.Constant(mesh, np.float64(value))


def compiled(form: Any) -> Any:
    """Compile a form, or take it from the cache of forms.

    The cache is impactfem's own and locked while a form is compiled: what a killed process left
    half-made there is thrown away instead of waited for. ImpactfemError where the cache cannot be
    written.
    """
    with _cache() as folder:
        return fem.form(form, **_options(fem.form, folder))


def _options(call: Any, folder: Path) -> dict[str, Any]:
    """The options of compilation under the keyword of this version (renamed in 0.6)."""
    names = inspect.signature(call).parameters
    keyword = "jit_options" if "jit_options" in names else "jit_params"
    return {keyword: {"cache_dir": folder, "timeout": 600}}


def assembled(form: Any) -> Any:
    """The matrix of a compiled form, a PETSc AIJ matrix on COMM_SELF. Not collective."""
    matrix = fem.petsc.assemble_matrix(form)
    matrix.assemble()
    return matrix


@cache
def _separate_folder(shared: Path, reason: str) -> Path:
    """The folder of compiled forms of this process alone, as long as it lives; warns of it."""
    LOGGER.warning(
        "warning: the folder of compiled forms, %s, cannot be locked (%s). Runs cannot share "
        "compiled forms there, so each run compiles its own in a temporary folder, which takes "
        "about a minute. Set XDG_CACHE_HOME to a folder on a local disk",
        shared,
        reason,
    )
    made = TemporaryDirectory(prefix="impactfem-forms-", ignore_cleanup_errors=True)
    atexit.register(made.cleanup)
    return Path(made.name)


@contextmanager
def _cache() -> Iterator[Path]:
    """The folder of compiled forms, locked for this process; where it has no locks, another one."""
    # Compiled code is bound to the versions of Python and dolfinx that made it.
    folder = cache_folder(f"forms-{dolfinx.__version__}-{sys.version_info.minor}")
    with (folder / "lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)  # given back by the kernel when a process is killed
        except OSError as error:
            if error.errno not in NO_LOCKS:
                raise
            folder = _separate_folder(folder, error.strerror)
        for source in folder.glob("*.c"):
            if not source.with_suffix(".c.cached").exists():
                source.unlink()
        before = logging.root.manager.disable
        logging.disable(logging.INFO)  # the compiler's commands, told through the root logger
        try:
            with warnings.catch_warnings():
                # FFCx leaves the closing of the source it makes to the garbage collector.
                warnings.simplefilter("ignore", ResourceWarning)
                yield folder
        finally:
            logging.disable(before)
