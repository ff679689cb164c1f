"""Natural modes of a stick: frequencies, participation, effective masses, families."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from impactfem.errors import SolutionError
from impactfem.sticks.stick import Stick

Array = NDArray[np.float64]

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
FAMILIES = {"x": (0, 4), "y": (1, 3), "z": (2,), "rz": (5,)}
"""Components that move in a family: "y" is bending about e_x, which moves along y."""


@dataclass(frozen=True)
class Modes:
    """Modes in ascending frequency, normalised so that φᵀ M φ = 1.

    Args:
        frequency: Natural frequencies, shape (n_modes,) [Hz].
        shape: Mode shapes, shape (n, n_modes).
        participation: Factors Γ = φᵀ M r for the six rigid-body motions about the base,
            shape (6, n_modes).
        family: Name of the family (a key of FAMILIES) with the largest kinetic energy, a mode each.
        total: Mass and inertia of each direction, rᵀ M r, shape (6,) [kg, kg m2].
    """

    frequency: Array
    shape: Array
    participation: Array
    family: tuple[str, ...]
    total: Array

    @property
    def effective_mass(self) -> Array:
        """Effective modal masses and inertias Γ², shape (6, n_modes) [kg, kg m2]."""
        return self.participation**2

    def of_family(self, family: str) -> NDArray[np.int64]:
        """Indices of the modes of one family, in natural order."""
        return np.array([i for i, name in enumerate(self.family) if name == family], dtype=np.int64)


def modes(stick: Stick) -> Modes:
    """All modes with mass of a stick.

    Solves M φ = (1/ω²) K φ, so that points without mass (inside storeys) give 1/ω² = 0 and drop
    out instead of making M singular.

    Raises:
        SolutionError: The stiffness is not positive definite (the stick is a mechanism).
    """
    # Equilibrated first: translations and rotations differ by orders of magnitude.
    scale = 1.0 / np.sqrt(np.diag(stick.K))
    K = stick.K * np.outer(scale, scale)
    M = stick.M * np.outer(scale, scale)
    try:
        inverse_squares, vectors = scipy.linalg.eigh(M, K)
    except np.linalg.LinAlgError as error:
        raise SolutionError(
            f"building {stick.name}: the stiffness matrix is not positive definite: {error}"
        ) from error
    keep = inverse_squares > 1e-12 * inverse_squares[-1]
    values = inverse_squares[keep][::-1]
    shape = (vectors[:, keep] * scale[:, None])[:, ::-1] / np.sqrt(values)
    sign = np.sign(shape[np.argmax(np.abs(shape), axis=0), np.arange(shape.shape[1])])
    shape = shape * sign
    r = stick.rigid_body()
    kinetic = shape * (stick.M @ shape)
    by_component = kinetic.reshape(-1, 6, shape.shape[1]).sum(axis=0)
    shares = {name: by_component[list(dofs)].sum(axis=0) for name, dofs in FAMILIES.items()}
    names = list(shares)
    largest = np.argmax(np.array([shares[name] for name in names]), axis=0)
    return Modes(
        frequency=1.0 / (2.0 * np.pi * np.sqrt(values)),
        shape=shape,
        participation=r.T @ stick.M @ shape,
        family=tuple(names[i] for i in largest),
        total=np.diag(r.T @ stick.M @ r).copy(),
    )
