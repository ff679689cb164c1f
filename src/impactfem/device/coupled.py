"""A device as a part of a larger model: its matrices with the anchors as interface.

With the anchors' motions first, y = (a, x) in relative coordinates and, by x = q - r a, y = (a, q)
in absolute ones:

    relative   [J  Lᵀ] ÿ + [0  0] ẏ + [K_a  0] y = f
               [L  M ]     [0  C]     [0    K]

    absolute   Wᵀ (…) W,    W = [ I  0]
                                [-r  I]

f holds the forces of the floor on the device in its first 6 p rows: adding these rows to those of
the floor's model couples both exactly. Damping that acts on x leaves a rigid motion of the device
alone. A finite element program with Rayleigh damping puts α M on all degrees of freedom, which
holds the whole moving device against the fixed frame: `drag` is that choice, α [J Lᵀ; L M] in place
of α M.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from impactfem.device.device import Device
from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]

Coordinates = Literal["absolute", "relative"]


@dataclass(frozen=True, eq=False)
class CoupledDevice:
    """Matrices of anchors and own coordinates.

    Args:
        M: Mass, shape (6 p + n, 6 p + n); the anchors' 6 p components come first.
        C: Damping.
        K: Stiffness.
        own: From unit values of (a, y_own) to x, shape (n, 6 p + n): relative own coordinates, from
            which quantities are taken.
        interface: Number of components of the anchors, 6 p.
        coordinates: "absolute" or "relative".
    """

    M: Array
    C: Array
    K: Array
    own: Array
    interface: int
    coordinates: Coordinates


def coupled(
    device: Device, coordinates: Coordinates = "absolute", *, drag: bool = False
) -> CoupledDevice:
    """Give the matrices of a device with its anchors as interface.

    Args:
        device: The device.
        coordinates: Of the own degrees of freedom.
        drag: Whether the mass part of Rayleigh damping acts on absolute velocities, as in a finite
            element model; on those relative to the anchors otherwise.

    Raises:
        ImpactfemError: The coordinates are unknown, or `drag` is asked for a device without
            Rayleigh damping.
    """
    if coordinates not in get_args(Coordinates):
        raise ImpactfemError(f"the coordinates are one of {get_args(Coordinates)}: {coordinates!r}")
    n, p6 = device.M.shape[0], device.J.shape[0]
    zero = np.zeros((n, p6))
    K_a = np.zeros_like(device.J) if device.anchor_stiffness is None else device.anchor_stiffness
    M = np.block([[device.J, device.L.T], [device.L, device.M]])
    K = np.block([[K_a, zero.T], [zero, device.K]])
    C = np.block([[np.zeros_like(device.J), zero.T], [zero, device.C]])
    if drag:
        alpha = device.drag_coefficient()
        C = C + alpha * M
        C[p6:, p6:] -= alpha * device.M
    own = np.hstack([zero, np.eye(n)])
    if coordinates == "absolute":
        W = np.eye(p6 + n)
        W[p6:, :p6] = -device.r
        M, C, K, own = W.T @ M @ W, W.T @ C @ W, W.T @ K @ W, own @ W
    return CoupledDevice(M=M, C=C, K=K, own=own, interface=p6, coordinates=coordinates)
