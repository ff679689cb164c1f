"""Modes of a device: participation, effective masses, damping, and what is left over.

With φᵀ M φ = 1 and the participation Γ = Lᵀ φ, a mode moves by

    z̈ + 2 ξ ω ż + ω² z = -Γᵀ ä,    x = φ z                                                (1)

and pushes the anchors with -Γ (z̈ + Γᵀ ä). What no mode carries, J - Σ Γ Γᵀ, follows the anchors as
a rigid body: masses on blocked motions, and the modes that were left out.

A fit finds parameters p that give published or measured modes f̂, m̂, by least squares on

    min Σ (f_i(p) / f̂_i - 1)² + Σ (m_i(p) / m̂_i - 1)²                                      (2)

A rigid body on one spring along y and one about x has two modes, whose effective masses always add
up to its mass: with m = Σ m̂ there is the inertia alone to meet two frequencies and the ratio of two
masses.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from impactfem.device.device import Device
from impactfem.sticks.modes import natural_modes
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError, SolutionError

PROPORTIONAL = 1e-9
"""Damping is proportional when φᵢᵀ C φⱼ is below this part of √(φᵢᵀ C φᵢ φⱼᵀ C φⱼ)."""


@dataclass(frozen=True, eq=False)
class DeviceModes:
    """Modes in ascending frequency."""

    frequency: Array  #: natural frequencies, shape (m,) [Hz]
    damping: Array  #: damping ratios ξ = φᵀ C φ / (2 ω), shape (m,) [-]
    shape: Array  #: φ with φᵀ M φ = 1, shape (n, m)
    participation: Array  #: Γ of every component of the anchors, shape (6 p, m) [√kg, √kg m]
    total: Array  #: J of the device, shape (6 p, 6 p)
    proportional: bool  #: whether damping does not couple the modes

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
        """Refuse modes that do not oscillate, damped by 100 % or more."""
        if np.any(self.damping >= 1.0):
            k = int(np.argmax(self.damping >= 1.0))
            raise device.error(
                f"its mode at {self.frequency[k]:.4g} Hz is damped by {self.damping[k]:.0%};"
                " expected less than 100 %, or a maximum frequency below it: it then counts as"
                " rigid"
            )


def device_modes(device: Device) -> DeviceModes:
    """All modes with mass of a device.

    The largest participation of each in a translation, or else in a rotation, is positive.

    Raises:
        ImpactfemError: The device has no mode.
    """
    omega, shape = natural_modes(device.M, device.K)
    if not omega.size:
        raise device.error("it has no mode with mass")
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


@dataclass(frozen=True)
class Target:
    """A mode to be met: its frequency [Hz] and, where it is known, its effective mass [kg]."""

    frequency: float
    effective_mass: float | None = None


@dataclass(frozen=True, eq=False)
class Fit:
    """What a fit gives: the parameters by name, the device, and the modes that were compared.

    Frequencies [Hz], effective masses [kg] and their deviations f / f̂ - 1 and m / m̂ - 1, the latter
    nan where no mass was given, have shape (number of targets,).
    """

    parameters: dict[str, float]
    device: Device
    frequency: Array
    effective_mass: Array
    frequency_deviation: Array
    mass_deviation: Array


def fit_device(
    build: Callable[..., Device],
    start: Mapping[str, float],
    targets: tuple[Target, ...],
    masses: bool = True,
) -> Fit:
    """Find parameters that give the requested modes.

    Args:
        build: Makes the device from the parameters, given by name.
        start: Positive start values by name; each is looked for between a hundredth of it and a
            hundred times it.
        targets: The first modes with mass along y, in ascending frequency.
        masses: Whether the effective masses are part of (2); the deviations are given anyway.

    Raises:
        ImpactfemError: There are more parameters than values to meet, or a value is not positive.
        SolutionError: The search does not converge, or the device has fewer modes along y
            than requested.
    """
    names, s = tuple(start), np.array(list(start.values()))
    f = np.array([target.frequency for target in targets])
    m = np.array([target.effective_mass for target in targets], dtype=np.float64)  # None is nan
    known = ~np.isnan(m) & masses
    values = f.size + int(known.sum())
    if not targets or not 1 <= s.size <= values:
        raise ImpactfemError(
            f"a fit of {s.size} parameters to {values} values: expected at least one parameter, and"
            " as many values"
        )
    if not (np.all(s > 0.0) and np.all(f > 0.0) and np.all(m[~np.isnan(m)] > 0.0)):
        raise ImpactfemError("start values, frequencies and masses of a fit must be positive")

    def modes_of(p: Array) -> tuple[Device, Array, Array]:
        device = build(**dict(zip(names, p.tolist(), strict=True)))
        modes = device_modes(device)
        mass = modes.effective_mass[device.column("y")]
        moving = mass > 1e-9 * mass.sum()
        if int(moving.sum()) < f.size:
            raise SolutionError(
                f"device {device.name}: {int(moving.sum())} modes move it along y,"
                f" {f.size} are requested"
            )
        return device, modes.frequency[moving][: f.size], mass[moving][: f.size]

    def deviations(logarithms: Array) -> Array:
        _, frequency, mass = modes_of(s * np.exp(logarithms))
        return np.concatenate([frequency / f - 1.0, mass[known] / m[known] - 1.0])

    found = least_squares(
        deviations,
        np.zeros(s.size),
        bounds=(-np.log(100.0), np.log(100.0)),
        xtol=1e-14,
        ftol=1e-14,
        gtol=1e-14,
    )
    if not found.success:
        raise SolutionError(f"the fit of {', '.join(names)} does not converge: {found.message}")
    p = s * np.exp(found.x)
    device, frequency, mass = modes_of(p)
    return Fit(
        parameters=dict(zip(names, p.tolist(), strict=True)),
        device=device,
        frequency=frequency,
        effective_mass=mass,
        frequency_deviation=frequency / f - 1.0,
        mass_deviation=mass / m - 1.0,
    )
