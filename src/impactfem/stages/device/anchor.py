"""An anchor of a device: its place, its weight, and the model of the device.

Figures of a device show its springs, beam and body, and its modes over the height: a point at the
height z of a device on springs moves, relative to its anchor, by

    u(z) = R(z) E s + d(z)                                                                 (1)

with the own coordinates x = (s, d): the free motions s of the base, which a rigid link R(z) takes
there, and what the beam deforms by, d. Above the beam the body is rigid.
"""

import math
from collections.abc import Iterable

import numpy as np

from impactfem.building.links import BasePlate
from impactfem.case import DeviceSetup
from impactfem.case.devices import RIGID
from impactfem.device.anchor_force import own_weight, ring_tension
from impactfem.device.device import Device
from impactfem.device.modes import device_modes
from impactfem.device.parts import solid_cylinder
from impactfem.stages.device.analysis import Support
from impactfem.sticks.element import COMPONENTS, rigid_link
from impactfem.system.arrays import Array
from impactfem.system.quantity import results, si

TOUCH = 1e-9
"""Heights that differ by less are the same [m]."""


@results
class Anchor:
    """An anchor, with the device that it holds; None and nan for what a device has not."""

    position: Array = si("m", "position", dims="xyz", name="anchor_position")
    floor: int = si("", "number of the floor", name="anchor_floor")
    nodes: int = si("", "number of nodes under the base plate", name="anchor_nodes")
    radius: float = si("m", "radius of the circle of anchors", name="anchor_radius")
    weight: float | None = si("N", "weight on the anchor, nan if no mode moves along z")
    weight_force: Array = si("N, N m", "force on the floor by the weight alone", dims="component")
    mode_frequency: Array = si("Hz", "frequency of the mode, nan beyond the last one", dims="mode")
    mode_damping: Array = si("-", "damping ratio of the mode", dims="mode")
    effective_mass: Array = si("kg, kg m2", "effective mass", dims="component mode")
    mode_mass: Array = si("kg", "effective mass along x, y or z, the largest", dims="mode")
    base_stiffness: Array = si(
        "N/m, N m/rad", "stiffness of the springs, infinite for a rigid one", dims="component"
    )
    body_mass: float | None = si("kg", "mass of the body")
    body_height: float | None = si("m", "height of the mass centre above the anchor")
    body_inertia: Array = si("kg m2", "moment of inertia about the mass centre", dims="axis")
    body_radius: float | None = si("m", "radius of a cylindrical body")
    body_length: float | None = si("m", "length of a cylindrical body")
    beam_length: float | None = si("m", "length of the beam")
    beam_mass: float | None = si("kg", "mass of the beam")
    beam_bending: Array = si("N m2", "bending stiffness of the beam", dims="bending_about")
    level_height: Array = si("m", "height above the anchor", dims="level")
    mode_shape: Array = si("1/sqrt(kg)", "mode relative to the anchor", dims="mode level component")

    def pulls(self, force: Array, peaks: Array) -> Array:
        """Return net uplift and net tension in detail, then by analyses; nan for unknown weight.

        Args:
            force: On the floor over time, shape (6, n_t) [N, N m].
            peaks: Largest forces in detail, then by analyses, shape (1 + n, 6) [N, N m].

        Returns:
            Shape (2, 1 + n) [N].
        """
        found = np.full((2, len(peaks)), np.nan)
        if self.weight is not None:
            whole, own = force + self.weight_force[:, None], self.weight_force
            # All largest values of a response spectrum analysis are at one instant: what has no
            # sign adds to the moments of the weight.
            most = peaks + np.abs(own)
            most[:, 2] += 2.0 * own[2]
            found[:] = peaks[:, 2] + own[2], ring_tension(most.T, self.radius)
            found[:, 0] = whole[2].max(), ring_tension(whole, self.radius).max()
        return found


def anchor_of_device(
    support: Support, setup: DeviceSetup, device: Device, plate: BasePlate
) -> Anchor:
    """Return an anchor of a device on its base plate."""
    modes = device_modes(device).below(setup.maximum_frequency)
    # Next to modes a body is that of the whole device, not of its springs.
    on_springs = setup.modes is None
    shape, beam, inertia = setup.shape, setup.beam, setup.inertia
    if setup.mass is not None and shape is not None:
        inertia = solid_cylinder(setup.mass, shape.radius, shape.length)
    springs = [None if setup.stiffness is None else getattr(setup.stiffness, c) for c in COMPONENTS]
    heights, weight = _levels(setup), own_weight(device)[support.rows]
    mass = modes.effective_mass[support.rows]
    return Anchor(
        position=np.asarray(plate.point),
        floor=plate.floor,
        nodes=1 + len(plate.followers),
        radius=setup.anchor_points[support.number - 1].radius,
        weight=-float(weight[2]) if weight[2] < 0.0 else None,
        weight_force=weight,
        mode_frequency=modes.frequency,
        mode_damping=modes.damping,
        effective_mass=mass,
        mode_mass=mass[:3].max(axis=0),
        base_stiffness=_numbers(math.inf if one == RIGID else one for one in springs),
        body_mass=setup.mass if on_springs else None,
        body_height=setup.mass_height if on_springs else None,
        body_inertia=_numbers((on_springs and inertia) or (None,) * 3),
        body_radius=None if shape is None else shape.radius,
        body_length=None if shape is None else shape.length,
        beam_length=None if beam is None else beam.length,
        beam_mass=None if beam is None else beam.mass,
        beam_bending=_numbers(beam.bending if beam else (None,) * 2),
        level_height=heights,
        mode_shape=mode_shapes(setup, device)
        if len(heights)
        else np.zeros((len(modes.frequency), 0, 6)),
    )


def _numbers(values: Iterable[float | None]) -> Array:
    return np.array(list(values), dtype=np.float64)


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
