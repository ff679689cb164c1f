"""Series solutions of cylindrical shells between diaphragms, to compare finite elements with.

Shear-flexible (Naghdi) shell of radius R on 0 ≤ x ≤ L, with the angle φ around the axis.
Displacements u along x, v along φ, w outwards; rotations as slopes β_x, β_φ. Strains, with
u_φ = ∂u/∂φ and u_x = ∂u/∂x:

    membrane  ε_x = u_x,   ε_φ = (v_φ + w) / R,   γ_xφ = u_φ / R + v_x
    bending   κ_x = β_x,x, κ_φ = β_φ,φ / R,
              κ_xφ = β_x,φ / R + β_φ,x + (v_x − u_φ / R) / (2 R)
    shear     γ_x = w_x + β_x,   γ_φ = (w_φ − v) / R + β_φ

Diaphragms carry v, w and β_φ, and leave u and β_x free, so that with k = n π / L each term
u, β_x ~ cos k x and v, w, β_φ ~ sin k x stands alone (Fluegge, Stresses in Shells, 1960; Naghdi,
The theory of shells and plates, 1972). Around φ the fields are sums of given functions, by the
method of Ritz.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import eval_legendre, roots_legendre

from impactfem.building.section import Material

Array = NDArray[np.float64]
Basis = Callable[[Array], tuple[Array, Array]]
"""Functions of φ and their derivatives at some angles, each of shape (points, functions)."""

SHEAR = 5.0 / 6.0
POINTS = 80  # of the integration over φ


@dataclass(frozen=True)
class Cylinder:
    """A cylindrical panel, 0 ≤ φ ≤ span.

    Args:
        material: E and ν.
        thickness: t [m].
        radius: R [m].
        length: L, between the diaphragms [m].
        span: Angle of the panel, with symmetry at φ = 0 [rad].
        shear: Factor κ of the shear stiffness κ G t.
    """

    material: Material
    thickness: float
    radius: float
    length: float
    span: float
    shear: float = SHEAR

    def term(
        self, n: int, even: Basis, odd: Basis, pressure: Callable[[Array], tuple[Array, Array]]
    ) -> tuple[Array, Array, float]:
        """Amplitudes under the load term sin(n π x / L).

        Args:
            n: Number of half waves along x.
            even: Functions of φ for u, w and β_x.
            odd: Functions of φ for v and β_φ.
            pressure: Amplitudes of the load along v and w at some angles [N/m2].

        Returns:
            Coefficients of v and of w, and the work of the load amplitudes on the displacement
            amplitudes around the panel, for unit length [N].
        """
        s, weights = roots_legendre(POINTS)
        phi, dA = 0.5 * self.span * (s + 1.0), 0.5 * self.span * self.radius * weights
        R, k = self.radius, n * np.pi / self.length
        (c, dc), (d, dd) = even(phi), odd(phi)
        n_even, n_odd = c.shape[1], d.shape[1]
        starts = np.cumsum([0, n_even, n_odd, n_even, n_even, n_odd])
        u, v, w, bx, bf = (slice(*ends) for ends in itertools.pairwise(starts))
        B = np.zeros((len(phi), 8, int(starts[-1])))
        B[:, 0, u] = -k * c
        B[:, 1, v], B[:, 1, w] = dd / R, c / R
        B[:, 2, u], B[:, 2, v] = dc / R, k * d
        B[:, 3, bx] = -k * c
        B[:, 4, bf] = dd / R
        B[:, 5, bx], B[:, 5, bf] = dc / R, k * d
        B[:, 5, u], B[:, 5, v] = -0.5 * dc / R**2, 0.5 * k * d / R
        B[:, 6, w], B[:, 6, bx] = k * c, c
        B[:, 7, w], B[:, 7, v], B[:, 7, bf] = dc / R, -d / R, d
        weighted = dA[:, None, None] * (self._elasticity() @ B)
        K = B.reshape(-1, B.shape[2]).T @ weighted.reshape(-1, B.shape[2])
        along, outwards = pressure(phi)
        load = np.zeros(len(K))
        load[v], load[w] = (dA * along) @ d, (dA * outwards) @ c
        found = np.linalg.solve(K, load)
        return found[v], found[w], float(load @ found)

    def _elasticity(self) -> Array:
        E, nu, t = self.material.E, self.material.nu, self.thickness
        plane = E / (1.0 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, 0.5 * (1.0 - nu)]])
        D = np.zeros((8, 8))
        D[:3, :3], D[3:6, 3:6] = t * plane, t**3 / 12.0 * plane
        D[6:, 6:] = self.shear * self.material.G * t * np.eye(2)
        return D


def wave(m: int) -> tuple[Basis, Basis]:
    """One wave around the cylinder: cos m φ and sin m φ."""

    def even(phi: Array) -> tuple[Array, Array]:
        return np.cos(m * phi)[:, None], -m * np.sin(m * phi)[:, None]

    def odd(phi: Array) -> tuple[Array, Array]:
        return np.sin(m * phi)[:, None], m * np.cos(m * phi)[:, None]

    return even, odd


def polynomials(span: float, count: int) -> tuple[Basis, Basis]:
    """The first even and the first odd Legendre polynomials of φ / span, `count` of each."""
    degree = np.arange(2 * count)
    # P′_n = (2 n − 1) P_{n−1} + (2 n − 5) P_{n−3} + ...
    below = degree[None, :] - degree[:, None]
    derivative = np.where((below > 0) & (below % 2 == 1), 2 * degree[:, None] + 1, 0)

    def basis(first: int) -> Basis:
        def functions(phi: Array) -> tuple[Array, Array]:
            values = eval_legendre(degree, (phi / span)[:, None])
            return values[:, first::2], (values @ derivative)[:, first::2] / span

        return functions

    return basis(0), basis(1)


def weighed(roof: Cylinder, weight: float, terms: int = 20, count: int = 24) -> tuple[float, float]:
    """A roof under a vertical load, from its crown φ = 0 to its free edge.

    Args:
        roof: The roof.
        weight: Load on the area, downwards [N/m2].
        terms: Number of terms along x.
        count: Number of even, and of odd, functions around φ.

    Returns:
        Deflection of the middle of the free edge, downwards [m], and the work of the load on a
        quarter of the roof [J].
    """
    even, odd = polynomials(roof.span, count)
    edge = np.array([roof.span])
    deflection = total = 0.0

    def downwards(phi: Array) -> tuple[Array, Array]:
        return np.sin(phi), -np.cos(phi)

    for n in range(1, 2 * terms, 2):
        q = 4.0 * weight / (n * np.pi)  # of the sine series of a uniform load
        v, w, work = roof.term(n, even, odd, downwards)
        at_edge = float(odd(edge)[0][0] @ v) * np.sin(roof.span)
        at_edge -= float(even(edge)[0][0] @ w) * np.cos(roof.span)
        deflection += q * at_edge * np.sin(0.5 * n * np.pi)
        total += q**2 * work * 0.25 * roof.length  # ∫ sin² over half the length
    return float(deflection), float(total)
