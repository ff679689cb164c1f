"""Several devices as one interface: the matrices of their anchors and own modes, side by side.

Of each device the own coordinates are x = φ ζ with its modes with mass, φᵀ M φ = 1: motions without
mass follow these at once. With y = (a, ζ), the anchors of all devices first, relative to the
ground,

    M_d ÿ + C_d ẏ + K_d y = (-F, 0) - M_d (R, 0) g̈                                         (1)

where F are the forces of the devices on the floor, g̈ is the acceleration of the ground and R takes
it to the anchors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.device.body import Body
from impactfem.device.coupled import coupled
from impactfem.device.device import Device
from impactfem.device.natural import WITH_MASS, natural_modes
from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]

MASSLESS_DAMPING = 1e-9
"""Part of the largest entry of the equilibrated dampers that may act on a motion without mass."""


@dataclass(frozen=True, eq=False)
class MountedDevice:
    """A device and where it stands on the structure.

    Args:
        name: Its name.
        device: The device; a body alone is one rigid mass at its anchor.
        shapes: Φ of its anchors' components, shape (6 p, r): their motions relative to the ground
            are Φ z.
        drag: Whether the mass part of the device's Rayleigh damping acts on velocities against the
            ground, as in a finite element model; on those relative to the anchors otherwise.
    """

    name: str
    device: Device | Body
    shapes: Array
    drag: bool = False

    @property
    def anchors(self) -> int:
        """Number p of anchors."""
        return 1 if isinstance(self.device, Body) else self.device.anchors

    @property
    def mass(self) -> Array:
        """J, the mass of the rigid device about its anchors, shape (6 p, 6 p)."""
        if isinstance(self.device, Body):
            return self.device.about(np.zeros(3))
        return self.device.J

    @property
    def ground(self) -> Array:
        """R, the motion of the anchors by that of the ground, shape (6 p, 3)."""
        return np.tile(np.eye(6, 3), (self.anchors, 1))

    def error(self, text: str) -> ImpactfemError:
        """An error that names the device."""
        return ImpactfemError(f"mounted device {self.name}: {text}")


@dataclass(frozen=True, eq=False)
class Interface:
    """Equation (1) for all devices.

    Args:
        M: M_d, shape (N, N).
        C: C_d.
        K: K_d.
        R: Motion of the interface by that of the ground, shape (N, 3).
        shapes: Φ of all anchors, shape (N_a, r).
        anchors: Rows of each device's anchors in y.
        modes: Rows of each device's ζ in y.
        own: φ of each device, shape (n, number of its modes).
    """

    M: Array
    C: Array
    K: Array
    R: Array
    shapes: Array
    anchors: tuple[Index, ...]
    modes: tuple[Index, ...]
    own: tuple[Array, ...]


def interface_of(devices: Sequence[MountedDevice]) -> Interface:
    """Put devices side by side.

    Args:
        devices: At least one; Φ of all have the same number of columns.

    Raises:
        ImpactfemError: Φ does not fit its device, a stiffness between anchors holds the ground,
            drag is asked of a device without Rayleigh damping, or a damper acts on a motion without
            mass.
    """
    parts = [_part(one) for one in devices]
    anchored = np.array([6 * one.anchors for one in devices], dtype=np.int64)
    modal = np.array([own.shape[1] for *_, own in parts], dtype=np.int64)
    of_anchors = _rows(anchored, 0)
    of_modes = _rows(modal, int(anchored.sum()))
    n = int(anchored.sum() + modal.sum())
    M, C, K = (np.zeros((n, n)) for _ in range(3))
    R = np.zeros((n, 3))
    for one, part, a, m in zip(devices, parts, of_anchors, of_modes, strict=True):
        here = np.ix_(np.concatenate([a, m]), np.concatenate([a, m]))
        M[here], C[here], K[here] = part[:3]
        R[a] = one.ground
    return Interface(
        M=M,
        C=C,
        K=K,
        R=R,
        shapes=np.ascontiguousarray(np.vstack([one.shapes for one in devices])),
        anchors=of_anchors,
        modes=of_modes,
        own=tuple(own for *_, own in parts),
    )


def _rows(counts: Index, first: int) -> tuple[Index, ...]:
    ends = first + np.cumsum(counts)
    return tuple(
        np.arange(end - count, end, dtype=np.int64) for end, count in zip(ends, counts, strict=True)
    )


def _part(one: MountedDevice) -> tuple[Array, Array, Array, Array]:
    """M_d, C_d and K_d of one device, and φ."""
    J = one.mass
    if one.shapes.ndim != 2 or len(one.shapes) != len(J):
        raise one.error(
            f"the shapes of its anchors need {len(J)} rows, one a component, got shape"
            f" {one.shapes.shape}"
        )
    if not np.all(np.isfinite(one.shapes)):
        raise one.error("the shapes of its anchors hold a value that is not a finite number")
    if isinstance(one.device, Body):
        if one.drag:
            raise one.error("a rigid body has no Rayleigh damping; expected no drag")
        none = np.zeros_like(J)
        return J, none, none, np.zeros((0, 0))
    device = one.device
    device.refuse_held_ground()
    φ = natural_modes(device.M, device.K)[1]
    if device.dampers is not None and _damps_the_massless(device, device.dampers):
        raise one.error(
            "a damper acts on a motion without mass, which then no mode carries; expected a mass"
            " there"
        )
    part = coupled(device, "relative", drag=one.drag)
    p6 = part.interface
    T = np.zeros((len(part.M), p6 + φ.shape[1]))
    T[:p6, :p6] = np.eye(p6)
    T[p6:, p6:] = φ
    return T.T @ part.M @ T, T.T @ part.C @ T, T.T @ part.K @ T, φ


def _damps_the_massless(device: Device, dampers: Array) -> bool:
    """Whether dampers act on motions that the modes with mass do not carry on their own.

    Rayleigh damping and one ratio for all modes never couple both.
    """
    scale = 1.0 / np.sqrt(np.diag(device.K))
    values, motions = np.linalg.eigh(device.M * np.outer(scale, scale))
    massless = motions[:, values <= WITH_MASS * values[-1]]
    equilibrated = dampers * np.outer(scale, scale)
    acting = np.max(np.abs(equilibrated @ massless), initial=0.0)
    return bool(acting > MASSLESS_DAMPING * np.max(np.abs(equilibrated)))
