"""Modal equations integrated in time: exactly for piecewise-linear loads, or by Newmark.

z̈ + c ż + λ z = b p(t) with c = α + β λ, and p straight between its samples. One step is linear in
the state and in the load's samples at both ends,

    (z, ż)₁ = D (z, ż)₀ + G₀ b p₀ + G₁ b p₁,

with 2 × 2 matrices D and 2-vectors G for each mode. Exact: D = exp(B Δt), B = [0, 1; −λ, −c], and
the integrals of the load by the same exponential (Van Loan 1978). Newmark: average acceleration,
for the comparison with the full model at the same step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from impactfem.dynamics.reduced import ReducedModel

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModalHistory:
    """Modal coordinates at the samples of the load.

    Args:
        displacement: z, shape (r, n_steps + 1).
        velocity: ż, same shape.
        acceleration: z̈, same shape.
    """

    displacement: Array
    velocity: Array
    acceleration: Array


def modal_response(
    model: ReducedModel,
    amplitudes: Array,
    time_step: float,
    alpha: float,
    beta: float,
    *,
    scheme: str = "exact",
    start: Array | None = None,
) -> ModalHistory:
    """Integrate the modal equations.

    Args:
        model: The reduced model.
        amplitudes: Samples of the load of each pattern, shape (n_steps + 1, n_patterns).
        time_step: Δt [s].
        alpha: α [1/s].
        beta: β [s].
        scheme: "exact" or "newmark".
        start: Modal displacements at rest at the first sample, shape (r,); zero when None.
    """
    step = _exact_step if scheme == "exact" else _newmark_step
    damping = alpha + beta * model.eigenvalue
    D, G = step(model.eigenvalue, damping, time_step)
    loads = np.ascontiguousarray(model.load @ amplitudes.T)
    z0 = np.zeros(len(model.eigenvalue)) if start is None else np.asarray(start, dtype=np.float64)
    z, v = _march(D, G, loads, z0)
    if scheme == "exact":
        a = loads - damping[:, None] * v - model.eigenvalue[:, None] * z
    else:
        a = _newmark_acceleration(loads, v, z, damping, model.eigenvalue, time_step)
    return ModalHistory(z, v, a)


def _exact_step(eigenvalue: Array, damping: Array, dt: float) -> tuple[Array, Array]:
    """D, shape (r, 2, 2), and G, shape (r, 2, 2) with columns G₀ and G₁."""
    r = len(eigenvalue)
    # State (z ω, ż) and load (p, ṗ): with the scale ω = √λ the matrix is balanced.
    omega = np.sqrt(np.maximum(eigenvalue, 1e-12 / dt**2))
    augmented = np.zeros((r, 4, 4))
    augmented[:, 0, 1] = omega
    augmented[:, 1, 0] = -eigenvalue / omega
    augmented[:, 1, 1] = -damping
    augmented[:, 1, 2] = 1.0
    augmented[:, 2, 3] = 1.0 / dt
    E = scipy.linalg.expm(augmented * dt)
    back = np.ones((r, 2))
    back[:, 0] = 1.0 / omega
    D = E[:, :2, :2] * back[:, :, None]
    D[:, :, 0] *= omega[:, None]
    slope = E[:, :2, 3] * back  # of the load's rise from 0 to 1 over the step
    whole = E[:, :2, 2] * back  # of the constant load 1
    return D, np.stack([whole - slope, slope], axis=-1)


def _newmark_step(eigenvalue: Array, damping: Array, dt: float) -> tuple[Array, Array]:
    """As `_exact_step`, for v₁ = v₀ + Δt/2 (a₀ + a₁), z₁ = z₀ + Δt/2 (v₀ + v₁)."""
    half = 0.5 * dt
    # (1 + c Δt/2 + λ Δt²/4) v₁ = v₀ + Δt/2 (p₀ + p₁ − c v₀ − 2 λ z₀ − λ Δt/2 v₀)
    pivot = 1.0 + half * damping + half**2 * eigenvalue
    D = np.empty((len(eigenvalue), 2, 2))
    D[:, 1, 0] = -dt * eigenvalue / pivot
    D[:, 1, 1] = (1.0 - half * damping - half**2 * eigenvalue) / pivot
    D[:, 0, 0] = 1.0 + half * D[:, 1, 0]
    D[:, 0, 1] = half * (1.0 + D[:, 1, 1])
    G = np.empty((len(eigenvalue), 2, 2))
    G[:, 1, :] = (half / pivot)[:, None]
    G[:, 0, :] = half * G[:, 1, :]
    return D, G


def _newmark_acceleration(
    loads: Array, v: Array, z: Array, damping: Array, eigenvalue: Array, dt: float
) -> Array:
    """a₁ = 2/Δt (v₁ − v₀) − a₀, from the equilibrium at the first sample."""
    a = np.empty_like(v)
    a[:, 0] = loads[:, 0] - damping * v[:, 0] - eigenvalue * z[:, 0]
    _alternate(a, 2.0 / dt * np.diff(v, axis=1))
    return a


@numba.njit(cache=True)
def _alternate(a: Array, rise: Array) -> None:
    for i in range(a.shape[0]):
        for n in range(rise.shape[1]):
            a[i, n + 1] = rise[i, n] - a[i, n]


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
