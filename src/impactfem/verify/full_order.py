"""Reference: the θ rule of a structure in full order before unilateral constraints, on one rank.

With C = α M + β K, M̂ = (1 + θ h α) M + (θ h β + θ² h²) K. The step (see
:mod:`impactfem.coupling.unilateral`) is

    M̂ v_θ = r,   r = M v₀ + θ h (f_θ − K u₀) − θ G P,    (1)

    u₁ = u₀ + h v_θ,   v₁ = v₀ + (v_θ − v₀)/θ.    (2)
"""

from typing import Any

import numpy as np
import scipy.sparse

from impactfem.building.shell_model import petsc_matrix
from impactfem.coupling.contact_loop import check_rule, state_of
from impactfem.dynamics.damping import UNDAMPED, Rayleigh
from impactfem.dynamics.factorisation import Factorisation, Held
from impactfem.system.arrays import Array

THETA = 0.5


class FullMotion(Held):
    """A structure with its step, constraints, loads and probes. A context manager. Not collective.

    Args:
        K: Stiffness, symmetric, positive semidefinite, of `scipy.sparse`, shape (n, n) [N/m].
        M: Mass, symmetric, positive definite, on part of the pattern of K [kg].
        contact: G, an array or of `scipy.sparse`, shape (n, m).
        time_step: h [s].
        damping: The damping.
        patterns: Spatial patterns of the loads, shape (n, n_patterns); none when None.
        probes: L of the recorded motion, shape (n, n_probes); none when None.

    SolutionError where the step is not positive, or M̂ is not positive definite.
    """

    def __init__(
        self,
        K: Any,
        M: Any,
        contact: Any,
        time_step: float,
        *,
        damping: Rayleigh = UNDAMPED,
        patterns: Any = None,
        probes: Any = None,
    ) -> None:
        check_rule(time_step, THETA)
        self.time_step, self.theta, self.damping = time_step, THETA, damping
        self._K, self._M, n = K, M, K.shape[0]
        self._G, self._F, L = (
            scipy.sparse.csr_matrix((n, 0) if rows is None else rows)
            for rows in (contact, patterns, probes)
        )
        self.constraints, self.patterns = self._G.shape[1], self._F.shape[1]
        self._seen = scipy.sparse.hstack([self._G, L]).T.tocsr()
        step = THETA * time_step
        matrix = petsc_matrix((1.0 + step * damping.alpha) * M + step * (damping.beta + step) * K)
        self._factor = Factorisation(matrix, name="the matrix of the time step")
        matrix.destroy()
        self.displacement, self.velocity, self._force, self._r, self._mean = np.zeros((5, n))

    def destroy(self) -> None:
        """Free the memory of the factor."""
        self._factor.destroy()

    def delassus(self) -> Array:
        """W = Gᵀ M̂⁻¹ G, shape (m, m)."""
        W: Array = self._G.T @ self._factor.solve_block(self._G)
        return W

    def start(self, displacement: Array | None, velocity: Array | None) -> tuple[Array, Array]:
        """Set u and v, zero when None; gives [G L]ᵀ of both."""
        n = len(self.displacement)
        self.displacement = state_of(displacement, n, f"{n} rows")
        self.velocity = state_of(velocity, n, f"{n} rows")
        return self._seen @ self.displacement, self._seen @ self.velocity

    def free(self, amplitude: Array) -> Array:
        """Solve (1) for v_θ of a step without impulses; gives [G L]ᵀ v_θ."""
        self._force = self._F @ amplitude
        scale = self.theta * self.time_step
        self._r = self._M @ self.velocity + scale * (self._force - self._K @ self.displacement)
        return self._solve()

    def push(self, impulse: Array) -> Array:
        """Add impulses to the step; gives [G L]ᵀ v_θ."""
        self._r -= self.theta * (self._G @ impulse)
        return self._solve()

    def advance(self) -> tuple[float, ...]:
        """Make the step (2); gives kinetic, elastic, damped, radiated, lost and supplied energy."""
        h, theta, mean = self.time_step, THETA, self._mean
        jump = (mean - self.velocity) / theta
        self.displacement = self.displacement + h * mean
        self.velocity = self.velocity + jump
        inertia, restoring = float(mean @ (self._M @ mean)), float(mean @ (self._K @ mean))
        damped = h * (self.damping.alpha * inertia + self.damping.beta * restoring)
        lost = (theta - 0.5) * (float(jump @ (self._M @ jump)) + h**2 * restoring)
        return *self.stored(), damped, 0.0, lost, h * float(mean @ self._force)

    def stored(self) -> tuple[float, float]:
        """Kinetic and elastic energy [J]."""
        u, v = self.displacement, self.velocity
        return 0.5 * float(v @ (self._M @ v)), 0.5 * float(u @ (self._K @ u))

    def coast(self, amplitudes: Array) -> None:
        """None: one step after the other."""

    def keep(self, steps: int) -> None:
        """Do nothing: only steps of `coast` are kept."""

    def _solve(self) -> Array:
        self._mean = self._factor.solve_block(self._r[:, None])[:, 0]
        seen: Array = self._seen @ self._mean
        return seen
