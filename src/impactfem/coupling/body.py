"""Bodies and their ports: linear structures in modal or Ritz coordinates.

    μ z̈ + d ż + λ z = -P ü_base + Σ Φᵀ f                                                   (1)

with the forces f at the ports, whose motion is Φ z relative to the base. The mass μ is one, and
zero without mass (points inside the storeys of a stick). A clamped base moves with the
ground. A free base adds six coordinates b, its motion relative to the ground: a port then moves by
Φ z + R b, the mass is

    [μ   P  ]
    [Pᵀ  M_b],    M_b the rigid mass about the base,                                        (2)

and springs and dashpots hold the base as a link to the ground does, or the soil under its raft:
matrices over b and degrees of freedom in the soil, relative to the free field.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg
from scipy.sparse.csgraph import connected_components

from impactfem.dynamics.damping import Damping, DampingLaw, ModalDamping
from impactfem.dynamics.soil import Soil
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

ROUNDING = 1e-9
"""Negative λ up to this part of the largest are zero."""


@dataclass(frozen=True, eq=False)
class Port:
    """A named place of a body where forces act."""

    shapes: Array  #: Φ, its motion by the coordinates, shape (components, r)
    rigid: Array  #: R, its motion by a rigid motion of the base, shape (components, 6)


@dataclass(frozen=True, eq=False)
class Body:
    """Equation (1).

    Raises:
        ImpactfemError: Shapes do not fit, a value is not finite, or the rigid mass of a free base
            is not positive definite; the message names the body.
    """

    name: str  #: unique name
    eigenvalue: Array  #: λ, shape (r,) [1/s2]
    damping: Damping  #: gives d of λ
    participation: Array  #: P for translations and rotations of the base, shape (r, 6)
    rigid_mass: Array  #: M_b, that of a raft included, shape (6, 6) [kg, kg m, kg m2]
    ports: Mapping[str, Port] = field(default_factory=dict)  #: the ports by name
    mass: Array | None = None  #: μ, ones or zeros, shape (r,); ones when None
    free_base: bool = False  #: whether the base moves by (2); it is clamped to the ground otherwise
    soil: Soil | None = None  #: soil under a free base, about the base

    def __post_init__(self) -> None:
        r = len(self.eigenvalue)
        wanted = {
            "eigenvalue": (self.eigenvalue, (r,)),
            "participation": (self.participation, (r, 6)),
            "rigid_mass": (self.rigid_mass, (6, 6)),
        }
        if self.mass is not None:
            wanted["mass"] = self.mass, (r,)
        for name, port in self.ports.items():
            count = len(port.shapes)
            wanted[f"shapes of port {name}"] = port.shapes, (count, r)
            wanted[f"rigid motion of port {name}"] = port.rigid, (count, 6)
        for name, (values, shape) in wanted.items():
            if np.shape(values) != shape or not np.all(np.isfinite(values)):
                raise ImpactfemError(
                    f"body {self.name}: {name} of shape {np.shape(values)}: expected finite values"
                    f" of shape {shape}"
                )
        if self.free_base and np.linalg.eigvalsh(self.rigid_mass)[0] <= 0.0:
            raise ImpactfemError(
                f"body {self.name}: a free base needs a positive definite rigid_mass"
            )

    def __len__(self) -> int:
        return len(self.eigenvalue) + 6 * self.free_base

    def port(self, name: str) -> Array:
        """Motion of a port by all coordinates, those of a free base last, (components, len(body)).

        Raises:
            ImpactfemError: The body has no such port.
        """
        if name not in self.ports:
            known = ", ".join(self.ports) or "none"
            raise ImpactfemError(f"body {self.name} has no port {name!r}; its ports: {known}")
        port = self.ports[name]
        return np.hstack([port.shapes, port.rigid]) if self.free_base else port.shapes


def reduced_body(
    name: str, eigenvalue: Array, damping: Damping, ports: Mapping[str, Array]
) -> Body:
    """A body of which λ [1/s2], shape (r,), damping and ports are known, Φ of each by its name.

    The ground moves it by patterns of loads.
    """
    r = len(eigenvalue)
    made = {port: Port(Φ, np.zeros((len(Φ), 6))) for port, Φ in ports.items()}
    return Body(name, eigenvalue, damping, np.zeros((r, 6)), np.zeros((6, 6)), made)


def modal_coordinates(
    M: Array, C: Array, K: Array, law: DampingLaw | None = None
) -> tuple[Array, Array, Array, ModalDamping]:
    """All coordinates of a small structure in which mass and stiffness are diagonal; exact.

    What has no mass follows the rest by its stiffness, x_s = -K_ss⁻¹ K_sm x_m + η, and keeps
    coordinates η of its own with the mass zero. Parts that nothing couples are solved apart: the
    coordinates of a part that does not move stay exactly zero.

    The matrices are symmetric, shape (n, n); M is positive but for rows of zeros, K positive
    definite on these. Gives Φ with x = Φ z, shape (n, n); μ; λ; the damping Φᵀ C Φ: that of the
    law, where C follows one, without the rounding of C.

    Raises:
        ImpactfemError: A mass is negative, or the stiffness is indefinite.
    """
    n = len(M)
    if np.any(np.diag(M) < 0.0):
        raise ImpactfemError("a mass or an inertia is negative; expected zero or more")
    rows = np.arange(n)
    s, m = rows[np.diag(M) == 0.0], rows[np.diag(M) > 0.0]
    T = np.eye(n)
    if s.size:
        T[np.ix_(s, m)] = -scipy.linalg.solve(K[np.ix_(s, s)], K[np.ix_(s, m)], assume_a="pos")
    K, C = T.T @ K @ T, T.T @ C @ T
    K[np.ix_(s, m)] = K[np.ix_(m, s)] = 0.0
    basis, eigenvalue = np.zeros((n, n)), np.zeros(n)
    for group, with_mass in ((m, True), (s, False)):
        here = np.ix_(group, group)
        _, part = connected_components((K[here] != 0.0) | (C[here] != 0.0) | (M[here] != 0.0))
        for number in np.unique(part):
            dofs = group[part == number]
            block = np.ix_(dofs, dofs)
            values, shapes = scipy.linalg.eigh(K[block], M[block] if with_mass else None)
            basis[block], eigenvalue[dofs] = shapes, values
        if np.any(eigenvalue[group] < -ROUNDING * np.max(np.abs(eigenvalue[group]), initial=0.0)):
            raise ImpactfemError("the stiffness is indefinite; expected none that is negative")
    # Of a structure that is free to move, zero but for rounding.
    eigenvalue = np.maximum(eigenvalue, 0.0)
    modal = basis.T @ C @ basis
    if law is not None:
        λ = eigenvalue[m]
        modal = np.diag(law.stiffness_part(λ) * eigenvalue)
        modal[m, m] = law.modal(λ)
    return T @ basis, (np.diag(M) > 0.0).astype(np.float64), eigenvalue, ModalDamping(modal)
