"""A device of a rigid body on base springs, with or without a beam between them.

The base moves by a + E s: the anchor's motion a, and s in the motions E that are not blocked. A
point at the height z is carried by the rigid link R(z) and deforms by d, so that with the own
coordinates x = (s, d) every node moves by

    u = R a + T x,    T = [R E, I]                                                         (1)

    M = Tᵀ m T,    L = Tᵀ m R,    J = Rᵀ m R,    K = diag(Eᵀ k E, k_beam)                   (2)
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from impactfem.device.beam import Beam
from impactfem.device.body import Body
from impactfem.device.device import Device
from impactfem.device.springs import COMPONENTS, BaseSprings
from impactfem.dynamics.damping import Rayleigh
from impactfem.sticks.element import rigid_link
from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]


def on_springs(
    name: str,
    springs: BaseSprings,
    body: Body,
    damping: Rayleigh | float,
    beam: Beam | None = None,
) -> Device:
    """Build a device on base springs.

    Args:
        name: Name of the device.
        springs: Between its base and its anchor, both at the anchor point.
        body: The rigid body; it sits on the beam's upper end where there is a beam.
        damping: Rayleigh damping of all its parts, or one ratio for all modes.
        beam: From the base upwards; none makes base and body one.

    Returns:
        The device. Its own motions are "base y" and so on, then "beam 0.23 m y" and so on.

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
