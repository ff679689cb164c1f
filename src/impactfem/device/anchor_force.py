"""Force of a device on its anchors while these move.

Each mode is an oscillator under the acceleration Γᵀ ä, straight between its samples, and is stepped
exactly (:mod:`impactfem.spectra.oscillator`). With b = z̈ + Γᵀ ä, its absolute acceleration, the
momentum of the device gives

    F = -Σ Γ b - (J - Σ Γ Γᵀ) ä - K_a a                                                    (1)

where modes that were left out follow the anchors rigidly. Springs and dampers give it a second time
for the motions that are not blocked:

    F = rᵀ (K x + C Σ φ ż),    x = Σ φ z - (K⁻¹ L - Σ φ Γᵀ / ω²) ä                          (2)

Both must agree: action equals reaction.

Its weight acts on the floor in addition to F, which is that of the motion alone: -J g with the
gravity g as an upward acceleration of all anchors. Anchors evenly spaced on a circle of radius r
about the anchor point, under a rigid plate and as stiff in tension as in pressure, carry the force
N upward and the overturning moment M with at most (N + 2 M / r) / n each of n, so that

    T = F_z + 2 √(M_x² + M_y²) / r                                                         (3)

above zero, weight included, pulls at one of them: net tension. N above zero lifts all of the base.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import constants

from impactfem.device.device import Device
from impactfem.device.modes import DeviceModes, device_modes
from impactfem.spectra import oscillator_response
from impactfem.sticks.element import COMPONENTS
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError, SolutionError


@dataclass(frozen=True, eq=False)
class Quantities:
    """Several linear quantities of one device, Q = c x + d ä + e a.

    Under a constant acceleration ä of the anchors the device comes to rest against them at
    x = -K⁻¹ L ä.

    Raises:
        ImpactfemError: Shapes do not fit each other.
    """

    names: tuple[str, ...]  #: what they are, n_q of them
    units: tuple[str, ...]
    own: Array  #: c, shape (n_q, n)
    acceleration: Array  #: d, shape (n_q, 6 p)
    displacement: Array  #: e, shape (n_q, 6 p)

    def __post_init__(self) -> None:
        n_q = len(self.names)
        shapes = [a.shape for a in (self.own, self.acceleration, self.displacement)]
        if len(self.units) != n_q or any(len(s) != 2 or s[0] != n_q for s in shapes):
            raise ImpactfemError(
                f"{n_q} quantities need as many units and rows, got {len(self.units)} units and"
                f" arrays of shapes {', '.join(map(str, shapes))}"
            )

    def static(self, device: Device) -> Array:
        """Q under a unit acceleration of each component, d - c K⁻¹ L, shape (n_q, 6 p)."""
        follow = np.linalg.solve(device.K, device.L)
        return np.asarray(self.acceleration - self.own @ follow, dtype=np.float64)

    def __add__(self, other: Quantities) -> Quantities:
        return Quantities(
            self.names + other.names,
            self.units + other.units,
            np.vstack([self.own, other.own]),
            np.vstack([self.acceleration, other.acceleration]),
            np.vstack([self.displacement, other.displacement]),
        )


def anchor_forces(device: Device) -> Quantities:
    """Forces and moments of the device on the floor at its anchors, in N and N m.

    In a mode b = z̈ + Γᵀ ä ≈ -ω² z, so that with Γ of all modes in (1) c = Γ φᵀ K,
    d = -(J - Γ Γᵀ) and e = -K_a. They are "force y", "moment x" and so on, "force y at anchor 2" of
    several anchors.
    """
    modes = device_modes(device)
    K_a = np.zeros_like(device.J) if device.anchor_stiffness is None else device.anchor_stiffness
    words = [f"force {name}" for name in "xyz"] + [f"moment {name}" for name in "xyz"]
    several = [f" at anchor {k + 1}" for k in range(device.anchors)]
    return Quantities(
        names=tuple(word + at for at in (several if len(several) > 1 else [""]) for word in words),
        units=device.anchors * (*3 * ("N",), *3 * ("N m",)),
        own=modes.participation @ modes.shape.T @ device.K,
        acceleration=-modes.rigid_mass,
        displacement=-K_a,
    )


def own_motions(device: Device, prefix: str = "base") -> Quantities:
    """Own coordinates relative to the anchors: how far the springs of the anchors give way.

    Only the motions whose names begin with the prefix; "" takes all.

    Raises:
        ImpactfemError: There is no such motion.
    """
    chosen = [i for i, name in enumerate(device.motions) if name.startswith(prefix)]
    if not chosen:
        raise device.error(f"it has no own motion whose name begins with {prefix!r}")
    none = np.zeros((len(chosen), device.J.shape[0]))
    return Quantities(
        names=tuple(f"displacement {device.motions[i]}" for i in chosen),
        units=tuple(_unit(device.motions[i], "m", "rad") for i in chosen),
        own=np.eye(len(device.motions))[chosen],
        acceleration=none,
        displacement=none,
    )


def own_accelerations(device: Device) -> Quantities:
    """Absolute accelerations q̈ = ẍ + r ä of all own coordinates.

    As in `anchor_forces`, c = -φ φᵀ K and d = r - φ Γᵀ.
    """
    modes = device_modes(device)
    return Quantities(
        names=tuple(f"acceleration {name}" for name in device.motions),
        units=tuple(_unit(name, "m/s2", "rad/s2") for name in device.motions),
        own=-modes.shape @ modes.shape.T @ device.K,
        acceleration=device.r - modes.shape @ modes.participation.T,
        displacement=np.zeros((len(device.motions), device.J.shape[0])),
    )


def _unit(motion: str, translation: str, rotation: str) -> str:
    return rotation if motion.split()[-1] in COMPONENTS[3:] else translation


LARGEST_IMBALANCE = 1e-6
"""How far inertia forces and spring forces may differ, of the largest force or moment."""


def base_imbalance(
    device: Device, inertia: Array, springs: Array, acceleration: Array | None = None
) -> float:
    """Compare the force on the anchors by the device's inertia with that in its springs.

    Only along components in which nothing is blocked, where M r = L: a blocked motion hands its
    force on without a spring. Masses that sit on the anchors, J - rᵀ L, press on them without a
    spring, too, by -(J - rᵀ L) ä; without ä, absolute [m/s2, rad/s2], components with such masses
    are left out.

    Of -Lᵀ ẍ - J ä and rᵀ (K x + C ẋ), shape (6 p, n_t) [N, N m], the largest difference over the
    largest force, or of moments over the largest moment [-]; nan where all motions are blocked.
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


@dataclass(frozen=True, eq=False)
class AnchorForce:
    """Histories at the samples of the motion, the device at rest at the first one."""

    time: Array  #: shape (n_t,) [s]
    force: Array  #: F of the device on the floor, shape (6 p, n_t) [N, N m]
    motion: Array  #: own coordinates x relative to the anchors, shape (n, n_t) [m, rad]
    modal: Array  #: z of the modes used, shape (m, n_t)
    modes: DeviceModes  #: those
    #: largest difference of (1) and (2), of the largest force or the largest moment [-]; nan where
    #: all motions of the base are blocked
    imbalance: float

    @property
    def largest(self) -> Array:
        """Largest |F| of every component, shape (6 p,) [N, N m]."""
        return np.asarray(np.max(np.abs(self.force), axis=1), dtype=np.float64)


def own_weight(device: Device) -> Array:
    """Force of a device on its anchors by its weight alone, shape (6 p,) [N, N m].

    Downward and negative along z; zero there for a device made of modes that have no vertical mass.
    """
    return np.asarray(-constants.g * device.J[:, 2::6].sum(axis=1), dtype=np.float64)


def ring_tension(force: Array, radius: float | Array) -> Array:
    """T of equation (3) [N]: n times the pull of the most loaded of n anchors on a circle.

    By the force of the device on the floor at one anchor, weight included, shape (6, ...) [N, N m],
    and the radius of the circle, or of several [m].
    """
    return np.asarray(force[2] + 2.0 * np.hypot(force[3], force[4]) / radius, dtype=np.float64)


def anchor_force(
    device: Device,
    acceleration: Array,
    time_step: float,
    *,
    maximum_frequency: float | None = None,
    displacement: Array | None = None,
) -> AnchorForce:
    """Compute the force of a device on its anchors under their motion.

    Args:
        device: The device, with damping that does not couple its modes.
        acceleration: ä, shape (6 p, n_t) [m/s2, rad/s2], straight between its samples.
        time_step: Of the samples [s].
        maximum_frequency: Modes above it follow the anchors rigidly [Hz]; none does when left out.
        displacement: a, shape (6 p, n_t) [m, rad]; needed when there is a stiffness between
            anchors.

    Raises:
        ImpactfemError: The motion does not fit the device or is not finite, a mode is damped by
            100 % or more, damping couples the modes, or the displacement is missing.
        SolutionError: Action and reaction differ.
    """
    a = _checked(device, "the acceleration", acceleration)
    every = device_modes(device)
    modes = every.below(maximum_frequency)
    modes.refuse_overdamped(device)
    if not every.proportional:
        raise device.error(
            "its damping couples its modes; expected Rayleigh damping, or the matrices of"
            " impactfem.device.device in a direct integration"
        )
    Γ = modes.participation
    z, v, b = np.empty((3, modes.frequency.size, a.shape[1]))
    for i, drive in enumerate(Γ.T @ a):
        f, xi = float(modes.frequency[i]), max(float(modes.damping[i]), 0.0)
        response = oscillator_response(drive, time_step, [f], [xi])
        z[i] = response.relative_displacement[0, 0]
        v[i] = response.relative_velocity[0, 0]
        b[i] = response.absolute_acceleration[0, 0]
    force = -Γ @ b - modes.rigid_mass @ a
    rest = np.linalg.solve(device.K, device.L) - modes.shape / modes.omega**2 @ Γ.T
    x = modes.shape @ z - rest @ a
    springs = device.r.T @ (device.K @ x + device.C @ modes.shape @ v)
    imbalance = base_imbalance(device, force, springs)
    if imbalance > LARGEST_IMBALANCE:
        raise SolutionError(
            f"device {device.name}: the force in its springs differs from its inertia force by"
            f" {imbalance:.1e} of the largest"
        )
    if device.anchor_stiffness is not None and np.any(device.anchor_stiffness):
        if displacement is None:
            raise device.error(
                "there is a stiffness between its anchors; expected their displacement as well"
            )
        force = force - device.anchor_stiffness @ _checked(
            device, "the displacement", displacement, a.shape[1]
        )
    return AnchorForce(
        time=np.asarray(np.arange(a.shape[1], dtype=np.float64) * time_step),
        force=force,
        motion=x,
        modal=z,
        modes=modes,
        imbalance=imbalance,
    )


def _checked(device: Device, what: str, values: Array, samples: int | None = None) -> Array:
    array = np.asarray(values, dtype=np.float64)
    wanted = (device.J.shape[0], array.shape[-1] if samples is None else samples)
    if array.shape != wanted or array.shape[-1] < 2:
        raise device.error(
            f"{what} of its anchors needs shape ({wanted[0]}, samples), got {array.shape}"
        )
    if not np.all(np.isfinite(array)):
        raise device.error(f"{what} of its anchors holds a value that is not a finite number")
    return array
