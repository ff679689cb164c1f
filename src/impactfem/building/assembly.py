"""From each rank's share of the cells to one global matrix.

A distributed mesh of dolfinx 0.6 to 0.9 tears apart where three panels meet at an edge, so each
rank makes a mesh of its own cells only, and the numbers of the nodes come from the mesh file's
quadratic cells.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from impactfem._fenicsx import blocked_space, cell_nodes, local_mesh, node_coordinates
from impactfem.building.mesh import DOFS
from impactfem.building.parts import BuildingParts, Kind
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError

# The kinds of cells: vertices, and for each vertex of a triangle the place of the mid node of the
# opposite edge in the mesh file's cell, whose mid nodes are those of the edges 01, 12 and 20.
_SHAPES = {3: "interval", 6: "triangle"}
_OPPOSITE = np.array([4, 5, 3])


@dataclass(frozen=True)
class LocalCells:
    """A rank's cells of one kind."""

    space: Any  #: P2 space with six components on them.
    cells: Index  #: Of each cell of the space's mesh its index in what was given, (n_cells,).
    nodes: Index  #: For each node of the space its global number, shape (n_nodes,).

    @property
    def mesh(self) -> Any:
        """The mesh of the space."""
        return self.space.mesh


def local_cells(nodes: Array, cells: Index) -> LocalCells:
    """Make the mesh and the space of a rank's cells. Not collective.

    `cells` are global nodes: shape (m, 6) of triangles, vertices and mid nodes of the edges 01, 12,
    20; or shape (m, 3) of intervals, ends and mid node; m > 0. SolutionError where the nodes of
    dolfinx's space are not where the mesh file's are.
    """
    width = cells.shape[1]
    corners = {6: 3, 3: 2}[width]
    used, numbered = np.unique(cells[:, :corners], return_inverse=True)
    made = local_mesh(numbered.reshape(-1, corners), nodes[used], _SHAPES[width])
    space = blocked_space(made.mesh, DOFS, 2)
    vertices = used[made.corners]
    rows = cells[made.cells]
    if width == 6:
        # An edge of dolfinx's triangle is opposite to the vertex of its number.
        place = np.argmax(vertices[:, :, None] == rows[:, None, :3], axis=2)
        mids = np.take_along_axis(rows, _OPPOSITE[place], axis=1)
    else:
        mids = rows[:, 2:]
    where = node_coordinates(space)
    numbers = np.full(len(where), -1, dtype=np.int64)
    numbers[cell_nodes(space)] = np.hstack([vertices, mids])
    away = np.linalg.norm(where - nodes[numbers], axis=1)
    if np.any(numbers < 0) or away.max() > 1e-6 * np.ptp(where, axis=0).max():
        worst = int(np.argmax(away))
        place = ", ".join(f"{x:g}" for x in nodes[numbers[worst]])
        raise SolutionError(
            f"node {numbers[worst]} at ({place}) m lies {away[worst]:.3g} m from its edge's "
            "middle; expected straight edges with mid nodes in the middle"
        )
    return LocalCells(space, made.cells, numbers)


def bisect(points: Array, weights: Array, parts: int) -> Index:
    """Divide points into compact parts of about equal weight by recursive coordinate bisection.

    The part of each point, 0 to parts − 1; some are empty when there are fewer points. The same for
    the same input.
    """
    part = np.zeros(len(points), dtype=np.int64)

    def divide(members: Index, first: int, count: int) -> None:
        if count == 1 or members.size == 0:
            part[members] = first
            return
        lower = count // 2
        # Across the longest extent, where the weights on either side go as the numbers of parts.
        axis = int(np.argmax(np.ptp(points[members], axis=0)))
        order = members[np.argsort(points[members, axis], kind="stable")]
        cumulative = np.cumsum(weights[order])
        # Middles of the steps, so that a single point falls on the side where most of it lies.
        middle = cumulative - 0.5 * weights[order]
        cut = int(np.searchsorted(middle, cumulative[-1] * lower / count))
        divide(order[:cut], first, lower)
        divide(order[cut:], first + lower, count - lower)

    divide(np.arange(len(points)), 0, parts)
    return part


@dataclass(frozen=True)
class Share:
    """A rank's share of a building."""

    comm: Any  #: Communicator of the matrices.
    kinds: list[Kind]  #: All cells by kind, the same on all ranks.
    cells_here: list[Index]  #: Of each kind the cells of this rank, by number.
    place: Index  #: Place of each node among the blocks of rows, the same on all ranks, (n_nodes,).
    owned: Index  #: Nodes of this rank's rows in their order, shape (n_owned,).
    base: Index  #: Nodes that are clamped.

    @property
    def free(self) -> NDArray[np.bool_]:
        """Whether each row of this rank is free, clamped nodes included, shape (n_local,)."""
        return np.repeat(np.isin(self.owned, self.base, invert=True), DOFS)

    def free_rows(self, matrix: Any) -> Index:
        """This rank's free rows of a matrix of all nodes, as global numbers, ascending."""
        first = int(matrix.getOwnershipRange()[0])
        return first + np.flatnonzero(self.free)


def shared_out(comm: Any, parts: BuildingParts) -> Share:
    """Share out the cells of a building, the same on all ranks. Collective.

    A node that belongs to no cell is refused.
    """
    mesh, kinds = parts.mesh, parts.kinds()
    centres = np.vstack([mesh.nodes[kind.cells].mean(axis=1) for kind in kinds])
    weights = np.concatenate([np.full(len(k.cells), float(k.cells.shape[1])) for k in kinds])
    joint = bisect(centres, weights, comm.size)
    ranks = np.split(joint, np.cumsum([len(kind.cells) for kind in kinds])[:-1])
    # Each node is of the lowest rank that has a cell with it.
    owner = np.full(len(mesh.nodes), comm.size, dtype=np.int64)
    for kind, rank in zip(kinds, ranks, strict=True):
        np.minimum.at(owner, kind.cells.ravel(), np.repeat(rank, kind.cells.shape[1]))
    if np.any(owner == comm.size):
        alone = int(np.argmax(owner == comm.size))
        raise SolutionError(f"node {alone} belongs to no shell and no beam")
    order = np.argsort(owner, kind="stable")
    place = np.empty(len(mesh.nodes), dtype=np.int64)
    place[order] = np.arange(len(mesh.nodes))
    first, last = np.searchsorted(owner[order], [comm.rank, comm.rank + 1])
    cells_here = [np.flatnonzero(rank == comm.rank) for rank in ranks]
    return Share(comm, kinds, cells_here, place, order[first:last], mesh.base)


def global_matrix(local: Any | None, nodes: Index, share: Share) -> Any:
    """Add the ranks' matrices up to one, PETSc AIJ, clamped nodes included. Collective.

    `local` is this rank's, PETSc AIJ on COMM_SELF with six rows for each of its nodes, whose
    global numbers are `nodes`, shape (n,); None on a rank without cells. It is destroyed.
    """
    comm = share.comm
    if local is None:
        local = PETSc.Mat().createAIJ((0, 0), bsize=DOFS, nnz=0, comm=PETSc.COMM_SELF)
        local.assemble()
    blocks = share.place[nodes].astype(PETSc.IntType)
    mapping = PETSc.LGMap().create(blocks, bsize=DOFS, comm=comm)
    rows = DOFS * len(share.owned), DOFS * len(share.place)
    joined = PETSc.Mat().create(comm)
    joined.setSizes((rows, rows), bsize=DOFS)
    joined.setType("is")
    joined.setLGMap(mapping, mapping)
    joined.setISLocalMat(local)
    joined.assemble()
    matrix = joined.convert("aij", PETSc.Mat())
    joined.destroy()
    local.destroy()
    return matrix


def added(matrices: list[Any], share: Share) -> Any:
    """Sum of matrices with any patterns, which are destroyed; zero without any. Collective."""
    if not matrices:
        return global_matrix(None, np.empty(0, dtype=np.int64), share)
    total, *others = matrices
    for other in others:
        total.axpy(1.0, other, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        other.destroy()
    return total


def without(matrix: Any, free: Index) -> Any:
    """Rows and columns of the free degrees of freedom of a matrix, destroyed. Collective.

    `free` are this rank's rows that stay, as global numbers in ascending order, shape (n,).
    """
    rows = PETSc.IS().createGeneral(free.astype(PETSc.IntType), comm=matrix.comm)
    rows.setBlockSize(DOFS)
    part = matrix.createSubMatrix(rows, rows)
    matrix.destroy()
    rows.destroy()
    return part
