"""What is recorded of a structure that moves between unilateral constraints, and its energies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ContactEnergy:
    """Energies at each time, shape (n_t,) each [J].

    The θ rule satisfies exactly, step by step, with v_θ = (1 − θ) v₀ + θ v₁ and the same for u, f,

        Δ(½ vᵀ M v) + Δ(½ uᵀ K u) + h v_θᵀ C v_θ + (θ − ½) (Δvᵀ M Δv + Δuᵀ K Δu)
            = h v_θᵀ f_θ − v_θᵀ G P.

    Args:
        kinetic: ½ vᵀ M v.
        elastic: ½ uᵀ K u.
        damped: What the damping has taken since step 0.
        numerical: What the rule has taken since step 0, zero for θ = ½.
        input: Work of the loads since step 0.
        contact: Work of the contact impulses since step 0, never positive but for rounding.
    """

    kinetic: Array
    elastic: Array
    damped: Array
    numerical: Array
    input: Array
    contact: Array

    @property
    def scale(self) -> float:
        """Largest energy that is there or came in [J]."""
        stored = float(np.max(self.kinetic + self.elastic))
        return max(stored, float(np.max(np.abs(self.input))))

    @property
    def residual(self) -> float:
        """Largest violation of the identity over the largest energy [-]."""
        balance = self.kinetic + self.elastic + self.damped + self.numerical
        balance = balance - self.input - self.contact
        return float(np.max(np.abs(balance - balance[0])) / self.scale) if self.scale > 0.0 else 0.0

    @property
    def gained(self) -> float:
        """Largest work that the contact put in within a step, over the largest energy [-]."""
        most = float(np.max(np.diff(self.contact), initial=0.0))
        return most / self.scale if self.scale > 0.0 else 0.0


@dataclass(frozen=True, eq=False)
class ContactHistory:
    """The response between unilateral constraints, the same on all ranks.

    Args:
        time: Shape (n_t,) [s].
        impulse: P of each constraint in the step that ends at the time, shape (n_t, m) [N s for
            columns of G without a unit]; the first row is zero. P / h is the mean force of the
            step, and G P / h that on the structure.
        gap: γ − Gᵀ u, shape (n_t, m) [m for such columns].
        displacement: Lᵀ u of the probes, shape (n_t, n_probes).
        velocity: Lᵀ v of the probes, shape (n_t, n_probes).
        residual: How far velocities and impulses after the step are from complementary: the
            largest of min(w, P) over the constraints that take part, each made comparable by the
            diagonal of the Delassus operator, over the largest speed of a constraint so far,
            shape (n_t,) [-].
        energy: The energies.
    """

    time: Array
    impulse: Array
    gap: Array
    displacement: Array
    velocity: Array
    residual: Array
    energy: ContactEnergy

    @property
    def force(self) -> Array:
        """P / h, shape (n_t, m): mean of the step that ends at the time [N as P is in N s]."""
        return np.asarray(self.impulse / (self.time[1] - self.time[0]), dtype=np.float64)

    @property
    def penetration(self) -> Array:
        """How far each constraint is violated at most, shape (m,), in the unit of the gap."""
        return np.asarray(np.maximum(0.0, -self.gap.min(axis=0)), dtype=np.float64)
