"""Steps of bodies without contact, by the θ rule: many of them at once.

With x_θ = (1 - θ) x₀ + θ x₁ a step h under the loads f_θ is

    M̂ v_θ = M v₀ + θ h (f_θ - K u₀),   M̂ = M + θ h C + θ² h² K,
    u₁ = u₀ + h v_θ,   v₁ = v₀ + (v_θ - v₀)/θ,                                             (1)

the average acceleration rule with θ = ½. Bodies alone are diagonal, and each mode is marched by
itself. Attachments (soil under a raft, mounts) couple all modes in each step by equation (2) of
`links`.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from impactfem.coupling.links import Assembly, Inverse
from impactfem.coupling.march import Attachments, Modes
from impactfem.system.arrays import Array, Index

ENERGIES = 6
"""Kinetic and elastic energy after a step; those that damping, radiation into the soil and the rule
dissipate in it; input of the loads [J]."""


class State(NamedTuple):
    """Coordinates of bodies and of what is attached to them, with their velocities."""

    z: Array  #: shape (r,), or (r, K) after each of K steps
    v: Array  #: their velocities
    y: Array  #: attachments, shape (N,) or (N, K)
    y_v: Array  #: their velocities

    def after(self, steps: int) -> State:
        """Return the state after so many of the steps."""
        return State(*(x[:, steps - 1].copy() for x in self))


class _Given(NamedTuple):
    load: Array  #: f_θ on the coordinates, shape (K, r)
    push: Array  #: on the attachments, shape (K, N)
    begin: Index  #: first coordinate that moves each row of B, shape (N_a,)
    end: Index  #: the one after the last


class FreeFlight:
    """Bodies with their step, equation (1).

    Attributes:
        inverse: M̂⁻¹.
    """

    def __init__(self, assembly: Assembly, time_step: float, theta: float = 0.5) -> None:
        self.time_step, self.theta, self.assembly = time_step, theta, assembly
        self.inverse, one = Inverse(assembly, theta * time_step), assembly.attached
        self._modes = Modes(
            assembly.mass, assembly.damping, assembly.eigenvalue, self.inverse.diagonal
        )
        self._attachments = Attachments(
            M=one.M,
            C=one.C,
            K=one.K,
            S=self.inverse.S,
            free=self.inverse.free,
            loaded=self.inverse.loaded,
            rows=self.inverse.rows,
        )
        # A row of B belongs to one body, that of a base coordinate to this coordinate alone.
        moved = [np.flatnonzero(row) for row in one.rows]
        self._begin = np.array([at[0] if at.size else 0 for at in moved], dtype=np.int64)
        self._end = np.array([at[-1] + 1 if at.size else 0 for at in moved], dtype=np.int64)

    def steps(self, state: State, load: Array, push: Array) -> State:
        """Make K steps from a state; return the states after them.

        Args:
            state: The state before them.
            load: f_θ of each step on the coordinates, shape (r, K).
            push: The same on what is attached, shape (N, K).
        """
        r, K = load.shape
        N = len(state.y)
        if N == 0:
            z, v, none = np.empty((r, K)), np.empty((r, K)), np.zeros((0, K))
            _march_modes(
                self.time_step, self.theta, self._modes, state, load, State(z, v, none, none)
            )
            return State(z, v, none, none)
        given = _Given(
            np.ascontiguousarray(load.T), np.ascontiguousarray(push.T), self._begin, self._end
        )
        made = State(*(np.empty((K, n)) for n in (r, r, N, N)))
        moving = State(*(x.copy() for x in state))
        _march_attached(
            self.time_step, self.theta, self._modes, self._attachments, given, moving, made
        )
        return State(*(x.T for x in made))

    def energies(self, before: State, made: State, load: Array, push: Array) -> Array:
        """Return the `ENERGIES` of steps that were made, shape (K, ENERGIES) [J]."""
        h, θ, all_, one = self.time_step, self.theta, self.assembly, self.assembly.attached
        first = [np.column_stack([x0, x[:, :-1]]) for x0, x in zip(before, made, strict=True)]
        mean, y_mean = ((1.0 - θ) * first[k] + θ * made[k] for k in (1, 3))
        lost = np.zeros(load.shape[1])
        if θ != 0.5:
            jump, y_jump = made.v - first[1], made.y_v - first[3]
            lost = all_.mass @ jump**2 + _square(one.M, y_jump)
            lost += h**2 * (all_.eigenvalue @ mean**2 + _square(one.K, y_mean))
            lost *= θ - 0.5
        radiated = h * _square(one.radiation, y_mean)
        found = np.zeros((load.shape[1], ENERGIES))
        found[:, 0] = 0.5 * (all_.mass @ made.v**2 + _square(one.M, made.y_v))
        found[:, 1] = 0.5 * (all_.eigenvalue @ made.z**2 + _square(one.K, made.y))
        found[:, 2] = h * (all_.damping @ mean**2 + _square(one.C, y_mean)) - radiated
        found[:, 3], found[:, 4] = radiated, lost
        found[:, 5] = h * (np.sum(mean * load, axis=0) + np.sum(y_mean * push, axis=0))
        return found


def _square(A: Array, x: Array) -> Array:
    """xᵀ A x of each column."""
    return np.asarray(np.sum(x * (A @ x), axis=0))


@numba.njit(cache=True)
def _march_modes(
    h: float, theta: float, modes: Modes, state: State, load: Array, made: State
) -> None:
    """Equation (1) mode by mode."""
    r, K = load.shape
    s, whole = theta * h, 1.0 / theta
    for i in range(r):
        x, y, μ, λ = state.z[i], state.v[i], modes.mass[i], modes.stiffness[i]
        for k in range(K):
            mean = modes.inverse[i] * (μ * y + s * (load[i, k] - λ * x))
            x, y = x + h * mean, y + whole * (mean - y)
            made.z[i, k], made.v[i, k] = x, y


@numba.njit(cache=True, fastmath={"contract", "reassoc"})
def _march_attached(
    h: float,
    theta: float,
    modes: Modes,
    other: Attachments,
    given: _Given,
    state: State,
    made: State,
) -> None:
    """Equation (1) step by step; arrays of `made` have a row for each step."""
    s, whole = theta * h, 1.0 / theta
    z, v, y, y_v = state.z, state.v, state.y, state.y_v
    r, N, N_a = z.size, y.size, other.rows.shape[0]
    b, mean, b_y, y_mean = np.empty(r), np.empty(r), np.empty(N), np.empty(N)
    reach = np.empty(N_a)
    for k in range(given.load.shape[0]):
        f, q = given.load[k], given.push[k]
        # M̂ v_θ = b: first by the diagonal alone.
        for i in range(r):
            b[i] = modes.mass[i] * v[i] + s * (f[i] - modes.stiffness[i] * z[i])
            mean[i] = modes.inverse[i] * b[i]
        for a in range(N_a):
            total = 0.0
            for i in range(given.begin[a], given.end[a]):
                total += other.rows[a, i] * b[i]
            reach[a] = total
        # Equation (2) of `links`: the attachments, and the forces T with which they act back.
        for a in range(N):
            total = s * q[a]
            for i in range(N):
                total += other.M[a, i] * y_v[i] - s * other.K[a, i] * y[i]
            b_y[a] = total
        for a in range(N):
            total = 0.0
            for i in range(N_a):
                total += other.free[a, i] * reach[i]
            for i in range(N):
                total += other.loaded[a, i] * b_y[i]
            y_mean[a] = total
        for a in range(N_a):
            T = b_y[a]
            for i in range(N):
                T -= other.S[a, i] * y_mean[i]
            for i in range(given.begin[a], given.end[a]):
                mean[i] += T * other.rows[a, i]
        for i in range(r):
            z[i] += h * mean[i]
            v[i] += whole * (mean[i] - v[i])
        for a in range(N):
            y[a] += h * y_mean[a]
            y_v[a] += whole * (y_mean[a] - y_v[a])
        made.z[k], made.v[k], made.y[k], made.y_v[k] = z, v, y, y_v
