"""Time integration of a structure in modal form and the interface of its devices.

The average acceleration rule with the step h,

    v₁ = v* + h/2 a₁,    v* = v₀ + h/2 a₀,
    u₁ = u* + h²/4 a₁,   u* = u₀ + h v₀ + h²/4 a₀,                                          (1)

and equilibrium at its end give, with D = 1 + h/2 c + h²/4 λ for the modes and
S = M_d + h/2 C_d + h²/4 K_d for the interface y = (a, ζ),

    D z̈ = s + Φᵀ F,              s = b p - c v* - λ z*                                      (2)
    S ÿ = f - (F, 0),            f = -M_d (R, 0) g̈ - C_d v* - K_d y*                        (3)

The anchors' part of y is Φ z. With the compliance Y = Φ D⁻¹ Φᵀ of the structure there, (2) gives
their acceleration Φ D⁻¹ s + Y F. F is in the first rows of (3): what remains to be solved,

    [1 + Y S_aa   Y S_aζ]     [Φ D⁻¹ s + Y f_a]
    [S_ζa         S_ζζ  ] ÿ = [f_ζ            ]                                             (4)

is as small as the interface, with one inverse for all steps. Never is a matrix of all modes made: a
step takes two products with Φ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
import numpy.typing as npt

from impactfem.device.interface import Interface
from impactfem.dynamics.energy import Energy

Array = npt.NDArray[np.float64]

# Fused multiply-add, and sums in any order; NaN and infinity keep their meaning.
_SUMS = {"contract", "reassoc"}


@dataclass(frozen=True, eq=False)
class March:
    """The interface at the samples of the loads.

    Args:
        displacement: y = (a, ζ) relative to the ground, shape (N, n_t).
        velocity: ẏ, same shape.
        acceleration: ÿ, same shape.
        force: F on the floor at all anchors, shape (N_a, n_t) [N, N m].
        energy: Of structure and devices.
    """

    displacement: Array
    velocity: Array
    acceleration: Array
    force: Array
    energy: Energy


def march(
    eigenvalue: Array,
    damping: Array,
    loads: Array,
    interface: Interface,
    ground: Array,
    step: float,
    substeps: int,
) -> March:
    """Integrate from rest.

    Args:
        eigenvalue: λ, shape (r,) [1/s2].
        damping: c = α + β λ, shape (r,) [1/s].
        loads: b p, shape (n_t, r).
        interface: The devices.
        ground: g̈, shape (n_t, 3) [m/s2].
        step: h, of the integration [s].
        substeps: Steps between two samples.
    """
    Φ, M, C, K = interface.shapes, interface.M, interface.C, interface.K
    push = np.ascontiguousarray(-M @ interface.R)
    D = 1.0 + 0.5 * step * damping + 0.25 * step**2 * eigenvalue
    S = M + 0.5 * step * C + 0.25 * step**2 * K
    compliant = Φ / D
    free, loaded = _small_inverse(S, compliant @ Φ.T)
    # At rest there are only the loads at the first sample, and h = 0 in (2) to (4).
    free_0, loaded_0 = _small_inverse(M, Φ @ Φ.T)
    f_0 = push @ ground[0]
    start = free_0 @ (Φ @ loads[0]) + loaded_0 @ f_0
    F = (f_0 - M @ start)[: len(Φ)]
    history, energy = _march(
        loads,
        np.ascontiguousarray(ground),
        step,
        substeps,
        eigenvalue,
        damping,
        np.asarray(1.0 / D, dtype=np.float64),
        compliant,
        M,
        C,
        K,
        S,
        push,
        free,
        loaded,
        loads[0] + F @ Φ,
        start,
        F,
    )
    n = len(M)
    y, v, a, force = np.split(history.T, [n, 2 * n, 3 * n])
    return March(y, v, a, force, Energy(*energy.T))


def _small_inverse(S: Array, compliance: Array) -> tuple[Array, Array]:
    """What takes Φ D⁻¹ s, and what takes f, to ÿ of (4); shapes (N, N_a) and (N, N)."""
    n = len(compliance)
    small = S.copy()
    small[:n] = compliance @ S[:n]
    small[:n, :n] += np.eye(n)
    inverse: Array = np.asarray(np.linalg.inv(small), dtype=np.float64)
    free = np.ascontiguousarray(inverse[:, :n])
    loaded = inverse.copy()
    loaded[:, :n] = free @ compliance
    return free, loaded


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def _march(
    loads: Array,
    ground: Array,
    step: float,
    substeps: int,
    eigenvalue: Array,
    damping: Array,
    inverse: Array,
    compliant: Array,
    M: Array,
    C: Array,
    K: Array,
    S: Array,
    push: Array,
    free: Array,
    loaded: Array,
    modal_start: Array,
    start: Array,
    force_start: Array,
) -> tuple[Array, Array]:
    samples, r = loads.shape
    anchored, size = len(compliant), len(M)
    # The structure: z, ż and z̈ at one end of a step, s and then z̈ at the other. The interface
    # likewise: y, ẏ, ÿ and ÿ at the other end.
    z, v, a, s = np.zeros(r), np.zeros(r), modal_start.copy(), np.empty(r)
    y, w, b, e = np.zeros(size), np.zeros(size), start.copy(), np.empty(size)
    f, before, pushed = np.empty(size), np.empty(size), np.empty(size)
    F, reached, g = force_start.copy(), np.empty(anchored), np.empty(3)
    _product(push, ground[0], before)
    history, energy = np.zeros((samples, 3 * size + anchored)), np.zeros((samples, 4))
    _put(history[0], y, w, b, F)
    damped, put_in = 0.0, 0.0
    for n in range(1, samples):
        p0, p1 = loads[n - 1], loads[n]
        for j in range(substeps):
            at = (j + 1) / substeps
            _predict(step, z, v, a)
            _predict(step, y, w, b)
            for i in range(r):
                s[i] = p0[i] + at * (p1[i] - p0[i]) - damping[i] * v[i] - eigenvalue[i] * z[i]
            _product(compliant, s, reached)
            for k in range(3):
                g[k] = ground[n - 1, k] + at * (ground[n, k] - ground[n - 1, k])
            _product(push, g, pushed)
            for k in range(size):
                f[k] = pushed[k] - _dot(C[k], w) - _dot(K[k], y)
            for k in range(size):
                e[k] = _dot(free[k], reached) + _dot(loaded[k], f)
            for i in range(r):
                s[i] *= inverse[i]
            for k in range(anchored):
                F[k] = f[k] - _dot(S[k], e)
                row = compliant[k]
                for i in range(r):
                    s[i] += F[k] * row[i]
            # Of both ends' loads and velocities, the sums.
            twice = (2 * j + 1) / substeps
            lost, gained = 0.0, 0.0
            for i in range(r):
                sum_v = 2.0 * v[i] + 0.5 * step * (s[i] - a[i])
                lost += damping[i] * sum_v * sum_v
                gained += sum_v * (2.0 * p0[i] + twice * (p1[i] - p0[i]))
            for k in range(size):
                f[k] = 2.0 * w[k] + 0.5 * step * (e[k] - b[k])
                gained += f[k] * (before[k] + pushed[k])
                before[k] = pushed[k]
            damped += 0.25 * step * (lost + _form(C, f))
            put_in += 0.25 * step * gained
            _correct(step, z, v, a, s)
            _correct(step, y, w, b, e)
        _put(history[n], y, w, b, F)
        kinetic, elastic = _dot(v, v) + _form(M, w), _form(K, y)
        for i in range(r):
            elastic += eigenvalue[i] * z[i] * z[i]
        energy[n, 0], energy[n, 1] = 0.5 * kinetic, 0.5 * elastic
        energy[n, 2], energy[n, 3] = damped, put_in
    return history, energy


@numba.njit(nogil=True, cache=True)
def _put(row: Array, y: Array, w: Array, b: Array, F: Array) -> None:
    """Fill a row with four vectors one after the other."""
    size = y.size
    for k in range(size):
        row[k], row[size + k], row[2 * size + k] = y[k], w[k], b[k]
    for k in range(F.size):
        row[3 * size + k] = F[k]


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def _predict(step: float, u: Array, v: Array, a: Array) -> None:
    """From u₀ and v₀ to u* and v* of (1)."""
    for i in range(u.size):
        u[i] += step * v[i] + 0.25 * step * step * a[i]
        v[i] += 0.5 * step * a[i]


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def _correct(step: float, u: Array, v: Array, a: Array, new: Array) -> None:
    """From u* and v* to u₁ and v₁; a becomes a₁."""
    for i in range(u.size):
        u[i] += 0.25 * step * step * new[i]
        v[i] += 0.5 * step * new[i]
        a[i] = new[i]


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def _dot(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def _product(A: Array, x: Array, out: Array) -> None:
    for k in range(out.size):
        out[k] = _dot(A[k], x)


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def _form(A: Array, x: Array) -> float:
    """The quadratic form xᵀ A x."""
    total = 0.0
    for k in range(x.size):
        total += x[k] * _dot(A[k], x)
    return total
