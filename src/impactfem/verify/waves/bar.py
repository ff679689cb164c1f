"""A floor as a bar with end masses, or with walls below its ends, by a small solver.

Dense matrices of linear bar elements with M, K and C = α M + β K; NumPy and SciPy alone, none of
the program's elements, bases or contact solvers. What the bar is and where its data come from:
`impactfem.building.floor`.
"""

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from impactfem.dynamics.damping import UNDAMPED, Rayleigh
from impactfem.system.arrays import Array

ELEMENTS = 60
IN_WALL = 8  # elements of a wall over its height


@dataclass(frozen=True)
class EdgeWall:
    """A wall below an end of the bar that bends out of its plane: h [m], E I [N m2], mass [kg].

    It is clamped at the floor below; at the slab it is held along the bar and free to turn.
    """

    height: float
    bending: float
    mass: float


class Bar:
    """A free bar: L [m], EA' [N], its mass, and masses lumped at its ends [kg]."""

    def __init__(
        self,
        length: float,
        stiffness: float,
        mass: float,
        end_mass: tuple[float, float] = (0.0, 0.0),
        damping: Rayleigh = UNDAMPED,
        wall: EdgeWall | None = None,
    ) -> None:
        n = ELEMENTS
        self.position = np.linspace(0.0, length, n + 1)
        of_wall = 0 if wall is None else 2 * IN_WALL - 1
        size = n + 1 + 2 * of_wall
        K, M = np.zeros((size, size)), np.zeros((size, size))
        ends = np.diff(np.eye(n + 1), axis=0)  # of each element: -1 and 1
        K[: n + 1, : n + 1] = stiffness * n / length * ends.T @ ends
        both = np.abs(ends)
        M[: n + 1, : n + 1] = mass / n / 6.0 * (both.T @ both + np.diag(both.sum(axis=0)))
        M[0, 0] += end_mass[0]
        M[n, n] += end_mass[1]
        if wall is not None:
            _hang(K, M, wall, 0, n + 1)
            _hang(K, M, wall, n, n + 1 + of_wall)
        self.K, self.M = K, M
        self.C = damping.matrix(self.K, self.M)
        self.mass = mass + sum(end_mass)

    def frequencies(self, count: int) -> Array:
        """The lowest frequencies, that of the rigid motion included, shape (count,) [Hz]."""
        values = scipy.linalg.eigvalsh(self.K, self.M, subset_by_index=(0, count - 1))
        return np.asarray(np.sqrt(np.maximum(values, 0.0)) / (2.0 * math.pi))

    def pushed(self, force: Array, step: float, distance: Array) -> Array:
        """Accelerations at distances from its lower end, on which a force acts, (n, n_t) [m/s2].

        Average acceleration, in 20 steps between samples of the force, straight there (n_t,) [N].
        """
        parts = 20
        h = step / parts
        fine = np.arange((len(force) - 1) * parts + 1) / parts
        fine = np.interp(fine, np.arange(len(force)), force)
        factor = scipy.linalg.cho_factor(self.M + h / 2.0 * self.C + h * h / 4.0 * self.K)
        u, v, a = (np.zeros(len(self.M)) for _ in range(3))
        nodes = len(self.position)
        found = np.zeros((len(force), nodes))
        for k, value in enumerate(fine):
            u, v = u + h * v + h * h / 4.0 * a, v + h / 2.0 * a
            load = -self.C @ v - self.K @ u
            load[0] += value
            a = scipy.linalg.cho_solve(factor, load)
            u, v = u + h * h / 4.0 * a, v + h / 2.0 * a
            if k % parts == 0:
                found[k // parts] = a[:nodes]
        return np.array([[np.interp(d, self.position, row) for row in found] for d in distance])

    def against_wall(self, speed: float, step: float, window: float = 0.05) -> tuple[float, float]:
        """The bar meets a rigid wall with its lower end, all of it at one speed [m/s].

        Each step first goes free; where the end would then be behind the wall, an impulse stops it
        there. What moves the end has the mass of its element, which loses its energy. Gives the
        impulse on the wall [N s], and the time from the touch to the last of it [s].
        """
        size, h = len(self.M), step
        factor = scipy.linalg.cho_factor(self.M + h / 2.0 * self.C + h * h / 4.0 * self.K)
        unit = np.zeros(size)
        unit[0] = 1.0
        response = scipy.linalg.cho_solve(factor, unit)
        u, v, nodes = np.zeros(size), np.zeros(size), len(self.position)
        v[:nodes] = -speed
        if size > nodes:  # its walls move in their static shape
            K = self.K[nodes:]
            v[nodes:] = -np.linalg.solve(K[:, nodes:], K[:, :nodes] @ v[:nodes])
        total = last = 0.0
        for k in range(round(window / h)):
            # M (v1 − v0) = −h (C v + K u) at the middle of the step, towards the wall negative.
            change = scipy.linalg.cho_solve(factor, -h * (self.C @ v + self.K @ (u + h / 2.0 * v)))
            end = v[0] + change[0]
            if u[0] <= 0.0 and end < 0.0:
                change -= end / response[0] * response
                total += -end / response[0]
                last = (k + 1) * h
            u = u + h * (v + change / 2.0)
            v = v + change
        return total, last


def _hang(K: Array, M: Array, wall: EdgeWall, top: int, first: int) -> None:
    """Add the beam of a wall below an end, its own rows from `first` on."""
    # In (w, l θ), which leaves the length of an element out of the matrices.
    EI, m = wall.bending, wall.mass / IN_WALL
    # Hermite's element: Przemieniecki, Theory of Matrix Structural Analysis (1968).
    k = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    k = EI * (IN_WALL / wall.height) ** 3 * k
    mass = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    # Rows: rotation at the top, then both of each node below.
    rows = [(top, first), *((first + 1 + 2 * j, first + 2 + 2 * j) for j in range(IN_WALL - 1))]
    for j in range(IN_WALL - 1):
        part = np.ix_((*rows[j], *rows[j + 1]), (*rows[j], *rows[j + 1]))
        K[part] += k
        M[part] += m / 420.0 * mass
    part = np.ix_(rows[-1], rows[-1])  # the lowest element, clamped at its foot
    K[part] += k[:2, :2]
    M[part] += m / 420.0 * mass[:2, :2]
