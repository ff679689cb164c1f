"""Natural modes of a stick: frequencies, participation, effective masses, families."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from impactfem.sticks.stick import Stick
from impactfem.system.errors import SolutionError

Array = NDArray[np.float64]

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
FAMILIES = {"x": (0, 4), "y": (1, 3), "z": (2,), "rz": (5,)}
"""Components of a family: "y" is bending about e_x, which moves along y."""


@dataclass(frozen=True)
class Modes:
    """Modes in ascending frequency, normalised so that φᵀ M φ = 1.

    Args:
        frequency: Natural frequencies, shape (n_modes,) [Hz].
        shape: Mode shapes, shape (n, n_modes).
        participation: Factors Γ = φᵀ M r for the six rigid-body motions about the base,
            shape (6, n_modes).
        family: Name of the family (a key of FAMILIES) of each mode.
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

    A straight stick does not couple the families, so each is solved on its own: with equal
    properties along x and y, the modes of a joint problem would be any mixture of both. Solves
    M φ = (1/ω²) K φ, so that points without mass (inside storeys) give 1/ω² = 0 and drop out
    instead of making M singular.

    Raises:
        SolutionError: The stiffness is not positive definite (the stick is a mechanism).
    """
    values, shapes, families = [], [], []
    for family, components in FAMILIES.items():
        dofs = np.array([6 * i + c for i in range(stick.n // 6) for c in components])
        found, vectors = _block_modes(stick, dofs)
        shape = np.zeros((stick.n, found.size))
        shape[dofs] = vectors
        values.append(found)
        shapes.append(shape)
        families += [family] * found.size
    joined = np.concatenate(values)
    order = np.argsort(-joined, kind="stable")
    every = np.hstack(shapes)[:, order]
    every = every * np.sign(every[np.argmax(np.abs(every), axis=0), np.arange(every.shape[1])])
    r = stick.rigid_body()
    return Modes(
        frequency=np.asarray(0.5 / (np.pi * np.sqrt(joined[order])), dtype=np.float64),
        shape=every,
        participation=r.T @ stick.M @ every,
        family=tuple(families[i] for i in order),
        total=np.diag(r.T @ stick.M @ r).copy(),
    )


def _block_modes(stick: Stick, dofs: NDArray[np.int64]) -> tuple[Array, Array]:
    """1/ω² and shapes with unit modal mass of the modes with mass of one block."""
    block = np.ix_(dofs, dofs)
    diagonal = np.diag(stick.K)[dofs]
    mechanism = f"building {stick.name}: the stiffness matrix is not positive definite"
    if not np.all(diagonal > 0.0):
        raise SolutionError(mechanism)
    # Equilibrated first: translations and rotations differ by orders of magnitude.
    scale = 1.0 / np.sqrt(diagonal)
    try:
        values, vectors = scipy.linalg.eigh(
            stick.M[block] * np.outer(scale, scale), stick.K[block] * np.outer(scale, scale)
        )
    except np.linalg.LinAlgError as error:
        raise SolutionError(f"{mechanism}: {error}") from error
    keep = values > 1e-12 * values[-1]
    return values[keep], vectors[:, keep] * scale[:, None] / np.sqrt(values[keep])
