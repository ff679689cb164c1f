"""The time loop of unilateral contact: free flight, and steps with contact by one of two schemes.

Steps in which no constraint takes part are computed many at once; a scheme says which they are, and
makes the others (`unilateral`: impulses; `massless`: points of contact without mass).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from impactfem.coupling.complementarity import Complementarity, Mask
from impactfem.coupling.free_flight import ENERGIES
from impactfem.dynamics.energy import Energy
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError

COAST = 32
"""Steps that are computed together where nothing touches."""


@dataclass(frozen=True, eq=False)
class ContactHistory:
    """The response between unilateral constraints, the same on all ranks."""

    time: Array  #: shape (n_t,) [s]
    #: P of each constraint in the step that ends at the time, shape (n_t, m) [N s for columns of G
    #: without a unit]; the first row is zero. P / h is the mean force of the step, and G P / h that
    #: on the structure.
    impulse: Array
    gap: Array  #: γ − Gᵀ u, shape (n_t, m) [m for such columns]
    displacement: Array  #: Lᵀ u of the probes, shape (n_t, n_probes)
    velocity: Array  #: Lᵀ v of the probes, shape (n_t, n_probes)
    #: Error of the complementarity of velocities and impulses after the step: the largest of min(w,
    #: P) over the constraints that take part, each scaled by the diagonal of the Delassus operator,
    #: over the largest speed of a constraint so far, shape (n_t,) [-].
    residual: Array
    energy: Energy  #: the energies

    @property
    def force(self) -> Array:
        """P / h, shape (n_t, m): mean of the step that ends at the time [N as P is in N s]."""
        return np.asarray(self.impulse / (self.time[1] - self.time[0]), dtype=np.float64)

    @property
    def penetration(self) -> Array:
        """Largest violation of each constraint, shape (m,), in the unit of the gap."""
        return np.asarray(np.maximum(0.0, -self.gap.min(axis=0)), dtype=np.float64)


class Motion(Protocol):
    """The θ rule of a structure, seen at its constraints and probes, [G L]ᵀ x.

    Methods are collective; their results are the same on all ranks.
    """

    time_step: float
    theta: float
    constraints: int
    patterns: int

    def delassus(self) -> Array:
        """W = Gᵀ M̂⁻¹ G, shape (m, m)."""

    def start(self, displacement: Array | None, velocity: Array | None) -> tuple[Array, Array]:
        """Set u and v, zero when None; return both as seen, shape (m + n_probes,) each."""

    def free(self, amplitude: Array) -> Array:
        """Find v_θ of a step without impulses, under the loads f_θ; return it as seen.

        `amplitude` is (1 − θ) and θ times the amplitudes of the loads before and after.
        """

    def push(self, impulse: Array) -> Array:
        """Find v_θ of the step with the impulses P, shape (m,); return it as seen."""

    def advance(self) -> tuple[float, ...]:
        """Make the step with the v_θ found last.

        Returns its `ENERGIES`.
        """

    def stored(self) -> tuple[float, float]:
        """Kinetic and elastic energy [J]."""

    def coast(self, amplitudes: Array) -> tuple[Array, Array, Array] | None:
        """Try steps of free flight, without impulses.

        `amplitudes` are those of `free`, shape (K, n_patterns). Returns displacements and
        velocities after each step as seen, shape (K, m + n_probes) each, and `ENERGIES`, shape
        (K, ENERGIES); None if the motion has single steps only.
        """

    def keep(self, steps: int) -> None:
        """Make the first of the steps that `coast` tried."""


def check_rule(time_step: float, theta: float) -> None:
    """Raise SolutionError for a step that is not positive and for θ outside [½, 1]."""
    if not time_step > 0.0:
        raise SolutionError(f"a time step of {time_step} s: it must be positive")
    if not 0.5 <= theta <= 1.0:
        raise SolutionError(f"θ = {theta}: it must be from 0.5 to 1")


def state_of(given: Array | None, n: int, what: str) -> Array:
    """Return a copy of a state at the start, zero when None; refuse any shape but (n,)."""
    if given is not None and np.shape(given) != (n,):
        raise SolutionError(f"a state of shape {np.shape(given)} for {what}")
    return np.zeros(n) if given is None else np.array(given, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Walls:
    """Constraints of a structure; they may move."""

    rest: Array  #: γ, shape (n_t, m), or one row for walls at rest
    leaving: Array  #: velocity at which they move away, same shape
    restitution: Array  #: Newton's e, shape (m,)
    neutral: float  #: e = (1 - θ)/θ, with which an impulse does no work

    @classmethod
    def of(
        cls, motion: Motion, gap: ArrayLike, restitution: ArrayLike, opened: Array | None
    ) -> Walls:
        """Check the numbers that `unilateral_response` gets; SolutionError if one is invalid."""
        m, theta = motion.constraints, motion.theta
        if m == 0:
            raise SolutionError("there are no constraints that the structure could meet")
        gaps, neutral = _per_constraint(gap, m, "gaps"), (1.0 - theta) / theta
        e = _per_constraint(restitution, m, "restitutions")
        if np.any(e < 0.0) or np.any(e > neutral * (1.0 + 1e-12)):
            raise SolutionError(
                f"restitutions from {e.min():g} to {e.max():g}: with θ = {theta:g} they must be"
                f" from 0 to {neutral:g}"
            )
        moved, leaving = np.zeros((2, 1, m)) if opened is None else opened
        return cls(gaps + moved, leaving, e, neutral)

    def rows(self, steps: Index) -> tuple[Array, Array]:
        """Return γ and the leaving velocity after some numbers of steps, shape (K, m) each."""
        at = np.minimum(steps, len(self.rest) - 1)
        return self.rest[at], self.leaving[at]

    def start(self, x: Array, slack: float) -> Array:
        """Return the gaps of constraints at x before the first step, shape (m,).

        `slack` is the violation over the size of the terms of a gap that is still rounding.
        SolutionError where a constraint is violated.
        """
        rest = self.rest[0]
        gap = np.asarray(rest - x, dtype=np.float64)
        bad = np.flatnonzero(gap < -slack * np.maximum(np.abs(rest), np.abs(x)))
        if bad.size:
            raise SolutionError(
                f"{bad.size} of {gap.size} constraints are violated at the start: "
                f"constraint {bad[0]} by {-gap[bad[0]]:g}"
            )
        return gap


def _per_constraint(values: ArrayLike, m: int, name: str) -> Array:
    given: Array = np.asarray(values, dtype=np.float64)
    if given.shape not in ((), (m,)) or not np.all(np.isfinite(given)):
        raise SolutionError(
            f"{name} of shape {given.shape}: {m} finite numbers, or one, are needed"
        )
    return np.full(m, given) if given.ndim == 0 else given


class ContactLoop(ABC):
    """Steps of a structure between its constraints. Collective.

    Attributes:
        done: Number of steps that are made.
        x, v: Constraints and probes, [G L]ᵀ u and [G L]ᵀ v, after them.
        gap: Gaps after them, shape (m,).
    """

    slack: float
    """Violation over the size of the terms of a gap that is still rounding at the start."""

    def __init__(self, motion: Motion, walls: Walls, steps: int, problem: Complementarity) -> None:
        if steps < 1:
            raise SolutionError(f"{steps} steps: at least one is needed")
        self.motion, self.walls, self.problem = motion, walls, problem
        self.m, self.steps, self.done = motion.constraints, steps, 0
        self.active: Mask = np.zeros(self.m, dtype=np.bool_)
        self.gaps, self.impulses = np.zeros((2, steps + 1, self.m))
        self.residuals = np.zeros(steps + 1)
        self.energies = np.zeros((steps + 1, ENERGIES + 1))

    @property
    @abstractmethod
    def pressed(self) -> bool:
        """Whether the next step may have contact for what the last one had."""

    @abstractmethod
    def free(self, x: Array, v: Array) -> NDArray[np.bool_]:
        """Return of which steps no constraint takes part.

        By the motion of constraints before the first and after each of them, shape (K + 1, m).
        """

    @abstractmethod
    def step(self, before: Array, after: Array) -> None:
        """Make a step under amplitudes of the loads before and after it.

        Raises:
            SolutionError: The response is not finite, or the complementarity problem has no
                solution.
        """

    def run(
        self, displacement: Array | None, velocity: Array | None, amplitudes: Array | None
    ) -> None:
        """Make all steps from a state, zero when None; refuse one that violates a constraint."""
        shape = self.steps + 1, self.motion.patterns
        loads = np.zeros(shape) if amplitudes is None else np.asarray(amplitudes, dtype=np.float64)
        if loads.shape != shape:
            raise SolutionError(f"amplitudes of the loads of shape {loads.shape}, not {shape}")
        self.x, self.v = self.motion.start(displacement, velocity)
        self.gap = np.maximum(self.walls.start(self.x[: self.m], self.slack), 0.0)
        self.states, self.rates = np.zeros((2, self.steps + 1, self.x.size))
        self.states[0], self.rates[0], self.gaps[0] = self.x, self.v, self.gap
        self.energies[0, :2] = self.motion.stored()
        θ = self.motion.theta
        means = (1.0 - θ) * loads[:-1] + θ * loads[1:]
        while (k := self.done) < self.steps:
            if self.pressed or not self._fly(means[k : k + COAST]):
                self.step(loads[k], loads[k + 1])
                k = self.done = k + 1
                self.states[k], self.rates[k], self.gaps[k] = self.x, self.v, self.gap

    def _fly(self, means: Array) -> bool:
        """Make steps of free flight under loads f_θ, up to the first with a constraint.

        Returns whether there was one at least.
        """
        if (flight := self.motion.coast(means)) is None:
            return False
        xs, vs, energies = flight
        m, k = self.m, self.done
        free = self.free(*(np.vstack([a[:m], b[:, :m]]) for a, b in ((self.x, xs), (self.v, vs))))
        # A value that is not finite ends the flight; the step then raises the error.
        free &= np.isfinite(xs).all(axis=1)
        count = len(free) if free.all() else int(free.argmin())
        if count == 0:
            return False
        self.motion.keep(count)
        made = slice(k + 1, k + count + 1)
        self.states[made], self.rates[made] = xs[:count], vs[:count]
        self.gaps[made] = self.walls.rows(np.arange(k + 1, k + count + 1))[0] - xs[:count, :m]
        self.energies[made, :ENERGIES] = energies[:count]
        self.x, self.v, self.gap = xs[count - 1], vs[count - 1], self.gaps[k + count]
        self.done += count
        return True

    def history(self) -> ContactHistory:
        """Return all steps."""
        lost = np.cumsum(self.energies[:, 2:], axis=0).T
        damped, radiated, numerical, work, contact = lost
        kinetic, elastic = self.energies[:, :2].T
        return ContactHistory(
            time=self.motion.time_step * np.arange(len(self.impulses), dtype=np.float64),
            impulse=self.impulses,
            gap=self.gaps,
            displacement=self.states[:, self.m :],
            velocity=self.rates[:, self.m :],
            residual=self.residuals,
            energy=Energy(kinetic, elastic, damped, work, contact, numerical, radiated),
        )
