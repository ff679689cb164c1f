"""Forces in the bolts of a base plate, from the force and moment of a device on the floor.

The plate is rigid and does not bend (EN 1992-4, 6.2.1; ETAG 001 annex C, 4.2.1): the displacement
of its underside is plane, u = p · v with v = (1, x, y) about the anchor point, upward. Bolts of
equal stiffness carry tension alone, and the concrete under the plate carries pressure alone. With
the tensile stress area A_s of a bolt and the modular ratio n = E_s / E_c, both strains are over the
same length, and the unit of stress makes E_c over that length one:

    T_i = n A_s max(u_i, 0),    σ = max(-u, 0)                                              (1)

The force F_z upward and the moments M_x and M_y of the device at the anchor point, weight included,
are in equilibrium with both,

    Σ T_i v_i - ∫ σ v dA = H(p) p = q = (F_z, -M_y, M_x)                                     (2)
    H(p) = n A_s Σ_{u_i > 0} v_i v_iᵀ + ∫_{u < 0} v vᵀ dA

H is also the tangent of (2), because u is zero at the border of the contact area. Hence (2) is the
minimum of the convex function ½ pᵀ H p - qᵀ p: Newton steps with a line search reach it, and end
exactly as soon as the bolts in tension stay the same and the neutral axis converges. The contact
area is the part of a convex polygon below the neutral axis, integrated in closed form.

Shear V and torsion M_z go to all bolts by the elastic method for a bolt group: without friction and
clearance each of m bolts has V / m, and about the centroid c of the bolts

    V_i = V / m + M_c (-(y_i - c_y), x_i - c_x) / Σ |r_j - c|²,   M_c = M_z - c × V          (3)

The interaction (T / T_R)^k + (V / V_R)^k of a bolt is at most one. k is 1.5 for failure of the
concrete and 2 for failure of the steel (EN 1992-4, table 7.3; ETAG 001 annex C, 5.2.4).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError
from impactfem.system.quantity import results, si

RESIDUAL, ROUNDED = 3e-13, 1e-11
"""Largest imbalance of (2), of the norm of q with lengths over the size of the plate; and where a
slender contact area leaves more to rounding."""
MOST_STEPS = 80
"""Most Newton steps; ten are usual."""
ARMIJO = 1e-4
"""Least decrease of a step in the line search, of the decrease along the tangent."""
SOFT = 1e-10
"""Part of the trace of H that is added to it: H is singular where the plate has no contact and its
bolts stand in a line."""
MOST_HALVES = 40
"""Most halves of a step in the line search."""
SEARCHES = ((45, 0.4), (15, 0.9), (1, 1.0))
"""Searches for the critical direction, each with its step [degree], and the part of the largest
value from which on a pair of instant and direction is refined in the next one. No direction is
farther than half a step from one of the search, where values are at most a sixth lower."""
CHUNK = 20000
"""Number of pairs of instant and direction that are solved together: limits the memory."""
ROUND = 64
"""Number of corners of a round plate."""


@dataclass(frozen=True, eq=False)
class BoltGroup:
    """Bolts of a rigid base plate, with their capacities; places are relative to the anchor point.

    Args:
        position: Places (x, y), at least two, within the plate, shape (m, 2) [m].
        area: Tensile stress area of a bolt [m2].
        plate: Corners of the convex plate, counterclockwise, shape (c, 2) [m].
        modular_ratio: Young's modulus of the bolts over that of the concrete [-].
        tension: Capacity of a bolt in tension, T_R [N].
        shear: Capacity of a bolt in shear, V_R [N].
        exponent: k of the interaction [-].
    """

    position: Array
    area: float
    plate: Array
    modular_ratio: float = 7.0
    tension: float = math.inf
    shear: float = math.inf
    exponent: float = 1.5


def round_plate(radius: float) -> Array:
    """Return the corners of a regular polygon with the area of a circle, shape (c, 2) [m]."""
    angle = 2.0 * math.pi * np.arange(ROUND) / ROUND
    # The area of the polygon is c/2 r² sin(2π/c).
    r = radius * math.sqrt(2.0 * math.pi / (ROUND * math.sin(2.0 * math.pi / ROUND)))
    return np.asarray(r * np.stack([np.cos(angle), np.sin(angle)], axis=1), dtype=np.float64)


def rectangular_plate(length: float, width: float) -> Array:
    """Return the corners of a plate with sides along x and y [m], shape (4, 2) [m]."""
    return 0.5 * np.array([[-length, -width], [length, -width], [length, width], [-length, width]])


@dataclass(frozen=True, eq=False)
class BoltForces:
    """Forces in the bolts at each instant."""

    tension: Array  #: shape (m, n_t) [N]
    shear: Array  #: along x and y, shape (2, m, n_t) [N]
    #: resultant of the pressure on the plate: force upward and moments about x and y, shape
    #: (3, n_t) [N, N m]
    pressure: Array

    def interaction(self, group: BoltGroup) -> Array:
        """Return the interaction of each bolt, shape (m, n_t) [-]."""
        T, V = self.tension / group.tension, np.hypot(*self.shear) / group.shear
        return np.asarray(T**group.exponent + V**group.exponent, dtype=np.float64)


def bolt_forces(group: BoltGroup, force: Array) -> BoltForces:
    """Compute the forces in the bolts of a plate by (1) to (3).

    Args:
        group: The bolts.
        force: Force and moment of the device on the floor at the anchor point, weight included:
            x, y, z, rx, ry, rz, shape (6, n_t) [N, N m].

    Raises:
        SolutionError: No equilibrium was found.
    """
    section = _Section.of(group)
    q = np.stack([force[2], -force[4], force[3]])
    p = section.equilibrium(q)
    tension = group.modular_ratio * group.area * np.maximum(section.bolts.T @ p, 0.0)
    contact = _times(section.contact(p), p)
    # Zero is added: a plate without contact has -0.
    pressure = np.stack([-contact[0], -contact[2], contact[1]]) + 0.0
    x, y = group.position.mean(axis=0)
    arm = group.position - (x, y)
    each = (force[5] - (x * force[1] - y * force[0])) / np.sum(arm**2)
    count = len(arm)
    shear = np.stack(
        [force[0] / count - np.outer(arm[:, 1], each), force[1] / count + np.outer(arm[:, 0], each)]
    )
    return BoltForces(tension, shear, pressure)


def _times(H: Array, p: Array) -> Array:
    """Return the products of matrices (n_t, 3, 3) with the columns of p (3, n_t)."""
    return np.asarray(np.einsum("tij,jt->it", H, p), dtype=np.float64)


def _products(v: Array) -> Array:
    """Return the entries 11, 12, 13, 22, 23, 33 of v vᵀ, shape (6, ...)."""
    return np.stack([v[i] * v[j] for i in range(3) for j in range(i, 3)])


def _triangles(a: Array, b: Array) -> Array:
    """Return ∫ v vᵀ dA over triangles from the origin to a and b, v of these points, (6, ...).

    The sign is that of the turn from a to b.
    """
    # Area / 12 (Σ v_k v_kᵀ + Σ v_k Σ v_kᵀ) of the three corners v_k; the origin has v = (1, 0, 0).
    twice = a[1] * b[2] - a[2] * b[1]
    origin = np.zeros_like(a)
    origin[0] = 1.0
    return np.asarray(
        twice / 24.0 * (sum(map(_products, (origin, a, b))) + _products(origin + a + b))
    )


@dataclass(frozen=True, eq=False)
class _Section:
    """Bolts and contact area of a plate: v of places, and their shares of H, six entries each."""

    size: float  #: L, to which the balance of forces and moments is related [m]
    bolts: Array  #: v, shape (3, m)
    bolt_share: Array  #: n A_s v vᵀ, shape (6, m)
    corners: Array  #: v, shape (3, c)
    edge_share: Array  #: ∫ v vᵀ dA over the triangle from the origin to an edge, shape (6, c)

    @classmethod
    def of(cls, group: BoltGroup) -> _Section:
        """Return the section of a group of bolts."""
        bolts = np.vstack([np.ones(len(group.position)), group.position.T])
        corners = np.vstack([np.ones(len(group.plate)), group.plate.T])
        return cls(
            size=float(np.linalg.norm(group.plate, axis=1).max()),
            bolts=bolts,
            bolt_share=group.modular_ratio * group.area * _products(bolts),
            corners=corners,
            edge_share=_triangles(corners, np.roll(corners, -1, axis=1)),
        )

    def contact(self, p: Array) -> Array:
        """Return ∫ v vᵀ dA over the part of the plate where p · v < 0, shape (n_t, 3, 3)."""
        return _matrices(self._pressed(p))

    def stiffness(self, p: Array) -> Array:
        """Return H of (2), shape (n_t, 3, 3)."""
        pulled = (self.bolts.T @ p > 0.0).astype(np.float64)
        return _matrices(self.bolt_share @ pulled + self._pressed(p))

    def _pressed(self, p: Array) -> Array:
        # Green: the integral is the sum over triangles from the origin to each edge of the contact
        # area. These are whole edges, two that the neutral axis cuts, and the neutral axis.
        u = self.corners.T @ p
        w = np.roll(u, -1, axis=0)
        share = self.edge_share @ ((u < 0.0) & (w < 0.0)).astype(np.float64)
        leaves, enters = (u < 0.0) & (w >= 0.0), (u >= 0.0) & (w < 0.0)
        cut = np.flatnonzero(leaves.any(axis=0))
        after = np.roll(self.corners, -1, axis=1)

        def crossing(edges: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
            """First corner, point on the neutral axis and second corner of the cut edge."""
            k = edges[:, cut].argmax(axis=0)
            a, b = self.corners[:, k], after[:, k]
            return a, a + u[k, cut] / (u[k, cut] - w[k, cut]) * (b - a), b

        last, end, _ = crossing(leaves)
        _, start, first = crossing(enters)
        for a, b in ((last, end), (end, start), (start, first)):
            share[:, cut] += _triangles(a, b)
        return np.asarray(share, dtype=np.float64)

    def equilibrium(self, q: Array) -> Array:
        """Return p of (2), the minimum of ½ pᵀ H(p) p - qᵀ p for each column of q, (3, n_t).

        Raises:
            SolutionError: It was not found.
        """
        units = np.array([[1.0], [self.size], [self.size]])
        # All bolts and the whole plate, in tension and pressure alike, are the first guess.
        whole = _matrices((self.bolt_share.sum(axis=1) + self.edge_share.sum(axis=1))[:, None])[0]
        p = np.linalg.solve(whole, q)
        H = self.stiffness(p)
        residual = _times(H, p) - q
        size = np.linalg.norm(q / units, axis=0)
        todo = np.arange(q.shape[1])
        for part in (*(MOST_STEPS - 1) * (RESIDUAL,), ROUNDED):
            off = np.linalg.norm(residual[:, todo] / units, axis=0)
            todo = todo[off > part * size[todo]]
            if not todo.size:
                return np.asarray(p, dtype=np.float64)
            # Softened in the units of H, in which lengths are of the size of the plate.
            soft = SOFT * H[todo, 0, 0][:, None, None] * np.diag(units[:, 0] ** 2)
            step = -np.linalg.solve(H[todo] + soft, residual[:, todo].T[..., None])[..., 0].T
            p[:, todo], H[todo] = self._searched(q[:, todo], p[:, todo], H[todo], step)
            residual[:, todo] = _times(H[todo], p[:, todo]) - q[:, todo]
        raise SolutionError(
            f"the forces in the bolts were not found in {MOST_STEPS} steps at {todo.size} instants"
        )

    def _searched(self, q: Array, p: Array, H: Array, step: Array) -> tuple[Array, Array]:
        """Return p and H after a step that is halved until the function decreases enough."""
        units = np.array([[1.0], [self.size], [self.size]])

        def energy(H: Array, p: Array, q: Array) -> tuple[Array, Array]:
            """The function, and the norm of its gradient."""
            force = _times(H, p)
            function = np.sum(p * (0.5 * force - q), axis=0)
            return function, np.linalg.norm((force - q) / units, axis=0)

        before, off = energy(H, p, q)
        slope = np.sum(step * (_times(H, p) - q), axis=0)
        part = np.ones(q.shape[1])
        after, stiffness = p + step, self.stiffness(p + step)
        late = np.arange(q.shape[1])
        for _ in range(MOST_HALVES):
            function, left = energy(stiffness[late], after[:, late], q[:, late])
            limit = before[late] + ARMIJO * part[late] * slope[late]
            # Near the minimum the decrease is below rounding: half of the gradient counts, too.
            late = late[(function > limit) & (left > 0.5 * off[late])]
            if not late.size:
                break
            part[late] *= 0.5
            after[:, late] = p[:, late] + part[late] * step[:, late]
            stiffness[late] = self.stiffness(after[:, late])
        return after, stiffness


def _matrices(entries: Array) -> Array:
    """Return symmetric matrices (n_t, 3, 3) from their entries 11, 12, 13, 22, 23, 33, (6, n_t)."""
    return np.asarray(entries.T[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3))


def rotated(force: Array, degrees: float | Index) -> Array:
    """Turn forces and moments about the vertical through the anchor point.

    Args:
        force: Shape (6, n_t) [N, N m].
        degrees: Rotation from x towards y, one or one for each instant [degree].
    """
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    x, y, z, rx, ry, rz = force
    turned = (c * x - s * y, s * x + c * y, z, c * rx - s * ry, s * rx + c * ry, rz)
    return np.asarray(np.stack(turned), dtype=np.float64)


@results
class BoltDemand:
    """Largest demand on the bolts of a base plate over time, in the critical direction.

    The horizontal components of force and moment are turned together about the vertical through the
    anchor point, by 0 to 360 degrees: the motion may come from any direction, or the equipment may
    be turned on its floor. Zero is the direction of the analysis.
    """

    interaction: float = si("-", "interaction, (T/T_R)^k + (V/V_R)^k of the governing bolt")
    interaction_as_computed: float = si("-", "interaction as computed, without rotation")
    bolt: int = si("", "governing bolt, number from 1")
    time: float = si("s", "time, of the largest interaction")
    direction: float = si("deg", "critical direction, rotation of the horizontal components")
    bolt_tension: float = si("N", "its tension, of this bolt at this time", shown="kN")
    bolt_shear: float = si("N", "its shear, of this bolt at this time", shown="kN")
    tension: float = si("N", "largest tension, of all bolts, times and directions", shown="kN")
    shear: float = si("N", "largest shear, of all bolts, times and directions", shown="kN")


def bolt_demand(group: BoltGroup, force: Array, time: Array) -> BoltDemand:
    """Find the largest demand on the bolts over all times and horizontal directions.

    Args:
        group: The bolts.
        force: As of `bolt_forces`, shape (6, n_t) [N, N m].
        time: Of the samples, shape (n_t,) [s].

    Raises:
        SolutionError: No equilibrium was found.
    """
    as_computed = bolt_forces(group, force).interaction(group).max()
    step = SEARCHES[0][0]
    at, turn = (one.ravel() for one in np.mgrid[: force.shape[1], 0:360:step])
    for (step, part), (finer, _) in itertools.pairwise((*SEARCHES, SEARCHES[-1])):
        values = _peaks(group, force, at, turn)
        largest = values.max(axis=1)
        if part < 1.0:
            near = np.flatnonzero((values >= part * largest[:, None]).any(axis=0))
            within = finer * (step // (2 * finer))
            offsets = np.arange(-within, within + 1, finer)
            at = np.repeat(at[near], offsets.size)
            turn = np.add.outer(turn[near], offsets).ravel() % 360
    most = int(values[0].argmax())
    forces = bolt_forces(group, rotated(force[:, at[[most]]], turn[[most]]))
    bolt = int(forces.interaction(group)[:, 0].argmax())
    return BoltDemand(
        interaction=float(largest[0]),
        interaction_as_computed=float(as_computed),
        bolt=bolt + 1,
        time=float(time[at[most]]),
        direction=float(turn[most]),
        bolt_tension=float(forces.tension[bolt, 0]),
        bolt_shear=float(np.hypot(*forces.shear[:, bolt, 0])),
        tension=float(largest[1]),
        shear=float(largest[2]),
    )


def _peaks(group: BoltGroup, force: Array, at: Index, turn: Index) -> Array:
    """Return largest interaction, tension and shear of the bolts, shape (3, n).

    Args:
        group: The bolts.
        force: As of `bolt_forces`, shape (6, n_t) [N, N m].
        at: Numbers of instants, shape (n,).
        turn: Directions at these instants, shape (n,) [degree].
    """
    found = [np.zeros((3, 0))]
    for k in range(0, at.size, CHUNK):
        here = slice(k, k + CHUNK)
        forces = bolt_forces(group, rotated(force[:, at[here]], turn[here]))
        every = forces.interaction(group), forces.tension, np.hypot(*forces.shear)
        found.append(np.array([values.max(axis=0) for values in every]))
    return np.concatenate(found, axis=1)
