"""What a drawing of a device shows: its springs, beam and body, and its modes over the height.

A point at the height z of a device on springs moves, relative to its anchor, by

    u(z) = R(z) E s + d(z)                                                                 (1)

with the own coordinates x = (s, d): the free motions s of the base, which a rigid link R(z) takes
there, and what the beam deforms by, d. Above the beam the body is rigid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.case import DeviceSetup
from impactfem.case.devices import RIGID
from impactfem.device.device import Device
from impactfem.device.modes import device_modes
from impactfem.device.parts import solid_cylinder
from impactfem.sticks.element import COMPONENTS, rigid_link

Array = NDArray[np.float64]

TOUCH = 1e-9
"""Heights that differ by less are the same [m]."""


def drawing_values(setups: Sequence[DeviceSetup], devices: Sequence[Device]) -> dict[str, Array]:
    """Variables of `device.nc` that figures of the devices need, by name.

    Nan for a device from modes; a rigid spring has an infinite stiffness.
    """
    rows = [_parts(setup) for setup in setups]
    values = {name: np.array([row[name] for row in rows], dtype=np.float64) for name in rows[0]}
    # Modes over the height, with nan where a device has fewer modes or levels than others.
    both = zip(setups, devices, strict=True)
    count = [device_modes(d).below(s.maximum_frequency).frequency.size for s, d in both]
    levels = [_levels(setup) for setup in setups]
    shapes = np.full((len(setups), max(count), max(map(len, levels)), 6), np.nan)
    heights = np.full(shapes.shape[::2], np.nan)
    for k, (setup, device) in enumerate(zip(setups, devices, strict=True)):
        heights[k, : len(levels[k])] = levels[k]
        if len(levels[k]):
            shapes[k, : count[k], : len(levels[k])] = mode_shapes(setup, device)
    return values | {"level_height": heights, "mode_shape": shapes}


def _parts(setup: DeviceSetup) -> dict[str, Any]:
    """Springs, body and beam; None for what the device has not."""
    shape, beam, springs = setup.shape, setup.beam, setup.stiffness
    # In addition to modes a body is that of the whole device.
    on_springs = setup.modes is None
    inertia = setup.inertia
    if setup.mass is not None and shape is not None:
        inertia = solid_cylinder(setup.mass, shape.radius, shape.length)
    stiffness = [None if springs is None else getattr(springs, name) for name in COMPONENTS]
    return {
        "base_stiffness": [math.inf if value == RIGID else value for value in stiffness],
        "body_mass": setup.mass if on_springs else None,
        "body_height": setup.mass_height if on_springs else None,
        "body_inertia": (on_springs and inertia) or (None,) * 3,
        "body_radius": shape and shape.radius,
        "body_length": shape and shape.length,
        "beam_length": beam and beam.length,
        "beam_mass": beam and beam.mass,
        "beam_bending": beam.bending if beam else (None,) * 2,
    }


def mode_shapes(setup: DeviceSetup, device: Device) -> Array:
    """Modes of a device on springs over its height, equation (1).

    Translations and rotations relative to the anchor, shape (n_modes, n_levels, 6) [1/√kg].
    """
    shape = device_modes(device).below(setup.maximum_frequency).shape
    heights, elements = _levels(setup), 0 if setup.beam is None else setup.beam.elements
    s, d = np.zeros((6, shape.shape[1])), np.zeros((len(heights), 6, shape.shape[1]))
    free = sum(motion.startswith("base ") for motion in device.motions)
    each = (len(shape) - free) // max(elements, 1)
    for row, motion in enumerate(device.motions):
        component = COMPONENTS.index(motion.split()[-1])
        if row < free:
            s[component] = shape[row]
        else:
            d[1 + (row - free) // each, component] = shape[row]
    if len(heights) > elements + 1:
        # The body's mass centre, on a rigid link above the last node.
        d[-1] = rigid_link(np.array([0.0, 0.0, heights[-1] - heights[-2]])) @ d[-2]
    u = [rigid_link(np.array([0.0, 0.0, z])) @ s + bent for z, bent in zip(heights, d, strict=True)]
    return np.asarray(np.moveaxis(np.array(u), 2, 0), dtype=np.float64)


def _levels(setup: DeviceSetup) -> Array:
    """Heights of the beam's nodes or of the base, then of the mass centre if it is none of them."""
    if setup.modes is not None or setup.mass_height is None:
        return np.zeros(0)
    beam = setup.beam
    heights: Array = np.zeros(1)
    if beam is not None:
        heights = np.asarray(np.linspace(0.0, beam.length, beam.elements + 1), dtype=np.float64)
    if abs(heights[-1] - setup.mass_height) > TOUCH:
        heights = np.append(heights, setup.mass_height)
    return heights
