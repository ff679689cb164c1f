"""Links between ports, and bodies and links put together.

A link is a law: one force between two ports, or a port and the ground, from their gap
δ = g + n · (u_b - u_a), its rate and the state of the contact. A spring (with dashpot) and a
mount are linear: they hang matrices on rows a = B z of the coordinates,

    M_y ÿ + C_y ẏ + K_y y = (-T, 0) - N g̈,    y = (a, ζ),                                 (1)

with own coordinates ζ and the forces T on the bodies. So do the six coordinates of a free base (by
the mass that couples them to the others), with the soil under it, and damping that couples modes.
All else is diagonal, and

    M̂ = M + s C + s² K,    M̂ (z, y) = (b_z + Bᵀ T, b_y - (T, 0))

is solved by one inverse as small as y. With D the diagonal of M̂, S = M_y + s C_y + s² K_y and the
compliance Y = B D⁻¹ Bᵀ,

    [1 + Y S_aa   Y S_aζ]     [B D⁻¹ b_z + Y b_a]
    [S_ζa         S_ζζ  ] y = [b_ζ              ],    T = (b_y - S y)_a.                    (2)

A step takes two products with B. The time loops, `implicit` and `contact_loop`, need nothing else
of the bodies than M̂⁻¹, the rows Γ of the links, and W = Γ M̂⁻¹ Γᵀ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg

from impactfem.coupling.body import Body
from impactfem.coupling.law import Law
from impactfem.dynamics.soil import Soil
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import ImpactfemError

Place = tuple[str, str]
"""Names of a body and of its port."""


@dataclass(frozen=True, eq=False)
class Link:
    """A law between two ports; the force F acts as -F n on a and +F n on b."""

    name: str  #: unique name
    a: Place  #: the first port
    b: Place | None  #: the second one; None for the ground
    direction: Array  #: n over the components of the ports, from a to b
    gap: float = 0.0  #: g at rest [m]
    law: Law | None = None  #: the law; None for a unilateral constraint, δ ≥ 0


@dataclass(frozen=True, eq=False)
class Spring:
    """Springs and dashpots between all components of two ports, or of one and the ground."""

    a: Place  #: the first port
    b: Place | None  #: the second one; None for the ground
    stiffness: Array  #: K, shape (components, components)
    damping: Array  #: C, same shape


@dataclass(frozen=True, eq=False)
class Mount:
    """A body whose supports are fixed to ports, by its matrices; equation (1)."""

    at: tuple[Place, ...]  #: the ports that bear it; their components come first in y
    fixed: int  #: number of these components
    M: Array  #: M_y, shape (N, N)
    C: Array  #: C_y
    K: Array  #: K_y
    ground: Array  #: motion of y by that of the ground, shape (N, 3): N = M_y times it


@dataclass(frozen=True, eq=False)
class Base:
    """A base on soil among what is attached."""

    rows: Index  #: rows in y of the base, six, and after them those of its soil
    motion: Array  #: T, from these six to the motion of the base, shape (6, 6)
    soil: Soil  #: over y in these rows


@dataclass(frozen=True, eq=False)
class Attached:
    """All that hangs on the bodies, equation (1); rows of each part in order."""

    rows: Array  #: B, shape (N_a, r)
    M: Array  #: M_y, shape (N, N); the rows of B come first
    C: Array  #: C_y
    K: Array  #: K_y
    push: Array  #: -N, shape (N, 3)
    #: Rows in y of each mount: those that are fixed, then its own.
    mounts: tuple[tuple[Index, Index], ...]
    bases: dict[str, Base]  #: those on soil by the name of the body
    radiation: Array  #: part of C_y that radiates into the soil

    @classmethod
    def alone(cls, mounts: Sequence[Mount]) -> Attached:
        """Mounts on a structure that is not in modal coordinates."""
        return _attached([_mounted(mount, np.zeros((mount.fixed, 0))) for mount in mounts], 0)


class Assembly:
    """Bodies, laws and springs between their ports, and what stands on these.

    Coordinates are those of one body after the other.

    Attributes:
        eigenvalue, damping, mass: λ, the diagonal of d, and μ, shape (r,).
        ground: Loads of a unit ground acceleration along x, y, z, shape (r, 3).
        gamma: Γ of the links, shape (m, r).
        attached: Springs, mounts, free bases and damping that couples modes.

    Raises:
        ImpactfemError: Two bodies have one name, a body or port is not there, or a link, spring or
            mount does not fit the components of its ports.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        links: Sequence[Link] = (),
        springs: Sequence[Spring] = (),
        mounts: Sequence[Mount] = (),
    ) -> None:
        self.bodies = {body.name: body for body in bodies}
        if len(self.bodies) < len(bodies):
            names = ", ".join(body.name for body in bodies)
            raise ImpactfemError(f"expected a unique name for each body, got {names}")
        ends = np.cumsum([len(body) for body in bodies])
        self.columns = {
            body.name: slice(int(end) - len(body), int(end))
            for body, end in zip(bodies, ends, strict=True)
        }
        r = sum(map(len, bodies))
        self.eigenvalue, self.damping, self.mass = np.zeros(r), np.zeros(r), np.ones(r)
        self.ground = np.zeros((r, 3))
        parts = [part for body in bodies for part in self._place(body)]
        for spring in springs:
            rows = self._between(spring.a, spring.b)
            for what, matrix in (("stiffness", spring.stiffness), ("damping", spring.damping)):
                _refuse_shape(what, matrix, (len(rows), len(rows)), spring)
            none = np.zeros_like(spring.damping)
            parts.append(_Part(rows, none, spring.damping, spring.stiffness))
        for mount in mounts:
            rows = np.vstack([self.rows(place) for place in mount.at])
            if len(rows) != mount.fixed:
                raise ImpactfemError(
                    f"what stands on {', '.join(map(str, mount.at))} has {mount.fixed} fixed"
                    f" components, the ports have {len(rows)}"
                )
            parts.append(_mounted(mount, rows))
        self.attached = _attached(parts, r)
        self.links = tuple(links)
        self.gaps = np.array([link.gap for link in links], dtype=np.float64)
        self.gamma = np.zeros((len(links), r))
        for row, link in zip(self.gamma, links, strict=True):
            rows = self._between(link.a, link.b)
            _refuse_shape("direction", link.direction, (len(rows),), link)
            row -= link.direction @ rows

    def __len__(self) -> int:
        return len(self.eigenvalue)

    def rows(self, place: Place) -> Array:
        """Motion of a port by the coordinates of all bodies, shape (components, r)."""
        name, port = place
        if name not in self.bodies:
            raise ImpactfemError(f"no body {name!r}; there are {', '.join(self.bodies)}")
        shapes = self.bodies[name].port(port)
        rows = np.zeros((len(shapes), len(self)))
        rows[:, self.columns[name]] = shapes
        if self.bodies[name].free_base:
            base = rows[:, self.columns[name]][:, -6:]
            base[:] = base @ self.base_motion(self.bodies[name])
        return rows

    def _between(self, a: Place, b: Place | None) -> Array:
        """Motion of a against b, or the ground; refuses ports with other components."""
        rows = self.rows(a)
        if b is None:
            return rows
        other = self.rows(b)
        if len(other) != len(rows):
            raise ImpactfemError(
                f"between {a} and {b}: one port has {len(rows)} components, the other {len(other)};"
                " expected the same number"
            )
        return rows - other

    @staticmethod
    def base_motion(body: Body) -> Array:
        """L⁻ᵀ of M_b = L Lᵀ: from base coordinates with unit mass to the motion of the base."""
        L = scipy.linalg.cholesky(body.rigid_mass, lower=True)
        return np.asarray(np.linalg.inv(L).T, dtype=np.float64)

    def _place(self, body: Body) -> list[_Part]:
        """Fill the body's rows; what couples its coordinates."""
        here = self.columns[body.name]
        count = len(body.eigenvalue)
        own = slice(here.start, here.start + count)
        self.eigenvalue[own] = body.eigenvalue
        if body.mass is not None:
            self.mass[own] = body.mass
        self.ground[own] = -body.participation[:, :3]
        d = body.damping.modal(body.eigenvalue)
        parts = []
        if d.ndim == 2:
            self.damping[own] = np.diag(d)
            off = d - np.diag(np.diag(d))
            coupled = np.flatnonzero(np.any(off, axis=0))
            rows = np.zeros((coupled.size, len(self)))
            rows[np.arange(coupled.size), here.start + coupled] = 1.0
            none = np.zeros((coupled.size, coupled.size))
            parts.append(_Part(rows, none, off[np.ix_(coupled, coupled)], none))
        else:
            self.damping[own] = d
        if body.free_base:
            T = self.base_motion(body)
            # ½ μ ż² + ½ ḃ² + (Pᵀ ż) · ḃ with b of unit mass.
            rows = np.zeros((12, len(self)))
            rows[:6, own] = (body.participation @ T).T
            rows[6:, own.stop : here.stop] = np.eye(6)
            soil = None if body.soil is None else body.soil.moved(T)
            M, C, K = np.zeros((3, *(2 * (12 if soil is None else 6 + len(soil),))))
            M[:6, 6:12] = M[6:12, :6] = np.eye(6)
            if soil is not None:
                for whole, matrix in ((M, soil.M), (C, soil.C), (K, soil.K)):
                    whole[6:, 6:] += matrix
            parts.append(_Part(rows, M, C, K, base=None if soil is None else (body.name, T, soil)))
            self.ground[own.stop : here.stop] = -np.linalg.inv(T)[:, :3]
        return parts


def _refuse_shape(what: str, values: Array, shape: tuple[int, ...], of: Link | Spring) -> None:
    if np.shape(values) != shape:
        raise ImpactfemError(
            f"the {what} between {of.a} and {of.b or 'the ground'}: expected shape {shape} for the"
            f" components of the ports, got {np.shape(values)}"
        )


@dataclass(frozen=True, eq=False)
class _Part:
    """One part of what is attached; its matrices over its rows and, after them, its own."""

    rows: Array
    M: Array
    C: Array
    K: Array
    push: Array = field(default_factory=lambda: np.zeros((0, 3)))
    mount: bool = False
    base: tuple[str, Array, Soil] | None = None


def _mounted(mount: Mount, rows: Array) -> _Part:
    return _Part(rows, mount.M, mount.C, mount.K, -mount.M @ mount.ground, True)


def _attached(parts: Sequence[_Part], r: int) -> Attached:
    """Parts one after the other: first the fixed rows of all, then the own ones of all."""
    fixed = [len(part.rows) for part in parts]
    own = [len(part.M) - n for part, n in zip(parts, fixed, strict=True)]
    N = sum(fixed) + sum(own)
    M, C, K = (np.zeros((N, N)) for _ in range(3))
    push, mounts, bases, radiation = np.zeros((N, 3)), [], {}, np.zeros((N, N))
    first, second = 0, sum(fixed)
    for part, n, k in zip(parts, fixed, own, strict=True):
        a, z = np.arange(first, first + n), np.arange(second, second + k)
        at = np.concatenate([a, z])
        for whole, matrix in ((M, part.M), (C, part.C), (K, part.K)):
            whole[np.ix_(at, at)] = matrix
        if len(part.push):
            push[at] = part.push
        if part.mount:
            mounts.append((a, z))
        if part.base is not None:
            name, T, soil = part.base
            bases[name] = Base(at[6:], T, soil)
            radiation[np.ix_(at[6:], at[6:])] = soil.C - soil.material
        first, second = first + n, second + k
    rows = np.vstack([np.zeros((0, r)), *(part.rows for part in parts)])
    rows = np.ascontiguousarray(rows)
    return Attached(rows, M, C, K, push, tuple(mounts), bases, radiation)


class Inverse:
    """M̂⁻¹ with M̂ = M + s C + s² K, s in [s], by equation (2); that of the mass with s = 0.

    Attributes:
        diagonal: D⁻¹, shape (r,); zero where D is.
        rows: B D⁻¹, shape (N_a, r).
        S: M_y + s C_y + s² K_y, shape (N, N).
        free, loaded: What takes B D⁻¹ b_z, and what takes b_y, to y.
    """

    def __init__(self, assembly: Assembly, s: float) -> None:
        one = assembly.attached
        D = assembly.mass + s * assembly.damping + s**2 * assembly.eigenvalue
        self.diagonal = np.divide(1.0, D, out=np.zeros_like(D), where=D > 0.0)
        self.rows = np.ascontiguousarray(one.rows * self.diagonal)
        self.S = one.M + s * one.C + s**2 * one.K
        n, Y = len(one.rows), self.rows @ one.rows.T
        small = self.S.copy()
        small[:n] = Y @ self.S[:n]
        small[:n, :n] += np.eye(n)
        # Own coordinates without mass have no acceleration of their own at the start, s = 0.
        still = np.flatnonzero(~small.any(axis=1))
        small[still, still] = 1.0
        inverse = np.linalg.inv(small)
        inverse[still, still] = 0.0
        self.free = np.ascontiguousarray(inverse[:, :n])
        self.loaded = inverse.copy()
        self.loaded[:, :n] = self.free @ Y

    def solve(self, b_z: Array, b_y: Array) -> tuple[Array, Array, Array]:
        """z, y and T under right sides of shapes (..., r) and (..., N)."""
        z = b_z * self.diagonal
        n = len(self.rows)
        if n == 0:
            return z, b_y, b_y
        y = (b_z @ self.rows.T) @ self.free.T + b_y @ self.loaded.T
        T = (b_y - y @ self.S.T)[..., :n]
        return z + T @ self.rows, y, T
