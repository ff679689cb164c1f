"""What a drawing of a device shows: its springs, beam and body, and its modes over the height.

A point at the height z of a device on springs moves, relative to its anchor, by

    u(z) = R(z) E s + d(z)                                                                 (1)

with the own coordinates x = (s, d): the free motions s of the base, which a rigid link R(z) takes
there, and what the beam deforms by, d. Above the beam the body is rigid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

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
    """Variables of `device.nc` that figures of the devices need; nan for a device from modes.

    Args:
        setups: The devices of the case.
        devices: They as matrices, in the same order.

    Returns:
        Values by name. A rigid spring has an infinite stiffness.
    """
    shapes, beams = [setup.shape for setup in setups], [setup.beam for setup in setups]
    return {
        "base_stiffness": np.array([_springs(setup) for setup in setups]),
        "body_mass": _numbers([_of(s, s.mass) for s in setups]),
        "body_height": _numbers([_of(s, s.mass_height) for s in setups]),
        "body_inertia": np.array([_inertia(setup) for setup in setups]),
        "body_radius": _numbers([None if s is None else s.radius for s in shapes]),
        "body_length": _numbers([None if s is None else s.length for s in shapes]),
        "beam_length": _numbers([None if b is None else b.length for b in beams]),
        "beam_mass": _numbers([None if b is None else b.mass for b in beams]),
        "beam_bending": np.array([(math.nan,) * 2 if b is None else b.bending for b in beams]),
        **_modes(setups, devices),
    }


def _modes(setups: Sequence[DeviceSetup], devices: Sequence[Device]) -> dict[str, Array]:
    """Modes over the height, with nan where a device has fewer modes or levels than others."""
    both = list(zip(setups, devices, strict=True))
    count = [device_modes(d).below(s.maximum_frequency).frequency.size for s, d in both]
    levels = [_levels(setup) for setup in setups]
    shapes = np.full((len(setups), max(count), max(map(len, levels)), 6), np.nan)
    heights = np.full(shapes.shape[::2], np.nan)
    for k, (setup, device) in enumerate(both):
        heights[k, : len(levels[k])] = levels[k]
        if len(levels[k]):
            shapes[k, : count[k], : len(levels[k])] = mode_shapes(setup, device)
    return {"level_height": heights, "mode_shape": shapes}


def mode_shapes(setup: DeviceSetup, device: Device) -> Array:
    """Modes of a device on springs over its height, equation (1).

    Args:
        setup: The device of the case.
        device: It as matrices.

    Returns:
        Shape (n_modes, n_levels, 6) [1/√kg]: translations and rotations relative to the anchor.
    """
    shape = device_modes(device).below(setup.maximum_frequency).shape
    heights = _levels(setup)
    free = [COMPONENTS.index(m.split()[-1]) for m in device.motions if m.startswith("base ")]
    base = np.zeros((6, shape.shape[1]))
    base[free] = shape[: len(free)]
    bent = [COMPONENTS.index(m.split()[-1]) for m in device.motions[len(free) :]]
    elements = 0 if setup.beam is None else setup.beam.elements
    nodes = np.zeros((elements + 1, 6, shape.shape[1]))
    each = len(bent) // max(elements, 1)
    for i in range(elements):
        rows = slice(i * each, (i + 1) * each)
        nodes[i + 1, bent[rows]] = shape[len(free) :][rows]
    top = 0.0 if setup.beam is None else setup.beam.length
    found = []
    for level, z in enumerate(heights):
        d = nodes[min(level, elements)]
        if level > elements:
            d = rigid_link(np.array([0.0, 0.0, z - top])) @ d
        found.append(rigid_link(np.array([0.0, 0.0, z])) @ base + d)
    return np.asarray(np.moveaxis(np.array(found), 2, 0), dtype=np.float64)


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


def _of(setup: DeviceSetup, value: float | None) -> float | None:
    """A value of the body of a device on springs: beside modes it is that of the whole device."""
    return None if setup.modes is not None else value


def _inertia(setup: DeviceSetup) -> tuple[float, float, float]:
    if setup.mass is not None and setup.shape is not None:
        found = solid_cylinder(setup.mass, setup.shape.radius, setup.shape.length)
    else:
        found = setup.inertia or (math.nan,) * 3
    return (math.nan,) * 3 if setup.modes is not None else found


def _springs(setup: DeviceSetup) -> list[float]:
    stiffness = setup.stiffness
    if stiffness is None:
        return [math.nan] * 6
    values = [getattr(stiffness, name) for name in COMPONENTS]
    return [math.inf if value == RIGID else float(value) for value in values]


def _numbers(values: Sequence[float | None]) -> Array:
    return np.array([math.nan if v is None else v for v in values], dtype=np.float64)
