"""Unilateral contact of bodies whose contact points have no mass.

Moreau's scheme stops the mass of a contact point within one step: its force is m v/(2 h), without a
limit as the step h decreases. Here the contact points have no mass. A body in modal coordinates,

    z̈ + d ż + λ z = b p + Γᵀ F,    u_c = Γ z,                                              (1)

moves its contact points under their forces F by the flexibility Γ (λ - ω²)⁻¹ Γᵀ. With a corner
frequency σ = ω_c² it is divided, mode by mode, into a part with mass and a part without,

    u_c = Γ̃ z + R F,    Γ̃ = Γ (1 + λ/σ)^(-½),    R = Γ (λ + σ)⁻¹ Γᵀ.                        (2)

For F at rest both parts add up to the flexibility of the body, Γ λ⁻¹ Γᵀ, and modes far below ω_c
keep their rows: the error is of order (ω/ω_c)². R is the response of the body at the shift σ,
(K + σ M)⁻¹ at the points, that is of a layer of a wave's length c/ω_c without mass. The mass matrix
of (z, u_c) is singular, as that of MacNeal's method, which leaves out modes above a frequency
(Monjaraz-Tec, Gross, Krack, Computers & Structures 260 (2022) 106698); there the limit of the modes
is sharp, and the force in a bar overshoots by 0.9 of its exact value instead of 0.3.

With the gap γ and a compliance C of the surfaces, what is solved at the end of each step is

    0 ≤ F₁ ⟂ δ₁ = γ₁ - G̃ᵀ u₁ + (R + C) F₁ ≥ 0,    G̃ = -Γ̃ᵀ,                               (3)

for displacements, not velocities. The coordinates follow by average acceleration under the mean
½ (F₀ + F₁), which is the θ rule of `unilateral` with θ = ½ and the impulses P = ½ h (F₀ + F₁). What
F₁ adds to it opens the gap by ¼ h² W F₁, W = G̃ᵀ M̂⁻¹ G̃, and (3) is the complementarity problem with

    A = ¼ h² W + R + C.                                                                    (4)

As h decreases, A tends to R + C, and F to a limit. The energies balance exactly in each step,

    Δ(½ vᵀ M v + ½ uᵀ K u + ½ Fᵀ (R + C) F) + h v_mᵀ D v_m = h v_mᵀ f_m + F_mᵀ Δ(δ - γ),      (5)

with the damping D and means v_m, f_m and F_m of both ends,
where the work in δ, ½ (F₀ᵀ δ₁ - F₁ᵀ δ₀), is not zero in a step in which a point closes or opens. It
is the error of the scheme, of second order in h.

C is the local compliance of edges, which shells do not have. Two edges of slabs of the thickness t
touch over a part of it. Of a strip in plane strain, between smooth sides, whose end has a line load
q over the middle half of its thickness, the load beyond its mean is Σ a_n cos(2 π n y/t) with
a_n = 2 q/t sin(π n/2)/(π n/2); each term indents the end by 2 (1 - ν²)/E a_n t/(2 π n). The mean
under the load is q/k with

    1/k = 2 (1 - ν²)/(π E) Σ (sin(π n/2)/(π n/2))²/n = 7 ζ(3) (1 - ν²)/(π³ E),             (6)

for any thickness.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from impactfem.coupling.body import Port
from impactfem.coupling.complementarity import Complementarity
from impactfem.coupling.contact_loop import ContactHistory, ContactLoop, Walls
from impactfem.coupling.links import Assembly
from impactfem.coupling.modal_motion import ModalMotion
from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError

HALF_THICKNESS = math.pi**3 / (7.0 * 1.2020569031595942)
"""π³/(7 ζ(3)) of equation (6)."""
RESOLVED = 0.6
"""Most of ω_c h in a step with contact. Two strips: the largest force is then within 0.5 % of its
limit, with 1.2 within 1 %, with 1.7 within 5 %."""


def strip_stiffness(young_modulus: float, poisson_ratio: float) -> float:
    """Return the local stiffness per length of the edge of a slab, equation (6) [N/m2]."""
    return HALF_THICKNESS * young_modulus / (1.0 - poisson_ratio**2)


@dataclass(frozen=True, eq=False)
class MasslessPoints:
    """Bodies with contact points without mass, equation (2)."""

    assembly: Assembly  #: the bodies with Γ̃ in place of Γ
    flexibility: Array  #: R, shape (m, m) [m/N]
    corner: float  #: largest ω_c of a body [rad/s]
    resolved: float = RESOLVED  #: most of ω_c h in a step with contact

    @classmethod
    def of(cls, assembly: Assembly, shifts: Mapping[str, float]) -> MasslessPoints:
        """Remove the mass of the contact points of some bodies.

        Args:
            assembly: Bodies and links.
            shifts: σ of each such body by its name [1/s2].

        Raises:
            SolutionError: A shift is not positive, or no body is named.
        """
        if not shifts or min(shifts.values()) <= 0.0:
            raise SolutionError(f"shifts {shifts}: expected a positive one for a body at least")
        bodies, R = [], np.zeros((len(assembly.links),) * 2)
        for body in assembly.bodies.values():
            if (shift := shifts.get(body.name)) is None:
                bodies.append(body)
                continue
            here = assembly.columns[body.name]
            own = slice(here.start, here.start + len(body.eigenvalue))
            Γ, λ = assembly.gamma[:, own], body.eigenvalue
            # (2): what remains of the rows, and what they lose without its mass.
            R += (Γ / (λ + shift)) @ Γ.T
            kept = 1.0 / np.sqrt(1.0 + λ / shift)
            ports = {k: Port(port.shapes * kept, port.rigid) for k, port in body.ports.items()}
            bodies.append(replace(body, ports=ports))
        made = Assembly(bodies, assembly.links)
        return cls(made, 0.5 * (R + R.T), math.sqrt(max(shifts.values())))


@dataclass(frozen=True, eq=False)
class MasslessHistory(ContactHistory):
    """The response; impulses of a step are ∫ F dt, gaps those of the surfaces, δ."""

    #: Largest sum of F of each group within the step that ends at the time, (n_t, n_groups) [N].
    largest: Array
    parts: int  #: equal parts of a step with contact
    #: Work in δ of each point since the start, shape (n_t, m) [J]: the error of the scheme.
    work: Array


class _Given(NamedTuple):
    flexibility: Array  #: R + C, shape (m, m) [m/N]
    groups: Array  #: columns that sum forces, shape (m, n_groups)


class _Contact(ContactLoop):
    """Steps h in free flight, parts of them in contact."""

    slack = 1e-9

    def __init__(
        self, motion: ModalMotion, walls: Walls, steps: int, given: _Given, longest: float
    ) -> None:
        self.parts = max(1, math.ceil(motion.time_step / longest))
        self.fine = motion.refined(self.parts) if self.parts > 1 else motion
        h, self.given = self.fine.time_step, given
        # (4)
        problem = Complementarity(
            0.25 * h**2 * self.fine.delassus() + given.flexibility,
            name="the flexibility of the contact points",
        )
        super().__init__(motion, walls, steps, problem)
        self.coarse = motion
        self.F, self.size = np.zeros(self.m), 0.0
        self.work = np.zeros((steps + 1, self.m))
        self.largest = np.zeros((steps + 1, given.groups.shape[1]))

    @property
    def pressed(self) -> bool:
        """Whether there is a force."""
        return bool(self.F.any())

    def free(self, x: Array, v: Array) -> NDArray[np.bool_]:
        """See `ContactLoop`; those that do not penetrate at their end."""
        rest, _ = self.walls.rows(self.done + 1 + np.arange(len(x) - 1))
        return np.asarray((rest - x[1:] >= 0.0).all(axis=1))

    def step(self, before: Array, after: Array) -> None:
        """Make a step in its parts; see `ContactLoop`."""
        (old, new), _ = self.walls.rows(np.array([self.done, self.done + 1]))
        if self.fine is not self.coarse:
            self.fine.adopt(self.coarse)
        for part in range(self.parts):
            load = before + (part + 0.5) / self.parts * (after - before)
            walls = old + np.array([[part], [part + 1.0]]) / self.parts * (new - old)
            self._part(load, walls)
        if self.fine is not self.coarse:
            self.coarse.adopt(self.fine)

    def _part(self, load: Array, walls: Array) -> None:
        """Make one part with the walls at both of its ends."""
        motion, m, k = self.fine, self.m, self.done + 1
        h, F0, scale = motion.time_step, self.F, self.problem.scale
        mean = motion.free(load)
        if not np.all(np.isfinite(mean)):
            raise SolutionError(f"the response is not finite in step {k}")
        if F0.any():
            mean = motion.push(0.5 * h * F0)
        # (3): δ₁ without F₁.
        free = walls[1] - self.x[:m] - h * mean[:m]
        F = np.zeros(m)
        if np.any(free < 0.0):
            solution = self.problem.solve(free, active=self.active)
            F, self.active = solution.p, solution.active
            mean = motion.push(0.5 * h * F)
        self.x = np.asarray(self.x + h * mean, dtype=np.float64)
        self.v = np.asarray(2.0 * mean - self.v, dtype=np.float64)
        # From the displacements that the structure has, not from A.
        gap = walls[1] - self.x[:m] + self.given.flexibility @ F
        self.size = max(self.size, float(np.max(F / scale, initial=0.0)))
        if self.size > 0.0:
            off = np.abs(np.minimum(scale * gap, F / scale)).max()
            self.residuals[k] = max(self.residuals[k], float(off) / self.size)
        middle = 0.5 * (F0 + F)
        # (5): elastic energy of the points, work of walls that move, and work in δ.
        own = middle * (gap - self.gap)
        energies = np.array([*motion.advance(), float(own.sum())])
        energies[1] += 0.5 * float(F @ self.given.flexibility @ F)
        energies[-2] -= float((walls[1] - walls[0]) @ middle)
        self.energies[k, :2] = energies[:2]
        self.energies[k, 2:] += energies[2:]
        self.work[k] += own
        self.impulses[k] += h * middle
        self.largest[k] = np.maximum(self.largest[k], F @ self.given.groups)
        self.F, self.gap = F, np.asarray(gap)

    def history(self) -> MasslessHistory:
        """Return all steps."""
        made = super().history()
        return MasslessHistory(
            **vars(made),
            largest=self.largest,
            parts=self.parts,
            work=np.cumsum(self.work, axis=0),
        )


def massless_response(
    points: MasslessPoints,
    motion: ModalMotion,
    steps: int,
    *,
    compliance: Array | None = None,
    displacement: Array | None = None,
    velocity: Array | None = None,
    amplitudes: Array | None = None,
    opened: Array | None = None,
    groups: Array | None = None,
) -> MasslessHistory:
    """Step bodies with contact points without mass from a given state. Not collective.

    Args:
        points: The bodies; the gaps at rest are those of its links.
        motion: The motion of `points.assembly` with θ = ½; left at the last step. A step with
            contact is made in equal parts, so many that ω_c h is at most `points.resolved` in each.
        steps: Number of steps, n_t - 1.
        compliance: Diagonal of C, shape (m,) [m/N]; zero when None.
        displacement: z₀, shape (r,); default 0.
        velocity: ż₀, likewise.
        amplitudes: Of the loads at all times, shape (n_t, n_patterns), linear between.
        opened: Distance by which the gaps open, and its rate, shape (2, n_t, m); None at rest.
        groups: Columns that sum the forces of each group, shape (m, n_groups), for
            `MasslessHistory.largest`; each point alone when None.

    Raises:
        SolutionError: Numbers of the wrong shape, a start that penetrates, points whose
            flexibility is dependent, a response that is not finite.
    """
    m = motion.constraints
    total = points.flexibility + np.diag(np.zeros(m) if compliance is None else compliance)
    given = _Given(total, np.eye(m) if groups is None else groups)
    walls = Walls.of(motion, points.assembly.gaps, 0.0, opened)
    contact = _Contact(motion, walls, steps, given, points.resolved / points.corner)
    contact.run(displacement, velocity, amplitudes)
    return contact.history()
