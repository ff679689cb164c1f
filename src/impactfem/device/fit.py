"""Parameters of a device that give published or measured modes.

Least squares on the relative deviations of frequencies and effective masses,

    min Σ (f_i(p) / f̂_i - 1)² + Σ (m_i(p) / m̂_i - 1)²                                      (1)

over the parameters p that are not known. A rigid body on one spring along y and one about x has two
modes, whose effective masses always add up to its mass: with m = Σ m̂ there is the inertia alone to
meet two frequencies and the ratio of two masses, and three conditions remain for one unknown:

    ω₁² ω₂² = k κ / (m J),    1/ω₁² + 1/ω₂² = m/k + (J + m h²)/κ,
    m₁/ω₁² + m₂/ω₂² = m²/k + m² h²/κ                                                       (2)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from impactfem.device.device import Device
from impactfem.device.modes import device_modes
from impactfem.system.errors import ImpactfemError, SolutionError

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Target:
    """A mode to be met.

    Args:
        frequency: [Hz].
        effective_mass: Along the direction of the fit [kg]; None when it is not known.
    """

    frequency: float
    effective_mass: float | None = None


@dataclass(frozen=True, eq=False)
class Fit:
    """What a fit gives.

    Args:
        parameters: The values found, by name.
        device: The device with them.
        frequency: Of the modes compared, shape (number of targets,) [Hz].
        effective_mass: Of the same, shape (number of targets,) [kg].
        frequency_deviation: f / f̂ - 1 [-].
        mass_deviation: m / m̂ - 1 [-], nan where no mass was given.
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
    direction: str = "y",
    masses: bool = True,
) -> Fit:
    """Find parameters that give the modes asked for.

    Args:
        build: Makes the device from the parameters, given by name.
        start: Positive start values by name; each is looked for between a hundredth of it and a
            hundred times it.
        targets: The first modes with mass along the direction, in ascending frequency.
        direction: Component of the anchor.
        masses: Whether the effective masses are part of (1); the deviations are given anyway.

    Raises:
        ImpactfemError: There are more parameters than values to meet, or a value is not positive.
        SolutionError: The search does not converge, or the device has fewer modes along the
            direction than are asked for.
    """
    names = tuple(start)
    s = np.array([start[name] for name in names])
    f = np.array([target.frequency for target in targets])
    m = np.array(
        [np.nan if t.effective_mass is None else t.effective_mass for t in targets],
        dtype=np.float64,
    )
    known = ~np.isnan(m) if masses else np.zeros(m.shape, dtype=np.bool_)
    if not targets or not 1 <= s.size <= f.size + int(known.sum()):
        raise ImpactfemError(
            f"a fit of {s.size} parameters to {f.size + int(known.sum())} values: expected at least"
            " one parameter, and as many values"
        )
    if not (np.all(s > 0.0) and np.all(f > 0.0) and np.all(m[~np.isnan(m)] > 0.0)):
        raise ImpactfemError("start values, frequencies and masses of a fit must be positive")

    def modes_of(p: Array) -> tuple[Device, Array, Array]:
        device = build(**dict(zip(names, map(float, p), strict=True)))
        modes = device_modes(device)
        mass = modes.effective_mass[device.column(direction)]
        moving = mass > 1e-9 * mass.sum()
        if int(moving.sum()) < f.size:
            raise SolutionError(
                f"device {device.name}: {int(moving.sum())} modes move it along {direction},"
                f" {f.size} are asked for"
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
        parameters=dict(zip(names, map(float, p), strict=True)),
        device=device,
        frequency=frequency,
        effective_mass=mass,
        frequency_deviation=frequency / f - 1.0,
        mass_deviation=mass / m - 1.0,
    )
