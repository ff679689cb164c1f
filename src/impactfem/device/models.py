"""Devices from what is known of them: a body on springs, matrices, or a table of modes.

On springs: the base moves by a + E s: the anchor's motion a, and s in the motions E that are not
blocked. A point at the height z is carried by the rigid link R(z) and deforms by d, so that with
the own coordinates x = (s, d) every node moves by

    u = R a + T x,    T = [R E, I]                                                         (1)

    M = Tᵀ m T,    L = Tᵀ m R,    J = Rᵀ m R,    K = diag(Eᵀ k E, k_beam)                   (2)

Of matrices: the degrees of freedom are those of the anchors, a, and the others, q, which are
absolute. Without any force, q follows the anchors by r = -K_qq⁻¹ K_qa, and with x = q - r a

    M = M_qq,    L = M_qq r + M_qa,    J = rᵀ M_qq r + rᵀ M_qa + M_aq r + M_aa              (3)
    K = K_qq,    K_a = K_aa + K_aq r                                                       (4)

K_a is zero when a motion of the anchors moves the device as a rigid body. Damping acts on x only.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from impactfem.device.device import Device, refuse_mechanism
from impactfem.device.parts import BaseSprings, Beam, RigidBody
from impactfem.dynamics.damping import DampingLaw, as_law, checked_ratio
from impactfem.sticks.element import COMPONENTS, rigid_link
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError


def on_springs(
    name: str,
    springs: BaseSprings,
    body: RigidBody,
    damping: DampingLaw | float,
    beam: Beam | None = None,
) -> Device:
    """Build a device on base springs, between its base and its anchor, both at the anchor point.

    The rigid body sits on the upper end of the beam, which goes from the base upwards; none makes
    base and body one. Damping follows a law, or is one ratio for all modes. Its own motions are
    "base y" and so on, then "beam 0.23 m y" and so on.

    Raises:
        ImpactfemError: Nothing can move, or the stiffness leaves a motion free.
    """
    free = springs.free
    heights = np.zeros(1) if beam is None else beam.heights
    R = np.vstack([rigid_link(np.array([0.0, 0.0, z])) for z in heights])
    m, k = (np.zeros((6, 6)), np.zeros((6, 6))) if beam is None else beam.matrices()
    m[-6:, -6:] += body.about(np.array([0.0, 0.0, heights[-1]]))
    # The base does not deform against itself.
    deforming = () if beam is None else beam.deforming
    d = np.array([6 * i + c for i in range(1, heights.size) for c in deforming], dtype=np.int64)
    motions = [f"base {COMPONENTS[c]}" for c in free]
    motions += [f"beam {heights[i // 6]:.3g} m {COMPONENTS[i % 6]}" for i in d]
    if not motions:
        raise ImpactfemError(f"device {name}: nothing moves, all motions of its base are blocked")
    E = np.eye(6)[:, free]
    T = np.hstack([R @ E, np.eye(R.shape[0])[:, d]])
    K = np.zeros((len(motions), len(motions)))
    K[: free.size, : free.size] = springs.stiffness[np.ix_(free, free)]
    K[free.size :, free.size :] = k[np.ix_(d, d)]
    return Device(
        name=name,
        motions=tuple(motions),
        M=_symmetric(T.T @ m @ T),
        K=K,
        L=T.T @ m @ R,
        J=_symmetric(R.T @ m @ R),
        r=np.vstack([E.T, np.zeros((d.size, 6))]),
        damping=damping,
    )


def _symmetric(matrix: Array) -> Array:
    return np.asarray(0.5 * (matrix + matrix.T), dtype=np.float64)


def from_matrices(
    name: str,
    M: Array,
    K: Array,
    anchored: Mapping[int, int],
    damping: DampingLaw | float,
    anchors: int = 1,
    motions: tuple[str, ...] | None = None,
) -> Device:
    """Build a device from the matrices of a model.

    Args:
        name: Name of the device.
        M: Mass of all degrees of freedom, shape (n, n).
        K: Stiffness of all degrees of freedom, shape (n, n).
        anchored: For each degree of freedom that is one of an anchor, which component it is: for
            anchor k, 6 (k - 1) plus its place in COMPONENTS.
        damping: Law of the other degrees of freedom, or one ratio for all modes.
        anchors: Number of anchors.
        motions: Names of the other degrees of freedom, in their order; numbers when left out.

    Raises:
        ImpactfemError: The matrices do not fit, a component is anchored twice, nothing is left to
            move, or the stiffness leaves a motion free.
    """
    n = M.shape[0]
    if M.shape != (n, n) or K.shape != (n, n):
        raise ImpactfemError(
            f"device {name}: mass and stiffness need one square shape, got {M.shape} and {K.shape}"
        )
    fixed = np.array(sorted(anchored), dtype=np.int64)
    columns = np.array([anchored[int(i)] for i in fixed], dtype=np.int64)
    if (
        len(set(columns)) < len(columns)
        or not np.all((fixed >= 0) & (fixed < n))
        or not np.all((columns >= 0) & (columns < 6 * anchors))
    ):
        raise ImpactfemError(
            f"device {name}: expected each of the {6 * anchors} components of its anchors at most"
            f" once, and degrees of freedom below {n}"
        )
    q = np.setdiff1d(np.arange(n), fixed)
    if motions is None:
        motions = tuple(f"degree of freedom {i}" for i in q)
    if len(motions) != q.size:
        raise ImpactfemError(f"device {name}: {q.size} motions need as many names")
    K_qq, M_qq = K[np.ix_(q, q)], M[np.ix_(q, q)]
    K_qa, M_qa = K[np.ix_(q, fixed)], M[np.ix_(q, fixed)]
    refuse_mechanism(name, K_qq, motions)
    follow = -scipy.linalg.solve(K_qq, K_qa, assume_a="pos")
    every = np.eye(6 * anchors)[columns]
    L = M_qq @ follow + M_qa
    J = follow.T @ L + M_qa.T @ follow + M[np.ix_(fixed, fixed)]
    K_a = K[np.ix_(fixed, fixed)] + K_qa.T @ follow
    K_a = np.where(np.abs(K_a) > 1e-10 * np.max(np.abs(K)), K_a, 0.0)
    return Device(
        name=name,
        motions=motions,
        M=M_qq,
        K=K_qq,
        L=L @ every,
        J=every.T @ _symmetric(J) @ every,
        r=follow @ every,
        damping=damping,
        anchor_stiffness=every.T @ _symmetric(K_a) @ every,
    )


ROUNDING = 1e-6
"""How far effective masses may exceed the mass of the device, of it: tables are rounded."""

INDEFINITE = 1e-7
"""Of what modes leave of a device, equilibrated; it is then indefinite for `Device` as well."""


@dataclass(frozen=True)
class TableMode:
    """One mode."""

    frequency: float  #: [Hz]
    direction: str  #: "x", "y", "z", "rx", "ry" or "rz": how it moves
    effective_mass: float  #: of this direction [kg], or about this axis [kg m2]
    #: where it acts above the anchor, for a horizontal direction [m]: overturning moment over force
    height: float = 0.0
    damping: float | None = None  #: ratio of its own; that of the device when None [-]


def from_modes(
    name: str,
    modes: Sequence[TableMode],
    damping: DampingLaw | float,
    body: RigidBody | None = None,
) -> Device:
    """Build a device of oscillators, one a mode: each a mass in its direction at its height.

    With the mass, mass centre and inertia of the whole device given, what its modes do not carry
    follows the anchor as a rigid body. `damping` is that of modes that have none of their own.

    Raises:
        ImpactfemError: A value of the table is not usable, or the modes carry more mass than the
            device has.
    """
    if not modes:
        raise ImpactfemError(f"device {name}: its table holds no mode")
    r = np.zeros((len(modes), 6))
    for i, mode in enumerate(modes):
        _check(name, i + 1, mode)
        # The row of the direction at the height: a rotation moves a point there, too.
        link = rigid_link(np.array([0.0, 0.0, mode.height if mode.direction in "xy" else 0.0]))
        r[i] = link[COMPONENTS.index(mode.direction)]
    m = np.array([mode.effective_mass for mode in modes])
    omega = np.array([2.0 * math.pi * mode.frequency for mode in modes])
    carried = r.T @ np.diag(m) @ r
    whole = carried if body is None else body.about(np.zeros(3))
    for c, component in enumerate(COMPONENTS[:3]):
        if carried[c, c] > whole[c, c] * (1.0 + ROUNDING):
            raise ImpactfemError(
                f"device {name}: its modes carry {carried[c, c]:g} kg along {component}, more than"
                f" the {whole[c, c]:g} kg it weighs; expected at most its mass"
            )
    if body is not None:
        size = np.diag(whole)
        scale = 1.0 / np.sqrt(np.where(size > 0.0, size, 1.0))
        rest = (whole - carried) * np.outer(scale, scale)
        for axis, along in ((3, 1), (4, 0), (5, 5)):
            block = sorted({axis, along})
            if np.linalg.eigvalsh(rest[np.ix_(block, block)])[0] > -INDEFINITE:
                continue
            here = [mode for mode in modes if mode.direction in {COMPONENTS[i] for i in block}]
            directions = " and ".join(sorted({mode.direction for mode in here}))
            heights = sorted(mode.height for mode in here)
            raise ImpactfemError(
                f"device {name}: its modes of direction {directions}, of height {heights[0]:g} to "
                f"{heights[-1]:g} m, leave a part of it with a negative moment of inertia: it has "
                f"{body.mass:g} kg at {body.centre[2]:g} m and "
                f"{body.inertia[axis - 3, axis - 3]:g} kg m2 about {COMPONENTS[axis][1]}; expected "
                "another mass_height or inertia (or shape), or another height in its table of modes"
            )
    d = as_law(damping).modal(np.square(omega))
    for i, mode in enumerate(modes):
        if mode.damping is not None:
            d[i] = 2.0 * checked_ratio(mode.damping) * omega[i]
    return Device(
        name=name,
        motions=tuple(f"mode {i + 1} {mode.direction}" for i, mode in enumerate(modes)),
        M=np.diag(m),
        K=np.diag(m * omega**2),
        L=m[:, None] * r,
        J=whole,
        r=r,
        damping=0.0,
        dampers=np.diag(d * m),
    )


def _check(name: str, number: int, mode: TableMode) -> None:
    where = f"device {name}: mode {number}"
    if mode.direction not in COMPONENTS:
        raise ImpactfemError(
            f"{where}: direction {mode.direction!r}: expected one of {', '.join(COMPONENTS)}"
        )
    for what, value, unit in (
        ("frequency", mode.frequency, "Hz"),
        ("effective mass", mode.effective_mass, "kg"),
    ):
        if not (math.isfinite(value) and value > 0.0):
            raise ImpactfemError(f"{where}: {what} {value!r} {unit}: expected a positive number")
    if not math.isfinite(mode.height):
        raise ImpactfemError(f"{where}: height {mode.height!r} m: expected a finite number")
