"""The springs between the base of a device and its anchor."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
"""Translations along and rotations about the axes; z points upwards."""


@dataclass(frozen=True, eq=False)
class BaseSprings:
    """Stiffness of the base against the anchor, both at the anchor point.

    Args:
        stiffness: Symmetric matrix, shape (6, 6) [N/m, N, N m/rad] in the order of COMPONENTS.
            Rows and columns of the blocked motions are not read.
        blocked: Which motions the base shares with the anchor, as if their spring were rigid,
            shape (6,).

    Raises:
        ImpactfemError: The matrix is not symmetric and finite in the motions that are free.
    """

    stiffness: Array
    blocked: npt.NDArray[np.bool_]

    def __post_init__(self) -> None:
        if self.stiffness.shape != (6, 6) or self.blocked.shape != (6,):
            raise ImpactfemError(
                f"base springs need a matrix of shape (6, 6) and 6 marks, got"
                f" {self.stiffness.shape} and {self.blocked.shape}"
            )
        k = self.stiffness[np.ix_(~self.blocked, ~self.blocked)]
        if not np.all(np.isfinite(k)) or not np.allclose(k, k.T, rtol=1e-9, atol=0.0):
            raise ImpactfemError("the stiffness matrix of the base must be symmetric and finite")

    @classmethod
    def of_directions(cls, **stiffness: float) -> BaseSprings:
        """Springs that do not couple, one a direction.

        Args:
            stiffness: By component x, y, z [N/m], rx, ry, rz [N m/rad]. Infinity blocks the motion.

        Raises:
            ImpactfemError: A component is missing or unknown, or its stiffness is not a number.
        """
        if set(stiffness) != set(COMPONENTS):
            raise ImpactfemError(
                f"base springs need a stiffness for each of {', '.join(COMPONENTS)} (infinity"
                f" blocks a motion); got {', '.join(sorted(stiffness)) or 'none'}"
            )
        k = np.array([float(stiffness[name]) for name in COMPONENTS])
        if np.any(np.isnan(k)):
            raise ImpactfemError("the stiffness of a base spring is not a number")
        blocked = k == math.inf
        return cls(np.diag(np.where(blocked, 0.0, k)), blocked)

    @property
    def free(self) -> npt.NDArray[np.int64]:
        """Indices of the motions that are not blocked, in the order of COMPONENTS."""
        return np.flatnonzero(~self.blocked).astype(np.int64)
