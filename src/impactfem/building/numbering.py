"""The rows of the global matrices: which rank owns a node, and in which order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.system.errors import SolutionError

Index = NDArray[np.int64]


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
