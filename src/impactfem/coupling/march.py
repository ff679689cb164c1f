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

Bodies are diagonal; attachments to them couple their coordinates by a Schur complement, equation
(2) of `links`. The loop is plain numpy code: `march` is compiled by numba, `march.py_func` is the
code itself.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np

from impactfem.coupling.law_function import call_advance, law_force
from impactfem.coupling.link_forces import Laws, LinkTrial, contact_forces
from impactfem.system.arrays import Array, Index

# The loop allocates nothing: counting references to arrays would take half of its time.
_LOOP: Any = {"cache": True, "nogil": True, "forceinline": True, "_nrt": False}
# Fused multiply-add, and sums in any order; nan and infinity keep their meaning.
_SUMS: Any = {"fastmath": {"contract", "reassoc"}}


class Modes(NamedTuple):
    """Diagonals of the matrices over the coordinates, shape (r,) each."""

    mass: Array  #: M
    damping: Array  #: C
    stiffness: Array  #: K
    inverse: Array  #: D⁻¹, the inverse of M̂ without attachments


class Attachments(NamedTuple):
    """Matrices of equations (1) and (2) of `links`, over y = (a, ζ)."""

    M: Array  #: M_y, shape (N, N)
    C: Array  #: C_y
    K: Array  #: K_y
    S: Array  #: M_y + h C_y + h² K_y
    free: Array  #: from B D⁻¹ b_z to ÿ, shape (N, N_a)
    loaded: Array  #: from b_y to ÿ, shape (N, N)
    rows: Array  #: B D⁻¹, shape (N_a, r)


class Contacts(NamedTuple):
    """Links: their rows, and the responses to unit forces of each of them."""

    gamma: Array  #: Γ, shape (m, r)
    X: Array  #: z̈, shape (m, r)
    X_y: Array  #: ÿ of the attachments, shape (m, N)
    X_T: Array  #: T on the bodies, shape (m, N_a)
    W: Array  #: h Γ M̂⁻¹ Γᵀ, shape (m, m)
    ends: Index  #: first coordinate of each body, and the end of the last one


class Scheme(NamedTuple):
    """Time steps."""

    h: float  #: half a step [s]
    substeps: int  #: steps between two samples
    lagged: bool  #: forces of the links from the state before the step


class Structure(NamedTuple):
    """Bodies, attachments and links for one step."""

    modes: Modes
    attachments: Attachments
    contacts: Contacts
    laws: Laws


class Inputs(NamedTuple):
    """Given histories; one row of gaps where they rest."""

    loads: Array  #: on the coordinates, shape (n_t, r)
    pushes: Array  #: on the attachments, shape (n_t, N)
    gaps: Array  #: g of the links at rest, shape (n_t or 1, m) [m]
    opening: Array  #: its rate, same shape [m/s]


class State(NamedTuple):
    """Motion at a time; the loop advances it in place."""

    u: Array  #: coordinates, shape (r,)
    v: Array  #: their velocities
    a: Array  #: their accelerations
    y: Array  #: attachments, shape (N,)
    y_v: Array  #: their velocities
    y_a: Array  #: their accelerations
    T: Array  #: forces of the attachments on the bodies, shape (N_a,)
    gap: Array  #: δ of the links, shape (m,) [m]
    F: Array  #: forces of the links [N]
    sums: Array  #: damped, input and contact energy since the start, shape (3,) [J]


class Trial(NamedTuple):
    """Quantities at the end of a step, without the new forces of the links and then with them."""

    b: Array  #: f₁ - C v* - K u*, right side of (2), shape (r,)
    a: Array  #: a₁, shape (r,)
    b_y: Array  #: the same right side of the attachments, shape (N,)
    y_a: Array  #: ÿ₁, shape (N,)
    reach: Array  #: B D⁻¹ b, shape (N_a,)
    links: LinkTrial  #: gaps and forces of the links

    @classmethod
    def of(cls, state: State) -> Trial:
        """Make room for a trial from a state."""
        r, N, m = state.u.size, state.y.size, state.F.size
        return cls(
            b=np.empty(r),
            a=np.empty(r),
            b_y=np.empty(N),
            y_a=np.empty(N),
            reach=np.empty(state.T.size),
            links=LinkTrial.of(m),
        )


class Records(NamedTuple):
    """Histories that the loop fills."""

    u: Array  #: kept coordinates, shape (n_t, kept)
    v: Array  #: their velocities
    force: Array  #: F, shape (n_t, m)
    attached: Array  #: y, ẏ, ÿ and T in one row, shape (n_t, 3 N + N_a)
    energy: Array  #: kinetic, elastic, damped, input and contact energy, shape (n_t, 5)
    kept: Index  #: indices of the kept coordinates among the moving ones

    @classmethod
    def of(cls, n_t: int, state: State, kept: Index) -> Records:
        """Make room for the histories at n_t times."""
        return cls(
            u=np.zeros((n_t, kept.size)),
            v=np.zeros((n_t, kept.size)),
            force=np.zeros((n_t, state.F.size)),
            attached=np.zeros((n_t, 3 * state.y.size + state.T.size)),
            energy=np.zeros((n_t, 5)),
            kept=kept,
        )


@numba.njit(**(_LOOP | {"forceinline": False}), **_SUMS)
def march(
    scheme: Scheme,
    structure: Structure,
    inputs: Inputs,
    state: State,
    trial: Trial,
    records: Records,
) -> int:
    """Step through time by equations (1) and (2); fill the records.

    The state is that at the start; it moves on. Returns the number of times done: n_t, or less
    where the forces of the links do not converge.
    """
    n_t, m = inputs.loads.shape[0], state.F.size
    gamma, ends = structure.contacts.gamma, structure.contacts.ends
    for k in range(m):
        # Rounding of a gap that is just closed is no penetration, and would hide the approach.
        state.gap[k] = max(state.gap[k] + _motion(gamma[k], state.u, ends), 0.0)
        trial.links.rate[k] = inputs.opening[0, k] + _motion(gamma[k], state.v, ends)
    _record(0, structure, state, records)
    for t in range(1, n_t):
        for j in range(scheme.substeps):
            pressed = _advance_laws(scheme, structure.laws, state, trial)
            _predict(scheme, structure, inputs, t, j, state, trial)
            touching = _open_gaps(scheme, structure, inputs, t, j, state, trial)
            if touching and not scheme.lagged:
                if not contact_forces(scheme.h, structure.contacts.W, structure.laws, trial.links):
                    return t
                pressed = True
            if pressed:
                _add_contact(scheme.h, structure.contacts, state, trial)
            _account(scheme, structure, inputs, t, j, state, trial)
            _correct(scheme.h, state, trial)
        _record(t, structure, state, records)
    return n_t


@numba.njit(**_LOOP, **_SUMS)
def _advance_laws(scheme: Scheme, laws: Laws, state: State, trial: Trial) -> bool:
    """Update the states of the contacts from the motion before the step.

    Sets F₁ to zero or, lagged, to the force before the step; returns whether one is not zero.
    """
    pressed = False
    for k in range(state.F.size):
        # The approach velocity of a contact is the rate of the last time without penetration.
        if state.gap[k] >= 0.0:
            laws.state[k, 0] = max(-trial.links.rate[k], 0.0)
        trial.links.F[k] = 0.0
        if laws.advance[k] == 0 and not scheme.lagged:
            continue
        p, v = -state.gap[k], -trial.links.rate[k]
        row, memory = laws.parameters[k, : laws.size[k, 0]], laws.state[k, : laws.size[k, 1]]
        if laws.advance[k] != 0:
            call_advance(laws.advance[k], row, p, v, memory)
        if scheme.lagged:
            trial.links.F[k] = law_force(laws.force[k], row, p, v, memory)[0]
            pressed = pressed or trial.links.F[k] != 0.0
    return pressed


@numba.njit(**_LOOP, **_SUMS)
def _predict(
    scheme: Scheme,
    structure: Structure,
    inputs: Inputs,
    t: int,
    j: int,
    state: State,
    trial: Trial,
) -> None:
    """Find u*, v* of (1), and a₁ of (2) without the forces of the links."""
    h, at = scheme.h, (j + 1) / scheme.substeps
    modes, other = structure.modes, structure.attachments
    u, v = state.u, state.v
    f0, f1 = inputs.loads[t - 1], inputs.loads[t]
    # (1): u* = u₀ + 2 h v₀ + h² a₀, v* = v₀ + h a₀.
    _extrapolate(h, u, v, state.a)
    for i in range(u.size):
        # (2) mode by mode: a₁ = D⁻¹ b, b = f₁ - C v* - K u*.
        trial.b[i] = (
            f0[i] + at * (f1[i] - f0[i]) - modes.damping[i] * v[i] - modes.stiffness[i] * u[i]
        )
        trial.a[i] = modes.inverse[i] * trial.b[i]
    N, N_a = state.y.size, other.rows.shape[0]
    if N == 0:
        return
    # Attachments, equation (2) of `links`. The same predictor, and b_y = q₁ - C_y ẏ* - K_y y*.
    _extrapolate(h, state.y, state.y_v, state.y_a)
    q0, q1 = inputs.pushes[t - 1], inputs.pushes[t]
    for k in range(N):
        q = q0[k] + at * (q1[k] - q0[k])
        trial.b_y[k] = q - _dot(other.C[k], state.y_v) - _dot(other.K[k], state.y)
    # B D⁻¹ b: the accelerations that the bodies would have at the rows of the attachments.
    for k in range(N_a):
        trial.reach[k] = _dot(other.rows[k], trial.b)
    # The Schur complement 1 + Y S, inverted once, gives ÿ₁ from these and b_y.
    for k in range(N):
        trial.y_a[k] = _dot(other.free[k], trial.reach) + _dot(other.loaded[k], trial.b_y)
    # T = (b_y - S ÿ₁)_a acts back on the bodies: a₁ = D⁻¹ (b + Bᵀ T).
    for k in range(N_a):
        state.T[k] = trial.b_y[k] - _dot(other.S[k], trial.y_a)
        _add(trial.a, state.T[k], other.rows[k])


@numba.njit(**_LOOP, **_SUMS)
def _open_gaps(
    scheme: Scheme,
    structure: Structure,
    inputs: Inputs,
    t: int,
    j: int,
    state: State,
    trial: Trial,
) -> bool:
    """Find δ₁ = g + Γ u₁ and its rate without the forces of the links.

    Returns whether a gap closes.
    """
    h, at = scheme.h, (j + 1) / scheme.substeps
    gamma, ends = structure.contacts.gamma, structure.contacts.ends
    last = inputs.gaps.shape[0] - 1
    before, after = min(t - 1, last), min(t, last)
    touching = False
    for k in range(trial.links.gap.size):
        # (1): Γ u₁ = Γ u* + h² Γ a₁, Γ v₁ = Γ v* + h Γ a₁.
        change = _motion(gamma[k], trial.a, ends)
        g0, g1 = inputs.gaps[before, k], inputs.gaps[after, k]
        g = g0 + at * (g1 - g0)
        trial.links.gap[k] = g + _motion(gamma[k], state.u, ends) + h * h * change
        w0, w1 = inputs.opening[before, k], inputs.opening[after, k]
        opens = w0 + at * (w1 - w0)
        trial.links.rate[k] = opens + _motion(gamma[k], state.v, ends) + h * change
        touching = touching or trial.links.gap[k] < 0.0
    return touching


@numba.njit(**_LOOP, **_SUMS)
def _add_contact(h: float, contacts: Contacts, state: State, trial: Trial) -> None:
    """Add the responses to the forces F₁ of the links: a₁ += M̂⁻¹ Γᵀ F₁, δ₁ += h W F₁."""
    m = trial.links.F.size
    for k in range(m):
        F = trial.links.F[k]
        if F != 0.0:
            _add(trial.a, F, contacts.X[k])
            for i in range(trial.y_a.size):
                trial.y_a[i] += F * contacts.X_y[k, i]
            for i in range(trial.reach.size):
                state.T[i] += F * contacts.X_T[k, i]
            for i in range(m):
                trial.links.gap[i] += h * contacts.W[i, k] * F
                trial.links.rate[i] += contacts.W[i, k] * F


@numba.njit(**_LOOP, **_SUMS)
def _account(
    scheme: Scheme,
    structure: Structure,
    inputs: Inputs,
    t: int,
    j: int,
    state: State,
    trial: Trial,
) -> None:
    """Add the terms of (3) to the sums, from the state before the correction."""
    h, twice = scheme.h, (2 * j + 1) / scheme.substeps
    f0, f1, q0, q1 = inputs.loads[t - 1], inputs.loads[t], inputs.pushes[t - 1], inputs.pushes[t]
    lost, gained = 0.0, 0.0
    for i in range(state.u.size):
        # w = v₀ + v₁ = 2 v* + h (a₁ - a₀), f₀ + f₁ at both ends of the step.
        w = 2.0 * state.v[i] + h * (trial.a[i] - state.a[i])
        lost += structure.modes.damping[i] * w * w
        gained += w * (2.0 * f0[i] + twice * (f1[i] - f0[i]))
    w_y = trial.b_y  # no longer needed
    for k in range(state.y.size):
        w_y[k] = 2.0 * state.y_v[k] + h * (trial.y_a[k] - state.y_a[k])
        gained += w_y[k] * (2.0 * q0[k] + twice * (q1[k] - q0[k]))
    for k in range(state.y.size):
        lost += w_y[k] * _dot(structure.attachments.C[k], w_y)
    state.sums[0] += 0.5 * h * lost
    state.sums[1] += 0.5 * h * gained
    last = inputs.gaps.shape[0] - 1
    for k in range(state.F.size):
        # ½ (Δδ - Δg) (F₀ + F₁); the work of the ground on the gap, ½ Δg (F₀ + F₁), is input.
        mean = state.F[k] + trial.links.F[k]
        opened = inputs.gaps[min(t, last), k] - inputs.gaps[min(t - 1, last), k]
        state.sums[1] -= 0.5 * opened / scheme.substeps * mean
        state.sums[2] += 0.5 * (trial.links.gap[k] - state.gap[k]) * mean


@numba.njit(**_LOOP, **_SUMS)
def _correct(h: float, state: State, trial: Trial) -> None:
    """Complete (1): u₁ = u* + h² a₁, v₁ = v* + h a₁; the state becomes that after the step."""
    for i in range(state.u.size):
        state.u[i] += h * h * trial.a[i]
        state.v[i] += h * trial.a[i]
        state.a[i] = trial.a[i]
    for k in range(state.y.size):
        state.y[k] += h * h * trial.y_a[k]
        state.y_v[k] += h * trial.y_a[k]
        state.y_a[k] = trial.y_a[k]
    for k in range(state.F.size):
        state.gap[k], state.F[k] = trial.links.gap[k], trial.links.F[k]


@numba.njit(**_LOOP, **_SUMS)
def _record(t: int, structure: Structure, state: State, records: Records) -> None:
    """Fill a row of the records, kinetic and elastic energy among them."""
    modes, other = structure.modes, structure.attachments
    N = state.y.size
    kinetic, elastic = 0.0, 0.0
    for i in range(state.u.size):
        kinetic += modes.mass[i] * state.v[i] * state.v[i]
        elastic += modes.stiffness[i] * state.u[i] * state.u[i]
    for k in range(N):
        kinetic += state.y_v[k] * _dot(other.M[k], state.y_v)
        elastic += state.y[k] * _dot(other.K[k], state.y)
        row = records.attached[t]
        row[k], row[N + k], row[2 * N + k] = state.y[k], state.y_v[k], state.y_a[k]
    for k in range(state.T.size):
        records.attached[t, 3 * N + k] = state.T[k]
    records.energy[t, 0], records.energy[t, 1] = 0.5 * kinetic, 0.5 * elastic
    for k in range(3):
        records.energy[t, 2 + k] = state.sums[k]
    for k in range(state.F.size):
        records.force[t, k] = state.F[k]
    for i in range(records.kept.size):
        records.u[t, i], records.v[t, i] = state.u[records.kept[i]], state.v[records.kept[i]]


@numba.njit(**_LOOP, **_SUMS)
def _dot(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@numba.njit(**_LOOP, **_SUMS)
def _add(x: Array, factor: float, row: Array) -> None:
    """Add factor times row to x."""
    for i in range(x.size):
        x[i] += factor * row[i]


@numba.njit(**_LOOP, **_SUMS)
def _motion(row: Array, x: Array, ends: Index) -> float:
    """Product row · x, body by body: equal motions of two bodies alike cancel to the last bit."""
    total = 0.0
    for body in range(ends.size - 1):
        total += _dot(row[ends[body] : ends[body + 1]], x[ends[body] : ends[body + 1]])
    return total


@numba.njit(**_LOOP, **_SUMS)
def _extrapolate(h: float, u: Array, v: Array, a: Array) -> None:
    """From u₀ and v₀ to u* and v* of (1)."""
    for i in range(u.size):
        u[i] += 2.0 * h * v[i] + h * h * a[i]
        v[i] += h * a[i]
