"""Relations of the damping of contact laws and the restitution of two free masses.

A requested restitution ε is above 0 and at most 1; damping ratios ξ and χ are at least 0.
With `tension` a Kelvin-Voigt contact may pull at its end.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy.integrate
import scipy.optimize


def kelvin_voigt_phase(xi: float, *, tension: bool = True) -> float:
    """Duration of a Kelvin-Voigt contact of two free masses times Ω = √(K/m) [-].

    With tension, until p = 0: π / √(1 - ξ²). Without, until the force is zero, at the phase
    θ = Ω_D t with tan θ = 2 ξ √(1 - ξ²) / (2 ξ² - 1); for ξ >= 1 its continuation.
    """
    if xi < 1.0:
        root = np.sqrt(1.0 - xi**2)
        theta = np.pi if tension else np.arctan2(2.0 * xi * root, 2.0 * xi**2 - 1.0)
        return float(theta / root)
    if tension:
        return float("inf")
    r = np.sqrt(xi**2 - 1.0)
    return float(2.0 if r == 0.0 else np.log((xi + r) / (xi - r)) / r)


def kelvin_voigt(xi: float, *, tension: bool = True) -> float:
    """Restitution of a Kelvin-Voigt contact: ε = exp(-ξ Ω t) at its end.

    With tension ε = exp(-π ξ / √(1 - ξ²)) (paper, equation 4; Anagnostopoulos 1988); without, the
    same of the earlier end (Schwager and Pöschel 2007, Granular Matter 9, 465-469).
    """
    return float(np.exp(-xi * kelvin_voigt_phase(xi, tension=tension)))


def kelvin_voigt_xi(epsilon: float, *, tension: bool = True) -> float:
    """Damping ratio of a Kelvin-Voigt contact that returns the restitution ε.

    With tension ξ_c = -ln ε / √(π² + ln² ε) (paper, equation 4); without, by solution.
    """
    if epsilon == 1.0:
        return 0.0
    if tension:
        return float(-np.log(epsilon) / np.hypot(np.pi, np.log(epsilon)))
    upper = 1.0
    while kelvin_voigt(upper, tension=False) > epsilon:
        upper *= 2.0

    def difference(xi: float) -> float:
        return kelvin_voigt(xi, tension=False) - epsilon

    return float(scipy.optimize.brentq(difference, 0.0, upper, xtol=1e-15))


def exact_chi(epsilon: float) -> float:
    """The χ with which F = K pⁿ (1 + χ v / v₀) returns the restitution ε, for any n.

    From m v dv = -K pⁿ (1 + χ v / v₀) dp over a whole contact,
    ln((1 + χ) / (1 - χ ε)) = χ (1 + ε).
    """
    if epsilon == 1.0:
        return 0.0
    if epsilon < 1.0 / 30.0:
        return 1.0 / epsilon  # the rest is e^(-1/ε)
    if 1.0 - epsilon < 1e-4:
        # Series: the roots at 0 and here are too close for rounded logarithms.
        return 1.5 * (1.0 - epsilon)

    # In y = -ln(1 - χ ε): χ → 1/ε is y → ∞, and the difference is negative behind χ = 0.
    def in_y(y: float) -> float:
        chi = -np.expm1(-y) / epsilon
        return float(np.log1p(chi) + y - chi * (1.0 + epsilon))

    high = 2.0 * (1.0 + 1.0 / epsilon)
    y = scipy.optimize.brentq(in_y, 1e-5 * (1.0 - epsilon), high, xtol=1e-15)
    return float(-np.expm1(-y) / epsilon)


def damped_hertz(chi: float) -> float:
    """Restitution of F = K pⁿ (1 + χ v / v₀): the relation of `exact_chi` solved for ε."""
    if chi < 1.5e-4:
        return 1.0 - chi / 1.5
    if chi > 30.0:
        return 1.0 / chi  # the rest is e^-χ

    def difference(epsilon: float) -> float:
        return float(np.log1p(chi) - np.log1p(-chi * epsilon) - chi * (1.0 + epsilon))

    # It falls from ln(1 + χ) - χ < 0 at ε = 0 ... and rises to infinity at ε = 1/χ.
    high = min(1.0, (1.0 - 1e-15) / chi)
    return float(scipy.optimize.brentq(difference, 0.0, high, xtol=1e-15))


@lru_cache(maxsize=256)
def jankowski(xi: float) -> float:
    """Restitution of Jankowski's law for two free masses, by integration.

    In the variables x = p / L, τ = t v₀ / L with β L^2.5 = m v₀², approaching masses obey
    x'' = -x^1.5 - 2 ξ x^0.25 x'; they part elastically, so that ε² = 4/5 x_max^2.5.
    """
    if xi == 0.0:
        return 1.0

    def rates(_: float, y: list[float]) -> list[float]:
        x, speed = max(y[0], 0.0), y[1]
        return [speed, -(x**1.5) - 2.0 * xi * x**0.25 * speed]

    def stopped(_: float, y: list[float]) -> float:
        return y[1]

    stopped.terminal = True  # type: ignore[attr-defined]
    found = scipy.integrate.solve_ivp(
        rates, (0.0, 1e3), [0.0, 1.0], events=stopped, rtol=1e-11, atol=1e-13, method="DOP853"
    )
    return float(np.sqrt(0.8 * found.y[0, -1] ** 2.5))


@lru_cache(maxsize=256)
def exact_jankowski_xi(epsilon: float) -> float:
    """The ξ with which Jankowski's law returns the restitution ε."""
    if epsilon == 1.0:
        return 0.0
    upper = 1.0
    while jankowski(upper) > epsilon:
        upper *= 2.0
    return float(scipy.optimize.brentq(lambda xi: jankowski(xi) - epsilon, 0.0, upper, xtol=1e-10))
