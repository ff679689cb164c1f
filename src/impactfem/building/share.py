"""Which rank has which cells of a building, and the order of the rows that follows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.local import DOFS
from impactfem.building.parts import BuildingParts, Kind
from impactfem.system.errors import SolutionError

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def bisect(points: Array, weights: Array, parts: int) -> Index:
    """Divide points into compact parts of about equal weight by recursive coordinate bisection.

    Args:
        points: Coordinates, shape (n, 3) [m].
        weights: Weight of each point, shape (n,).
        parts: Number of parts; some are empty when there are fewer points.

    Returns:
        Part of each point, 0 to parts − 1, shape (n,). The same for the same input.
    """
    part = np.zeros(len(points), dtype=np.int64)
    _divide(part, np.arange(len(points)), points, weights, 0, parts)
    return part


def _divide(
    part: Index, members: Index, points: Array, weights: Array, first: int, parts: int
) -> None:
    if parts == 1 or members.size == 0:
        part[members] = first
        return
    lower = parts // 2
    axis = int(np.argmax(np.ptp(points[members], axis=0)))
    order = members[np.argsort(points[members, axis], kind="stable")]
    cumulative = np.cumsum(weights[order])
    # Middles of the steps, so that a single point falls on the side where most of it lies.
    middle = cumulative - 0.5 * weights[order]
    cut = int(np.searchsorted(middle, cumulative[-1] * lower / parts))
    _divide(part, order[:cut], points, weights, first, lower)
    _divide(part, order[cut:], points, weights, first + lower, parts - lower)


@dataclass(frozen=True)
class Numbering:
    """Order of all nodes in the global matrices, the same on all ranks.

    Args:
        comm: Communicator of the matrices.
        place: Place of each node among the blocks of rows, shape (n_nodes,).
        owned: Nodes of this rank's rows in their order, shape (n_owned,).
    """

    comm: Any
    place: Index
    owned: Index


def number_nodes(comm: Any, n_nodes: int, cells: list[Index], parts: list[Index]) -> Numbering:
    """Give each node to the lowest rank that has a cell with it.

    Args:
        comm: Communicator.
        n_nodes: Number of nodes.
        cells: Nodes of all cells, one array (m, k) for each kind.
        parts: Rank of all cells, one array (m,) for each kind.

    Raises:
        SolutionError: A node belongs to no cell.
    """
    owner = np.full(n_nodes, comm.size, dtype=np.int64)
    for nodes, ranks in zip(cells, parts, strict=True):
        np.minimum.at(owner, nodes.ravel(), np.repeat(ranks, nodes.shape[1]))
    if np.any(owner == comm.size):
        alone = int(np.argmax(owner == comm.size))
        raise SolutionError(f"node {alone} belongs to no shell and no beam")
    order = np.argsort(owner, kind="stable")
    place = np.empty(n_nodes, dtype=np.int64)
    place[order] = np.arange(n_nodes)
    first, last = np.searchsorted(owner[order], [comm.rank, comm.rank + 1])
    return Numbering(comm, place, order[first:last])


@dataclass(frozen=True)
class Share:
    """A rank's share of a building.

    Args:
        kinds: All cells by kind, the same on all ranks.
        mine: Of each kind the cells of this rank.
        numbering: Order of the rows.
        base: Nodes that are clamped.
    """

    kinds: list[Kind]
    mine: list[Index]
    numbering: Numbering
    base: Index

    @property
    def free(self) -> NDArray[np.bool_]:
        """Whether each row of this rank is free, clamped nodes included, shape (n_local,)."""
        return np.repeat(np.isin(self.numbering.owned, self.base, invert=True), DOFS)

    def free_rows(self, matrix: Any) -> Index:
        """This rank's free rows of a matrix of all nodes, as global numbers, ascending."""
        first = int(matrix.getOwnershipRange()[0])
        return first + np.flatnonzero(self.free)


def shared_out(comm: Any, parts: BuildingParts) -> Share:
    """Share out the cells of a building. Collective.

    Args:
        comm: Communicator.
        parts: Mesh and sections, the same on all ranks.

    Raises:
        SolutionError: A node belongs to no cell.
    """
    mesh, kinds = parts.mesh, parts.kinds()
    centres = np.vstack([mesh.nodes[kind.cells].mean(axis=1) for kind in kinds])
    weights = np.concatenate([np.full(len(k.cells), float(k.cells.shape[1])) for k in kinds])
    joint = bisect(centres, weights, comm.size)
    ranks = np.split(joint, np.cumsum([len(kind.cells) for kind in kinds])[:-1])
    numbering = number_nodes(comm, len(mesh.nodes), [kind.cells for kind in kinds], ranks)
    mine = [np.flatnonzero(rank == comm.rank) for rank in ranks]
    return Share(kinds, mine, numbering, mesh.base)
