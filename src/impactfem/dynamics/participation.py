"""How much mass moves in each mode, for the six rigid-body motions of the base."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from impactfem.dynamics.columns import inner, product

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Participation:
    """Participation of modes with φᵀ M φ = 1.

    Args:
        factor: Participation factors Γ = φᵀ M r, shape (6, n_modes).
        total: Mass and inertia of each direction, rᵀ M r, shape (6,) [kg, kg m2].
    """

    factor: Array
    total: Array

    @property
    def effective_mass(self) -> Array:
        """Effective modal masses and inertias Γ², shape (6, n_modes) [kg, kg m2]."""
        return self.factor**2

    @property
    def share(self) -> Array:
        """Effective masses over the totals, shape (6, n_modes); over all modes they add up to 1."""
        return self.effective_mass / self.total[:, None]


def participation(M: PETSc.Mat, shapes: Array, r: Array) -> Participation:
    """Participation factors of modes. Collective.

    Args:
        M: Mass of the degrees of freedom that are free (AIJ).
        shapes: Rows of this rank of the mode shapes, φᵀ M φ = 1, shape (n_local, n_modes).
        r: Rows of this rank of the rigid-body motions, shape (n_local, 6).
    """
    Mr = product(M, r)
    return Participation(
        factor=inner(M, Mr, shapes),
        total=np.einsum("ii->i", inner(M, r, Mr)).copy(),
    )
