"""A floor: loads on its edge and its slab, contact along its edge, and the floor as a bar."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse

from impactfem.building.facade import facades
from impactfem.building.mesh import BuildingMesh, area_shares, areas, line_lengths
from impactfem.building.parts import BuildingParts, lever_rule
from impactfem.system.arrays import Array, Index

if TYPE_CHECKING:
    from impactfem.building.model import BuildingModel

Line = tuple[tuple[float, float], ...]
"""A line load: positions along a side, ascending [m], and its values there [N/m]."""

IN_EDGE = 1e-6
"""How far from an edge a cell may be that stands in it, over the length of the bar."""


@dataclass(frozen=True, eq=False)
class NodalLoad:
    """Parallel forces on nodes with the resultant 1 N."""

    nodes: Index  #: The nodes, shape (n,).
    forces: Array  #: Force on each of them for the unit resultant, shape (n,) [N/N].

    def vector(self, model: BuildingModel, direction: Sequence[float] | Array) -> Array:
        """The load at this rank's rows, shape (n_local,); the resultant is along a unit vector."""
        return np.asarray(model.along(self.nodes, direction) @ self.forces)


def linear(start: float, end: float, at: float) -> Line:
    """The straight line load of 1 N from one position to another [m], its resultant at a third.

    With the length ℓ and the distance e of the resultant from the middle s0 it is
    q(s) = (1 + 12 e (s − s0) / ℓ²) / ℓ.
    """
    length = end - start
    e = at - 0.5 * (start + end)
    return tuple(
        (s, (1.0 + sign * 6.0 * e / length) / length) for s, sign in ((start, -1), (end, 1))
    )


def edge_load(
    mesh: BuildingMesh, floor: int, side: str = "", line: Line | None = None
) -> NodalLoad:
    """Consistent nodal forces ∫ N q ds of a line load on a side of a floor, as of `facades`.

    q is straight between the positions that it is given at and zero outside of them; uniform with
    the resultant 1 N when None. Of one position alone, 1 N there.

    Raises:
        KeyError: The floor has no such side.
    """
    facade, lines = facades(mesh, floor, side)[side]
    t = np.array(facade.along[:2])
    ends = mesh.nodes[lines[:, :2], :2] @ t
    forces, nodes = np.zeros(len(mesh.nodes)), np.unique(lines)
    if line is not None and len(line) == 1:
        # A force on a point of the element that has it.
        s = line[0][0] + np.array(facade.start) @ t
        k = int(np.abs(np.clip(s, ends.min(axis=1), ends.max(axis=1)) - s).argmin())
        ξ = (s - ends[k, 0]) / (ends[k, 1] - ends[k, 0])
        forces[lines[k]] = (1.0 - ξ) * (1.0 - 2.0 * ξ), ξ * (2.0 * ξ - 1.0), 4.0 * ξ * (1.0 - ξ)
        return NodalLoad(nodes, forces[nodes])
    if line is None:
        # ∫ N ds of a quadratic element is h (1, 1, 4) / 6.
        h = np.abs(ends[:, 1] - ends[:, 0]) * (1.0 / np.ptp(ends))
        for column, share in enumerate((h / 6.0, h / 6.0, h * 2.0 / 3.0)):
            np.add.at(forces, lines[:, column], share)
        return NodalLoad(nodes, forces[nodes])
    ends -= np.array(facade.start) @ t
    known, q = np.array(line).T
    # On the part of each element between two neighbours of `known` N q is a cubic.
    for a, b in itertools.pairwise(known):
        low, high = (np.clip(end, a, b) for end in (ends.min(axis=1), ends.max(axis=1)))
        inside = high > low
        (s0, s1), low, high = ends[inside].T, low[inside], high[inside]
        for node in (-1.0 / math.sqrt(3.0), 1.0 / math.sqrt(3.0)):
            s = 0.5 * (low + high) + 0.5 * (high - low) * node
            ξ = (s - s0) / (s1 - s0)
            N = np.array([(1.0 - ξ) * (1.0 - 2.0 * ξ), ξ * (2.0 * ξ - 1.0), 4.0 * ξ * (1.0 - ξ)])
            weight = 0.5 * (high - low) * np.interp(s, known, q)
            np.add.at(forces, lines[inside], (N * weight).T)
    return NodalLoad(nodes, forces[nodes])


def floor_load(mesh: BuildingMesh, floor: int) -> NodalLoad:
    """Consistent nodal forces of an even load with the resultant 1 N over the slab of a floor.

    What stands upright on the slab takes no load.

    Raises:
        KeyError: The floor has no slab.
    """
    flat = mesh.triangles[mesh.slab(floor)]
    if not len(flat):
        raise KeyError(f"floor {floor} has no slab")
    shares = area_shares(mesh.nodes, flat)
    nodes = np.unique(flat[:, 3:])
    return NodalLoad(nodes, shares[nodes] / areas(mesh.nodes, flat).sum())


@dataclass(frozen=True, eq=False)
class ContactEdge:
    """Contact along a side with a pressure that is straight between its vertices.

    With the hat function N_i of vertex i along the edge, w_i = ∫ N_i ds and the displacement u_n
    towards the wall, constraint i is

        g_i = ∫ N_i u_n ds / w_i ≤ gap,

    a weighted mean over the sides next to the vertex. Its force P_i is the resultant of the line
    load P_i N_i / w_i; the resultant of the edge is Σ P_i. On quadratic sides nodal forces would
    alternate between vertices and middles; these do not. Of vertices that are closer to each other
    than a given distance only some have a constraint, and hats that reach to the next of these.
    """

    #: Distance of each constraint from the first end of the edge, ascending, shape (m,) [m].
    position: Array
    weight: Array  #: w_i, shape (m,) [m].
    nodes: Index  #: Nodes of the edge, ascending, shape (n,).
    #: Share of each node in each constraint, shape (n, m), sparse; columns add up to 1.
    means: scipy.sparse.csr_matrix

    def columns(self, model: BuildingModel, normal: Array) -> scipy.sparse.csr_matrix:
        """G at this rank's rows, with g = Gᵀ u, shape (n_local, m); `normal` points to the wall."""
        return scipy.sparse.csr_matrix(model.along(self.nodes, normal) @ self.means)


def contact_edge(
    mesh: BuildingMesh, floor: int, spacing: float | None = None, side: str = ""
) -> ContactEdge:
    """Contact along a side of a floor, as of `facades`.

    Two constraints are a spacing [m] or more apart; there is one at each vertex when None.

    Raises:
        KeyError: The floor has no such side.
    """
    facade, lines = facades(mesh, floor, side)[side]
    ends = mesh.nodes[lines[:, :2]]
    axis = int(np.argmax(np.abs(facade.along)))
    h = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    vertices = np.unique(lines[:, :2])
    vertices = vertices[np.argsort(mesh.nodes[vertices, axis])]
    position = np.linalg.norm(mesh.nodes[vertices] - mesh.nodes[vertices[0]], axis=1)
    nodes = np.unique(lines)
    # Constraint of each vertex of the edge; the place of a node among all is by their order.
    column = np.zeros(len(mesh.nodes), dtype=np.int64)
    column[vertices] = np.arange(len(vertices), dtype=np.int64)
    # With the hat λ_i of an end of a quadratic side: ∫ λ_i (N_i, N_j, N_mid) ds = h (1, 0, 2) / 6.
    first, second, middle = lines.T
    weight = np.zeros(len(vertices))
    np.add.at(weight, column[lines[:, :2]], h[:, None] / 2.0)
    rows = np.searchsorted(nodes, np.concatenate([first, middle, second, middle]))
    columns = column[np.concatenate([first, first, second, second])]
    values = np.concatenate([h / 6.0, h / 3.0, h / 6.0, h / 3.0]) / weight[columns]
    shape = len(nodes), len(vertices)
    shares = scipy.sparse.csr_matrix((values, (rows, columns)), shape=shape)
    # The hats N_I of fewer points are sums of those of all vertices: N_I = Σ_i N_I(s_i) N_i.
    kept = _spread(position, spacing or 0.0)
    hats = np.array([np.interp(position, position[kept], one) for one in np.eye(len(kept))]).T
    coarse = hats.T @ weight
    means = scipy.sparse.csr_matrix(shares @ (weight[:, None] * hats / coarse))
    return ContactEdge(position[kept], coarse, nodes, means)


def _spread(position: Array, spacing: float) -> Index:
    """Both ends, and as many positions between as are no closer than a distance to each other."""
    kept = [0]
    last = len(position) - 1
    for k in range(1, last):
        near = (position[k] - position[kept[-1]], position[last] - position[k])
        if min(near) >= spacing * (1.0 - 1e-9):
            kept.append(k)
    return np.array([*kept, last], dtype=np.int64)


@dataclass(frozen=True)
class FloorBar:
    """A floor as a bar across the building: what a wave between its edges meets, by hand.

    A load normal to an edge, even along it, stretches and presses a wide slab across itself and
    hardly along itself. Across the building the floor is then a bar of the length L, the distance
    of its edges, with

        EA' = (1/L) (∫ E t/(1 − ν²) dA + Σ E A_b cos⁴φ ℓ_b),    m' = (1/L) Σ m,    c = √(EA'/m'),

    where dA is the slab's area, A_b, ℓ_b and φ the section, the length and the angle to the bar of
    its beams, and m the masses of slab and beams and what is added on the slab. Half a storey of
    the walls and columns next to the floor moves with it, too: what stands in the edges themselves
    is a mass at an end of the bar, the rest is spread along it. Eccentricity of the beams, upstands
    and the bending of slab and walls are not in the bar.
    """

    length: float  #: L [m].
    stiffness: float  #: EA' [N].
    slab_mass: float  #: Of slab, beams and what is added on the slab [kg].
    #: Of what stands on the floor and below it by the lever rule, outside of the bar's ends [kg].
    standing_mass: float
    #: Of what stands in the edges at the lower and the upper end [kg].
    end_mass: tuple[float, float]

    @property
    def speed(self) -> float:
        """Speed c = √(EA'/m') of the slab with its beams and what is added on it [m/s]."""
        return math.sqrt(self.stiffness * self.length / self.slab_mass)

    @property
    def crossing(self) -> float:
        """L/c [s]."""
        return self.length / self.speed


def floor_bar(parts: BuildingParts, floor: int, axis: int) -> FloorBar:
    """The bar of a floor, along x (axis 0) or y (axis 1).

    Raises:
        KeyError: The floor has no slab.
    """
    mesh, shells_of, beams_of = parts.mesh, parts.materials.shells, parts.materials.beams
    slab = mesh.slab(floor)
    if not len(slab):
        raise KeyError(f"floor {floor} has no slab")
    along = mesh.nodes[mesh.triangles[slab, :3], axis]
    ends = float(along.min()), float(along.max())
    L = ends[1] - ends[0]
    dA, t = areas(mesh.nodes, mesh.triangles), parts.thickness()
    rho = np.array([m.rho for m in shells_of])[mesh.triangle_part]
    shells = rho * t * dA  # without the added mass, which lies on slabs alone
    plane = np.array([m.E / (1.0 - m.nu**2) for m in shells_of])[mesh.triangle_part]
    EA = float((plane * t * dA)[slab].sum()) / L
    in_slab = float((shells + parts.added_mass * dA)[slab].sum())
    beams = mesh.lines_of("beam", floor)
    A, ell, rods = np.zeros(0), np.zeros(0), np.zeros(0)
    if len(mesh.lines):
        A = np.array([section.A for section in parts.sections.beams])[mesh.line_part]
        E = np.array([m.E for m in beams_of])[mesh.line_part]
        ell = line_lengths(mesh)
        rods = np.array([m.rho for m in beams_of])[mesh.line_part] * A * ell
        tangent = mesh.nodes[mesh.lines[beams, 1], axis] - mesh.nodes[mesh.lines[beams, 0], axis]
        EA += float(((E * A)[beams] * (tangent / ell[beams]) ** 4 * ell[beams]).sum()) / L
        in_slab += float(rods[beams].sum())
    upright = np.ones(len(shells), dtype=bool)
    upright[slab] = False
    columns = np.ones(len(rods), dtype=bool)
    columns[beams] = False
    standing, at_ends = 0.0, np.zeros(2)
    for cells, part, of, mass, chosen in (
        (mesh.triangles[:, :3], mesh.triangle_part, mesh.shell_parts, shells, upright),
        (mesh.lines[:, :2], mesh.line_part, mesh.beam_parts, rods, columns),
    ):
        if not len(cells):
            continue
        level, upper = lever_rule(mesh, of, part, cells)
        # Half a storey below goes with the floor, and half of the one that stands on it.
        share = mass * (upper * (level == floor) + (1.0 - upper) * (level == floor + 1)) * chosen
        for end, place in enumerate(ends):
            here = np.abs(mesh.nodes[cells, axis] - place).max(axis=1) < IN_EDGE * L
            at_ends[end] += share[here].sum()
            share[here] = 0.0
        standing += float(share.sum())
    return FloorBar(L, EA, in_slab, standing, (float(at_ends[0]), float(at_ends[1])))
