"""The Timoshenko beam element of a storey: a vertical member with six degrees of freedom a node."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from impactfem.system.arrays import Array

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
"""Translations along and rotations about the axes; z points upwards."""


@dataclass(frozen=True)
class Section:
    """Cross-section and material of a vertical member, in the building's axes."""

    E: float  #: Young's modulus [Pa]
    G: float  #: shear modulus [Pa]
    A: float  #: area [m2]
    Avx: float  #: shear area along x [m2]
    Avy: float  #: shear area along y [m2]
    Ix: float  #: second moment of area about x, for bending that moves the member along y [m4]
    Iy: float  #: second moment of area about y, for bending that moves the member along x [m4]
    Iz: float  #: torsion constant about the member's axis [m4]

    def stiffness(self, L: float, share: float) -> Array:
        """Stiffness of a piece of the member of length L [m], shape (12, 12)."""
        return storey_stiffness(L, self)

    def shear_area(self, n_x: float, n_y: float) -> float:
        """Shear area along a horizontal unit vector [m2]."""
        return n_x**2 * self.Avx + n_y**2 * self.Avy


@dataclass(frozen=True)
class StoreySprings:
    """A storey as springs between the floors: a shear building, whose floors stay level.

    The storey shear is V = k (u_upper - u_lower). Columns that do not shorten carry the moment V h
    down to the base, so that translations and rotations do not couple. Displacements are those
    relative to the base, which may turn on soil.
    """

    kx: float  #: lateral stiffness along x, storey shear over storey drift [N/m]
    ky: float  #: lateral stiffness along y [N/m]
    kz: float  #: axial stiffness [N/m]
    krx: float  #: rotational stiffness about x [N m/rad]
    kry: float  #: rotational stiffness about y [N m/rad]
    kt: float  #: torsional stiffness about z [N m/rad]

    def stiffness(self, L: float, share: float) -> Array:
        """Stiffness of a piece with this share of the storey's height, shape (12, 12)."""
        k = np.array([self.kx, self.ky, self.kz, self.krx, self.kry, self.kt]) / share
        return np.kron(np.array([[1.0, -1.0], [-1.0, 1.0]]), np.diag(k))

    def shear_area(self, n_x: float, n_y: float) -> float:
        """Shear area, which springs do not have."""
        return np.nan


def bending_stiffness(L: float, EI: float, GAv: float) -> Array:
    """Stiffness of a Timoshenko member of length L [m] in one plane, shape (4, 4) [N, m].

    With Φ = 12 EI / (G A_v L²) the matrix is exact for end loads (Przemieniecki 1968, Theory of
    Matrix Structural Analysis, equation 5.116). It is that of (v₁, φ₁, v₂, φ₂), where φ = dv/dz for
    a member without shear strain; EI is the bending stiffness [N m2], GAv the shear stiffness [N].
    """
    Phi = 12.0 * EI / (GAv * L**2)
    k = EI / (L**3 * (1.0 + Phi))
    return k * np.array(
        [
            [12.0, 6.0 * L, -12.0, 6.0 * L],
            [6.0 * L, (4.0 + Phi) * L**2, -6.0 * L, (2.0 - Phi) * L**2],
            [-12.0, -6.0 * L, 12.0, -6.0 * L],
            [6.0 * L, (2.0 - Phi) * L**2, -6.0 * L, (4.0 + Phi) * L**2],
        ]
    )


def storey_stiffness(L: float, section: Section) -> Array:
    """Stiffness of a vertical member of length L [m] between two nodes, shape (12, 12).

    Axial, torsional and bending parts do not couple: the section's axes are the building's. A
    rotation about x tilts the member so that dv/dz = -r_x along y; one about y so that du/dz = +r_y
    along x. The six components (ux, uy, uz, rx, ry, rz) of the lower node come first.
    """
    k = np.zeros((12, 12))
    for dof, rigidity in ((2, section.E * section.A), (5, section.G * section.Iz)):
        k[np.ix_([dof, dof + 6], [dof, dof + 6])] += (
            rigidity / L * np.array([[1.0, -1.0], [-1.0, 1.0]])
        )
    for u, r, sign, EI, GAv in (
        (0, 4, 1.0, section.E * section.Iy, section.G * section.Avx),
        (1, 3, -1.0, section.E * section.Ix, section.G * section.Avy),
    ):
        signs = np.array([1.0, sign, 1.0, sign])
        dofs = [u, r, u + 6, r + 6]
        k[np.ix_(dofs, dofs)] += bending_stiffness(L, EI, GAv) * np.outer(signs, signs)
    return k


def rigid_link(offset: ArrayLike) -> Array:
    """Motion of a point that a rigid link ties to a node: u + θ × r, and the same θ.

    The matrix, shape (6, 6), takes the node's components to those of the point at r from it [m].
    """
    x, y, z = np.asarray(offset, dtype=np.float64)
    T = np.eye(6)
    T[0, 4], T[0, 5] = z, -y
    T[1, 3], T[1, 5] = -z, x
    T[2, 3], T[2, 4] = y, -x
    return T
