"""Which rank has which cells of a building, and the order of the rows that follows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.local import DOFS
from impactfem.building.numbering import Numbering, number_nodes
from impactfem.building.partition import bisect
from impactfem.building.parts import BuildingParts, Kind

Index = NDArray[np.int64]


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
