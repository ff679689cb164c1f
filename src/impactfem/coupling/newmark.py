"""The time loop of the sticks: average acceleration with contact, compiled by numba.

The loop is plain numpy code; `march` is that code compiled, `march.py_func` the code itself.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from impactfem.coupling.contact import KELVIN_VOIGT_NO_TENSION, law_force

Array = NDArray[np.float64]
MAX_SWEEPS = 200
FREE_SWEEPS = 20
MAX_NEWTON = 200


@numba.njit(cache=True)
def add_product(A: Array, x: Array, y: Array) -> None:
    """Add A x to y, A symmetric: along rows, which vectorises without reordering sums."""
    for j in range(x.size):
        if x[j] != 0.0:
            for i in range(y.size):
                y[i] += A[j, i] * x[j]


@numba.njit(cache=True)
def pair_force(
    code: int, parameters: Array, p_free: float, v_free: float, v0: float, h: float, W: float
) -> tuple[float, float]:
    """Force of one pair at the new time, given the motion that it would have without it.

    Solves F = law(p, v) with p = p_free - h W F and v = v_free - W F by Newton's method (one
    iteration for a linear law), halving the bracket where a step leaves it. The pair is taken to
    touch: a law that jumps at p = 0 has no solution when its own force would open the gap within
    the step; its force at p = 0 counts then.

    Args:
        code: The law, as in `law_force`.
        parameters: Its parameters.
        p_free: Penetration without this force [m].
        v_free: Its rate [m/s].
        v0: Speed of approach with which the contact began [m/s].
        h: Half the time step [s].
        W: Velocity of the pair per force [m/s/N].

    Returns:
        The force [N], nan if the iteration does not converge; and the size of the terms that add
        up to it, of which it can be a small difference [N].
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
    codes: NDArray[np.int64],
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

    Args:
        h: Half the time step [s].
        W: Velocities per force, symmetric, positive semidefinite, shape (m, m) [m/s/N].
        delta: Gap functions without the new forces, shape (m,) [m].
        rate: Their rates, shape (m,) [m/s].
        codes: Contact laws, as in `law_force`, shape (m,).
        parameters: Their parameters, shape (m, N_PARAMETERS).
        onset: Speeds of approach with which the contacts began, shape (m,) [m/s].
        touches: Room for who touches, shape (m,).
        F: Filled with the forces, shape (m,) [N].

    Returns:
        Whether they agree.
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


@numba.njit(cache=True)
def march(
    dt: float,
    K: Array,
    M: Array,
    S_inv: Array,
    patterns: Array,
    histories: Array,
    J: Array,
    SJ: Array,
    gap: Array,
    codes: NDArray[np.int64],
    parameters: Array,
    lagged: bool,
    u: Array,
    v: Array,
    F: Array,
) -> int:
    """Step through time and fill u, v and F from their first rows on.

    The equilibrium M a + C v + K u = f + Jᵀ F at two times, added, with the average acceleration
    rule (Newmark, β = 1/4, γ = 1/2) gives for w = v₀ + v₁

        S w = f₀ + f₁ + Jᵀ (F₀ + F₁) + 4/Δt M v₀ - 2 K u₀,   S = 2/Δt M + C + Δt/2 K,

    and u₁ = u₀ + Δt/2 w, v₁ = w - v₀. With the gap function δ = g + J u (negative in contact),
    penetration p = -δ and W = J S⁻¹ Jᵀ, the forces F₁ change δ by Δt/2 W F₁ and δ̇ by W F₁.

    Args:
        dt: Time step Δt [s].
        K: Stiffness, shape (n, n).
        M: Mass, shape (n, n), diagonal.
        S_inv: Inverse of S, shape (n, n).
        patterns: Patterns of the external forces, shape (q, n).
        histories: Their factors, f = Σ_q histories[t, q] patterns[q], shape (n_t, q).
        J: Rows of relative displacement of the pairs, shape (m, n); tension positive.
        SJ: S⁻¹ Jᵀ, transposed, shape (m, n).
        gap: Gaps g, shape (m,) [m].
        codes: Contact laws, as in `law_force`, shape (m,).
        parameters: Their parameters, shape (m, N_PARAMETERS).
        lagged: Take the force of a step from the state before it (paper, equation 2 as printed)
            instead of the new state.
        u: Displacements, shape (n_t, n), first row given.
        v: Velocities, shape (n_t, n), first row given.
        F: Contact forces, shape (n_t, m), positive in compression, first row given [N].

    Returns:
        The number of times done: n_t, or less where the contact forces did not converge.
    """
    n_t, n = u.shape
    m = gap.size
    h = dt / 2.0
    W = np.zeros((m, m))
    for i in range(m):
        for j in range(m):
            for c in range(n):
                W[i, j] += J[i, c] * SJ[j, c]
    w = np.zeros(n)
    b = np.zeros(n)
    x = np.zeros(n)
    delta = np.zeros(m)
    rate = np.zeros(m)
    F1 = np.zeros(m)
    onset = np.zeros(m)
    touches = np.zeros(m, dtype=np.bool_)
    for t in range(n_t - 1):
        for i in range(n):
            x[i] = -2.0 * u[t, i]
            b[i] = 4.0 / dt * M[i, i] * v[t, i]
            w[i] = 0.0
        for q in range(patterns.shape[0]):
            factor = histories[t, q] + histories[t + 1, q]
            for i in range(n):
                b[i] += factor * patterns[q, i]
        add_product(K, x, b)
        for j in range(m):
            if F[t, j] != 0.0:
                for i in range(n):
                    b[i] += J[j, i] * F[t, j]
        add_product(S_inv, b, w)

        # Motion of the pairs without the new forces.
        touching = False
        for j in range(m):
            delta[j] = gap[j]
            rate[j] = 0.0
            before = gap[j]
            before_rate = 0.0
            for i in range(n):
                if J[j, i] != 0.0:
                    delta[j] += J[j, i] * (u[t, i] + h * w[i])
                    rate[j] += J[j, i] * (w[i] - v[t, i])
                    before += J[j, i] * u[t, i]
                    before_rate += J[j, i] * v[t, i]
            if before >= 0.0:
                onset[j] = max(-before_rate, 0.0)
            if lagged:
                F1[j] = law_force(codes[j], parameters[j], -before, -before_rate, onset[j])[0]
            else:
                F1[j] = 0.0
            touching = touching or delta[j] < 0.0 or F1[j] != 0.0
        if touching and not lagged:
            converged = contact_forces(h, W, delta, rate, codes, parameters, onset, touches, F1)
            if not converged:
                return t + 1
        for j in range(m):
            F[t + 1, j] = F1[j]
            if F1[j] != 0.0:
                for i in range(n):
                    w[i] += SJ[j, i] * F1[j]
        for i in range(n):
            u[t + 1, i] = u[t, i] + h * w[i]
            v[t + 1, i] = w[i] - v[t, i]
    return n_t
