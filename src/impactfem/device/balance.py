"""Action and reaction at the anchors of a device."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from impactfem.device.device import Device

Array = npt.NDArray[np.float64]

LARGEST_IMBALANCE = 1e-6
"""How far inertia forces and spring forces may differ, of the largest force or moment."""


def base_imbalance(
    device: Device, inertia: Array, springs: Array, acceleration: Array | None = None
) -> float:
    """Compare the force on the anchors by the device's inertia with that in its springs.

    Only along components in which nothing is blocked, where M r = L: a blocked motion hands its
    force on without a spring. Masses that sit on the anchors, J - rᵀ L, press on them without a
    spring, too, by -(J - rᵀ L) ä; without ä components with such masses are left out.

    Args:
        device: The device.
        inertia: -Lᵀ ẍ - J ä, with any drag, shape (6 p, n_t) [N, N m].
        springs: rᵀ (K x + C ẋ), same shape.
        acceleration: ä, absolute, same shape [m/s2, rad/s2].

    Returns:
        The largest difference over the largest force, or of moments over the largest moment [-];
        nan where all motions of the base are blocked.
    """
    size = np.max(np.abs(device.L), axis=0)
    same = np.max(np.abs(device.M @ device.r - device.L), axis=0) <= 1e-9 * size
    carried = device.r.T @ device.L
    if acceleration is None:
        whole = np.diag(device.J)
        same &= np.abs(np.diag(carried) - whole) <= 1e-9 * whole
    else:
        springs = springs - (device.J - carried) @ acceleration
    same &= np.diag(carried) > 0.0
    if not np.any(same):
        return float("nan")
    worst = 0.0
    turning = np.arange(same.size) % 6 >= 3
    for kind in (same & ~turning, same & turning):
        largest = np.max(np.abs(inertia[kind]), initial=0.0)
        if largest > 0.0:
            worst = max(worst, float(np.max(np.abs(inertia[kind] - springs[kind])) / largest))
    return worst
