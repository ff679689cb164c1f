"""The supports of all devices, one after the other: what results are told of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.device.device import Device

Array = NDArray[np.float64]

FREE = 1e-6
"""A motion of all anchors as a rigid body is free if the force that it needs is below this part of
the largest force of its parts."""


@dataclass(frozen=True)
class Support:
    """One anchor of one device.

    Args:
        device: Number of the device, from 0.
        number: Number of the anchor, from 1.
        name: The device's name; with several anchors, with the number of the anchor.
        several: Whether the device has several.
    """

    device: int
    number: int
    name: str
    several: bool

    @property
    def rows(self) -> slice:
        """Its components among those of the device's anchors."""
        return slice(6 * (self.number - 1), 6 * self.number)

    def quantity(self, word: str) -> str:
        """Name of a force at it, such as "force y", among those of the device."""
        return f"{word} at anchor {self.number}" if self.several else word


def supports_of(devices: Sequence[Device]) -> tuple[Support, ...]:
    """All supports, device by device."""
    return tuple(
        Support(
            device=k,
            number=number,
            name=f"{device.name}_{number}" if device.anchors > 1 else device.name,
            several=device.anchors > 1,
        )
        for k, device in enumerate(devices)
        for number in range(1, device.anchors + 1)
    )


def largest_apart(device: Device, points: Array, displacement: Array) -> Array:
    """Largest displacements of anchors against where the first one carries them.

    A motion of the first anchor carries the others along as a rigid body, by its translations, and
    by those rotations that the stiffness between the anchors leaves free.

    Args:
        device: The device.
        points: Its anchors, shape (p, 3) [m].
        displacement: Of the anchors, shape (6 p, n_t) [m, rad].

    Returns:
        Shape (6 p,) [m, rad]; zero for a device with one anchor or nothing between its anchors.
    """
    K_a = device.anchor_stiffness
    if device.anchors == 1 or K_a is None or not np.any(K_a):
        return np.zeros(6 * device.anchors)
    R = np.tile(np.eye(6), (device.anchors, 1))
    for k, (x, y, z) in enumerate(points - points[0]):
        R[6 * k : 6 * k + 3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    force = np.abs(K_a @ R).max(axis=0)
    parts = (np.abs(K_a) @ np.abs(R)).max(axis=0)
    carried = np.where(force <= FREE * parts, 1.0, 0.0)[:, None] * displacement[:6]
    return np.asarray(np.abs(displacement - R @ carried).max(axis=1), dtype=np.float64)
