"""Linear response in time by Newmark's average acceleration, in full order.

With C = α M + β K + C₊, the equilibrium M a + C v + K u = f at two times, added, and the rules
u₁ = u₀ + Δt/2 (v₀ + v₁), v₁ = v₀ + Δt/2 (a₀ + a₁) (β = 1/4, γ = 1/2) give for w = v₀ + v₁

    S w = r,   r = f₀ + f₁ + 4/Δt M v₀ - 2 K u₀,   S = (2/Δt + α) M + (β + Δt/2) K + C₊,

    u₁ = u₀ + Δt/2 w,   v₁ = w - v₀,   a₁ = 2/Δt (w - 2 v₀) - a₀.

One solve and one product, M w, make a step: M v₁ = M w - M v₀, and K w follows from S w = r.

C₊ may have a part U G Uᵀ of low rank, with U = M φ of some modes and G what a law of damping gives
each in addition to α + β λ (`ModalPart`). The factor is that of S without it (Woodbury),

    w = y - Z (1 + G Uᵀ Z)⁻¹ G Uᵀ y,   S₀ y = r,   S₀ Z = U.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numba
import numpy as np
import scipy.sparse
from petsc4py import PETSc

from impactfem.dynamics.columns import combined, product, summed, wrapped
from impactfem.dynamics.damping import UNDAMPED, DampingLaw, ModeRatios, Rayleigh
from impactfem.dynamics.factorisation import Factorisation, Held
from impactfem.dynamics.history import QUANTITIES, History, Recorder, State, joined
from impactfem.dynamics.modes import modes, number_below
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError

CHUNK = 100
"""Steps between two sums over the ranks, and most steps between two reports of the progress."""


@dataclass(frozen=True, eq=False)
class ModalPart:
    """Damping of some modes in addition to α M + β K."""

    images: Array  #: U = M φ at the rows of this rank, shape (n_local, m).
    excess: Array  #: diagonal of G, d - α - β λ, shape (m,) [1/s].


def in_full_order(
    law: DampingLaw, K: PETSc.Mat, M: PETSc.Mat, highest: float
) -> tuple[Rayleigh, ModalPart | None]:
    """A law as α M + β K, and what it gives the modes in addition. Collective.

    Rayleigh's has no such modes. Of other laws they are those with a ratio of their own, or all up
    to the highest frequency [Hz]: exact there, and above β K that goes through the law at that
    frequency.
    """
    if isinstance(law, Rayleigh):
        return law, None
    top = (2.0 * np.pi * highest) ** 2
    if isinstance(law, ModeRatios) and isinstance(law.others, Rayleigh):
        base, count = law.others, len(law.ratios)
    else:
        base, count = Rayleigh(0.0, float(law.modal(np.array([top]))[0]) / top), 0
        count = number_below(K, M, top)
    if count == 0:
        return base, None
    found = modes(K, M, count)
    eigenvalue = (2.0 * np.pi * found.frequency) ** 2
    excess = law.modal(eigenvalue) - base.modal(eigenvalue)
    return base, ModalPart(product(M, found.shapes), excess)


class Newmark(Held):
    """A linear system, its step and its loads. A context manager that frees the memory.

    All methods are collective.

    Args:
        K: Stiffness, symmetric, positive definite (AIJ).
        M: Mass, symmetric, positive definite (AIJ), on part of the pattern of K. It is
            multiplied at each step, so it should not store zeros.
        time_step: Δt [s].
        patterns: Rows of this rank of the spatial patterns of the loads, shape (n_local, m); the
            load at time i is patterns @ amplitudes[i].
        damping: α and β of C = α M + β K + C₊.
        C: C₊, symmetric (AIJ); for damping by part. It is multiplied at each step.
        modal: The part of C₊ of low rank.

    SolutionError where the step is not positive.
    """

    def __init__(
        self,
        K: PETSc.Mat,
        M: PETSc.Mat,
        time_step: float,
        patterns: Array,
        *,
        damping: Rayleigh = UNDAMPED,
        C: PETSc.Mat | None = None,
        modal: ModalPart | None = None,
    ) -> None:
        if not time_step > 0.0:
            raise SolutionError(f"a time step of {time_step} s: it must be positive")
        self.time_step = time_step
        self.damping = damping
        self._K, self._M, self._C = K, M, C
        self._patterns = np.asarray(patterns, dtype=np.float64)
        self._factor: Factorisation | None = None
        self._modal = modal
        self._update: Array | None = None

    def destroy(self) -> None:
        """Free the memory; the system is of no use afterwards."""
        if self._factor is not None:
            self._factor.destroy()

    def factorise(self) -> Factorisation:
        """The factorisation of S, made at the first call."""
        if self._factor is None:
            dt, α, β = self.time_step, self.damping.alpha, self.damping.beta
            S = combined(β + dt / 2.0, self._K, 2.0 / dt + α, self._M)
            if self._C is not None:
                S.axpy(1.0, self._C, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
            self._factor = Factorisation(S, name="the matrix of the time step")
            S.destroy()
        return self._factor

    def correct(self, w: Array) -> Array | None:
        """Correct w = S₀⁻¹ r, in place, for the part of low rank; gives that part of C₊ w."""
        if self._modal is None:
            return None
        U, g = self._modal.images, self._modal.excess
        if self._update is None:
            Z = self.factorise().solve_block(U)
            inner = np.eye(len(g)) + g[:, None] * summed(self._M, U.T @ Z)
            self._update = np.linalg.solve(inner.T, Z.T).T * g
        w -= self._update @ summed(self._M, U.T @ w)
        return np.asarray(U @ (g * summed(self._M, U.T @ w)))

    def start(
        self, amplitude: Array, displacement: Array | None = None, velocity: Array | None = None
    ) -> State:
        """State at step 0 with the acceleration that is in equilibrium with it.

        From amplitudes of the loads there, shape (m,), and u₀ and v₀, shape (n_local,), zero when
        None.
        """
        n = self._patterns.shape[0]
        u = np.zeros(n) if displacement is None else np.array(displacement, dtype=np.float64)
        v = np.zeros(n) if velocity is None else np.array(velocity, dtype=np.float64)
        momentum, Kv = product(self._M, v[:, None])[:, 0], product(self._K, v[:, None])[:, 0]
        restoring = product(self._K, u[:, None])[:, 0]
        out_of_balance = self._patterns @ np.asarray(amplitude, dtype=np.float64) - restoring
        out_of_balance -= self.damping.alpha * momentum + self.damping.beta * Kv
        if self._C is not None:
            out_of_balance -= product(self._C, v[:, None])[:, 0]
        if self._modal is not None:
            U = self._modal.images
            out_of_balance -= U @ (self._modal.excess * summed(self._M, U.T @ v))
        acceleration: Array = np.zeros(n)
        if summed(self._M, np.dot(out_of_balance, out_of_balance)) > 0.0:
            with Factorisation(self._M, full_blocks=False, name="the mass matrix") as factor:
                acceleration = factor.solve_block(out_of_balance[:, None])[:, 0]
        return State(0, u, v, acceleration, momentum, restoring)

    def static(self, amplitude: Array) -> State:
        """State at rest in the deformed shape of the loads with amplitudes of shape (m,)."""
        f = self._patterns @ np.asarray(amplitude, dtype=np.float64)
        with Factorisation(self._K, name="the stiffness matrix") as factor:
            u = factor.solve_block(f[:, None])[:, 0]
        zero = np.zeros_like(u)
        # K u and not f: the energy counts what the state has.
        return State(0, u, zero, zero.copy(), zero.copy(), product(self._K, u[:, None])[:, 0])

    def march(
        self,
        state: State,
        amplitudes: Array,
        *,
        last: int | None = None,
        probes: Sequence[int] | Index = (),
        record: Sequence[str] = QUANTITIES,
        each_step: Callable[[State], None] | None = None,
        each_chunk: Callable[[State, History], None] | None = None,
        chunk: int = CHUNK,
    ) -> History:
        """Step on from a state, which moves along.

        Args:
            state: Where to start; changed in place.
            amplitudes: Amplitudes of the loads at all times from step 0 on, shape (n_t, m).
            last: Step to stop at; default n_t - 1.
            probes: Global rows whose motion is recorded.
            record: Which of QUANTITIES are recorded.
            each_step: Called after each step, for snapshots; must not change the state.
            each_chunk: Called with the state and what was recorded since the last call, for
                checkpoints; must not change the state.
            chunk: Steps between two such calls.

        Gives the history from the given state, included, to the last step. SolutionError where the
        response is not finite, or the state is beyond the last step.
        """
        amplitudes = np.asarray(amplitudes, dtype=np.float64)
        last = amplitudes.shape[0] - 1 if last is None else last
        if not state.step <= last < amplitudes.shape[0]:
            raise SolutionError(
                f"from step {state.step} to step {last} with loads up to step"
                f" {amplitudes.shape[0] - 1}"
            )
        factor = self.factorise()
        recorder = Recorder(self._M, probes, record, chunk, self.time_step)
        stepper = _Stepper(self, factor, state)
        kinetic = 0.5 * float(state.velocity @ state.momentum)
        elastic = 0.5 * float(state.displacement @ state.restoring)
        recorder.put(state, (kinetic, elastic, 0.0, 0.0))
        recorder.reduce(state)
        while state.step < last:
            end = min(last, (state.step // chunk + 1) * chunk)
            while state.step < end:
                energies = stepper.step(amplitudes[state.step], amplitudes[state.step + 1])
                recorder.put(state, energies)
                if each_step is not None:
                    each_step(state)
            part = recorder.reduce(state)
            if each_chunk is not None:
                each_chunk(state, part)
        stepper.destroy()
        return joined(recorder.parts)


class _Stepper:
    """The vectors of the loop, made once."""

    def __init__(self, system: Newmark, factor: Factorisation, state: State) -> None:
        self.system, self.factor, self.state = system, factor, state
        patterns = scipy.sparse.csr_matrix(system._patterns)
        csr = patterns.indptr, patterns.indices, patterns.data
        self.F = PETSc.Mat().createAIJ(patterns.shape, csr=csr, comm=PETSc.COMM_SELF)
        n, m = patterns.shape
        self.sum = np.zeros(m)
        self.f, self.r, self.w, self.Mw, self.Cw = (np.zeros(n) for _ in range(5))
        self.sum_vector, self.f_vector = (
            PETSc.Vec().createWithArray(array, comm=PETSc.COMM_SELF) for array in (self.sum, self.f)
        )
        self.r_vector, self.w_vector, self.Mw_vector, self.Cw_vector = (
            wrapped(system._M, array) for array in (self.r, self.w, self.Mw, self.Cw)
        )

    def step(self, before: Array, after: Array) -> tuple[float, float, float, float]:
        """One step; energies of this rank: kinetic, elastic, newly damped, newly put in."""
        system, state = self.system, self.state
        np.add(before, after, out=self.sum)
        self.F.mult(self.sum_vector, self.f_vector)
        # r = f + 4/Δt M v - 2 K u.
        np.multiply(state.momentum, 4.0 / system.time_step, out=self.r)
        self.r += self.f
        self.r -= 2.0 * state.restoring
        self.factor.solve(self.r_vector, self.w_vector)
        modal = system.correct(self.w)
        system._M.mult(self.w_vector, self.Mw_vector)
        if system._C is not None:
            system._C.mult(self.w_vector, self.Cw_vector)
        if modal is not None:
            self.Cw[:] = modal if system._C is None else self.Cw + modal
        energies: tuple[float, float, float, float] = _advance(
            system.time_step,
            system.damping.alpha,
            system.damping.beta,
            StepVectors(
                f=self.f,
                r=self.r,
                w=self.w,
                Mw=self.Mw,
                Cw=self.Cw,
                u=state.displacement,
                v=state.velocity,
                a=state.acceleration,
                p=state.momentum,
                q=state.restoring,
            ),
        )
        state.step += 1
        return energies

    def destroy(self) -> None:
        vectors = self.sum_vector, self.f_vector, self.r_vector, self.w_vector
        for item in (self.F, *vectors, self.Mw_vector, self.Cw_vector):
            item.destroy()


class StepVectors(NamedTuple):
    """Vectors of a step at this rank's rows, shape (n_local,) each."""

    f: Array  #: f₀ + f₁
    r: Array  #: right side of the step
    w: Array  #: v₀ + v₁
    Mw: Array
    Cw: Array  #: by damping that is not Rayleigh's
    u: Array  #: the state, which moves on
    v: Array
    a: Array
    p: Array  #: M v
    q: Array  #: K u


@numba.njit(cache=True)
def _advance(
    dt: float, alpha: float, beta: float, vectors: StepVectors
) -> tuple[float, float, float, float]:
    """Move u, v, a, p = M v and q = K u on by one step; return the energies of the stepper."""
    f, r, w, Mw, Cw, u, v, a, p, q = vectors
    kinetic, elastic, damped, put_in = 0.0, 0.0, 0.0, 0.0
    mass = 2.0 / dt + alpha
    stiffness = beta + dt / 2.0
    # Sums of short sums: the rounding of one long sum would show in the balance of energy.
    for first in range(0, u.size, 512):
        k, e, d, s = 0.0, 0.0, 0.0, 0.0
        for i in range(first, min(first + 512, u.size)):
            # K w from the equation of the step, (2/Δt M + C + Δt/2 K) w = r.
            Kw = (r[i] - mass * Mw[i] - Cw[i]) / stiffness
            d += w[i] * (alpha * Mw[i] + beta * Kw + Cw[i])
            s += w[i] * f[i]
            a[i] = 2.0 / dt * (w[i] - 2.0 * v[i]) - a[i]
            u[i] += dt / 2.0 * w[i]
            v[i] = w[i] - v[i]
            p[i] = Mw[i] - p[i]
            q[i] += dt / 2.0 * Kw
            k += v[i] * p[i]
            e += u[i] * q[i]
        kinetic += k
        elastic += e
        damped += d
        put_in += s
    return 0.5 * kinetic, 0.5 * elastic, dt / 4.0 * damped, dt / 4.0 * put_in
