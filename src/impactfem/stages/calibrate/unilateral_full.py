"""The θ rule of a structure in full order before rigid walls, on any number of ranks.

With C = α M + β K, M̂ = (1 + θ h α) M + (θ h β + θ² h²) K. The step (see `unilateral`) is

    M̂ v_θ = r,   r = M v₀ + θ h (f_θ − K u₀) − θ G P,

    u₁ = u₀ + h v_θ,   M v₁ = (M v_θ − (1 − θ) M v₀)/θ,   K u₁ = K u₀ + h K v_θ:

one solve and one product, M v_θ, make it, and K v_θ follows from M̂ v_θ = r. With impulses it takes
a second solve: M̂⁻¹ G would be as fast, but is as large as the basis of a reduced model.
"""

from typing import Any

import numba
import numpy as np
import scipy.sparse
from petsc4py import PETSc

from impactfem.coupling.unilateral import check_rule, state_of
from impactfem.dynamics.columns import combined, inner, product, wrapped
from impactfem.dynamics.damping import UNDAMPED, Rayleigh
from impactfem.dynamics.factorisation import BLOCK, Factorisation, Held
from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError


class FullMotion(Held):
    """A structure with its step, constraints, loads and probes. A context manager.

    Args:
        K: Stiffness, symmetric, positive semidefinite (AIJ): the structure may be free.
        M: Mass, symmetric, positive definite (AIJ), on part of the pattern of K.
        contact: G, rows of this rank, shape (n_local, m), an array or of `scipy.sparse`.
        time_step: h [s].
        damping: The damping.
        theta: θ, from ½ to 1.
        patterns: Rows of this rank of the spatial patterns of the loads, shape
            (n_local, n_patterns); none when None.
        probes: L, rows of this rank of what is recorded, shape (n_local, n_probes), an array or of
            `scipy.sparse`; none when None.

    Raises:
        SolutionError: The step or θ is out of range; shapes that do not fit; M̂ is not positive
            definite.

    Making one and all methods are collective.
    """

    def __init__(
        self,
        K: PETSc.Mat,
        M: PETSc.Mat,
        contact: Any,
        time_step: float,
        *,
        damping: Rayleigh = UNDAMPED,
        theta: float = 0.5,
        patterns: Array | None = None,
        probes: Any = None,
    ) -> None:
        check_rule(time_step, theta)
        self.time_step, self.theta = time_step, theta
        self._K, self._M = K, M
        self._comm = K.getComm().tompi4py()
        n = K.getLocalSize()[0]
        none = scipy.sparse.csr_matrix((n, 0))
        G, L, F = (
            none if rows is None else scipy.sparse.csr_matrix(rows)
            for rows in (contact, probes, patterns)
        )
        for name, rows in (("constraints", G), ("probes", L), ("loads", F)):
            if rows.shape[0] != n:
                raise SolutionError(f"{name} of shape {rows.shape} for {n} rows of this rank")
        self.constraints, self.patterns = G.shape[1], F.shape[1]
        self._G, self._F = G, F
        self._seen = scipy.sparse.hstack([G, L]).T.tocsr()
        self._mass = 1.0 + theta * time_step * damping.alpha
        self._stiffness = theta * time_step * (damping.beta + theta * time_step)
        self._rates = damping.alpha, damping.beta
        matrix = combined(self._stiffness, K, self._mass, M)
        self._factor = Factorisation(matrix, name="the matrix of the time step")
        matrix.destroy()
        self.displacement, self.velocity, self._momentum, self._restoring = np.zeros((4, n))
        self._force, self._r, self._mean, self._M_mean = np.zeros((4, n))
        self._vectors = [wrapped(M, array) for array in (self._r, self._mean, self._M_mean)]

    def destroy(self) -> None:
        """Free the memory; the structure is of no use afterwards."""
        for vector in self._vectors:
            vector.destroy()
        self._factor.destroy()

    def delassus(self) -> Array:
        """W = Gᵀ M̂⁻¹ G, shape (m, m)."""
        m = self.constraints
        W: Array = np.empty((m, m))
        for first in range(0, m, BLOCK):
            part = slice(first, min(first + BLOCK, m))
            W[:, part] = self._G.T @ self._factor.solve_block(self._G[:, part].toarray())
        total: Array = self._comm.allreduce(W)
        return total

    def start(self, displacement: Array | None, velocity: Array | None) -> tuple[Array, Array]:
        """Set u and v, rows of this rank, zero when None; what is seen of both.

        A SolutionError where one has another shape.
        """
        n = len(self.displacement)
        self.displacement = state_of(displacement, n, f"{n} rows of this rank")
        self.velocity = state_of(velocity, n, f"{n} rows of this rank")
        self._momentum = product(self._M, self.velocity[:, None])[:, 0]
        self._restoring = product(self._K, self.displacement[:, None])[:, 0]
        return self._look(self.displacement), self._look(self.velocity)

    def free(self, amplitude: Array) -> Array:
        """Find v_θ of a step without impulses; what is seen of it."""
        self._force = self._F @ amplitude
        scale = self.theta * self.time_step
        np.multiply(scale, self._force - self._restoring, out=self._r)
        self._r += self._momentum
        return self._solve()

    def push(self, impulse: Array) -> Array:
        """Add impulses to the step; what is seen of its v_θ."""
        self._r -= self.theta * (self._G @ impulse)
        return self._solve()

    def advance(self) -> tuple[float, ...]:
        """Make the step; kinetic, elastic energy, and what was damped, lost and put in."""
        _, mean, M_mean = self._vectors
        self._M.mult(mean, M_mean)
        mine = _advance(
            *(self.time_step, self.theta, *self._rates, self._mass, self._stiffness),
            *(self._force, self._r, self._mean, self._M_mean),
            *(self.displacement, self.velocity, self._momentum, self._restoring),
        )
        return tuple(float(x) for x in self._comm.allreduce(np.array(mine)))

    def coast(self, amplitudes: Array) -> None:
        """None: one step after the other."""

    def keep(self, steps: int) -> None:
        """Of no use without `coast`."""

    def stored(self) -> tuple[float, float]:
        """Kinetic and elastic energy [J]."""
        u, v = self.displacement[:, None], self.velocity[:, None]
        kinetic = inner(self._M, v, self._momentum[:, None])
        elastic = inner(self._K, u, self._restoring[:, None])
        return 0.5 * float(kinetic[0, 0]), 0.5 * float(elastic[0, 0])

    def _solve(self) -> Array:
        right, mean, _ = self._vectors
        self._factor.solve(right, mean)
        return self._look(self._mean)

    def _look(self, x: Array) -> Array:
        """[G L]ᵀ x over all ranks."""
        total: Array = self._comm.allreduce(self._seen @ x)
        return total


@numba.njit(cache=True)
def _advance(
    h: float,
    theta: float,
    alpha: float,
    beta: float,
    mass: float,
    stiffness: float,
    f: Array,
    r: Array,
    mean: Array,
    M_mean: Array,
    u: Array,
    v: Array,
    p: Array,
    q: Array,
) -> tuple[float, float, float, float, float]:
    """Move u, v, p = M v and q = K u on by one step; energies as the method gives them."""
    kinetic, elastic, damped, lost, put_in = 0.0, 0.0, 0.0, 0.0, 0.0
    # Sums of short sums: the rounding of one long sum would show in the balance of energy.
    for first in range(0, u.size, 512):
        k, e, d, g, s = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(first, min(first + 512, u.size)):
            K_mean = (r[i] - mass * M_mean[i]) / stiffness
            jump = (mean[i] - v[i]) / theta
            M_jump = (M_mean[i] - p[i]) / theta
            d += mean[i] * (alpha * M_mean[i] + beta * K_mean)
            g += jump * M_jump + h * h * mean[i] * K_mean
            s += mean[i] * f[i]
            v[i] += jump
            p[i] += M_jump
            u[i] += h * mean[i]
            q[i] += h * K_mean
            k += v[i] * p[i]
            e += u[i] * q[i]
        kinetic += k
        elastic += e
        damped += d
        lost += g
        put_in += s
    return 0.5 * kinetic, 0.5 * elastic, h * damped, (theta - 0.5) * lost, h * put_in
