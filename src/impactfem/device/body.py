"""A rigid body, and its mass about a point."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.sticks.element import rigid_link
from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body.

    Args:
        mass: m, positive [kg].
        centre: Mass centre, from the anchor, shape (3,) [m]; (0, 0, h) is at the height h.
        inertia: Tensor about the mass centre along the axes, shape (3, 3) [kg m2].

    Raises:
        ImpactfemError: The mass is not positive and finite, or the inertia is not symmetric, or
            negative in a direction.
    """

    mass: float
    centre: Array
    inertia: Array

    def __post_init__(self) -> None:
        if not (math.isfinite(self.mass) and self.mass > 0.0):
            raise ImpactfemError(f"the mass of a body is {self.mass!r} kg: expected a positive one")
        if self.centre.shape != (3,) or not np.all(np.isfinite(self.centre)):
            raise ImpactfemError("the mass centre of a body needs three finite coordinates in m")
        tensor = self.inertia
        if tensor.shape != (3, 3) or not np.all(np.isfinite(tensor)):
            raise ImpactfemError("the inertia of a body needs a finite tensor of shape (3, 3)")
        size = np.max(np.abs(tensor))
        if np.max(np.abs(tensor - tensor.T)) > 1e-9 * size:
            raise ImpactfemError("the inertia tensor of a body is not symmetric")
        if np.linalg.eigvalsh(tensor)[0] < -1e-9 * size:
            raise ImpactfemError("the inertia tensor of a body is negative in a direction")

    @classmethod
    def at_height(cls, mass: float, height: float, *inertia: float) -> Body:
        """A body above its anchor.

        Args:
            mass: m [kg].
            height: Of the mass centre [m].
            inertia: J_x, J_y, J_z about the mass centre [kg m2].

        Raises:
            ImpactfemError: As above, or there are not three inertias.
        """
        if len(inertia) != 3:
            raise ImpactfemError(f"a body has three moments of inertia, got {len(inertia)}")
        return cls(mass, np.array([0.0, 0.0, height]), np.diag(np.asarray(inertia, dtype=float)))

    def about(self, point: Array) -> Array:
        """Mass about a point that moves with the body.

        Args:
            point: From the anchor, shape (3,) [m].

        Returns:
            Shape (6, 6), in the order of COMPONENTS [kg, kg m, kg m2].
        """
        T = rigid_link(self.centre - point)
        own = np.zeros((6, 6))
        own[:3, :3] = self.mass * np.eye(3)
        own[3:, 3:] = self.inertia
        return np.asarray(T.T @ own @ T, dtype=np.float64)


def solid_cylinder(mass: float, radius: float, length: float) -> tuple[float, float, float]:
    """Moments of inertia of a solid upright cylinder about its middle.

    J_x = J_y = m (3 R² + l²) / 12, J_z = m R² / 2.

    Args:
        mass: m [kg].
        radius: R [m].
        length: l [m].
    """
    across = mass * (3.0 * radius**2 + length**2) / 12.0
    return across, across, 0.5 * mass * radius**2
