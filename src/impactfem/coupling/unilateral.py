"""A structure before rigid walls: Moreau's time stepping with the θ rule.

    M ü + C u̇ + K u = f − G p,   0 ≤ p ⟂ γ − Gᵀ u ≥ 0

with a gap γ for each column of G. A step h with impulses P ≥ 0 (x_θ = (1 − θ) x₀ + θ x₁) is

    M (v₁ − v₀) = h (f_θ − C v_θ − K u_θ) − G P,   u₁ = u₀ + h v_θ,

so that v_θ = M̂⁻¹ (M v₀ + θ h (f_θ − K u₀) − θ G P) with M̂ = M + θ h C + θ² h² K, and the closing
speeds s = Gᵀ v obey s₁ = s₁(P = 0) − W P with the Delassus operator W = Gᵀ M̂⁻¹ G. The constraints
that take part are those that a stop in this step would leave at the wall or behind it,

    γ − Gᵀ u₀ ≤ (1 − θ) h s₀,   with   0 ≤ P ⟂ −(s₁ + e s₀) ≥ 0,

the complementarity problem with W and q = −(s₁(P = 0) + e s₀). The impulses work

    −v_θᵀ G P = −Σ (1 − θ (1 + e)) s₀ P,

which is never positive if θ (1 + e) ≤ 1 and s₀ ≥ 0 (Acary, ZAMM 96 (2016) 585). Where a constraint
that is behind the wall opens, s₀ < 0, this would be a gain: there e is (1 − θ)/θ instead, which is
s_θ ≤ 0. The impulse then does no work, and the constraint does not go further behind the wall. The
law is continuous in s₀, so that rounding about s₀ = 0 does not matter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numba
import numpy as np
from numpy.typing import ArrayLike

from impactfem.coupling.body import reduced_body
from impactfem.coupling.complementarity import Complementarity, Mask
from impactfem.coupling.links import Assembly, Inverse, Link
from impactfem.coupling.march import Modes
from impactfem.dynamics.damping import UNDAMPED, Damping
from impactfem.dynamics.energy import Energy
from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError

SLACK = 1e-9
"""Distance to a wall that counts as contact, over the way in a step at the largest speed."""
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

        Returns kinetic and elastic energy after it, the energies that damping and rule dissipate in
        it, and the input of the loads [J].
        """

    def stored(self) -> tuple[float, float]:
        """Kinetic and elastic energy [J]."""

    def coast(self, amplitudes: Array) -> tuple[Array, Array, Array] | None:
        """Try steps of free flight, without impulses.

        `amplitudes` are those of `free`, shape (K, n_patterns). Returns displacements and
        velocities after each step as seen, shape (K, m + n_probes) each, and the energies of
        `advance`, shape (K, 5); None if the motion has single steps only.
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


def body_before_walls(eigenvalue: Array, contact: Array, damping: Damping = UNDAMPED) -> Assembly:
    """Return a body of λ, shape (r,) [1/s2], with links to rigid walls of modal rows, (r, m)."""
    r = len(eigenvalue)
    if contact.ndim != 2 or len(contact) != r:
        raise SolutionError(f"constraints of shape {contact.shape} for {r} modes")
    m = contact.shape[1]
    body = reduced_body("body", eigenvalue, damping, {"wall": contact.T})
    return Assembly(
        [body], [Link(str(k), ("body", "wall"), None, n) for k, n in enumerate(np.eye(m))]
    )


class ModalMotion:
    """Bodies and unilateral links with their step, loads and probes. Not collective.

    Args:
        assembly: The bodies; the closing speeds of its links are s = -Γ v.
        time_step: h [s].
        theta: θ, from ½ to 1.
        load: Patterns b of the loads, shape (r, n_patterns); none when None.
        push: The same on what is attached to the bodies, shape (N, n_patterns); none when None.
        probes: Φᵀ L, modal rows of what is recorded, shape (r, n_probes); none when None.

    Raises:
        SolutionError: The step or θ is out of range; shapes that do not fit.
    """

    def __init__(
        self,
        assembly: Assembly,
        time_step: float,
        *,
        theta: float = 0.5,
        load: Array | None = None,
        push: Array | None = None,
        probes: Array | None = None,
    ) -> None:
        check_rule(time_step, theta)
        self.time_step, self.theta = time_step, theta
        self.assembly, one = assembly, assembly.attached
        r, N = len(assembly), len(one.M)
        given = {"loads": np.empty((r, 0)) if load is None else load}
        given["probes"] = np.empty((r, 0)) if probes is None else probes
        for name, rows in given.items():
            if rows.ndim != 2 or len(rows) != r:
                raise SolutionError(f"{name} of shape {rows.shape} for {r} modes")
        self.patterns = given["loads"].shape[1]
        self._load = np.ascontiguousarray(given["loads"], dtype=np.float64)
        self._push = np.zeros((N, self.patterns)) if push is None else push
        self.constraints = len(assembly.links)
        self._contact = np.ascontiguousarray(-assembly.gamma.T)
        self._probes = given["probes"]
        self._seen = np.ascontiguousarray(np.hstack([self._contact, self._probes]).T)
        self._inverse = Inverse(assembly, theta * time_step)
        # Responses to unit impulses: columns M̂⁻¹ G of the bodies, and of what is attached.
        pushed = self._inverse.solve(self._contact.T, np.zeros((self.constraints, N)))
        self._pushed, self._pushed_y = pushed[0].T, pushed[1].T
        self.displacement, self.velocity, self._mean, self._force = np.zeros((4, r))
        self._y, self._y_velocity, self._y_mean, self._y_force = np.zeros((4, N))
        self._coasted = np.zeros((r, 0)), np.zeros((r, 0)), np.zeros((0, 5))

    def refined(self, parts: int) -> ModalMotion:
        """Return the same motion with a step of a part of this one."""
        given = {"load": self._load, "push": self._push, "probes": self._probes}
        return ModalMotion(self.assembly, self.time_step / parts, theta=self.theta, **given)

    def adopt(self, other: ModalMotion) -> None:
        """Take over the state of a motion of the same assembly."""
        self.displacement, self.velocity = other.displacement, other.velocity
        self._y, self._y_velocity = other._y, other._y_velocity

    def delassus(self) -> Array:
        """W = Γ M̂⁻¹ Γᵀ, shape (m, m)."""
        W = self._contact.T @ self._pushed
        return np.asarray(0.5 * (W + W.T), dtype=np.float64)

    def start(self, displacement: Array | None, velocity: Array | None) -> tuple[Array, Array]:
        """Set z and ż, zero when None, and the attachments; return both as seen."""
        rows, what = self.assembly.attached.rows, f"{len(self.assembly)} modes"
        self.displacement = state_of(displacement, len(self.assembly), what)
        self.velocity = state_of(velocity, len(self.assembly), what)
        self._y[: len(rows)] = rows @ self.displacement
        self._y_velocity[: len(rows)] = rows @ self.velocity
        return self._seen @ self.displacement, self._seen @ self.velocity

    def free(self, amplitude: Array) -> Array:
        """Find ż_θ of a step without impulses; return it as seen."""
        s, all_, one = self.theta * self.time_step, self.assembly, self.assembly.attached
        self._force, self._y_force = self._load @ amplitude, self._push @ amplitude
        b_z = all_.mass * self.velocity + s * (self._force - all_.eigenvalue * self.displacement)
        b_y = one.M @ self._y_velocity + s * (self._y_force - one.K @ self._y)
        self._mean, self._y_mean, _ = self._inverse.solve(b_z, b_y)
        return np.asarray(self._seen @ self._mean, dtype=np.float64)

    def push(self, impulse: Array) -> Array:
        """Add impulses to the step; return its ż_θ as seen."""
        self._mean = self._mean - self.theta * (self._pushed @ impulse)
        self._y_mean = self._y_mean - self.theta * (self._pushed_y @ impulse)
        return np.asarray(self._seen @ self._mean, dtype=np.float64)

    def advance(self) -> tuple[float, ...]:
        """Make the step; return kinetic and elastic energy, damping, numerical loss, input."""
        h, all_, one = self.time_step, self.assembly, self.assembly.attached
        mean, y_mean = self._mean, self._y_mean
        jump = (mean - self.velocity) / self.theta
        y_jump = (y_mean - self._y_velocity) / self.theta
        self.velocity, self._y_velocity = self.velocity + jump, self._y_velocity + y_jump
        self.displacement, self._y = self.displacement + h * mean, self._y + h * y_mean
        lost = jump @ (all_.mass * jump) + y_jump @ one.M @ y_jump
        lost += h**2 * (mean @ (all_.eigenvalue * mean) + y_mean @ one.K @ y_mean)
        return (
            *self.stored(),
            h * float(mean @ (all_.damping * mean) + y_mean @ one.C @ y_mean),
            (self.theta - 0.5) * float(lost),
            h * float(mean @ self._force + y_mean @ self._y_force),
        )

    def stored(self) -> tuple[float, float]:
        """Kinetic and elastic energy [J]."""
        all_, one = self.assembly, self.assembly.attached
        z, v, y, w = self.displacement, self.velocity, self._y, self._y_velocity
        kinetic = v @ (all_.mass * v) + w @ one.M @ w
        elastic = z @ (all_.eigenvalue * z) + y @ one.K @ y
        return 0.5 * float(kinetic), 0.5 * float(elastic)

    def coast(self, amplitudes: Array) -> tuple[Array, Array, Array] | None:
        """See `Motion`; all modes are marched alone, which attachments do not allow."""
        if len(self._y):
            return None
        everything, load = self.assembly, self._load @ amplitudes.T
        modes = Modes(
            everything.mass, everything.damping, everything.eigenvalue, self._inverse.diagonal
        )
        self._coasted = march_modes(
            modes, self.displacement, self.velocity, load, self.time_step, self.theta
        )
        _, v, energies = self._coasted
        before = self._seen @ np.column_stack([self.displacement, self.velocity])
        seen = np.vstack([before[:, 1], (self._seen @ v).T])
        mean = (1.0 - self.theta) * seen[:-1] + self.theta * seen[1:]
        return before[:, 0] + self.time_step * np.cumsum(mean, axis=0), seen[1:], energies

    def keep(self, steps: int) -> None:
        """Make the first of the steps that `coast` tried."""
        z, v, _ = self._coasted
        self.displacement, self.velocity = z[:, steps - 1].copy(), v[:, steps - 1].copy()


@numba.njit(cache=True)
def march_modes(
    modes: Modes,
    displacement: Array,
    velocity: Array,
    load: Array,
    h: float,
    theta: float,
    counted: bool = True,
) -> tuple[Array, Array, Array]:
    """March modes alone by the θ rule under loads f_θ, shape (r, K).

    Returns displacements and velocities after each step, shape (r, K) each, and the energies as of
    `Motion.advance`, shape (K, 5), summed over the modes if they are counted.
    """
    mass, damping, stiffness, inverse = modes
    r, K = load.shape
    z, v, energies = np.empty((r, K)), np.empty((r, K)), np.zeros((K if counted else 0, 5))
    s, whole = theta * h, 1.0 / theta
    for i in range(r):
        x, y, μ, λ = displacement[i], velocity[i], mass[i], stiffness[i]
        for k in range(K):
            # v_θ = M̂⁻¹ (M v₀ + θ h (f_θ - K u₀)), u₁ = u₀ + h v_θ, v₁ = v₀ + (v_θ - v₀)/θ.
            mean = inverse[i] * (μ * y + s * (load[i, k] - λ * x))
            jump = whole * (mean - y)
            x, y = x + h * mean, y + jump
            z[i, k], v[i, k] = x, y
            if not counted:
                continue
            energies[k, 0] += 0.5 * μ * y * y
            energies[k, 1] += 0.5 * λ * x * x
            energies[k, 2] += h * damping[i] * mean * mean
            energies[k, 3] += (theta - 0.5) * (μ * jump * jump + h * h * λ * mean * mean)
            energies[k, 4] += h * mean * load[i, k]
    return z, v, energies


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


class MoreauTheta:
    """Moreau's time stepping of a structure between its constraints. Collective.

    Attributes:
        done: Number of steps that are made.
        x, v: Constraints and probes, [G L]ᵀ u and [G L]ᵀ v, after them.
        near: A constraint took part in the last step.
    """

    def __init__(self, motion: Motion, walls: Walls, steps: int) -> None:
        self.motion, self.walls, self.m = motion, walls, motion.constraints
        self.problem = Complementarity(
            motion.delassus(), name="the Delassus operator of the constraints"
        )
        self.done, self.near, self.fastest = 0, True, 0.0
        self.active: Mask = np.zeros(self.m, dtype=np.bool_)
        self.impulses, self.residuals = np.zeros((steps + 1, self.m)), np.zeros(steps + 1)
        self.energies = np.zeros((steps + 1, 6))

    def start(self, displacement: Array | None, velocity: Array | None) -> None:
        """Set the state; refuse one that violates a constraint."""
        x, v = self.motion.start(displacement, velocity)
        m = self.m
        self.walls.start(x[:m], SLACK)
        self.states, self.rates = np.zeros((2, len(self.impulses), x.size))
        self.states[0], self.rates[0], self.energies[0, :2] = x, v, self.motion.stored()
        self.x, self.v = x, v
        self.fastest = _largest(self.problem.scale * (v[:m] - self.walls.leaving[0]))

    def fly(self, means: Array) -> bool:
        """Make steps of free flight under loads f_θ, up to the first with a constraint.

        Returns whether there was one at least.
        """
        flight = self.motion.coast(means)
        if flight is None:
            return False
        (xs, vs, energies), m, walls = flight, self.m, self.walls
        at = np.minimum(np.arange(self.done, self.done + len(xs) + 1), len(walls.rest) - 1)
        speed = np.abs(self.problem.scale * (vs[:, :m] - walls.leaving[at[1:]])).max(axis=1)
        fastest = np.maximum(np.maximum.accumulate(speed), self.fastest)
        # A constraint takes part in a step by the state before it: γ - Gᵀ u₀ ≤ (1 - θ) h s₀.
        x = np.vstack([self.x[:m], xs[:-1, :m]])
        closing = np.vstack([self.v[:m], vs[:-1, :m]]) - walls.leaving[at[:-1]]
        reach = (1.0 - self.motion.theta) * self.motion.time_step
        slack = SLACK * self.motion.time_step * fastest[:, None] / self.problem.scale
        met = (walls.rest[at[:-1]] - x <= reach * closing + slack).any(axis=1)
        count = int(met.argmax()) if met.any() else len(xs)
        if count == 0 or not np.all(np.isfinite(xs[count - 1])):
            return False
        self.motion.keep(count)
        done = slice(self.done + 1, self.done + count + 1)
        self.states[done], self.rates[done] = xs[:count], vs[:count]
        self.energies[done, :5] = energies[:count]
        self.x, self.v, self.fastest = xs[count - 1], vs[count - 1], float(fastest[count - 1])
        self.done += count
        return True

    def step(self, mean_load: Array) -> None:
        """Make one step under the load f_θ.

        Raises:
            SolutionError: The response is not finite, or the complementarity problem has no
                solution.
        """
        motion, walls, m = self.motion, self.walls, self.m
        theta, h, scale = motion.theta, motion.time_step, self.problem.scale
        last = len(walls.rest) - 1
        old, new = min(self.done, last), min(self.done + 1, last)
        self.done += 1
        # v_θ without impulses, and the closing speeds s₀ and s₁ = (s_θ - (1 - θ) s₀)/θ.
        mean = motion.free(mean_load)
        if not np.all(np.isfinite(mean)):
            raise SolutionError(f"the response is not finite in step {self.done}")
        before = self.v[:m] - walls.leaving[old]
        after = (mean[:m] - (1.0 - theta) * self.v[:m]) / theta - walls.leaving[new]
        self.fastest = max(self.fastest, _largest(scale * after))
        # Those take part that a stop would leave at the wall: γ - Gᵀ u₀ ≤ (1 - θ) h s₀.
        slack = SLACK * h * self.fastest / scale
        among = walls.rest[old] - self.x[:m] <= (1.0 - theta) * h * before + slack
        self.near = bool(np.any(among))
        # 0 ≤ P ⟂ W P - (s₁ + e s₀) ≥ 0; where a constraint opens, with e = (1 - θ)/θ.
        bounce = np.where(before >= 0.0, walls.restitution, walls.neutral) * before
        impulse: Array = np.zeros(m)
        if self.near:
            solution = self.problem.solve(-(after + bounce), active=self.active, among=among)
            impulse, self.active = solution.p, solution.active
        if np.any(impulse):
            mean = motion.push(impulse)
        # v₁ = (v_θ - (1 - θ) v₀)/θ, u₁ = u₀ + h v_θ.
        self.v = np.asarray((mean - (1.0 - theta) * self.v) / theta, dtype=np.float64)
        self.x = np.asarray(self.x + h * mean, dtype=np.float64)
        # From the velocities that the structure has, not from W.
        w, p = -scale * (self.v[:m] - walls.leaving[new] + bounce), impulse / scale
        if self.fastest > 0.0:
            self.residuals[self.done] = _largest(np.minimum(w, p)[among]) / self.fastest
        self.states[self.done], self.rates[self.done] = self.x, self.v
        self.impulses[self.done] = impulse
        # -v_θᵀ G P is the work of the impulses; what moving walls do is input.
        by_walls = float((walls.rest[new] - walls.rest[old]) @ impulse) / h
        energies = (*motion.advance(), by_walls - float(mean[:m] @ impulse))
        self.energies[self.done] = energies
        self.energies[self.done, 4] -= by_walls

    def history(self) -> ContactHistory:
        """Return all steps."""
        damped, numerical, work, contact = np.cumsum(self.energies[:, 2:], axis=0).T
        kinetic, elastic = self.energies[:, :2].T
        return ContactHistory(
            time=self.motion.time_step * np.arange(len(self.impulses), dtype=np.float64),
            impulse=self.impulses,
            gap=self.walls.rest - self.states[:, : self.m],
            displacement=self.states[:, self.m :],
            velocity=self.rates[:, self.m :],
            residual=self.residuals,
            energy=Energy(kinetic, elastic, damped, work, contact, numerical),
        )


def unilateral_response(
    motion: Motion,
    gap: ArrayLike,
    steps: int,
    *,
    displacement: Array | None = None,
    velocity: Array | None = None,
    amplitudes: Array | None = None,
    restitution: ArrayLike = 0.0,
    opened: Array | None = None,
) -> ContactHistory:
    """Step a structure from a given state between its constraints. Collective.

    Args:
        motion: The structure; left at the last step, for its `displacement` and `velocity`.
        gap: γ of each constraint in the undeformed structure, shape (m,) or one for all, in the
            unit of Gᵀ u.
        steps: Number of steps, n_t - 1.
        displacement: u₀, as `motion` takes it; default 0.
        velocity: v₀, likewise; default 0.
        amplitudes: Amplitudes of the loads at all times, shape (n_t, n_patterns); no loads when
            None.
        restitution: Newton's e of each constraint, shape (m,) or one for all, from 0 to
            (1 − θ)/θ. The e of nodes is not that of a building: without it, a mesh loses only the
            energy of its contact nodes, which falls with their mass.
        opened: Distance by which the walls move away, and its rate, shape (2, n_t, m), in the unit
            of the gaps; None where they rest. Their work is input.

    Returns:
        The history, the state at the start included.

    Raises:
        SolutionError: No constraints, numbers of the wrong shape or size, a constraint that is
            violated at the start, dependent constraints, a response that is not finite.
    """
    walls = Walls.of(motion, gap, restitution, opened)
    if steps < 1:
        raise SolutionError(f"{steps} steps: at least one is needed")
    shape = (steps + 1, motion.patterns)
    loads = np.zeros(shape) if amplitudes is None else np.asarray(amplitudes, dtype=np.float64)
    if loads.shape != shape:
        raise SolutionError(f"amplitudes of the loads of shape {loads.shape}, not {shape}")
    scheme = MoreauTheta(motion, walls, steps)
    scheme.start(displacement, velocity)
    means = (1.0 - motion.theta) * loads[:-1] + motion.theta * loads[1:]
    while scheme.done < steps:
        if scheme.near or not scheme.fly(means[scheme.done : scheme.done + COAST]):
            scheme.step(means[scheme.done])
    return scheme.history()


def _per_constraint(values: ArrayLike, m: int, name: str) -> Array:
    given: Array = np.asarray(values, dtype=np.float64)
    if given.shape not in ((), (m,)) or not np.all(np.isfinite(given)):
        raise SolutionError(
            f"{name} of shape {given.shape}: {m} finite numbers, or one, are needed"
        )
    return np.full(m, given) if given.ndim == 0 else given


def _largest(values: Array) -> float:
    return float(np.max(np.abs(values), initial=0.0))
