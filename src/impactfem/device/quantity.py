"""Linear response quantities of a device: forces, displacements, accelerations.

A quantity is Q = c x + d ä + e a, with the own coordinates x and the anchors' motion a. Under a
constant acceleration ä of the anchors the device comes to rest against them at x = -K⁻¹ L ä.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.device.device import Device
from impactfem.device.modes import device_modes
from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Quantities:
    """Several quantities of one device.

    Args:
        names: What they are, n_q of them.
        units: Their units.
        own: c, shape (n_q, n).
        acceleration: d, shape (n_q, 6 p).
        displacement: e, shape (n_q, 6 p).

    Raises:
        ImpactfemError: Shapes do not fit each other.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    own: Array
    acceleration: Array
    displacement: Array

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
    """Forces and moments of the device on the floor at its anchors.

    In a mode b = z̈ + Γᵀ ä ≈ -ω² z, so that with Γ of all modes (equation 1 of
    :mod:`impactfem.device.anchor_force`) c = Γ φᵀ K, d = -(J - Γ Γᵀ) and e = -K_a.

    Args:
        device: The device.

    Returns:
        "force y", "moment x" and so on of each anchor, in N and N m.
    """
    modes = device_modes(device)
    K_a = np.zeros_like(device.J) if device.anchor_stiffness is None else device.anchor_stiffness
    words = [_as_force(name) for name in device.inputs]
    return Quantities(
        names=tuple(words),
        units=tuple("N m" if "moment" in word else "N" for word in words),
        own=modes.participation @ modes.shape.T @ device.K,
        acceleration=-modes.rigid_mass,
        displacement=-K_a,
    )


def own_motions(device: Device, prefix: str = "base") -> Quantities:
    """Own coordinates relative to the anchors: how far the springs of the anchors give way.

    Args:
        device: The device.
        prefix: Only the motions whose names begin with it; "" takes all.

    Raises:
        ImpactfemError: There is no such motion.
    """
    chosen = [i for i, name in enumerate(device.motions) if name.startswith(prefix)]
    if not chosen:
        raise device.error(f"it has no own motion whose name begins with {prefix!r}")
    own = np.eye(len(device.motions))[chosen]
    none = np.zeros((len(chosen), device.J.shape[0]))
    names = tuple(f"displacement {device.motions[i]}" for i in chosen)
    units = tuple(_unit(device.motions[i], "m", "rad") for i in chosen)
    return Quantities(names, units, own, none, none)


def own_accelerations(device: Device, motions: Sequence[str] | None = None) -> Quantities:
    """Absolute accelerations q̈ = ẍ + r ä of own coordinates.

    As above, c = -φ φᵀ K and d = r - φ Γᵀ.

    Args:
        device: The device.
        motions: Names of the motions; all when None.

    Raises:
        ImpactfemError: There is no such motion.
    """
    wanted = device.motions if motions is None else tuple(motions)
    unknown = [name for name in wanted if name not in device.motions]
    if unknown or not wanted:
        raise device.error(
            f"it has no own motion {unknown[0] if unknown else 'without a name'!r}; expected one of"
            f" {', '.join(device.motions)}"
        )
    chosen = [device.motions.index(name) for name in wanted]
    modes = device_modes(device)
    return Quantities(
        names=tuple(f"acceleration {name}" for name in wanted),
        units=tuple(_unit(name, "m/s2", "rad/s2") for name in wanted),
        own=-modes.shape[chosen] @ modes.shape.T @ device.K,
        acceleration=device.r[chosen] - modes.shape[chosen] @ modes.participation.T,
        displacement=np.zeros((len(chosen), device.J.shape[0])),
    )


def _as_force(component: str) -> str:
    anchor, _, name = component.rpartition(".")
    word = f"moment {name[1]}" if name.startswith("r") else f"force {name}"
    return f"{word} at anchor {anchor}" if anchor else word


def _unit(motion: str, translation: str, rotation: str) -> str:
    return rotation if motion.split()[-1] in ("rx", "ry", "rz") else translation
