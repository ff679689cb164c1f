"""The stick of a 3D building: its floors on the stiffness that the 3D model has between them.

The flexibility F of the floors (`impactfem.building.condensation`) gives K = F⁻¹, and the floors'
own masses M. K has the frequencies of the building to a per cent where floors are stiff. Modes φ_i
of the 3D model that move floors as a whole, ω_i, are then made exact: with their floor motions Φ,
Φᵀ M Φ = 1 (Löwdin's orthonormalisation, which changes the shapes least), and P = 1 − Φ Φᵀ M,

    K′ = Pᵀ K P + M Φ Ω² Φᵀ M

has the pairs (ω_i, φ_i), and the stiffness K for all that is orthogonal to them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from scipy.sparse.csgraph import connected_components

from impactfem.sticks.element import Section
from impactfem.sticks.modes import FAMILIES, natural_modes
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError
from impactfem.system.quantity import results, si

UNCOUPLED = 0.01
"""Cosine between loads on the floors, in the norm of F, below which families do not couple."""
WHOLE = 0.5
"""Part of the modal mass that the floors move as rigid bodies, from which on a mode is one of the
building and not of its slabs."""
ALIKE = 0.5
"""MAC of the floor motions of two modes above which the floors cannot tell them apart."""
MATCHED = 3
"""Modes along each axis that are matched."""
LEAST_SHARE = 0.01
"""Effective mass of a matched mode along its axis over the total mass."""
AXES = {"x": 0, "y": 1, "rz": 5}
"""Axes of the matched modes, with their number among the six motions."""


_MATRIX = "stick_row stick_column"


@results
class CondensedStick:
    """Matrices of the floors of a 3D model, and how well they have its modes."""

    #: K, shape (6 f, 6 f).
    K: Array = si(
        "N/m, N, N m", "stiffness of the floors, x to rz each", dims=_MATRIX, name="stick_stiffness"
    )
    #: M, shape (6 f, 6 f).
    M: Array = si(
        "kg, kg m, kg m2", "mass of the floors, x to rz each", dims=_MATRIX, name="stick_mass"
    )
    #: Numbers of the matched modes of the 3D model, from 1, shape (m,).
    number: Index = si("", "number of the mode of the 3D model", dims="matched", name="stick_mode")
    #: Of the stick, shape (m,).
    frequency: Array = si("Hz", "frequency of the stick", dims="matched", name="stick_frequency")
    #: Of the 3D model, shape (m,).
    model_frequency: Array = si(
        "Hz", "frequency of the 3D model", dims="matched", name="stick_model_frequency"
    )
    #: Shape (m,).
    mac: Array = si("-", "MAC of the floor motions", dims="matched", name="stick_mac")


@dataclass(frozen=True, eq=False)
class ModelStick:
    """Floors of a 3D model, for the stick of its building."""

    K: Array  #: Stiffness of the floors, shape (6 f, 6 f) [N/m, N m].
    M: Array  #: Mass of the floors, shape (6 f, 6 f) [kg, kg m2].
    mass: Array  #: Mass of each floor, shape (f,) [kg].
    inertia: Array  #: Moments of inertia about its centre of mass, shape (f, 3) [kg m2].
    sections: tuple[Section, ...]  #: Of the storeys, for the motion of points inside them.


def condensed_stick(
    F: Array, M: Array, frequency: Array, shapes: Array, effective: Array
) -> CondensedStick:
    """Make the stick of a 3D model.

    Args:
        F: Flexibility of its floors, shape (6 f, 6 f).
        M: Their mass, shape (6 f, 6 f).
        frequency: Frequencies of the 3D model, shape (n_modes,) [Hz].
        shapes: Motions of the floors in its modes of unit mass, shape (6 f, n_modes).
        effective: Effective mass of each mode over the total one, shape (n_modes, 6).

    Raises:
        SolutionError: F is not positive definite.
    """
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(decoupled(F)))
    except np.linalg.LinAlgError as error:
        raise SolutionError(f"the flexibility of the floors is not definite: {error}") from error
    K = np.asarray(inverse.T @ inverse, dtype=np.float64)
    chosen = _matched(M, shapes, effective)
    omega = np.asarray(2.0 * np.pi * frequency[chosen], dtype=np.float64)
    K = _with_modes(K, M, omega, shapes[:, chosen])
    found, own = natural_modes(M, K)
    # By pairs of the largest MAC: the order of near modes may differ.
    target = shapes[:, chosen]
    mac = (own.T @ M @ target) ** 2 / np.einsum("ik,ij,jk->k", target, M, target)
    nearest = mac.argmax(axis=0)
    return CondensedStick(
        K=K,
        M=M,
        number=chosen + 1,
        frequency=found[nearest] / (2.0 * np.pi),
        model_frequency=frequency[chosen],
        mac=mac[nearest, np.arange(len(chosen))],
    )


def decoupled(F: Array) -> Array:
    """Return F without coupling of families below `UNCOUPLED`, as of a symmetric building."""
    components = list(FAMILIES.values())
    scale = 1.0 / np.sqrt(np.diag(F))
    cosine = np.abs(F * np.outer(scale, scale))
    rows = [np.flatnonzero(np.isin(np.arange(len(F)) % 6, of)) for of in components]
    coupled = [[cosine[np.ix_(a, b)].max() > UNCOUPLED for b in rows] for a in rows]
    _, group = connected_components(np.array(coupled), directed=False)
    of_row = np.array(
        [group[next(k for k, of in enumerate(components) if i % 6 in of)] for i in range(len(F))]
    )
    return np.where(of_row[:, None] == of_row, F, 0.0)


def floor_mass(mass: Array, inertia: Array, centre: Array) -> Array:
    """Return the mass matrix of floors about their nodes, shape (6 f, 6 f).

    Args:
        mass: Their masses, shape (f,) [kg].
        inertia: Their moments of inertia about the centres of mass, shape (f, 3) [kg m2].
        centre: Positions (x, y) of these from the nodes, shape (f, 2) [m].
    """
    blocks = []
    for m, J, (x, y) in zip(mass, inertia, centre, strict=True):
        T = np.eye(6)
        T[0, 5], T[1, 5], T[2, 3], T[2, 4] = -y, x, y, -x
        blocks.append(T.T @ np.diag([m, m, m, *J]) @ T)
    return np.asarray(scipy.linalg.block_diag(*blocks))


def _matched(M: Array, shapes: Array, effective: Array) -> Index:
    """Numbers of the modes to match: up to three along each axis, of the building as a whole."""
    norm = np.einsum("ik,ij,jk->k", shapes, M, shapes)
    axes = list(AXES.values())
    main = effective[:, axes].argmax(axis=1)
    chosen: list[int] = []
    for axis in range(len(axes)):
        share = effective[:, axes[axis]]
        own = np.flatnonzero((main == axis) & (share >= LEAST_SHARE) & (norm >= WHOLE))
        taken: Sequence[int] = []
        for k in own:
            others = shapes[:, [*chosen, *taken]]
            mac = (shapes[:, k] @ M @ others) ** 2 / (norm[k] * norm[[*chosen, *taken]])
            if len(taken) < MATCHED and mac.max(initial=0.0) < ALIKE:
                taken = [*taken, int(k)]
        chosen += taken
    return np.array(sorted(chosen), dtype=np.int64)


def _with_modes(K: Array, M: Array, omega: Array, shapes: Array) -> Array:
    """Return the stiffness that has modes of given frequencies [rad/s] and shapes, as said."""
    if not omega.size:
        return K
    values, vectors = np.linalg.eigh(shapes.T @ M @ shapes)
    Phi = shapes @ (vectors / np.sqrt(values)) @ vectors.T
    MPhi = M @ Phi
    P = np.eye(len(K)) - Phi @ MPhi.T
    made = P.T @ K @ P + (MPhi * omega**2) @ MPhi.T
    return np.asarray((made + made.T) / 2.0)
