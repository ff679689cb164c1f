"""Action and reaction at the anchors of a device."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from impactfem.device.device import Device

Array = npt.NDArray[np.float64]

LARGEST_IMBALANCE = 1e-6
"""How far inertia forces and spring forces may differ, of the largest force or moment."""


def base_imbalance(device: Device, inertia: Array, springs: Array) -> float:
    """Compare the force on the anchors by the device's inertia with that in its springs.

    Only along components in which nothing is blocked, where M r = L and rᵀ L = J: a blocked motion
    hands its force on without a spring.

    Args:
        device: The device.
        inertia: -Lᵀ ẍ - J ä, with any drag, shape (6 p, n_t) [N, N m].
        springs: rᵀ (K x + C ẋ), same shape.

    Returns:
        The largest difference over the largest force, or of moments over the largest moment [-];
        nan where all motions of the base are blocked.
    """
    size = np.max(np.abs(device.L), axis=0)
    same = np.max(np.abs(device.M @ device.r - device.L), axis=0) <= 1e-9 * size
    carried = np.einsum("ij,ij->j", device.r, device.L)
    same &= np.abs(carried - np.diag(device.J)) <= 1e-9 * np.diag(device.J)
    same &= np.diag(device.J) > 0.0
    if not np.any(same):
        return float("nan")
    worst = 0.0
    turning = np.arange(same.size) % 6 >= 3
    for kind in (same & ~turning, same & turning):
        largest = np.max(np.abs(inertia[kind]), initial=0.0)
        if largest > 0.0:
            worst = max(worst, float(np.max(np.abs(inertia[kind] - springs[kind])) / largest))
    return worst
