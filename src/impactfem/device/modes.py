"""Modes of a device: participation, effective masses, damping, and what is left over.

With φᵀ M φ = 1 and the participation Γ = Lᵀ φ, a mode moves by

    z̈ + 2 ξ ω ż + ω² z = -Γᵀ ä,    x = φ z                                                (1)

and pushes the anchors with -Γ (z̈ + Γᵀ ä). What no mode carries, J - Σ Γ Γᵀ, follows the anchors as
a rigid body: masses on blocked motions, and the modes that were left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from impactfem.device.device import Device
from impactfem.device.natural import natural_modes
from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]

PROPORTIONAL = 1e-9
"""Damping is proportional when φᵢᵀ C φⱼ is below this part of √(φᵢᵀ C φᵢ φⱼᵀ C φⱼ)."""


@dataclass(frozen=True, eq=False)
class DeviceModes:
    """Modes in ascending frequency.

    Args:
        frequency: Natural frequencies, shape (m,) [Hz].
        damping: Damping ratios ξ = φᵀ C φ / (2 ω), shape (m,) [-].
        shape: φ with φᵀ M φ = 1, shape (n, m).
        participation: Γ of every component of the anchors, shape (6 p, m) [√kg, √kg m].
        total: J of the device, shape (6 p, 6 p).
        proportional: Whether damping does not couple the modes.
    """

    frequency: Array
    damping: Array
    shape: Array
    participation: Array
    total: Array
    proportional: bool

    @property
    def omega(self) -> Array:
        """Circular frequencies ω, shape (m,) [rad/s]."""
        return np.asarray(2.0 * np.pi * self.frequency, dtype=np.float64)

    @property
    def effective_mass(self) -> Array:
        """Effective masses and inertias Γ², shape (6 p, m) [kg, kg m2]."""
        return np.asarray(self.participation**2, dtype=np.float64)

    @property
    def share(self) -> Array:
        """Effective masses over those of the rigid device, or 0, shape (6 p, m) [-]."""
        whole = np.diag(self.total)[:, None]
        return np.divide(
            self.effective_mass, whole, out=np.zeros_like(self.participation), where=whole > 0.0
        )

    @property
    def reaction_mass(self) -> Array:
        """Γ Γᵀ of each mode, shape (m, 6 p, 6 p).

        Reaction in the first component to a unit pseudo-acceleration along the second: effective
        masses on the diagonal, effective mass moments [kg m] between translations and rotations.
        """
        return np.asarray(np.einsum("im,jm->mij", self.participation, self.participation))

    @property
    def rigid_mass(self) -> Array:
        """J - Σ Γ Γᵀ, the mass that these modes do not carry, shape (6 p, 6 p)."""
        return np.asarray(self.total - self.participation @ self.participation.T)

    @property
    def height(self) -> Array:
        """Where an effective mass acts above the first anchor, shape (m,) [m]; nan without one.

        Overturning moment over horizontal force, (Γ_x Γ_ry - Γ_y Γ_rx) / (Γ_x² + Γ_y²); it may lie
        above the device or below its anchor.
        """
        x, y, _, rx, ry, _ = self.participation[:6]
        push = x**2 + y**2
        horizontal = push > 1e-12 * np.max(np.diag(self.total)[:2])
        out: Array = np.full(push.shape, np.nan, dtype=np.float64)
        np.divide(x * ry - y * rx, push, out=out, where=horizontal)
        return out

    def below(self, frequency: float | None) -> DeviceModes:
        """The modes up to a frequency [Hz]; all when None."""
        return self if frequency is None else self.only(self.frequency <= frequency)

    def only(self, keep: npt.NDArray[np.bool_]) -> DeviceModes:
        """The modes that are marked, shape (m,)."""
        return replace(
            self,
            frequency=self.frequency[keep],
            damping=self.damping[keep],
            shape=self.shape[:, keep],
            participation=self.participation[:, keep],
        )

    def refuse_overdamped(self, device: Device) -> None:
        """Refuse modes that do not oscillate.

        Raises:
            ImpactfemError: A mode is damped by 100 % or more.
        """
        if np.any(self.damping >= 1.0):
            k = int(np.argmax(self.damping >= 1.0))
            raise device.error(
                f"its mode at {self.frequency[k]:.4g} Hz is damped by {self.damping[k]:.0%};"
                " expected less than 100 %, or a maximum frequency below it: it then counts as"
                " rigid"
            )


def device_modes(device: Device) -> DeviceModes:
    """All modes with mass of a device.

    Args:
        device: The device.

    Returns:
        Its modes, each with its largest participation in a translation, or else in a rotation,
        positive.

    Raises:
        ImpactfemError: The device has no mode.
    """
    omega, shape = natural_modes(device.M, device.K)
    if not omega.size:
        raise ImpactfemError(f"device {device.name}: it has no mode with mass")
    participation = device.L.T @ shape
    size = np.sqrt(np.maximum(np.diag(device.J), np.finfo(np.float64).tiny))
    largest = np.argmax(np.abs(participation) / size[:, None], axis=0)
    sign = np.where(participation[largest, np.arange(omega.size)] < 0.0, -1.0, 1.0)
    shape, participation = shape * sign, participation * sign
    modal = shape.T @ device.C @ shape
    diagonal = np.diag(modal)
    size = np.sqrt(np.outer(np.abs(diagonal), np.abs(diagonal)))
    off = np.abs(modal - np.diag(diagonal)) > PROPORTIONAL * np.maximum(
        size, PROPORTIONAL * np.max(np.abs(diagonal), initial=0.0)
    )
    return DeviceModes(
        frequency=np.asarray(omega / (2.0 * np.pi), dtype=np.float64),
        damping=diagonal / (2.0 * omega),
        shape=shape,
        participation=participation,
        total=device.J,
        proportional=not bool(np.any(off)),
    )
