"""Shell parts: flat Reissner–Mindlin facets with drilling rotations, as UFL forms.

Displacement of a point at the height ζ above the mid-surface, with the facet's frame
(e1, e2, e3): u + ζ θ × e3. Strains, with the in-plane gradient ∇:

    membrane   ε = sym ∇(u1, u2)
    bending    κ = sym ∇β,  β = ((θ × e3)·e1, (θ × e3)·e2) = (θ·e2, −θ·e1)
    shear      γ = ∇u3 + β
    drilling   ω = ½ (∂1 u2 − ∂2 u1) − θ·e3

Forces, with D(ε) = E / (1 − ν²) ((1 − ν) ε + ν tr(ε) I), μ = E / (2 (1 + ν)) and k = 5/6 μ t:

    N = t D(ε),   M = t³/12 D(κ),   Q = (k⁻¹ + τ)⁻¹ (Rγ + τ div M)

Energy of an area:

    ½ ∫ N:ε + M:κ − div M·τ div M + Q·(k⁻¹ + τ) Q + c μ t ω²  dA

Quadratic u3 and β lock in thin plates when γ counts as it is. So γ is reduced and stabilised as in
the element MITC7 (Bathe, Brezzi and Cho 1989; analysed by Brezzi, Fortin and Stenberg 1991):

- Rγ is the Nédélec field of 8 parameters that has γ's mean over the triangle and, along each side,
  the mean and the first moment of γ's tangential part. R leaves linear fields as they are: all of
  ∇u3 stays, and of β its second derivatives say what goes (`_reduced`).
- τ is the flexibility of a cubic bubble β = v b, b = 27 λ1 λ2 λ3 and v constant on the triangle,
  whose reduced shear counts by its mean, 9/20 v: τ = (9/20)² a⁻¹ with its bending stiffness per
  area a = ∫ M(b ei):κ(b ej) dA / A (`_flexibility`). Eliminated where Rγ is constant, the bubble
  leaves the energy above, which has this form for all of Rγ. In an equilateral triangle of the
  side h the shear stiffness is k t² / (t² + c h²), as of Lyly, Stenberg and Vihinen (1993), with
  c = (1 − ν) / (4 (3 − ν)). Never is div M·τ div M more than the bending energy.

What τ adds vanishes where Q = div M, so that nothing is lost where t is large beside h (Stenberg
1995). Nothing depends on the numbering of the vertices, and no size of a triangle has to
be chosen. The drilling energy is integrated in full: with the rule of degree 2 quadratic drilling
modes cost nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ufl
import ufl.geometry

SHEAR = 5.0 / 6.0
FULL, REDUCED = 4, 2
"""Quadrature degrees: full for products of P2 values, reduced for products of their gradients,
which it integrates exactly."""
SIDES = ((1, 2), (2, 0), (0, 1))
"""Vertices of the sides of a triangle; side k is opposite to the vertex k."""

Frame = tuple[Any, Any, Any]


@dataclass(frozen=True)
class ShellFields:
    """What the shell forms need, constant on each cell or on all."""

    thickness: Any  #: t [m]
    young_modulus: Any  #: E [Pa]
    poisson_ratio: Any  #: ν
    density: Any  #: ρ [kg/m3]
    added_mass: Any  #: mass on the area that neither stiffens nor has rotary inertia [kg/m2]
    drilling: Any  #: factor c of the drilling energy

    @property
    def shear_modulus(self) -> Any:
        """Shear modulus μ [Pa]."""
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def bending_stiffness(self) -> Any:
        """E t³ / (12 (1 − ν²)) [N m]."""
        return self.young_modulus * self.thickness**3 / (12.0 * (1.0 - self.poisson_ratio**2))

    def stiffness(self, space: Any) -> Any:
        """Stiffness form on a P2 space on triangles with six components (u, θ)."""
        mesh = space.mesh
        trial, test = (
            _Strains(w, _frame(mesh), mesh, self)
            for w in (ufl.TrialFunction(space), ufl.TestFunction(space))
        )
        full, reduced = (
            ufl.dx(mesh, metadata={"quadrature_degree": degree}) for degree in (FULL, REDUCED)
        )
        N, M, Q = trial.forces()
        drilling = self.drilling * self.shear_modulus * self.thickness
        return (
            ufl.inner(N, test.membrane)
            + ufl.inner(M, test.bending)
            - ufl.inner(ufl.dot(trial.tau, trial.moment_divergence), test.moment_divergence)
        ) * reduced + (
            ufl.inner(Q, test.stabilised_shear) + drilling * trial.drilling * test.drilling
        ) * full

    def mass(self, space: Any) -> Any:
        """Consistent mass form on such a space: (ρ t + added) u·v + ρ t³/12 θ·ψ.

        The rotary inertia acts on all of θ, drilling included, so that M is positive definite.
        """
        t, rho = self.thickness, self.density
        (u, theta), (v, psi) = halves(ufl.TrialFunction(space)), halves(ufl.TestFunction(space))
        translation = (rho * t + self.added_mass) * ufl.inner(u, v)
        full = ufl.dx(space.mesh, metadata={"quadrature_degree": FULL})
        return (translation + rho * t**3 / 12.0 * ufl.inner(theta, psi)) * full

    def section_forces(self, w: Any, plane: Any) -> Any:
        """N11, N22, N12 [N/m], M11, M22, M12 [N], Q1, Q2 [N/m] of a displacement, as one vector.

        `w` is a function of such a space, `plane` orthonormal vectors e1 and e2 in the plane of
        each facet, as six components.
        """
        e1, e2 = (ufl.as_vector([plane[k + i] for i in range(3)]) for k in (0, 3))
        frame = e1, e2, ufl.cross(e1, e2)
        N, M, Q = _Strains(w, frame, w.function_space.mesh, self).forces()
        return ufl.as_vector([N[0, 0], N[1, 1], N[0, 1], M[0, 0], M[1, 1], M[0, 1], Q[0], Q[1]])


def halves(w: Any) -> tuple[Any, Any]:
    """Displacement u and rotation θ of a six-component field."""
    u = ufl.as_vector([w[0], w[1], w[2]])
    theta = ufl.as_vector([w[3], w[4], w[5]])
    return u, theta


def _frame(mesh: Any) -> Frame:
    """The facet's orthonormal frame: e1 along its first edge, e3 normal."""
    J = ufl.Jacobian(mesh)
    t1 = ufl.as_vector([J[i, 0] for i in range(3)])
    t2 = ufl.as_vector([J[i, 1] for i in range(3)])
    normal = ufl.cross(t1, t2)
    e3 = normal / ufl.sqrt(ufl.dot(normal, normal))
    e1 = t1 / ufl.sqrt(ufl.dot(t1, t1))
    return e1, ufl.cross(e3, e1), e3


class _Strains:
    """Strains of a six-component field in a facet's frame, and the forces they cause."""

    def __init__(self, w: Any, frame: Frame, mesh: Any, fields: ShellFields) -> None:
        e1, e2, e3 = frame
        plane = (e1, e2)
        u, theta = halves(w)
        grad_u, grad_theta = ufl.grad(u), ufl.grad(theta)
        self._fields = fields
        # β1 = θ·e2, β2 = −θ·e1, and their first and second derivatives along e1 and e2.
        turned = (e2, -e1)
        beta = [ufl.dot(theta, a) for a in turned]
        d_beta = ufl.as_matrix(
            [[ufl.dot(a, ufl.dot(grad_theta, b)) for b in plane] for a in turned]
        )
        # ∂b ∂c β_a as a tensor [a, b, c].
        second = ufl.grad(grad_theta)
        dd_beta = ufl.as_tensor(
            [
                [[ufl.dot(a, ufl.dot(ufl.dot(second, c), b)) for c in plane] for b in plane]
                for a in turned
            ]
        )
        du = ufl.as_matrix([[ufl.dot(a, ufl.dot(grad_u, b)) for b in plane] for a in plane])
        self.shear = ufl.as_vector(
            [ufl.dot(e3, ufl.dot(grad_u, a)) + b for a, b in zip(plane, beta, strict=True)]
        )
        triangle = _Triangle(mesh, frame)
        self.membrane = ufl.sym(du)
        self.bending = ufl.sym(d_beta)
        self.drilling = 0.5 * (du[1, 0] - du[0, 1]) - ufl.dot(theta, e3)
        # τ = (9/20)² a⁻¹ = (20 D_b ((1 − ν)/2 tr G I + (1 + ν)/2 G))⁻¹, G = Σ ∇λ ⊗ ∇λ: for the
        # bubble b, ∫ ∇b ⊗ ∇b dA / A = 81/20 G, and its mean is 9/20.
        nu = fields.poisson_ratio
        G = sum(ufl.outer(g, g) for g in triangle.gradients)
        shape = 0.5 * (1.0 - nu) * ufl.tr(G) * ufl.Identity(2) + 0.5 * (1.0 + nu) * G
        self.tau = ufl.inv(20.0 * fields.bending_stiffness * shape)
        # div M = D_b ((1 − ν)/2 Δβ + (1 + ν)/2 ∇ div β).
        self.moment_divergence = fields.bending_stiffness * ufl.as_vector(
            [
                0.5 * (1.0 - nu) * (dd_beta[a, 0, 0] + dd_beta[a, 1, 1])
                + 0.5 * (1.0 + nu) * (dd_beta[0, a, 0] + dd_beta[1, a, 1])
                for a in range(2)
            ]
        )
        self.stabilised_shear = _reduced(self.shear, dd_beta, triangle) + ufl.dot(
            self.tau, self.moment_divergence
        )

    def forces(self) -> tuple[Any, Any, Any]:
        """N, M and Q."""
        t, E, nu = self._fields.thickness, self._fields.young_modulus, self._fields.poisson_ratio
        k = SHEAR * self._fields.shear_modulus * t

        def stress(strain: Any) -> Any:
            identity = ufl.Identity(2)
            return E / (1.0 - nu**2) * ((1.0 - nu) * strain + nu * ufl.tr(strain) * identity)

        shear_stiffness = ufl.inv(ufl.Identity(2) / k + self.tau)
        return (
            t * stress(self.membrane),
            t**3 / 12.0 * stress(self.bending),
            ufl.dot(shear_stiffness, self.stabilised_shear),
        )


class _Triangle:
    """A facet's sides, area coordinates λ and their gradients, in its frame."""

    def __init__(self, mesh: Any, frame: Frame) -> None:
        plane = frame[:2]
        corners = ufl.geometry.CellVertices(mesh)
        x = [ufl.as_vector([corners[k, i] for i in range(3)]) for k in range(3)]
        vectors = [x[j] - x[i] for i, j in SIDES]
        self.sides = [ufl.as_vector([ufl.dot(a, s) for a in plane]) for s in vectors]
        (a1, a2), (b1, b2) = self.sides[2], self.sides[1]
        # Twice the area, negative where the vertices go round e3 clockwise.
        twice = b1 * a2 - a1 * b2
        self.gradients = [ufl.as_vector([-s[1] / twice, s[0] / twice]) for s in self.sides]
        away = ufl.SpatialCoordinate(mesh) - (x[0] + x[1] + x[2]) / 3.0
        place = ufl.as_vector([ufl.dot(a, away) for a in plane])
        self.coordinates = [1.0 / 3.0 + ufl.dot(g, place) for g in self.gradients]


def _reduced(gamma: Any, dd_beta: Any, triangle: _Triangle) -> Any:
    """Rγ of a shear strain whose part β is quadratic."""
    # With s_k the side opposite to the vertex k and d_k = (s_k·∇)² β, β differs from the linear
    # field through its vertices by −½ Σ λi λj d_k. Along side k the linear fit of λi λj is 1/6,
    # which Whitney's function N_k = λi ∇λj − λj ∇λi, with N_k·s_k = 1, takes over:
    #
    #     Rγ = γ + Σ_k (½ λi λj d_k − s_k·d_k / 12 N_k) − 4 Σ_k (δ·s_k) λ_k N_k.
    #
    # The last sum, with no tangential part on any side and the mean δ, gives the mean back that the
    # first one adds, as λi λj has the mean 1/12 and N_k the mean (∇λj − ∇λi) / 3.
    sides, gradients, at = triangle.sides, triangle.gradients, triangle.coordinates
    bends = [ufl.dot(ufl.dot(dd_beta, s), s) for s in sides]
    along = [ufl.dot(s, d) for s, d in zip(sides, bends, strict=True)]
    delta = sum(
        d / 24.0 - a / 36.0 * (gradients[j] - gradients[i])
        for d, a, (i, j) in zip(bends, along, SIDES, strict=True)
    )
    reduced = gamma
    for k, (i, j) in enumerate(SIDES):
        whitney = at[i] * gradients[j] - at[j] * gradients[i]
        reduced = reduced + 0.5 * at[i] * at[j] * bends[k]
        reduced = reduced - (along[k] / 12.0 + 4.0 * ufl.dot(delta, sides[k]) * at[k]) * whitney
    return reduced
