"""Devices on a structure in modal form, all integrated as one system.

The structure, whose displacements relative to the ground are Φ z, bears the forces F of the devices
at their anchors:

    z̈ + (α + β λ) ż + λ z = b p(t) + Φᵀ F                                                  (1)

With those of the devices (equation 1 of :mod:`impactfem.device.interface`) these are the equations
of one model with the mass blkdiag(1, 0) + Bᵀ M_d B, B = blkdiag(Φ, 1). It is integrated by the
average acceleration rule, with loads that are straight between their samples
(:mod:`impactfem.device.mounted_march`); sub-steps bring its error down with the square of the step.

Once F is known, the motion of any other point is that of the structure alone with the patterns Φᵀ
and the amplitudes F among its loads.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.device.balance import LARGEST_IMBALANCE, base_imbalance
from impactfem.device.body import Body
from impactfem.device.interface import Interface, MountedDevice, interface_of
from impactfem.device.mounted_march import March, march
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.energy import Energy
from impactfem.system.errors import ImpactfemError, SolutionError

Array = npt.NDArray[np.float64]

LARGEST_RESIDUAL = 1e-6
"""How far the energies may be out of balance, of the largest energy that came in."""


@dataclass(frozen=True, eq=False)
class ModalStructure:
    """Equation (1) of a structure.

    Args:
        eigenvalue: λ, shape (r,) [1/s2].
        load: b, shape (r, n_patterns); what the ground motion does to the structure itself is one
            of the patterns, or several.
        damping: The damping.

    Raises:
        ImpactfemError: Shapes do not fit, or a value is not finite.
    """

    eigenvalue: Array
    load: Array
    damping: Rayleigh

    def __post_init__(self) -> None:
        if self.eigenvalue.ndim != 1 or self.load.ndim != 2 or len(self.load) != len(self):
            raise ImpactfemError(
                f"a structure with eigenvalues of shape {self.eigenvalue.shape} and loads of shape"
                f" {self.load.shape}: expected (r,) and (r, patterns)"
            )
        values = (self.eigenvalue, self.load)
        if not all(np.all(np.isfinite(value)) for value in values):
            raise ImpactfemError(
                "the modal equations of a structure hold a value that is not a finite number"
            )

    def __len__(self) -> int:
        return len(self.eigenvalue)


@dataclass(frozen=True, eq=False)
class MountedHistory:
    """One device, at the samples of the loads.

    Args:
        name: Its name.
        force: F of the device on the floor at its anchors, shape (6 p, n_t) [N, N m]: N, F and M of
            its base. The floor's on the device is -F.
        anchor_displacement: Relative to the ground, shape (6 p, n_t) [m, rad].
        anchor_velocity: Relative to the ground, same shape [m/s, rad/s].
        anchor_acceleration: Absolute, same shape [m/s2, rad/s2].
        motion: Own coordinates x relative to the anchors, shape (n, n_t) [m, rad].
        acceleration: Own coordinates' absolute acceleration ẍ + r ä, shape (n, n_t)
            [m/s2, rad/s2].
        centre_acceleration: Absolute acceleration of the mass centre, shape (3, n_t) [m/s2]; nan
            along a direction in which the device has no mass.
        imbalance: Largest difference of inertia forces and spring forces at the base, of the
            largest force or moment [-]; nan where all motions of the base are blocked.
    """

    name: str
    force: Array
    anchor_displacement: Array
    anchor_velocity: Array
    anchor_acceleration: Array
    motion: Array
    acceleration: Array
    centre_acceleration: Array
    imbalance: float

    @property
    def largest(self) -> Array:
        """Largest |F| of every component, shape (6 p,) [N, N m]."""
        return np.asarray(np.max(np.abs(self.force), axis=1), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class MountedResponse:
    """All devices.

    Args:
        time: Shape (n_t,) [s].
        devices: In the order they were given.
        energy: Of structure and devices, by velocities relative to the ground.
    """

    time: Array
    devices: tuple[MountedHistory, ...]
    energy: Energy


def mounted_response(
    structure: ModalStructure,
    devices: Sequence[MountedDevice],
    amplitudes: Array,
    ground: Array,
    time_step: float,
    *,
    substeps: int = 1,
) -> MountedResponse:
    """Integrate a structure together with its devices, from rest.

    Args:
        structure: The structure, without the devices.
        devices: Any number of them from one on.
        amplitudes: p of every pattern, shape (n_t, n_patterns), straight between its samples.
        ground: Acceleration g̈ of the ground, shape (n_t, 3) [m/s2], likewise straight. It acts on
            the devices only; on the structure by its patterns.
        time_step: Of the samples [s].
        substeps: Steps of the integration in one of them.

    Raises:
        ImpactfemError: Shapes do not fit each other, a value is not finite, two devices have one
            name, or a device cannot be mounted.
        SolutionError: The result is not finite, the energies do not balance, or action and reaction
            at a base differ.
    """
    _check(structure, devices, amplitudes, ground, time_step, substeps)
    interface = interface_of(devices)
    damping = structure.damping.modal(structure.eigenvalue)
    loads = np.ascontiguousarray(amplitudes @ structure.load.T)
    found = march(
        structure.eigenvalue, damping, loads, interface, ground, time_step / substeps, substeps
    )
    time = np.arange(len(ground), dtype=np.float64) * time_step
    histories = mounted_histories(devices, interface, found, ground)
    return MountedResponse(time=np.asarray(time), devices=histories, energy=found.energy)


def mounted_histories(
    devices: Sequence[MountedDevice], interface: Interface, found: March, ground: Array
) -> tuple[MountedHistory, ...]:
    """The devices one by one, from the motion of their interface with a structure.

    Args:
        devices: The devices.
        interface: Their interface.
        found: Its motion, and the energies of structure and devices.
        ground: Acceleration of the ground at the same times, shape (n_t, 3) [m/s2].

    Raises:
        SolutionError: The motion is not finite, the energies do not balance, or action and reaction
            at a base differ.
    """
    # Checked before energies and forces are compared: comparisons with nan are false.
    if not (np.all(np.isfinite(found.force)) and np.all(np.isfinite(found.acceleration))):
        raise SolutionError("the response of the structure with its devices is not finite")
    if found.energy.residual > LARGEST_RESIDUAL:
        raise SolutionError(
            f"the energies of the structure with its devices are out of balance by"
            f" {found.energy.residual:.1e} of what came in"
        )
    return tuple(
        _history(one, found, ground, a, m, φ)
        for one, a, m, φ in zip(
            devices, interface.anchors, interface.modes, interface.own, strict=True
        )
    )


def _history(
    one: MountedDevice,
    found: March,
    ground: Array,
    anchors: npt.NDArray[np.int64],
    modes: npt.NDArray[np.int64],
    φ: Array,
) -> MountedHistory:
    force = found.force[anchors]
    moved, speed = found.displacement[anchors], found.velocity[anchors]
    a = found.acceleration[anchors] + one.ground @ ground.T
    # x, ẋ and ẍ.
    x, v, w = (φ @ y[modes] for y in (found.displacement, found.velocity, found.acceleration))
    momentum = one.mass @ a
    absolute, imbalance = w, float("nan")
    if not isinstance(one.device, Body):
        device = one.device
        momentum = momentum + device.L.T @ w
        absolute = w + device.r @ a
        alpha = device.drag_coefficient() if one.drag else 0.0
        springs = device.r.T @ (device.K @ x + (device.C - alpha * device.M) @ v)
        between = 0.0 if device.anchor_stiffness is None else device.anchor_stiffness @ moved
        imbalance = base_imbalance(device, force + between, springs, None if one.drag else a)
        if imbalance > LARGEST_IMBALANCE:
            raise SolutionError(
                f"mounted device {one.name}: the force in its springs differs from its inertia"
                f" force by {imbalance:.1e} of the largest"
            )
    mass = np.diag(one.ground.T @ one.mass @ one.ground)[:, None]
    pushed = one.ground.T @ momentum
    centre: Array = np.full(pushed.shape, np.nan, dtype=np.float64)
    np.divide(pushed, mass, out=centre, where=np.broadcast_to(mass > 0.0, pushed.shape))
    return MountedHistory(
        name=one.name,
        force=force,
        anchor_displacement=moved,
        anchor_velocity=speed,
        anchor_acceleration=a,
        motion=x,
        acceleration=absolute,
        centre_acceleration=centre,
        imbalance=imbalance,
    )


def _check(
    structure: ModalStructure,
    devices: Sequence[MountedDevice],
    amplitudes: Array,
    ground: Array,
    time_step: float,
    substeps: int,
) -> None:
    names = [one.name for one in devices]
    if not names or len(set(names)) < len(names):
        raise ImpactfemError(
            f"expected at least one mounted device, each with a name of its own; got"
            f" {', '.join(names) or 'none'}"
        )
    samples = len(ground)
    for what, values, wanted in (
        ("the ground acceleration", ground, (samples, 3)),
        ("the amplitudes of the loads", amplitudes, (samples, structure.load.shape[1])),
    ):
        if values.shape != wanted or samples < 2:
            raise ImpactfemError(
                f"{what} needs shape (samples, {wanted[1]}), two samples or more and as many as"
                f" the other loads, got {values.shape}"
            )
        if not np.all(np.isfinite(values)):
            raise ImpactfemError(f"{what} holds a value that is not a finite number")
    for one in devices:
        if one.shapes.ndim == 2 and one.shapes.shape[1] != len(structure):
            raise one.error(
                f"the shapes of its anchors have {one.shapes.shape[1]} columns, the structure has"
                f" {len(structure)} modes"
            )
    if not (math.isfinite(time_step) and time_step > 0.0) or substeps < 1:
        raise ImpactfemError(
            f"a time step of {time_step!r} s in {substeps!r} sub-steps: expected a positive step"
            " and one sub-step or more"
        )
