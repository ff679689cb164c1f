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

import numpy as np
from numpy.typing import ArrayLike, NDArray

from impactfem.coupling.complementarity import Complementarity
from impactfem.coupling.contact_loop import ContactHistory, ContactLoop, Motion, Walls
from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError


class MoreauTheta(ContactLoop):
    """Moreau's time stepping of a structure between its constraints. Collective.

    `slack` is also the distance to a wall that counts as contact, over the way in a step at the
    largest speed.
    """

    slack = 1e-9

    def __init__(self, motion: Motion, walls: Walls, steps: int) -> None:
        problem = Complementarity(
            motion.delassus(), name="the Delassus operator of the constraints"
        )
        super().__init__(motion, walls, steps, problem)
        self.fastest, self._near = 0.0, True

    @property
    def pressed(self) -> bool:
        """Whether a constraint took part in the last step."""
        return self._near

    def free(self, x: Array, v: Array) -> NDArray[np.bool_]:
        """See `ContactLoop`; by the state before a step, γ - Gᵀ u₀ > (1 - θ) h s₀."""
        rest, leaving = self.walls.rows(self.done + np.arange(len(x)))
        closing, h = v - leaving, self.motion.time_step
        speed = np.abs(self.problem.scale * closing).max(axis=1)
        fastest = np.maximum(np.maximum.accumulate(speed), self.fastest)
        reach = (1.0 - self.motion.theta) * h * closing[:-1]
        slack = self.slack * h * fastest[1:, None] / self.problem.scale
        free: NDArray[np.bool_] = (rest[:-1] - x[:-1] > reach + slack).all(axis=1)
        self.fastest = float(fastest[len(free) if free.all() else free.argmin()])
        return free

    def step(self, before: Array, after: Array) -> None:
        """See `ContactLoop`."""
        motion, walls, m, k = self.motion, self.walls, self.m, self.done + 1
        θ, h, scale = motion.theta, motion.time_step, self.problem.scale
        rest, leaving = walls.rows(np.array([k - 1, k]))
        # v_θ without impulses, and the closing speeds s₀ and s₁ = (s_θ - (1 - θ) s₀)/θ.
        mean = motion.free((1.0 - θ) * before + θ * after)
        if not np.all(np.isfinite(mean)):
            raise SolutionError(f"the response is not finite in step {k}")
        s0 = self.v[:m] - leaving[0]
        s1 = (mean[:m] - (1.0 - θ) * self.v[:m]) / θ - leaving[1]
        self.fastest = max(self.fastest, _largest(scale * s0), _largest(scale * s1))
        # Those take part that a stop would leave at the wall: γ - Gᵀ u₀ ≤ (1 - θ) h s₀.
        slack = self.slack * h * self.fastest / scale
        among = rest[0] - self.x[:m] <= (1.0 - θ) * h * s0 + slack
        self._near = bool(np.any(among))
        # 0 ≤ P ⟂ W P - (s₁ + e s₀) ≥ 0; where a constraint opens, with e = (1 - θ)/θ.
        bounce = np.where(s0 >= 0.0, walls.restitution, walls.neutral) * s0
        impulse: Array = np.zeros(m)
        if self._near:
            solution = self.problem.solve(-(s1 + bounce), active=self.active, among=among)
            impulse, self.active = solution.p, solution.active
        if np.any(impulse):
            mean = motion.push(impulse)
        # v₁ = (v_θ - (1 - θ) v₀)/θ, u₁ = u₀ + h v_θ.
        self.v = np.asarray((mean - (1.0 - θ) * self.v) / θ, dtype=np.float64)
        self.x = np.asarray(self.x + h * mean, dtype=np.float64)
        self.gap = rest[1] - self.x[:m]
        # From the velocities that the structure has, not from W.
        w, p = -scale * (self.v[:m] - leaving[1] + bounce), impulse / scale
        if self.fastest > 0.0:
            self.residuals[k] = _largest(np.minimum(w, p)[among]) / self.fastest
        self.impulses[k] = impulse
        # -v_θᵀ G P is the work of the impulses; what moving walls do is input.
        by_walls = float((rest[1] - rest[0]) @ impulse) / h
        energies = np.array([*motion.advance(), by_walls - float(mean[:m] @ impulse)])
        energies[-2] -= by_walls
        self.energies[k] = energies


def _largest(values: Array) -> float:
    return float(np.max(np.abs(values), initial=0.0))


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
    scheme = MoreauTheta(motion, Walls.of(motion, gap, restitution, opened), steps)
    scheme.run(displacement, velocity, amplitudes)
    return scheme.history()
