"""Shell parts: flat Reissner–Mindlin facets with drilling rotations, as UFL forms.

Displacement of a point at the height ζ above the mid-surface, with the facet's frame
(e1, e2, e3): u + ζ θ × e3. Strains, with the in-plane gradient ∇:

    membrane   ε = sym ∇(u1, u2)
    bending    κ = sym ∇β,  β = ((θ × e3)·e1, (θ × e3)·e2)
    shear      γ = ∇u3 + β
    drilling   ω = ½ (∂1 u2 − ∂2 u1) − θ·e3

Energy of an area, with D(ε) = E / (1 − ν²) ((1 − ν) ε + ν tr(ε) I) and μ = E / (2 (1 + ν)):

    ½ ∫ t D(ε):ε + t³/12 D(κ):κ + 5/6 μ t (α γ·γ + (1 − α) γ·γ|reduced) + c μ t ω²  dA

Partial selective reduced integration of the shear (Arnold and Brezzi 1997), α = t² / (t² + h²)
with the size h of the element, keeps thin facets from locking. The drilling energy is integrated
in full: with the reduced rule quadratic drilling modes cost nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ufl

SHEAR = 5.0 / 6.0
FULL, REDUCED = 4, 2
"""Quadrature degrees: full for products of P2 values, reduced for the split shear. Products of
gradients of P2 fields are integrated exactly by degree 2."""


@dataclass(frozen=True)
class ShellFields:
    """What the shell forms need, constant on each cell or on all.

    Args:
        thickness: t [m].
        young_modulus: E [Pa].
        poisson_ratio: ν.
        density: ρ [kg/m3].
        added_mass: Mass on the area that neither stiffens nor has rotary inertia [kg/m2].
        drilling: Factor c of the drilling energy.
    """

    thickness: Any
    young_modulus: Any
    poisson_ratio: Any
    density: Any
    added_mass: Any
    drilling: Any


def shell_stiffness(space: Any, fields: ShellFields) -> Any:
    """Stiffness form of shell cells.

    Args:
        space: P2 space on triangles with six components (u, θ).
        fields: Section and material.
    """
    mesh = space.mesh
    t, E, nu = fields.thickness, fields.young_modulus, fields.poisson_ratio
    mu = E / (2.0 * (1.0 + nu))
    frame = _frame(mesh)
    eps, kappa, gamma, omega = _strains(ufl.TrialFunction(space), frame)
    eps_, kappa_, gamma_, omega_ = _strains(ufl.TestFunction(space), frame)
    full = ufl.dx(mesh, metadata={"quadrature_degree": FULL})
    reduced = ufl.dx(mesh, metadata={"quadrature_degree": REDUCED})
    h = ufl.CellDiameter(mesh)
    alpha = t**2 / (t**2 + h**2)

    def stress(strain: Any) -> Any:
        identity = ufl.Identity(2)
        return E / (1.0 - nu**2) * ((1.0 - nu) * strain + nu * ufl.tr(strain) * identity)

    return (
        t * ufl.inner(stress(eps), eps_)
        + t**3 / 12.0 * ufl.inner(stress(kappa), kappa_)
        + SHEAR * mu * t * (1.0 - alpha) * ufl.inner(gamma, gamma_)
    ) * reduced + (
        SHEAR * mu * t * alpha * ufl.inner(gamma, gamma_)
        + fields.drilling * mu * t * omega * omega_
    ) * full


def shell_mass(space: Any, fields: ShellFields) -> Any:
    """Consistent mass form of shell cells: (ρ t + added) u·v + ρ t³/12 θ·ψ.

    The rotary inertia acts on all of θ, drilling included, so that M is positive definite.

    Args:
        space: P2 space on triangles with six components (u, θ).
        fields: Section and material.
    """
    t, rho = fields.thickness, fields.density
    u, theta = halves(ufl.TrialFunction(space))
    v, psi = halves(ufl.TestFunction(space))
    full = ufl.dx(space.mesh, metadata={"quadrature_degree": FULL})
    return (
        (rho * t + fields.added_mass) * ufl.inner(u, v) + rho * t**3 / 12.0 * ufl.inner(theta, psi)
    ) * full


def halves(w: Any) -> tuple[Any, Any]:
    """Displacement u and rotation θ of a six-component field."""
    u = ufl.as_vector([w[0], w[1], w[2]])
    theta = ufl.as_vector([w[3], w[4], w[5]])
    return u, theta


def _frame(mesh: Any) -> tuple[Any, Any, Any]:
    """The facet's orthonormal frame: e1 along its first edge, e3 normal."""
    J = ufl.Jacobian(mesh)
    t1 = ufl.as_vector([J[i, 0] for i in range(3)])
    t2 = ufl.as_vector([J[i, 1] for i in range(3)])
    normal = ufl.cross(t1, t2)
    e3 = normal / ufl.sqrt(ufl.dot(normal, normal))
    e1 = t1 / ufl.sqrt(ufl.dot(t1, t1))
    return e1, ufl.cross(e3, e1), e3


def _strains(w: Any, frame: tuple[Any, Any, Any]) -> tuple[Any, Any, Any, Any]:
    """ε, κ, γ and ω of a six-component field."""
    e1, e2, e3 = frame
    u, theta = halves(w)
    plane = (e1, e2)
    beta = ufl.cross(theta, e3)
    grad_u, grad_beta = ufl.grad(u), ufl.grad(beta)

    def in_plane(gradient: Any) -> Any:
        """Components ∂j (vector·ei), i and j in the plane."""
        return ufl.as_matrix([[ufl.dot(a, ufl.dot(gradient, b)) for b in plane] for a in plane])

    du = in_plane(grad_u)
    gamma = ufl.as_vector([ufl.dot(e3, ufl.dot(grad_u, a)) + ufl.dot(beta, a) for a in plane])
    omega = 0.5 * (du[1, 0] - du[0, 1]) - ufl.dot(theta, e3)
    return ufl.sym(du), ufl.sym(in_plane(grad_beta)), gamma, omega
