"""Modal equations integrated in time: exactly for piecewise-linear loads, or by Newmark.

z̈ + c ż + λ z = b p(t) with c = α + β λ, and p straight between its samples. One step is linear in
the state and in the load's samples at both ends,

    (z, ż)₁ = D (z, ż)₀ + G₀ b p₀ + G₁ b p₁,

with 2 × 2 matrices D and 2-vectors G for each mode. Exact: D = exp(B Δt), B = [0, 1; −λ, −c], in
closed form, whose load terms are the response h to a unit impulse integrated once and twice. No
mode is too stiff or too damped for it. Newmark: average acceleration, for the comparison with the
full model at the same step. Both are in equilibrium at each sample, which gives z̈.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.reduced import ReducedModel
from impactfem.system.errors import SolutionError

Array = NDArray[np.float64]


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
    damping: Rayleigh,
    *,
    scheme: str = "exact",
    start: Array | None = None,
) -> ModalHistory:
    """Integrate the modal equations by a scheme of STEPS: "exact" or "newmark".

    Args:
        model: The reduced model.
        amplitudes: Samples of the load of each pattern, shape (n_steps + 1, n_patterns).
        time_step: Δt [s].
        damping: The damping.
        scheme: The scheme.
        start: Modal displacements at rest at the first sample, shape (r,); zero when None.

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
    z0 = np.zeros(len(model.eigenvalue)) if start is None else np.asarray(start, dtype=np.float64)
    z, v = _march(D, G, loads, z0)
    a = loads - d[:, None] * v - model.eigenvalue[:, None] * z
    return ModalHistory(z, v, a)


def _exact_step(eigenvalue: Array, damping: Array, dt: float) -> tuple[Array, Array]:
    """D, shape (r, 2, 2), and G, shape (r, 2, 2) with columns G₀ and G₁."""
    e00, e11, h, h2, h3 = _unit_step(eigenvalue * dt**2, damping * dt)
    D, G = np.empty((len(h), 2, 2)), np.empty((len(h), 2, 2))
    D[:, 0, 0], D[:, 0, 1] = e00, dt * h
    D[:, 1, 0], D[:, 1, 1] = -dt * eigenvalue * h, e11
    # A load that rises from 0 to 1, and one that falls from 1 to 0.
    G[:, 0, 1], G[:, 1, 1] = dt**2 * h3, dt * h2
    G[:, 0, 0], G[:, 1, 0] = dt**2 * (h2 - h3), dt * (h - h2)
    return D, G


@numba.njit(cache=True)
def _unit_step(eigenvalue: Array, damping: Array) -> tuple[Array, Array, Array, Array, Array]:
    """For Δt = 1: diagonal of D, the response h to a unit impulse, and its first two integrals."""
    r = eigenvalue.size
    e00, e11, h, h2, h3 = np.empty(r), np.empty(r), np.empty(r), np.empty(r), np.empty(r)
    for i in range(r):
        λ, c = eigenvalue[i], damping[i]
        μ = 0.5 * c
        δ = μ * μ - λ
        if abs(λ) <= 1.0 and c <= 1.0:
            # h is the sum of g_j t^(j+1)/(j+1)! with g_j = −c g_{j−1} − λ g_{j−2}.
            e11[i] = h[i] = h2[i] = h3[i] = 0.0
            g, before, factorial = 1.0, 0.0, 1.0
            for j in range(25):
                e11[i] += g / factorial
                factorial *= j + 1
                h[i] += g / factorial
                h2[i] += g / (factorial * (j + 2))
                h3[i] += g / (factorial * (j + 2) * (j + 3))
                g, before = -c * g - λ * before, g
            e00[i] = e11[i] + c * h[i]
        elif δ < 0.0:
            ω = np.sqrt(-δ)
            h[i] = np.exp(-μ) * np.sin(ω) / ω
            e11[i] = np.exp(-μ) * np.cos(ω) - μ * h[i]
            e00[i] = e11[i] + c * h[i]
            # From ḧ + c ḣ + λ h = 0, integrated once and twice.
            h2[i] = (1.0 - e11[i] - c * h[i]) / λ
            h3[i] = (1.0 - h[i] - c * h2[i]) / λ
        else:
            # Decays b ≥ a, with ḣ + a h = exp(−b t); of the integrals, each follows from the one
            # before and from those of exp(−a t).
            η = np.sqrt(δ)
            b = μ + η
            a = λ / b
            rise = -np.expm1(-2.0 * η) / (2.0 * η) if η > 0.0 else 1.0
            h[i] = np.exp(-a) * rise
            e11[i] = np.exp(-b) - a * h[i]
            e00[i] = np.exp(-b) + b * h[i]
            φ1, φ2 = _integrals_of_decay(a)
            h2[i] = (φ1 - h[i]) / b
            h3[i] = (φ2 - h2[i]) / b
    return e00, e11, h, h2, h3


@numba.njit(cache=True)
def _integrals_of_decay(a: float) -> tuple[float, float]:
    """First two integrals of exp(−a t) from 0 to 1."""
    if abs(a) > 0.5:
        φ1 = -np.expm1(-a) / a
        return φ1, (1.0 - φ1) / a
    φ2, term = 0.0, 0.5
    for j in range(18):
        φ2 += term
        term *= -a / (j + 3)
    return 1.0 - a * φ2, φ2


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
def _march(D: Array, G: Array, loads: Array, start: Array) -> tuple[Array, Array]:
    r, samples = loads.shape
    z, v = np.empty((r, samples)), np.empty((r, samples))
    for i in range(r):
        d00, d01, d10, d11 = D[i, 0, 0], D[i, 0, 1], D[i, 1, 0], D[i, 1, 1]
        g00, g01, g10, g11 = G[i, 0, 0], G[i, 0, 1], G[i, 1, 0], G[i, 1, 1]
        x, y = start[i], 0.0
        z[i, 0], v[i, 0] = x, y
        for n in range(samples - 1):
            p0, p1 = loads[i, n], loads[i, n + 1]
            x, y = (
                d00 * x + d01 * y + g00 * p0 + g01 * p1,
                d10 * x + d11 * y + g10 * p0 + g11 * p1,
            )
            z[i, n + 1], v[i, n + 1] = x, y
    return z, v


STEPS = {"exact": _exact_step, "newmark": _newmark_step}
"""By scheme, what gives D and G of each mode."""
