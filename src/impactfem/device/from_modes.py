"""A device of which a table of modes is known: frequencies, effective masses, heights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.device.body import Body
from impactfem.device.device import Device
from impactfem.device.springs import COMPONENTS
from impactfem.dynamics.damping import Rayleigh, checked_ratio
from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]

ROUNDING = 1e-6
"""How far effective masses may exceed the mass of the device, of it: tables are rounded."""


@dataclass(frozen=True)
class TableMode:
    """One mode.

    Args:
        frequency: [Hz].
        direction: "x", "y", "z", "rx", "ry" or "rz": how it moves.
        effective_mass: Of this direction [kg], or about this axis [kg m2].
        height: Where it acts above the anchor, for a horizontal direction [m]: overturning moment
            over force.
        damping: Ratio of its own; that of the device when None [-].
    """

    frequency: float
    direction: str
    effective_mass: float
    height: float = 0.0
    damping: float | None = None


def from_modes(
    name: str, modes: Sequence[TableMode], damping: Rayleigh | float, body: Body | None = None
) -> Device:
    """Build a device of oscillators, one a mode.

    Each is a mass in its direction at its height. With the mass of the whole device given, what its
    modes do not carry follows the anchor as a rigid body.

    Args:
        name: Name of the device.
        modes: The table.
        damping: Of the modes that have none of their own.
        body: Mass, mass centre and inertia of the whole device; only its modes when None.

    Raises:
        ImpactfemError: A value of the table is not usable, or the modes carry more mass than the
            device has.
    """
    if not modes:
        raise ImpactfemError(f"device {name}: its table holds no mode")
    r = np.zeros((len(modes), 6))
    for i, mode in enumerate(modes):
        _check(name, i + 1, mode)
        c = COMPONENTS.index(mode.direction)
        r[i, c] = 1.0
        # A rotation moves a point at the height z by u_x = +z r_y, u_y = -z r_x.
        if c == 0:
            r[i, 4] = mode.height
        elif c == 1:
            r[i, 3] = -mode.height
    m = np.array([mode.effective_mass for mode in modes])
    omega = np.array([2.0 * math.pi * mode.frequency for mode in modes])
    carried = r.T @ np.diag(m) @ r
    whole = carried if body is None else body.about(np.zeros(3))
    for c, component in enumerate(COMPONENTS[:3]):
        if carried[c, c] > whole[c, c] * (1.0 + ROUNDING):
            raise ImpactfemError(
                f"device {name}: its modes carry {carried[c, c]:g} kg along {component}, more than"
                f" the {whole[c, c]:g} kg it weighs; expected at most its mass"
            )
    law = damping if isinstance(damping, Rayleigh) else checked_ratio(damping)
    ratios = [
        checked_ratio(mode.damping)
        if mode.damping is not None
        else float(law.ratio(mode.frequency))
        if isinstance(law, Rayleigh)
        else law
        for mode in modes
    ]
    return Device(
        name=name,
        motions=tuple(f"mode {i + 1} {mode.direction}" for i, mode in enumerate(modes)),
        M=np.diag(m),
        K=np.diag(m * omega**2),
        L=m[:, None] * r,
        J=whole,
        r=r,
        damping=0.0,
        dampers=np.diag(2.0 * np.array(ratios) * omega * m),
    )


def _check(name: str, number: int, mode: TableMode) -> None:
    where = f"device {name}: mode {number}"
    if mode.direction not in COMPONENTS:
        raise ImpactfemError(
            f"{where}: direction {mode.direction!r}: expected one of {', '.join(COMPONENTS)}"
        )
    for what, value, unit in (
        ("frequency", mode.frequency, "Hz"),
        ("effective mass", mode.effective_mass, "kg"),
    ):
        if not (math.isfinite(value) and value > 0.0):
            raise ImpactfemError(f"{where}: {what} {value!r} {unit}: expected a positive number")
    if not math.isfinite(mode.height):
        raise ImpactfemError(f"{where}: height {mode.height!r} m: expected a finite number")
