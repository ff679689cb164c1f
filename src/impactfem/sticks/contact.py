"""Contact laws: the force between two points from their penetration and its rate.

A law is one compiled function ``(parameters, p, v) -> (F, dF/dp, dF/dv)`` with the penetration
p > 0 [m], its rate v [m/s] and the force F [N], positive in compression. `law_force` picks it by
its code. A law is used only while p > 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
import scipy.optimize
from numpy.typing import NDArray

KELVIN_VOIGT = 0
KELVIN_VOIGT_NO_TENSION = 1
N_PARAMETERS = 4


def restitution(xi: float, *, tension: bool = True) -> float:
    """Restitution of a Kelvin-Voigt contact between two free masses.

    With tension, release is at p = 0 and ε = exp(-π ξ / √(1 - ξ²)). Without, the force is cut when
    it would pull, K p + C v = 0. With θ the phase Ω_D t of that moment, tan θ = 2 ξ √(1 - ξ²) /
    (2 ξ² - 1), the speed there is exp(-ξ θ / √(1 - ξ²)) of the first one; for ξ > 1 its
    continuation with r = √(ξ² - 1) is ((ξ + r) / (ξ - r))^(-ξ / r) (Schwager and Pöschel 2007,
    Granular Matter 9, 465-469).

    Args:
        xi: Damping ratio ξ >= 0 [-]; below 1 with tension.
        tension: Whether the contact may pull at its end.
    """
    if xi < 1.0:
        root = np.sqrt(1.0 - xi**2)
        theta = np.pi if tension else np.arctan2(2.0 * xi * root, 2.0 * xi**2 - 1.0)
        return float(np.exp(-xi * theta / root))
    if tension:
        return 0.0
    r = np.sqrt(xi**2 - 1.0)
    return float(np.exp(-2.0 * xi) if r == 0.0 else ((xi + r) / (xi - r)) ** (-xi / r))


def damping_ratio(epsilon: float, *, tension: bool = True) -> float:
    """Damping ratio of a Kelvin-Voigt contact that returns the restitution ε: `restitution` solved.

    With tension, ξ_c = -ln ε / √(π² + ln² ε) (paper, equation 4; Anagnostopoulos 1988).

    Args:
        epsilon: Restitution, 0 < ε <= 1 [-].
        tension: Whether the contact may pull at its end.
    """
    if tension:
        return float(-np.log(epsilon) / np.hypot(np.pi, np.log(epsilon)))
    if epsilon == 1.0:
        return 0.0
    upper = 1.0
    while restitution(upper, tension=False) > epsilon:
        upper *= 2.0
    return float(
        scipy.optimize.brentq(
            lambda xi: restitution(xi, tension=False) - epsilon, 0.0, upper, xtol=1e-15
        )
    )


@dataclass(frozen=True)
class Law:
    """A contact law for one pair, ready for the loop.

    Args:
        code: Which law.
        parameters: Its parameters, shape (N_PARAMETERS,); Kelvin-Voigt: K [N/m], C [N s/m].
        epsilon: The restitution asked [-].
        xi: Its damping ratio ξ_c [-].
        mass: Effective mass of the two points [kg].
    """

    code: int
    parameters: NDArray[np.float64]
    epsilon: float
    xi: float
    mass: float

    @property
    def duration(self) -> float:
        """Duration π / Ω_D of an impact of two free masses, Ω_D = √((1 - ξ²) K / m) [s]."""
        return float(np.pi / np.sqrt(self.parameters[0] * (1.0 - self.xi**2) / self.mass))

    @property
    def onset_force_per_speed(self) -> float:
        """Force per approach speed with which contact begins, C = 2 ξ √(K m) [N s/m]."""
        return float(self.parameters[1])


def effective_mass(m1: float, m2: float) -> float:
    """Effective mass m₁ m₂ / (m₁ + m₂) of two masses in contact [kg]; infinite ones count."""
    return 1.0 / (1.0 / m1 + 1.0 / m2)


def kelvin_voigt(K: float, xi: float, mass: float, *, tension: bool = True) -> Law:
    """The Kelvin-Voigt law of a pair.

    F = K p + C v with C = 2 ξ √(K m) (paper, equations 2 and 3).

    Args:
        K: Penalty stiffness [N/m].
        xi: Damping ratio at contact ξ_c [-].
        mass: Effective mass of the pair [kg].
        tension: Whether the contact may pull at its end, as in the paper.
    """
    C = 2.0 * xi * np.sqrt(K * mass)
    parameters = np.zeros(N_PARAMETERS)
    parameters[:2] = K, C
    code = KELVIN_VOIGT if tension else KELVIN_VOIGT_NO_TENSION
    return Law(code, parameters, restitution(xi, tension=tension), xi, mass)


@numba.njit(cache=True)
def kelvin_voigt_force(
    parameters: NDArray[np.float64], p: float, v: float
) -> tuple[float, float, float]:
    """F = K p + C v; pulls near the end of the contact (paper, equation 2)."""
    K, C = parameters[0], parameters[1]
    return K * p + C * v, K, C


@numba.njit(cache=True)
def kelvin_voigt_no_tension_force(
    parameters: NDArray[np.float64], p: float, v: float
) -> tuple[float, float, float]:
    """F = max(0, K p + C v)."""
    K, C = parameters[0], parameters[1]
    F = K * p + C * v
    if F <= 0.0:
        return 0.0, 0.0, 0.0
    return F, K, C


@numba.njit(cache=True)
def law_force(
    code: int, parameters: NDArray[np.float64], p: float, v: float
) -> tuple[float, float, float]:
    """Force and derivatives of the law with this code; (0, 0, 0) without penetration."""
    if p <= 0.0:
        return 0.0, 0.0, 0.0
    if code == KELVIN_VOIGT:
        return kelvin_voigt_force(parameters, p, v)
    return kelvin_voigt_no_tension_force(parameters, p, v)
