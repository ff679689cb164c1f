"""The implicit time loop on bodies and links, for smooth laws: average acceleration, by numba.

The average acceleration rule (Newmark, β = 1/4, γ = 1/2) with the step Δt = 2 h,

    v₁ = v* + h a₁,    v* = v₀ + h a₀,
    u₁ = u* + h² a₁,   u* = u₀ + 2 h v₀ + h² a₀,                                            (1)

and equilibrium at its end give

    M̂ a₁ = f₁ + Γᵀ F₁ - C v* - K u*,    M̂ = M + h C + h² K.                                 (2)

With the gap function δ = g + Γ u (negative in contact) and W = h Γ M̂⁻¹ Γᵀ, the new forces F₁ change
δ by h W F₁ and δ̇ by W F₁: what remains to be solved in a step is as small as the number of links.
With w = v₀ + v₁ the scheme satisfies, step by step and exactly,

    Δ(½ vᵀ M v) + Δ(½ uᵀ K u) + h/2 wᵀ C w = ½ Δuᵀ (f₀ + f₁) + ½ (Δδ − Δg)ᵀ (F₀ + F₁).        (3)

The gap at rest g moves where the ground is not the same under both ends; what it works is input.

The loop is plain numpy code: `march` is it compiled by numba, `march.py_func` the code itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from impactfem.coupling.contact import KELVIN_VOIGT_NO_TENSION, N_PARAMETERS, law_force
from impactfem.coupling.links import Assembly, Inverse
from impactfem.dynamics.energy import Energy
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError

MAX_SWEEPS = 200
FREE_SWEEPS = 20
MAX_NEWTON = 200
ROUNDING = 1e-12
"""Part of the terms of a gap at the start that is none."""
# Fused multiply-add, and sums in any order; nan and infinity keep their meaning.
_SUMS = {"contract", "reassoc"}


@dataclass(frozen=True, eq=False)
class Motion:
    """What bodies and links did, at the samples of the loads, relative to the ground."""

    moving: Index  #: indices of the coordinates that are recorded and move at all
    u: Array  #: these coordinates, shape (n_t, moving)
    v: Array  #: their velocities, same shape
    force: Array  #: F of the links, positive in compression, shape (n_t, m) [N]
    displacement: Array  #: y of what is attached, shape (n_t, N)
    velocity: Array  #: ẏ, same shape
    acceleration: Array  #: ÿ, same shape
    reaction: Array  #: T on the bodies at the rows of what is attached, shape (n_t, N_a)
    energy: Energy  #: equation (3), summed up


def respond(
    assembly: Assembly,
    loads: Array,
    ground: Array,
    time_step: float,
    *,
    substeps: int = 1,
    lagged: bool = False,
    u0: Array | None = None,
    v0: Array | None = None,
    recorded: Index | None = None,
    opened: Array | None = None,
) -> Motion:
    """Integrate bodies and links.

    Args:
        assembly: Bodies and links, each link with a law.
        loads: Forces on the coordinates, those of the ground motion included, shape (n_t, r);
            straight between their samples.
        ground: Acceleration of the ground, for what is attached, shape (n_t, 3) [m/s2].
        time_step: Between two samples [s].
        substeps: Steps of the integration in one of them.
        lagged: Take the force of a link from the state before the step (paper, equation 2 as
            printed) instead of the new state.
        u0: Coordinates at the start, shape (r,); zero when None.
        v0: Their velocities, likewise.
        recorded: Indices of the coordinates that are recorded with their velocities; all when None.
        opened: How far the ground opens the gaps of the links, and how fast, shape (2, n_t, m) [m,
            m/s]; None where it moves alike.

    Raises:
        SolutionError: A link is closed at the start, or the forces of the links do not converge.
    """
    n_t, r = loads.shape
    one, m = assembly.attached, len(assembly.links)
    u = np.zeros(r) if u0 is None else np.array(u0, dtype=np.float64)
    v = np.zeros(r) if v0 is None else np.array(v0, dtype=np.float64)
    # One row where they do not move.
    moved = np.zeros((2, 1, m)) if opened is None else opened
    gaps, opening = assembly.gaps + moved[0], np.ascontiguousarray(moved[1])
    size = np.abs(gaps[0]) + np.abs(assembly.gamma) @ np.abs(u)
    closed = np.flatnonzero(gaps[0] + assembly.gamma @ u < -ROUNDING * size)
    if closed.size:
        raise SolutionError(f"pair {assembly.links[closed[0]].name} penetrates at the start")
    laws = [link.law for link in assembly.links if link.law is not None]
    if len(laws) < m:
        raise SolutionError("a unilateral constraint needs the time loop of `unilateral`")
    h = time_step / substeps / 2.0
    inverse = Inverse(assembly, h)
    N = len(one.M)
    pushes = np.ascontiguousarray(ground @ one.push.T)
    # Responses of all coordinates to unit forces of the links.
    X, X_y, X_T = inverse.solve(assembly.gamma, np.zeros((m, N)))
    # At rest or not, the accelerations at the start are in equilibrium: M a = f - C v - K u.
    y, y_v = np.zeros((2, N))
    y[: len(one.rows)], y_v[: len(one.rows)] = one.rows @ u, one.rows @ v
    f_z = loads[0] - assembly.damping * v - assembly.eigenvalue * u
    f_y = pushes[0] - one.C @ y_v - one.K @ y
    a, y_a, T = Inverse(assembly, 0.0).solve(f_z, f_y)
    # Coordinates that nothing moves stay out of the loop.
    moving = np.flatnonzero(
        loads.any(axis=0) | (u != 0.0) | (v != 0.0) | X.any(axis=0) | inverse.rows.any(axis=0)
    )
    kept = np.arange(moving.size)
    if recorded is not None:
        kept = np.flatnonzero(np.isin(moving, recorded))
    us, vs = (np.zeros((n_t, kept.size)) for _ in range(2))
    force, history = np.zeros((n_t, m)), np.zeros((n_t, 3 * N + len(one.rows)))
    energy = np.zeros((n_t, 5))
    picked = [
        np.ascontiguousarray(values if moving.size == r else values[..., moving])
        for values in (
            *(assembly.mass, assembly.damping, assembly.eigenvalue, inverse.diagonal, loads),
            *(u, v, a, inverse.rows, assembly.gamma, X),
        )
    ]
    loop: Any = march
    done = loop(
        *(h, substeps, lagged),
        tuple(picked[:4]),
        picked[4],
        tuple(picked[5:8]),
        pushes,
        (one.M, one.C, one.K, inverse.S, inverse.free, inverse.loaded, picked[8]),
        (y, y_v, y_a, T.copy()),
        np.searchsorted(moving, [0, *(here.stop for here in assembly.columns.values())]),
        (*picked[9:], *map(np.ascontiguousarray, (X_y, X_T)), h * assembly.gamma @ X.T),
        (gaps, opening),
        np.array([law.code for law in laws], dtype=np.int64),
        np.array([law.parameters for law in laws]).reshape(m, N_PARAMETERS),
        (us, vs, force, history, energy),
        kept,
    )
    if done < n_t:
        raise SolutionError(
            f"contact forces did not converge at t = {done * time_step:.6g} s; "
            "a smaller pounding.time_step or a softer contact law would help"
        )
    y, y_v, y_a, T = np.split(history, [N, 2 * N, 3 * N], axis=1)
    return Motion(moving[kept], us, vs, force, y, y_v, y_a, T, Energy(*energy.T))


@numba.njit(cache=True)
def pair_force(
    code: int, parameters: Array, p_free: float, v_free: float, v0: float, h: float, W: float
) -> tuple[float, float]:
    """Force of one pair at the new time, given the motion that it would have without it.

    Solves F = law(p, v) with p = p_free - h W F and v = v_free - W F by Newton's method (one
    iteration for a linear law), halving the bracket where a step leaves it. The pair is taken to
    touch: a law that jumps at p = 0 has no solution when its own force would open the gap within
    the step; its force at p = 0 counts then.

    p_free and v_free are penetration and rate without this force, v0 the speed of approach with
    which the contact began, W the velocity of the pair per force. Returns the force, nan if the
    iteration does not converge; and the size of the terms that add up to it, of which it can be a
    small difference.
    """
    tiny = 1e-300
    f, k, c = law_force(code, parameters, max(p_free, tiny), v_free, v0)
    # The law falls with F, so the root of F - law lies between zero and the force at F = 0.
    low, high = min(0.0, f), max(0.0, f)
    F = 0.0
    outside = False
    size = abs(f) + k * abs(p_free) + c * abs(v_free)
    for _ in range(MAX_NEWTON):
        if f > F:
            low = F
        else:
            high = F
        step = F + (f - F) / (1.0 + W * (h * k + c))
        if outside or not low <= step <= high:
            step = 0.5 * (low + high)
        change = abs(step - F)
        F = step
        if change <= 1e-13 * size:
            return F, size
        p = p_free - h * W * F
        f, k, c = law_force(code, parameters, max(p, tiny), v_free - W * F, v0)
        outside = p < tiny and code > KELVIN_VOIGT_NO_TENSION
        if p < tiny:
            k = 0.0
    return np.nan, 0.0


@numba.njit(cache=True)
def contact_forces(
    h: float,
    W: Array,
    delta: Array,
    rate: Array,
    codes: Index,
    parameters: Array,
    onset: Array,
    touches: NDArray[np.bool_],
    F: Array,
) -> bool:
    """Forces of all pairs at the new time, swept until they agree.

    Block Gauss-Seidel on δ = δ_free + h W F, δ̇ = δ̇_free + W F and the laws. Whether a pair touches
    is decided by its penetration without its own force. Two pairs whose forces open each other's
    gap could flip for ever where the law jumps at p = 0: after FREE_SWEEPS sweeps who touches is
    kept.

    W, shape (m, m), is symmetric and positive semidefinite; delta and rate are the gap functions
    without the new forces; onset is the state of the links, the speed of approach with which the
    contact began; touches is memory. Fills F; returns whether the forces agree.
    """
    m = delta.size
    for sweep in range(MAX_SWEEPS):
        largest = 0.0
        change = 0.0
        for j in range(m):
            other = 0.0
            for k in range(m):
                if k != j:
                    other += W[j, k] * F[k]
            p_free = -delta[j] - h * other
            if sweep < FREE_SWEEPS:
                touches[j] = p_free > 0.0
            force, size = 0.0, 0.0
            if touches[j]:
                force, size = pair_force(
                    codes[j], parameters[j], p_free, -rate[j] - other, onset[j], h, W[j, j]
                )
            if np.isnan(force):
                return False
            change = max(change, abs(force - F[j]))
            largest = max(largest, size)
            F[j] = force
        if change <= 1e-13 * largest:
            return True
    return change <= 1e-10 * largest


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def march(
    h: float,
    substeps: int,
    lagged: bool,
    diagonals: tuple[Array, ...],
    loads: Array,
    state: tuple[Array, ...],
    pushes: Array,
    attached: tuple[Array, ...],
    attached_state: tuple[Array, ...],
    ends: Index,
    links: tuple[Array, ...],
    gaps: tuple[Array, Array],
    codes: Index,
    parameters: Array,
    records: tuple[Array, ...],
    kept: Index,
) -> int:
    """Step through time by equations (1) and (2); fill the records.

    The arguments are those of `respond`, `Assembly` and `Inverse`. The states are those at the
    start, which move on; X, X_y and X_T are the responses of a, ÿ and T to unit forces of the
    links. Returns the number of times done: n_t, or less where the forces of the links did not
    converge.
    """
    _, damping, eigenvalue, inverse = diagonals
    u, v, a = state
    _, C, K, S, free, loaded, rows = attached
    y, y_v, y_a, T = attached_state
    gamma, X, X_y, X_T, W = links
    energy = records[4]
    rest, opening = gaps
    last = rest.shape[0] - 1
    n_t, r = loads.shape
    m, N, fixed = rest.shape[1], y.size, rows.shape[0]
    b, new_a = np.empty(r), np.empty(r)
    b_y, new_y, reach, pushed = np.empty(N), np.empty(N), np.empty(fixed), np.empty(N)
    delta, rate, gap = np.empty(m), np.empty(m), rest[0].copy()
    F, new, onset = np.zeros(m), np.zeros(m), np.zeros(m)
    touches = np.zeros(m, dtype=np.bool_)
    for k in range(m):
        # Rounding of a gap that is just closed is no penetration, and would hide the approach.
        gap[k] = max(gap[k] + _motion(gamma[k], u, ends), 0.0)
        rate[k] = opening[0, k] + _motion(gamma[k], v, ends)
    damped, put_in, worked = 0.0, 0.0, 0.0
    _record(0, diagonals, state, attached, attached_state, F, records, kept)
    for t in range(1, n_t):
        p0, p1, q0, q1 = loads[t - 1], loads[t], pushes[t - 1], pushes[t]
        g0, g1 = rest[min(t - 1, last)], rest[min(t, last)]
        w0, w1 = opening[min(t - 1, last)], opening[min(t, last)]
        for j in range(substeps):
            at, twice = (j + 1) / substeps, (2 * j + 1) / substeps
            # How fast each contact began, and lagged forces, from the state before the step.
            touching = False
            for k in range(m):
                if gap[k] >= 0.0:
                    onset[k] = max(-rate[k], 0.0)
                new[k] = 0.0
                if lagged:
                    new[k] = law_force(codes[k], parameters[k], -gap[k], -rate[k], onset[k])[0]
                    touching = touching or new[k] != 0.0
            # u* and v* of (1), and a₁ without the forces of the links.
            _predict(h, u, v, a)
            for i in range(r):
                b[i] = p0[i] + at * (p1[i] - p0[i]) - damping[i] * v[i] - eigenvalue[i] * u[i]
                new_a[i] = inverse[i] * b[i]
            if N > 0:
                _predict(h, y, y_v, y_a)
                for k in range(N):
                    pushed[k] = q0[k] + at * (q1[k] - q0[k])
                    b_y[k] = pushed[k] - _dot(C[k], y_v) - _dot(K[k], y)
                for k in range(fixed):
                    reach[k] = _dot(rows[k], b)
                for k in range(N):
                    new_y[k] = _dot(free[k], reach) + _dot(loaded[k], b_y)
                for k in range(fixed):
                    T[k] = b_y[k] - _dot(S[k], new_y)
                    _add(new_a, T[k], rows[k])
            # Gaps without the new forces.
            for k in range(m):
                change = _motion(gamma[k], new_a, ends)
                g = g0[k] + at * (g1[k] - g0[k])
                delta[k] = g + _motion(gamma[k], u, ends) + h * h * change
                opens = w0[k] + at * (w1[k] - w0[k])
                rate[k] = opens + _motion(gamma[k], v, ends) + h * change
                touching = touching or (not lagged and delta[k] < 0.0)
            agreed = True
            if touching and not lagged:
                agreed = contact_forces(h, W, delta, rate, codes, parameters, onset, touches, new)
            if not agreed:
                return t
            if touching:
                for k in range(m):
                    if new[k] != 0.0:
                        _add(new_a, new[k], X[k])
                        for i in range(N):
                            new_y[i] += new[k] * X_y[k, i]
                        for i in range(fixed):
                            T[i] += new[k] * X_T[k, i]
                        for i in range(m):
                            delta[i] += h * W[i, k] * new[k]
                            rate[i] += W[i, k] * new[k]
            # Equation (3), with w = 2 v* + h (a₁ - a₀), and the state at the end of the step.
            lost, gained = 0.0, 0.0
            for i in range(r):
                w = 2.0 * v[i] + h * (new_a[i] - a[i])
                lost += damping[i] * w * w
                gained += w * (2.0 * p0[i] + twice * (p1[i] - p0[i]))
            for k in range(N):
                b_y[k] = 2.0 * y_v[k] + h * (new_y[k] - y_a[k])
                gained += b_y[k] * (2.0 * q0[k] + twice * (q1[k] - q0[k]))
            for k in range(N):
                lost += b_y[k] * _dot(C[k], b_y)
            damped += 0.5 * h * lost
            put_in += 0.5 * h * gained
            for k in range(m):
                put_in -= 0.5 * (g1[k] - g0[k]) / substeps * (F[k] + new[k])
                worked += 0.5 * (delta[k] - gap[k]) * (F[k] + new[k])
                gap[k], F[k] = delta[k], new[k]
            _correct(h, u, v, a, new_a)
            _correct(h, y, y_v, y_a, new_y)
        energy[t, 2], energy[t, 3], energy[t, 4] = damped, put_in, worked
        _record(t, diagonals, state, attached, attached_state, F, records, kept)
    return n_t


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def _record(
    t: int,
    diagonals: tuple[Array, ...],
    state: tuple[Array, ...],
    attached: tuple[Array, ...],
    attached_state: tuple[Array, ...],
    F: Array,
    records: tuple[Array, ...],
    kept: Index,
) -> None:
    """Fill a row of the records, kinetic and elastic energy among them."""
    mass, _, eigenvalue, _ = diagonals
    u, v, _ = state
    M, _, K, _, _, _, _ = attached
    y, y_v, y_a, T = attached_state
    us, vs, force, history, energy = records
    N = y.size
    kinetic, elastic = 0.0, 0.0
    for i in range(u.size):
        kinetic += mass[i] * v[i] * v[i]
        elastic += eigenvalue[i] * u[i] * u[i]
    for k in range(N):
        kinetic += y_v[k] * _dot(M[k], y_v)
        elastic += y[k] * _dot(K[k], y)
        history[t, k], history[t, N + k], history[t, 2 * N + k] = y[k], y_v[k], y_a[k]
    for k in range(T.size):
        history[t, 3 * N + k] = T[k]
    energy[t, 0], energy[t, 1] = 0.5 * kinetic, 0.5 * elastic
    for k in range(F.size):
        force[t, k] = F[k]
    for i in range(kept.size):
        us[t, i], vs[t, i] = u[kept[i]], v[kept[i]]


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def _dot(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def _add(x: Array, factor: float, row: Array) -> None:
    """Add factor times row to x."""
    for i in range(x.size):
        x[i] += factor * row[i]


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def _motion(row: Array, x: Array, ends: Index) -> float:
    """Product row · x, body by body: equal motions of two bodies alike cancel to the last bit."""
    total = 0.0
    for body in range(ends.size - 1):
        total += _dot(row[ends[body] : ends[body + 1]], x[ends[body] : ends[body + 1]])
    return total


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def _predict(h: float, u: Array, v: Array, a: Array) -> None:
    """From u₀ and v₀ to u* and v* of (1)."""
    for i in range(u.size):
        u[i] += 2.0 * h * v[i] + h * h * a[i]
        v[i] += h * a[i]


@numba.njit(nogil=True, cache=True, fastmath=_SUMS)
def _correct(h: float, u: Array, v: Array, a: Array, new: Array) -> None:
    """From u* and v* to u₁ and v₁ of (1); a becomes a₁."""
    for i in range(u.size):
        u[i] += h * h * new[i]
        v[i] += h * new[i]
        a[i] = new[i]
