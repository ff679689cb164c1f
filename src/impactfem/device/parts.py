"""Parts of a device: base springs, a rigid body, and an upright beam between both."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.sticks.element import COMPONENTS, bending_stiffness, rigid_link
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import ImpactfemError


@dataclass(frozen=True, eq=False)
class BaseSprings:
    """Stiffness of the base against the anchor, both at the anchor point.

    Raises:
        ImpactfemError: The matrix is not symmetric and finite in the motions that are free.
    """

    #: symmetric matrix, shape (6, 6) [N/m, N, N m/rad] in the order of COMPONENTS. Rows and columns
    #: of the blocked motions are not read
    stiffness: Array
    #: which motions the base shares with the anchor, as if their spring were rigid, shape (6,)
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
        """Springs that do not couple, one a direction: x, y, z [N/m], rx, ry, rz [N m/rad].

        Infinity blocks the motion.

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
    def free(self) -> Index:
        """Indices of the motions that are not blocked, in the order of COMPONENTS."""
        return np.flatnonzero(~self.blocked).astype(np.int64)


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A rigid body.

    Raises:
        ImpactfemError: The mass is not positive and finite, or the inertia is not symmetric, or
            negative in a direction.
    """

    mass: float  #: m, positive [kg]
    centre: Array  #: mass centre, from the anchor, shape (3,) [m]; (0, 0, h) is at the height h
    inertia: Array  #: tensor about the mass centre along the axes, shape (3, 3) [kg m2]

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
    def at_height(cls, mass: float, height: float, *inertia: float) -> RigidBody:
        """A body with its mass centre [m] above its anchor, and J_x, J_y, J_z about it [kg m2].

        Raises:
            ImpactfemError: As above, or there are not three inertias.
        """
        if len(inertia) != 3:
            raise ImpactfemError(f"a body has three moments of inertia, got {len(inertia)}")
        return cls(mass, np.array([0.0, 0.0, height]), np.diag(np.asarray(inertia, dtype=float)))

    def about(self, point: Array) -> Array:
        """Mass (6, 6) about a point that moves with the body, from the anchor [m]."""
        T = rigid_link(self.centre - point)
        own = np.zeros((6, 6))
        own[:3, :3] = self.mass * np.eye(3)
        own[3:, 3:] = self.inertia
        return np.asarray(T.T @ own @ T, dtype=np.float64)


def solid_cylinder(mass: float, radius: float, length: float) -> tuple[float, float, float]:
    """Moments of inertia of a solid upright cylinder about its middle.

    J_x = J_y = m (3 R² + l²) / 12, J_z = m R² / 2.
    """
    across = mass * (3.0 * radius**2 + length**2) / 12.0
    return across, across, 0.5 * mass * radius**2


# Across the beam, and the rotation that bends it there: dv/dz = -r_x, du/dz = +r_y.
PLANES = ((0, 4, 1.0), (1, 3, -1.0))


@dataclass(frozen=True)
class Beam:
    """An upright beam from the anchor point upwards.

    Raises:
        ImpactfemError: A stiffness or the length is not positive, the mass is negative, or there is
            no element.
    """

    length: float  #: l [m]
    bending_x: float  #: E I for bending about x, which moves it along y [N m2]
    bending_y: float  #: E I for bending about y, which moves it along x [N m2]
    shear_x: float = math.inf  #: shear stiffness G A_v along x [N]; infinite when left out
    shear_y: float = math.inf  #: along y
    stretching: float = math.inf  #: E A [N]; infinite when left out
    twisting: float = math.inf  #: G J [N m2]; infinite when left out
    mass: float = 0.0  #: of the whole beam, evenly distributed [kg]; its rotary inertia is left out
    elements: int = 4  #: number of elements

    def __post_init__(self) -> None:
        for name in ("length", "bending_x", "bending_y"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ImpactfemError(f"the beam's {name} is {value!r}: expected a positive number")
        for name in ("shear_x", "shear_y", "stretching", "twisting"):
            if not getattr(self, name) > 0.0:
                raise ImpactfemError(
                    f"the beam's {name} is {getattr(self, name)!r}: expected a positive number, or"
                    " infinity for a rigid one"
                )
        if not (math.isfinite(self.mass) and self.mass >= 0.0):
            raise ImpactfemError(f"the beam's mass is {self.mass!r} kg: expected 0 or more")
        if self.elements < 1:
            raise ImpactfemError(f"a beam of {self.elements} elements: expected at least one")

    @property
    def heights(self) -> Array:
        """Of the nodes, the base first, shape (elements + 1,) [m]."""
        return np.asarray(np.linspace(0.0, self.length, self.elements + 1), dtype=np.float64)

    @property
    def deforming(self) -> tuple[int, ...]:
        """Components of a node that deform against the base."""
        along = [(2, self.stretching), (5, self.twisting)]
        return (0, 1, 3, 4, *(c for c, stiffness in along if math.isfinite(stiffness)))

    def matrices(self) -> tuple[Array, Array]:
        """Mass and stiffness of all nodes, shape (6 (elements + 1), 6 (elements + 1)) each.

        A node's six components come one after the other. Rows without stiffness belong to what does
        not deform.
        """
        n = 6 * (self.elements + 1)
        M, K = np.zeros((n, n)), np.zeros((n, n))
        h, m = self.length / self.elements, self.mass / self.elements
        # Integrals of the products of Hermite's cubics.
        across = (m / 420.0) * np.array(
            [
                [156.0, 22.0 * h, 54.0, -13.0 * h],
                [22.0 * h, 4.0 * h**2, 13.0 * h, -3.0 * h**2],
                [54.0, 13.0 * h, 156.0, -22.0 * h],
                [-13.0 * h, -3.0 * h**2, -22.0 * h, 4.0 * h**2],
            ]
        )
        along = m / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
        pull = np.array([[1.0, -1.0], [-1.0, 1.0]]) / h
        bending = (self.bending_y, self.shear_x), (self.bending_x, self.shear_y)
        for e in range(self.elements):
            for (u, r, sign), (EI, GAv) in zip(PLANES, bending, strict=True):
                signs = np.outer(*(2 * [np.array([1.0, sign, 1.0, sign])]))
                here = 6 * e + np.array([u, r, u + 6, r + 6])
                K[np.ix_(here, here)] += signs * bending_stiffness(h, EI, GAv)
                M[np.ix_(here, here)] += signs * across
            here = 6 * e + np.array([2, 8])
            M[np.ix_(here, here)] += along
            for component, stiffness in ((2, self.stretching), (5, self.twisting)):
                if math.isfinite(stiffness):
                    here = 6 * e + np.array([component, component + 6])
                    K[np.ix_(here, here)] += stiffness * pull
        return M, K
