"""The beam between the base of a device and its body: an upright cantilever.

Its nodes move by u = (rigid motion of the base) + d. In an element, cubic shape functions carry the
translations across it and linear ones those along it; they make the mass matrix. The stiffness is
that of Timoshenko's beam, exact for loads at the nodes; with an infinite shear stiffness, Euler and
Bernoulli's. Stretching and twisting are left out where their stiffness is infinite.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.sticks.element import bending_stiffness
from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]

# Across the beam, and the rotation that bends it there: dv/dz = -r_x, du/dz = +r_y.
PLANES = ((0, 4, 1.0), (1, 3, -1.0))


@dataclass(frozen=True)
class Beam:
    """An upright beam from the anchor point upwards.

    Args:
        length: l [m].
        bending_x: E I for bending about x, which moves it along y [N m2].
        bending_y: E I for bending about y, which moves it along x [N m2].
        shear_x: Shear stiffness G A_v along x [N]; infinite when left out.
        shear_y: Along y.
        stretching: E A [N]; infinite when left out.
        twisting: G J [N m2]; infinite when left out.
        mass: Of the whole beam, evenly distributed [kg]; its rotary inertia is left out.
        elements: Number of elements.

    Raises:
        ImpactfemError: A stiffness or the length is not positive, the mass is negative, or there is
            no element.
    """

    length: float
    bending_x: float
    bending_y: float
    shear_x: float = math.inf
    shear_y: float = math.inf
    stretching: float = math.inf
    twisting: float = math.inf
    mass: float = 0.0
    elements: int = 4

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
        """Mass and stiffness of all nodes.

        Returns:
            M and K, shape (6 (elements + 1), 6 (elements + 1)) each, a node's six components one
            after the other. Rows without stiffness belong to what does not deform.
        """
        n = 6 * (self.elements + 1)
        M, K = np.zeros((n, n)), np.zeros((n, n))
        h, m = self.length / self.elements, self.mass / self.elements
        across = m / 420.0 * _cubic(h)
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


def _cubic(h: float) -> Array:
    """Integrals of the products of Hermite's cubics, times 420 over the length."""
    return np.array(
        [
            [156.0, 22.0 * h, 54.0, -13.0 * h],
            [22.0 * h, 4.0 * h**2, 13.0 * h, -3.0 * h**2],
            [54.0, 13.0 * h, 156.0, -22.0 * h],
            [-13.0 * h, -3.0 * h**2, -22.0 * h, 4.0 * h**2],
        ]
    )
