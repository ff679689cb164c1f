"""The θ rule of modal equations before rigid walls: z̈ + (α + β λ) ż + λ z = b p(t) − Γ P.

All is diagonal but the constraints Γ = Φᵀ G (see `unilateral`): M̂ = 1 + θ h (α + β λ) + θ² h² λ.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.coupling.unilateral import check_rule
from impactfem.dynamics.damping import UNDAMPED, Rayleigh
from impactfem.system.errors import SolutionError

Array = NDArray[np.float64]


class ModalMotion:
    """Modal equations with their step, constraints, loads and probes. Not collective.

    Args:
        eigenvalue: λ, shape (r,) [1/s2].
        contact: Γ, modal rows of the constraints, shape (r, m).
        time_step: h [s].
        damping: The damping.
        theta: θ, from ½ to 1.
        load: b, shape (r, n_patterns); none when None.
        probes: Φᵀ L, modal rows of what is recorded, shape (r, n_probes); none when None.

    Raises:
        SolutionError: The step or θ is out of range; shapes that do not fit.
    """

    def __init__(
        self,
        eigenvalue: Array,
        contact: Array,
        time_step: float,
        *,
        damping: Rayleigh = UNDAMPED,
        theta: float = 0.5,
        load: Array | None = None,
        probes: Array | None = None,
    ) -> None:
        check_rule(time_step, theta)
        self.time_step, self.theta = time_step, theta
        self._lambda: Array = np.asarray(eigenvalue, dtype=np.float64)
        r = len(self._lambda)
        none: Array = np.empty((r, 0))
        given = {
            "constraints": contact,
            "loads": none if load is None else load,
            "probes": none if probes is None else probes,
        }
        for name, rows in given.items():
            if rows.ndim != 2 or len(rows) != r:
                raise SolutionError(f"{name} of shape {rows.shape} for {r} modes")
        self.constraints, self.patterns = contact.shape[1], given["loads"].shape[1]
        self._contact: Array = np.ascontiguousarray(contact, dtype=np.float64)
        self._load: Array = np.ascontiguousarray(given["loads"], dtype=np.float64)
        self._seen: Array = np.ascontiguousarray(np.hstack([contact, given["probes"]]).T)
        self._damping = damping.modal(self._lambda)
        self._pivot = 1.0 + theta * time_step * (self._damping + theta * time_step * self._lambda)
        self.displacement: Array = np.zeros(r)
        self.velocity: Array = np.zeros(r)
        self._mean: Array = np.zeros(r)
        self._force: Array = np.zeros(r)

    def delassus(self) -> Array:
        """W = Γᵀ M̂⁻¹ Γ, shape (m, m)."""
        root = self._contact / np.sqrt(self._pivot)[:, None]
        return np.asarray(root.T @ root, dtype=np.float64)

    def start(self, displacement: Array | None, velocity: Array | None) -> tuple[Array, Array]:
        """Set z and ż, zero when None; what is seen of both.

        Raises:
            SolutionError: One has another shape.
        """
        r = len(self._lambda)
        for given in (displacement, velocity):
            if given is not None and np.shape(given) != (r,):
                raise SolutionError(f"a state of shape {np.shape(given)} for {r} modes")
        self.displacement = np.zeros(r) if displacement is None else np.array(displacement, float)
        self.velocity = np.zeros(r) if velocity is None else np.array(velocity, float)
        return self._seen @ self.displacement, self._seen @ self.velocity

    def free(self, amplitude: Array) -> Array:
        """Find ż_θ of a step without impulses; what is seen of it."""
        self._force = self._load @ amplitude
        push = self._force - self._lambda * self.displacement
        self._mean = (self.velocity + self.theta * self.time_step * push) / self._pivot
        return np.asarray(self._seen @ self._mean, dtype=np.float64)

    def push(self, impulse: Array) -> Array:
        """Add impulses to the step; what is seen of its ż_θ."""
        self._mean = self._mean - self.theta * (self._contact @ impulse) / self._pivot
        return np.asarray(self._seen @ self._mean, dtype=np.float64)

    def advance(self) -> tuple[float, ...]:
        """Make the step; kinetic, elastic energy, and what was damped, lost and put in."""
        h, mean = self.time_step, self._mean
        jump = (mean - self.velocity) / self.theta
        self.velocity = self.velocity + jump
        self.displacement = self.displacement + h * mean
        lost = jump @ jump + h**2 * (mean @ (self._lambda * mean))
        return (
            *self.stored(),
            h * float(mean @ (self._damping * mean)),
            (self.theta - 0.5) * float(lost),
            h * float(mean @ self._force),
        )

    def stored(self) -> tuple[float, float]:
        """Kinetic and elastic energy [J]."""
        z, v = self.displacement, self.velocity
        return 0.5 * float(v @ v), 0.5 * float(z @ (self._lambda * z))
