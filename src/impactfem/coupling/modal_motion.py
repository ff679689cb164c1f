"""Bodies with their step, loads and probes, for the loops of unilateral contact."""

from __future__ import annotations

import numpy as np

from impactfem.coupling.body import reduced_body
from impactfem.coupling.contact_loop import check_rule, state_of
from impactfem.coupling.free_flight import FreeFlight, State
from impactfem.coupling.links import Assembly, Link
from impactfem.dynamics.damping import UNDAMPED, Damping
from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError


def body_before_walls(
    eigenvalue: Array, contact: Array, damping: Damping = UNDAMPED, gap: float = 0.0
) -> Assembly:
    """Return a body of λ, shape (r,) [1/s2], with links to rigid walls of modal rows, (r, m).

    The gap of the links [m] counts where no other gaps are given.
    """
    r = len(eigenvalue)
    if contact.ndim != 2 or len(contact) != r:
        raise SolutionError(f"constraints of shape {contact.shape} for {r} modes")
    m = contact.shape[1]
    body = reduced_body("body", eigenvalue, damping, {"wall": contact.T})
    links = [Link(str(k), ("body", "wall"), None, n, gap) for k, n in enumerate(np.eye(m))]
    return Assembly([body], links)


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
        self._flight = FreeFlight(assembly, time_step, theta)
        self._inverse = self._flight.inverse
        # Responses to unit impulses: columns M̂⁻¹ G of the bodies, and of what is attached.
        pushed = self._inverse.solve(self._contact.T, np.zeros((self.constraints, N)))
        self._pushed, self._pushed_y = pushed[0].T, pushed[1].T
        self.displacement, self.velocity, self._mean, self._force = np.zeros((4, r))
        self._y, self._y_velocity, self._y_mean, self._y_force = np.zeros((4, N))
        self._coasted = State(*(np.zeros((n, 0)) for n in (r, r, N, N)))

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
        """Make the step; see `Motion`."""
        h, all_, one = self.time_step, self.assembly, self.assembly.attached
        mean, y_mean = self._mean, self._y_mean
        jump = (mean - self.velocity) / self.theta
        y_jump = (y_mean - self._y_velocity) / self.theta
        self.velocity, self._y_velocity = self.velocity + jump, self._y_velocity + y_jump
        self.displacement, self._y = self.displacement + h * mean, self._y + h * y_mean
        lost = jump @ (all_.mass * jump) + y_jump @ one.M @ y_jump
        lost += h**2 * (mean @ (all_.eigenvalue * mean) + y_mean @ one.K @ y_mean)
        radiated = h * float(y_mean @ one.radiation @ y_mean)
        return (
            *self.stored(),
            h * float(mean @ (all_.damping * mean) + y_mean @ one.C @ y_mean) - radiated,
            radiated,
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

    def coast(self, amplitudes: Array) -> tuple[Array, Array, Array]:
        """See `Motion`."""
        load, push = self._load @ amplitudes.T, self._push @ amplitudes.T
        before = State(self.displacement, self.velocity, self._y, self._y_velocity)
        self._coasted = self._flight.steps(before, load, push)
        energies = self._flight.energies(before, self._coasted, load, push)
        seen = (self._seen @ np.column_stack([self.velocity, self._coasted.v])).T
        mean = (1.0 - self.theta) * seen[:-1] + self.theta * seen[1:]
        moved = self._seen @ self.displacement + self.time_step * np.cumsum(mean, axis=0)
        return moved, seen[1:], energies

    def keep(self, steps: int) -> None:
        """Make the first of the steps that `coast` tried."""
        after = self._coasted.after(steps)
        self.displacement, self.velocity, self._y, self._y_velocity = after
