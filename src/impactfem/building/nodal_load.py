"""Forces on nodes, as loads of the building's matrices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.building.local import DOFS
from impactfem.building.model import BuildingModel

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class NodalLoad:
    """Parallel forces on nodes with the resultant 1 N.

    Args:
        nodes: The nodes, shape (n,).
        forces: Force on each of them for the unit resultant, shape (n,) [N/N].
    """

    nodes: Index
    forces: Array

    def vector(self, model: BuildingModel, direction: tuple[float, float, float]) -> Array:
        """The load at this rank's rows, shape (n_local,).

        Args:
            model: The building.
            direction: Direction of the resultant, a unit vector.
        """
        load = np.zeros(DOFS * len(model.nodes))
        rows = model.rows(self.nodes)
        here = rows >= 0
        for axis, part in enumerate(direction):
            load[rows[here] + axis] = part * self.forces[here]
        return load
