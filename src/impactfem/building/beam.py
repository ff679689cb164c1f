"""Beam and column parts: straight Timoshenko beams with an eccentric axis, as UFL forms.

Frame (t, n1, n2): tangent t, n2 along the depth of the section, n1 = n2 × t. The axis lies at the
vector e from the line of nodes and follows it rigidly, u_a = u + θ × e. With the derivative ′
along the line:

    axial ε = u_a′·t     shear γ1 = u_a′·n1 − θ·n2,  γ2 = u_a′·n2 + θ·n1
    twist τ = θ′·t       bending κ1 = θ′·n1,  κ2 = θ′·n2

    energy ½ ∫ E A ε² + G (k1 A γ1² + k2 A γ2²) + G J τ² + E I1 κ1² + E I2 κ2²  ds

I1 is the second moment of a section that moves along n2 (turns about n1). The shear is integrated
by the rule of degree 2: with a higher one P2 beams are about 1 % too stiff.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ufl

from impactfem.building.shell import FULL, REDUCED, halves


@dataclass(frozen=True)
class BeamFields:
    """What the beam forms need, constant on each cell or on all."""

    area: Any  #: A [m2]
    second_moments: Any  #: I1, I2 as components [m4]
    torsion: Any  #: J [m4]
    shear: Any  #: k1, k2 as components
    reference: Any  #: a vector in the plane of t and n2, not along t
    offset: Any  #: e, from the nodes to the axis [m]
    young_modulus: Any  #: E [Pa]
    poisson_ratio: Any  #: ν
    density: Any  #: ρ [kg/m3]

    def stiffness(self, space: Any) -> Any:
        """Stiffness form on a P2 space on intervals with six components (u, θ)."""
        A, J, E = self.area, self.torsion, self.young_modulus
        (I1, I2), (k1, k2) = self.second_moments, self.shear
        G = E / (2.0 * (1.0 + self.poisson_ratio))
        frame = self._frame(space.mesh)
        a, b = (
            self._strains(w, frame) for w in (ufl.TrialFunction(space), ufl.TestFunction(space))
        )
        weights = (E * A, k1 * G * A, k2 * G * A, G * J, E * I1, E * I2)
        energy = sum(weight * x * y for weight, x, y in zip(weights, a, b, strict=True))
        return energy * ufl.dx(space.mesh, metadata={"quadrature_degree": REDUCED})

    def mass(self, space: Any) -> Any:
        """Consistent mass form: ρ A u_a·v_a + ρ (I1 θ1 ψ1 + I2 θ2 ψ2 + (I1 + I2) θt ψt)."""
        I1, I2 = self.second_moments
        t, n1, n2 = self._frame(space.mesh)
        (u, theta), (v, psi) = halves(ufl.TrialFunction(space)), halves(ufl.TestFunction(space))
        ua, va = u + ufl.cross(theta, self.offset), v + ufl.cross(psi, self.offset)
        rotary = sum(
            inertia * ufl.dot(theta, n) * ufl.dot(psi, n)
            for inertia, n in ((I1, n1), (I2, n2), (I1 + I2, t))
        )
        full = ufl.dx(space.mesh, metadata={"quadrature_degree": FULL})
        return self.density * (self.area * ufl.inner(ua, va) + rotary) * full

    def _frame(self, mesh: Any) -> tuple[Any, Any, Any]:
        J = ufl.Jacobian(mesh)
        t = ufl.as_vector([J[i, 0] for i in range(3)])
        t = t / ufl.sqrt(ufl.dot(t, t))
        across = self.reference - ufl.dot(self.reference, t) * t
        n2 = across / ufl.sqrt(ufl.dot(across, across))
        return t, ufl.cross(n2, t), n2

    def _strains(self, w: Any, frame: tuple[Any, Any, Any]) -> tuple[Any, ...]:
        """ε, γ1, γ2, τ, κ1 and κ2 of a six-component field."""
        t, n1, n2 = frame
        u, theta = halves(w)
        dtheta = ufl.dot(ufl.grad(theta), t)
        dua = ufl.dot(ufl.grad(u), t) + ufl.cross(dtheta, self.offset)
        return (
            ufl.dot(dua, t),
            ufl.dot(dua, n1) - ufl.dot(theta, n2),
            ufl.dot(dua, n2) + ufl.dot(theta, n1),
            *(ufl.dot(dtheta, n) for n in frame),
        )
