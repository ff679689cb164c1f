"""Modal equations integrated in time: exactly for piecewise-linear loads, or by Newmark.

z̈ + c ż + λ z = b p(t) with c by the law of damping (α + β λ, if it is Rayleigh's), and p straight
between its samples. One step is linear in the state and in the load's samples at both ends,

    (z, ż)₁ = D (z, ż)₀ + G₀ b p₀ + G₁ b p₁,

with 2 × 2 matrices D and 2-vectors G for each mode. Exact: D = exp(B Δt), B = [0, 1; −λ, −c], in
closed form, whose load terms are the response h to a unit impulse integrated once and twice. No
mode is too stiff or too damped for it. Newmark: average acceleration, for the comparison with the
full model at the same step. Both are in equilibrium at each sample, which gives z̈.
"""

from dataclasses import dataclass
from typing import Any

import numba
import numpy as np

from impactfem.dynamics.damping import DampingLaw
from impactfem.reduction.reduced import ReducedModel
from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError


@dataclass(frozen=True, eq=False)
class ModalHistory:
    """Modal coordinates at the samples of the load."""

    displacement: Array  #: z, shape (r, n_steps + 1).
    velocity: Array  #: ż, same shape.
    acceleration: Array  #: z̈, same shape.


def modal_response(
    model: ReducedModel,
    amplitudes: Array,
    time_step: float,
    damping: DampingLaw,
    *,
    scheme: str = "exact",
) -> ModalHistory:
    """Integrate the modal equations from rest by a scheme of STEPS: "exact" or "newmark".

    By samples of the load of each pattern, shape (n_steps + 1, n_patterns), Δt [s] apart.

    Raises:
        SolutionError: An unknown scheme, a step that is not positive.
    """
    if scheme not in STEPS:
        raise SolutionError(f"the scheme {scheme}: there are {', '.join(STEPS)}")
    if not time_step > 0.0:
        raise SolutionError(f"a time step of {time_step} s: it must be positive")
    d = damping.modal(model.eigenvalue)
    D, G = STEPS[scheme](model.eigenvalue, d, time_step)
    loads = np.ascontiguousarray(model.load @ amplitudes.T)
    z, v = _march(D, G, loads)
    a = loads - d[:, None] * v - model.eigenvalue[:, None] * z
    return ModalHistory(z, v, a)


@numba.njit(cache=True)
def _exact_step(eigenvalue: Array, damping: Array, dt: float) -> tuple[Array, Array]:
    """D, shape (r, 2, 2), and G, shape (r, 2, 2) with columns G₀ and G₁."""
    # By the step Δt = 1 with λ Δt² and c Δt: the diagonal of D, the response h to a unit impulse,
    # and its first two integrals h2 and h3.
    r = eigenvalue.size
    D, G = np.empty((r, 2, 2)), np.empty((r, 2, 2))
    for i in range(r):
        λ, c = eigenvalue[i] * dt**2, damping[i] * dt
        μ = 0.5 * c
        δ = μ * μ - λ
        if abs(λ) <= 1.0 and c <= 1.0:
            # h is the sum of g_j t^(j+1)/(j+1)! with g_j = −c g_{j−1} − λ g_{j−2}.
            e11 = h = h2 = h3 = 0.0
            g, before, factorial = 1.0, 0.0, 1.0
            for j in range(25):
                e11 += g / factorial
                factorial *= j + 1
                h += g / factorial
                h2 += g / (factorial * (j + 2))
                h3 += g / (factorial * (j + 2) * (j + 3))
                g, before = -c * g - λ * before, g
            e00 = e11 + c * h
        elif δ < 0.0:
            ω = np.sqrt(-δ)
            h = np.exp(-μ) * np.sin(ω) / ω
            e11 = np.exp(-μ) * np.cos(ω) - μ * h
            e00 = e11 + c * h
            # From ḧ + c ḣ + λ h = 0, integrated once and twice.
            h2 = (1.0 - e11 - c * h) / λ
            h3 = (1.0 - h - c * h2) / λ
        else:
            # Decays b ≥ a, with ḣ + a h = exp(−b t); of the integrals, each follows from the one
            # before and from those of exp(−a t), φ1 and φ2.
            η = np.sqrt(δ)
            b = μ + η
            a = λ / b
            rise = -np.expm1(-2.0 * η) / (2.0 * η) if η > 0.0 else 1.0
            h = np.exp(-a) * rise
            e11 = np.exp(-b) - a * h
            e00 = np.exp(-b) + b * h
            if abs(a) > 0.5:
                φ1 = -np.expm1(-a) / a
                φ2 = (1.0 - φ1) / a
            else:
                φ2, term = 0.0, 0.5
                for j in range(18):
                    φ2 += term
                    term *= -a / (j + 3)
                φ1 = 1.0 - a * φ2
            h2 = (φ1 - h) / b
            h3 = (φ2 - h2) / b
        D[i, 0, 0], D[i, 0, 1] = e00, dt * h
        D[i, 1, 0], D[i, 1, 1] = -dt * eigenvalue[i] * h, e11
        # A load that falls from 1 to 0, and one that rises from 0 to 1.
        G[i, 0, 0], G[i, 1, 0] = dt**2 * (h2 - h3), dt * (h - h2)
        G[i, 0, 1], G[i, 1, 1] = dt**2 * h3, dt * h2
    return D, G


def _newmark_step(eigenvalue: Array, damping: Array, dt: float) -> tuple[Array, Array]:
    """As `_exact_step`, for v₁ = v₀ + Δt/2 (a₀ + a₁), z₁ = z₀ + Δt/2 (v₀ + v₁)."""
    half = 0.5 * dt
    # (1 + c Δt/2 + λ Δt²/4) v₁ = v₀ + Δt/2 (p₀ + p₁ − c v₀ − 2 λ z₀ − λ Δt/2 v₀)
    pivot = 1.0 + half * damping + half**2 * eigenvalue
    D = np.empty((len(eigenvalue), 2, 2))
    D[:, 1, 0] = -dt * eigenvalue / pivot
    D[:, 1, 1] = (1.0 - half * damping - half**2 * eigenvalue) / pivot
    D[:, 0, 0] = 1.0 + half * D[:, 1, 0]
    D[:, 0, 1] = dt / pivot  # Δt/2 (1 + D₁₁)
    G = np.empty((len(eigenvalue), 2, 2))
    G[:, 1, :] = (half / pivot)[:, None]
    G[:, 0, :] = half * G[:, 1, :]
    return D, G


@numba.njit(cache=True)
def _march(D: Array, G: Array, loads: Array) -> tuple[Array, Array]:
    r, samples = loads.shape
    z, v = np.empty((r, samples)), np.empty((r, samples))
    for i in range(r):
        d00, d01, d10, d11 = D[i, 0, 0], D[i, 0, 1], D[i, 1, 0], D[i, 1, 1]
        g00, g01, g10, g11 = G[i, 0, 0], G[i, 0, 1], G[i, 1, 0], G[i, 1, 1]
        x = y = z[i, 0] = v[i, 0] = 0.0
        for n in range(samples - 1):
            p0, p1 = loads[i, n], loads[i, n + 1]
            x, y = (
                d00 * x + d01 * y + g00 * p0 + g01 * p1,
                d10 * x + d11 * y + g10 * p0 + g11 * p1,
            )
            z[i, n + 1], v[i, n + 1] = x, y
    return z, v


STEPS: dict[str, Any] = {"exact": _exact_step, "newmark": _newmark_step}
"""By scheme, what gives D and G of each mode."""
