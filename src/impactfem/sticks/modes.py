"""Natural modes of a stick: frequencies, participation, effective masses, families."""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from scipy.sparse.csgraph import connected_components

from impactfem.dynamics.orientation import fields, signs
from impactfem.sticks.stick import Stick
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError

FAMILIES = {"x": (0, 4), "y": (1, 3), "z": (2,), "rz": (5,)}
"""Components of a family: "y" is bending about e_x, which moves along y."""


@dataclass(frozen=True)
class Modes:
    """Modes in ascending frequency, normalised so that φᵀ M φ = 1."""

    frequency: Array  #: natural frequencies, shape (n_modes,) [Hz]
    shape: Array  #: mode shapes, shape (n, n_modes)
    #: Factors Γ = φᵀ M r for the six rigid-body motions about the base, shape (6, n_modes).
    participation: Array
    family: tuple[str, ...]  #: name of the family (a key of FAMILIES) of each mode
    total: Array  #: mass and inertia of each direction, rᵀ M r, shape (6,) [kg, kg m2]

    @property
    def effective_mass(self) -> Array:
        """Effective modal masses and inertias Γ², shape (6, n_modes) [kg, kg m2]."""
        return self.participation**2

    def of_family(self, family: str) -> Index:
        """Indices of the modes of one family, in natural order."""
        return np.array([i for i, name in enumerate(self.family) if name == family], dtype=np.int64)


def modes(stick: Stick) -> Modes:
    """All modes with mass of a stick; its points without mass, inside storeys, have none.

    SolutionError where the stiffness is not positive definite (the stick is a mechanism).
    """
    mechanism = f"building {stick.name}: the stiffness matrix is not positive definite"
    if not np.all(np.diag(stick.K) > 0.0):
        raise SolutionError(mechanism)
    try:
        omega, shape = natural_modes(stick.M, stick.K)
    except np.linalg.LinAlgError as error:
        raise SolutionError(f"{mechanism}: {error}") from error
    ends = np.array([*stick.axis, stick.base]), stick.positions.max(axis=0)
    f = fields(stick.positions, *ends).reshape(stick.n, -1)
    Mf = stick.M @ f
    shape = shape * signs(shape.T @ Mf, np.sqrt(np.einsum("ik,ik->k", f, Mf)))
    # A family holds most of the modal mass; in a straight stick, all of it.
    energy = (shape * (stick.M @ shape)).reshape(-1, 6, shape.shape[1]).sum(axis=0)
    shares = [energy[list(components)].sum(axis=0) for components in FAMILIES.values()]
    main = np.argmax(shares, axis=0)
    r = stick.rigid_body()
    return Modes(
        frequency=omega / (2.0 * np.pi),
        shape=shape,
        participation=r.T @ stick.M @ shape,
        family=tuple(list(FAMILIES)[k] for k in main),
        total=np.diag(r.T @ stick.M @ r).copy(),
    )


COUPLING = 1e-12
"""Entries of the equilibrated matrices below this part of the largest couple nothing."""
WITH_MASS = 1e-12
"""Modes count whose 1/ω² is above this part of the largest one of their block."""


def natural_modes(M: Array, K: Array) -> tuple[Array, Array]:
    """Circular frequencies and shapes of the modes with mass.

    Solves M φ = (1/ω²) K φ, so that motions without mass drop out. Parts that do not couple are
    solved on their own: a mixture of modes with equal frequencies along x and along y would be a
    mode as well. M is not indefinite, K positive definite, both symmetric, shape (n, n); ω ascends,
    shape (m,) [rad/s], and φᵀ M φ = 1, shape (n, m).
    """
    # Equilibrated first: translations and rotations differ by orders of magnitude.
    scale = 1.0 / np.sqrt(np.diag(K))
    k, m = K * np.outer(scale, scale), M * np.outer(scale, scale)
    links = (np.abs(k) > COUPLING) | (np.abs(m) > COUPLING * np.max(np.abs(m)))
    count, part = connected_components(links, directed=False)
    inverse_squares, shapes = [], []
    for number in range(count):
        dofs = np.flatnonzero(part == number)
        block = np.ix_(dofs, dofs)
        values, vectors = scipy.linalg.eigh(m[block], k[block])
        keep = values > WITH_MASS * max(float(values[-1]), 0.0)
        shape = np.zeros((M.shape[0], int(keep.sum())))
        shape[dofs] = vectors[:, keep] * scale[dofs, None] / np.sqrt(values[keep])
        inverse_squares.append(values[keep])
        shapes.append(shape)
    omega = 1.0 / np.sqrt(np.concatenate(inverse_squares))
    # Rounded: the order of two equal frequencies does not depend on their last digits.
    order = np.argsort(np.round(np.log(omega), 9), kind="stable")
    return np.asarray(omega[order], dtype=np.float64), np.hstack(shapes)[:, order]
