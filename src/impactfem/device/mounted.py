"""Devices on bodies, all integrated as one system.

Of each device the own coordinates are x = φ ζ with its modes with mass, φᵀ M φ = 1: motions without
mass follow these at once. With y = (a, ζ) relative to the ground a device is a mount
(:mod:`impactfem.coupling.links`),

    M_y ÿ + C_y ẏ + K_y y = (-F, 0) - M_y (R, 0) g̈                                         (1)

where F is its force on the floor, g̈ the acceleration of the ground and R takes it to the anchors.
Bodies and devices are integrated by the average acceleration rule, with loads that are straight
between their samples (:mod:`impactfem.coupling.implicit`); sub-steps bring its error down with the
square of the step. Once F is known, the motion of any other point is that of the body alone with F
among its loads.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from impactfem.coupling.body import Body
from impactfem.coupling.implicit import Start, respond
from impactfem.coupling.links import Assembly, Attached, Link, Mount, Place, Spring
from impactfem.device.anchor_force import LARGEST_IMBALANCE, base_imbalance
from impactfem.device.device import Device, coupled
from impactfem.device.parts import RigidBody
from impactfem.dynamics.energy import Energy
from impactfem.sticks.modes import WITH_MASS, natural_modes
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError, SolutionError

LARGEST_RESIDUAL = 1e-6
"""How far the energies may be out of balance, of the largest energy that came in."""
MASSLESS_DAMPING = 1e-9
"""Part of the largest entry of the equilibrated dampers that may act on a motion without mass."""


@dataclass(frozen=True, eq=False)
class MountedDevice:
    """A device and where it stands."""

    name: str
    device: Device | RigidBody  #: the device; a rigid body alone is one mass at its anchor
    at: tuple[Place, ...] = ()  #: body and port of each anchor; none for matrices alone

    @property
    def mass(self) -> Array:
        """J, the mass of the rigid device about its anchors, shape (6 p, 6 p)."""
        if isinstance(self.device, RigidBody):
            return self.device.about(np.zeros(3))
        return self.device.J

    @property
    def ground(self) -> Array:
        """R, the motion of the anchors by that of the ground, shape (6 p, 3)."""
        return np.tile(np.eye(6, 3), (len(self.mass) // 6, 1))

    @cached_property
    def own(self) -> Array:
        """φ, shape (n, modes)."""
        if isinstance(self.device, RigidBody):
            return np.zeros((0, 0))
        return natural_modes(self.device.M, self.device.K)[1]

    @property
    def mount(self) -> Mount:
        """Equation (1).

        Raises:
            ImpactfemError: A stiffness between anchors holds the ground, or a damper acts on a
                motion without mass.
        """
        J, φ, device = self.mass, self.own, self.device
        if isinstance(device, RigidBody):
            return Mount(self.at, len(J), J, np.zeros_like(J), np.zeros_like(J), self.ground)
        device.refuse_held_ground()
        if device.dampers is not None:
            # Dampers may act on motions that the modes with mass carry on their own; Rayleigh
            # damping and one ratio for all modes never couple others with them.
            scale = 1.0 / np.sqrt(np.diag(device.K))
            values, motions = np.linalg.eigh(device.M * np.outer(scale, scale))
            massless = motions[:, values <= WITH_MASS * values[-1]]
            equilibrated = device.dampers * np.outer(scale, scale)
            acting = np.max(np.abs(equilibrated @ massless), initial=0.0)
            if acting > MASSLESS_DAMPING * np.max(np.abs(equilibrated)):
                raise ImpactfemError(
                    f"mounted device {self.name}: a damper acts on a motion without mass, which"
                    " then no mode carries; expected a mass there"
                )
        T = scipy.linalg.block_diag(np.eye(len(J)), φ)
        M, C, K = (T.T @ matrix @ T for matrix in coupled(device))
        return Mount(self.at, len(J), M, C, K, np.pad(self.ground, ((0, φ.shape[1]), (0, 0))))


@dataclass(frozen=True, eq=False)
class MountedHistory:
    """One device, at the samples of the loads."""

    name: str
    #: F of the device on the floor at its anchors, shape (6 p, n_t) [N, N m]: N, F and M of its
    #: base. The floor's on the device is -F
    force: Array
    anchor_displacement: Array  #: relative to the ground, shape (6 p, n_t) [m, rad]
    anchor_velocity: Array  #: relative to the ground, same shape [m/s, rad/s]
    anchor_acceleration: Array  #: absolute, same shape [m/s2, rad/s2]
    motion: Array  #: own coordinates x relative to the anchors, shape (n, n_t) [m, rad]
    #: own coordinates' absolute acceleration ẍ + r ä, shape (n, n_t) [m/s2, rad/s2]
    acceleration: Array
    #: largest difference of inertia forces and spring forces at the base, of the largest force or
    #: moment [-]; nan where all motions of the base are blocked
    imbalance: float

    @property
    def largest(self) -> Array:
        """Largest |F| of every component, shape (6 p,) [N, N m]."""
        return np.asarray(np.max(np.abs(self.force), axis=1), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class MountedResponse:
    """All devices."""

    time: Array  #: shape (n_t,) [s]
    devices: tuple[MountedHistory, ...]  #: in the order they were given
    link_force: Array  #: F of the links between the bodies, shape (n_t, n_links) [N]
    energy: Energy  #: of bodies and devices, by velocities relative to the ground


def mounted_response(
    bodies: Sequence[Body],
    devices: Sequence[MountedDevice],
    loads: Array,
    ground: Array,
    time_step: float,
    *,
    links: Sequence[Link] = (),
    springs: Sequence[Spring] = (),
    substeps: int = 1,
) -> MountedResponse:
    """Integrate bodies together with the devices on them, from rest.

    Args:
        bodies: The bodies, without the devices.
        devices: Any number of them from one on.
        loads: Forces on the coordinates of the bodies, those of the ground motion included, shape
            (n_t, r), straight between their samples.
        ground: Acceleration g̈ of the ground, shape (n_t, 3) [m/s2], likewise straight. It acts on
            the devices only; on the bodies by their loads.
        time_step: Of the samples [s].
        links: Laws between the bodies.
        springs: Springs between the bodies.
        substeps: Steps of the integration in one sample.

    Raises:
        ImpactfemError: Shapes do not fit each other, a value is not finite, two devices have one
            name, or a device cannot be mounted.
        SolutionError: The result is not finite, the energies do not balance, or action and reaction
            at a base differ.
    """
    names = [one.name for one in devices]
    if not names or len(set(names)) < len(names):
        raise ImpactfemError(
            f"expected at least one mounted device, each with a name of its own; got"
            f" {', '.join(names) or 'none'}"
        )
    r = sum(len(body) for body in bodies)
    for what, values, width in (
        ("the ground acceleration", ground, 3),
        ("the loads of the bodies", loads, r),
    ):
        if values.shape != (len(ground), width) or len(ground) < 2:
            raise ImpactfemError(
                f"{what}: expected shape (samples, {width}), two samples or more and as many as"
                f" the other loads, got {values.shape}"
            )
        if not np.all(np.isfinite(values)):
            raise ImpactfemError(f"{what}: a value is not a finite number")
    if not (math.isfinite(time_step) and time_step > 0.0) or substeps < 1:
        raise ImpactfemError(
            f"a time step of {time_step!r} s in {substeps!r} sub-steps: expected a positive step"
            " and one sub-step or more"
        )
    assembly = Assembly(bodies, links, springs, [one.mount for one in devices])
    start = Start(recorded=np.zeros(0, dtype=np.int64))
    motion = respond(assembly, loads, ground, time_step, substeps=substeps, start=start)
    histories = mounted_histories(
        devices,
        assembly.attached,
        motion.displacement.T,
        motion.velocity.T,
        motion.acceleration.T,
        motion.reaction.T,
        motion.energy,
        ground,
    )
    time = np.arange(len(ground), dtype=np.float64) * time_step
    return MountedResponse(np.asarray(time), histories, motion.force, motion.energy)


def mounted_histories(
    devices: Sequence[MountedDevice],
    attached: Attached,
    y: Array,
    v: Array,
    w: Array,
    force: Array,
    energy: Energy,
    ground: Array,
) -> tuple[MountedHistory, ...]:
    """The devices, the mounts of `attached`, one by one, from the motion of y of equation (1).

    y, ẏ and ÿ at all times have the shape (N, n_t), F at all anchors, their rows in y first, (N_a,
    n_t) [N, N m], the acceleration of the ground (n_t, 3) [m/s2].

    Raises:
        SolutionError: The motion is not finite, the energies do not balance, or action and reaction
            at a base differ.
    """
    # Checked before energies and forces are compared: comparisons with nan are false.
    if not (np.all(np.isfinite(force)) and np.all(np.isfinite(w))):
        raise SolutionError("the response of the structure with its devices is not finite")
    if energy.residual > LARGEST_RESIDUAL:
        raise SolutionError(
            f"the energies of the structure with its devices are out of balance by"
            f" {energy.residual:.1e} of what came in"
        )
    found = []
    for one, (fixed, own) in zip(devices, attached.mounts, strict=True):
        F, a = force[fixed], w[fixed] + one.ground @ ground.T
        x, speed, acceleration = (one.own @ of[own] for of in (y, v, w))
        imbalance = float("nan")
        if not isinstance(one.device, RigidBody):
            device = one.device
            acceleration = acceleration + device.r @ a
            springs = device.r.T @ (device.K @ x + device.C @ speed)
            K_a = device.anchor_stiffness
            inertia = F if K_a is None else F + K_a @ y[fixed]
            imbalance = base_imbalance(device, inertia, springs, a)
            if imbalance > LARGEST_IMBALANCE:
                raise SolutionError(
                    f"mounted device {one.name}: the force in its springs differs from its inertia"
                    f" force by {imbalance:.1e} of the largest"
                )
        anchors = (y[fixed], v[fixed], a)
        found.append(MountedHistory(one.name, F, *anchors, x, acceleration, imbalance))
    return tuple(found)
