"""The stick model of one building: floors as rigid bodies on Timoshenko storeys."""

from bisect import bisect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import scipy.linalg

from impactfem.dynamics.damping import UNDAMPED, DampingLaw
from impactfem.dynamics.soil import Soil
from impactfem.sticks.element import Section, StoreySprings, rigid_link
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import ImpactfemError

HIGH = np.array([1e12])
"""λ of modes beyond those of any storey [1/s2]."""


@dataclass(frozen=True)
class Floor:
    """A floor as a rigid body, and the storey below it."""

    number: int  #: the floor's number, unique in its building
    mass: float  #: mass M [kg]
    #: Moments of inertia (J_x, J_y, J_z) about the mass centre [kg m2].
    inertia: tuple[float, float, float]
    height: float  #: from the mass centre below (or the base) to this mass centre [m]
    #: The storey below the floor, stiffness factors included.
    section: Section | StoreySprings
    below: float = 0.0  #: from the mass centre down to the lower edge of the rigid zone [m]
    above: float = 0.0  #: from the mass centre up to its upper edge [m]


@dataclass(frozen=True)
class StoreyElement:
    """One beam element: its master nodes, its links to them, and its stiffness."""

    storey: int  #: index of the storey, from 0 at the base
    dofs: Index  #: degrees of freedom of the two masters, shape (12,); -1 where clamped
    T: Array  #: from the masters' components to the element's ends, shape (12, 12)
    k: Array  #: stiffness between the element's ends, shape (12, 12)


@dataclass(frozen=True)
class Stick:
    """Assembled matrices of a stick and the positions of its masters.

    Masters are the floors' mass centres, bottom to top, then the points that contact adds inside
    storeys. Each has the components (ux, uy, uz, rx, ry, rz), so n = 6 n_masters.
    """

    name: str  #: the building's name
    floors: tuple[Floor, ...]  #: the floors, bottom to top
    axis: tuple[float, float]  #: plan position (x, y) of the stick [m]
    base: float  #: elevation of the base [m]
    positions: Array  #: position of each master, shape (n_masters, 3) [m]
    M: Array  #: mass matrix, shape (n, n) [kg, kg m2]
    C: Array  #: damping matrix, shape (n, n) [N s/m, N m s]
    K: Array  #: stiffness matrix, shape (n, n) [N/m, N m]
    elements: tuple[StoreyElement, ...]  #: the beam elements, for the forces in the storeys
    damping: DampingLaw | None = None  #: the law of C; None where C is given
    #: Raft and soil about the base; None where it is clamped. M, C and K are those on the base.
    soil: Soil | None = None
    #: Master of each (storey number, relative height) added for contact.
    storey_points: Mapping[tuple[int, float], int] = field(default_factory=dict)

    @property
    def n(self) -> int:
        """Number of degrees of freedom."""
        return int(self.M.shape[0])

    def floor_master(self, number: int) -> int:
        """Index of the master at the mass centre of a floor; ImpactfemError where it is none."""
        numbers = [floor.number for floor in self.floors]
        if number in numbers:
            return numbers.index(number)
        known = ", ".join(map(str, numbers))
        raise ImpactfemError(f"building {self.name} has no floor {number}; its floors: {known}")

    def translation(self, master: int, offset: Sequence[float] = (0.0, 0.0, 0.0)) -> Array:
        """Operator from the displacements to the translation of a point, shape (3, n).

        A rigid link ties the point to the master of this index, at an offset from it [m].
        """
        B = np.zeros((3, self.n))
        B[:, 6 * master : 6 * master + 6] = rigid_link(offset)[:3]
        return B

    def storey_motion(self, number: int, relative_height: float) -> Array:
        """Operator from the displacements to the motion of the axis inside a storey, shape (6, n).

        The storey carries no load between its nodes, and its damping is proportional to its
        stiffness: a massless node at the point, of which the two adjacent elements are in
        equilibrium, moves as the Timoshenko beam does between its ends. The number is that of the
        floor above, the relative height from floor to floor between 0 and 1; a height in a rigid
        zone counts as the end of the flexible part.
        """
        index = self.floor_master(number)
        floor = self.floors[index]
        low, high = flexible_part(floor, self.floors[index - 1] if index else None)
        nodes = sorted(s for storey, s in self.storey_points if storey == number)
        ends = [low, *(s * floor.height for s in nodes), high]
        z = min(max(relative_height * floor.height, low), high)
        k = min(bisect(ends, z), len(ends) - 1) - 1
        element = [element for element in self.elements if element.storey == index][k]
        # N: from the ends of the element to the node.
        lower, upper = z - ends[k], ends[k + 1] - z
        if lower == 0.0 or upper == 0.0:
            N = np.eye(6, 12, 0 if lower == 0.0 else 6)
        else:
            below, above = (floor.section.stiffness(L, L / floor.height) for L in (lower, upper))
            coupling = np.hstack([below[6:, :6], above[:6, 6:]])
            N = -np.linalg.solve(below[6:, 6:] + above[:6, :6], coupling)
        free = element.dofs >= 0
        B = np.zeros((6, self.n))
        B[:, element.dofs[free]] = (N @ element.T)[:, free]
        return B

    def rigid_body(self) -> Array:
        """Unit translations and rotations about the base point of the axis, shape (n, 6)."""
        origin = np.array([*self.axis, self.base])
        return np.vstack([rigid_link(position - origin) for position in self.positions])

    def point_mass(self, master: int, offset: Sequence[float], normal: Array) -> float:
        """Effective mass of a point, at an offset [m] from a master, along a unit vector [kg].

        m = 1 / (j M⁻¹ jᵀ), j the point's translation along the direction: the floor's mass for a
        point on a line through its mass centre, less for an eccentric one. A point inside a storey
        has no mass of its own; it gets the interpolation of the adjacent floors.
        """
        weights = [(master, 1.0)]
        n_floors = len(self.floors)
        if master >= n_floors:
            storey, s = next(k for k, m in self.storey_points.items() if m == master)
            upper = self.floor_master(storey)
            weights = [(upper, s)] + ([(upper - 1, 1.0 - s)] if upper else [])
        inverse = 0.0
        for node, weight in weights:
            block = slice(6 * node, 6 * node + 6)
            j = weight * normal @ rigid_link(offset)[:3]
            inverse += float(j @ np.linalg.solve(self.M[block, block], j))
        return 1.0 / inverse

    def element_forces(self, u: Array) -> Array:
        """Elastic forces at the upper end of each beam element, acting on the part above.

        They balance the elastic forces K u of the masters above, floors and points inside storeys.
        Of displacements of shape (..., n) [m, rad] the forces along [N] and moments about [N m] x,
        y, z, shape (..., n_elements, 6).
        """
        loads = u @ self.K
        upper = []
        for element in self.elements:
            master = int(element.dofs[6]) // 6
            # The end of the element lies at an offset along z from its master.
            end = self.positions[master] + [0.0, 0.0, element.T[6, 10]]
            above = np.flatnonzero(self.positions[:, 2] >= self.positions[master, 2])
            # Work of rigid motions of the part above, about the end.
            motion = np.zeros((self.n, 6))
            for k in above:
                motion[6 * k : 6 * k + 6] = rigid_link(self.positions[k] - end)
            upper.append(-loads @ motion)
        return np.stack(upper, axis=-2)


def build_stick(
    name: str,
    floors: Sequence[Floor],
    *,
    damping: DampingLaw = UNDAMPED,
    axis: tuple[float, float] = (0.0, 0.0),
    base: float = 0.0,
    soil: Soil | None = None,
    storey_points: Sequence[tuple[int, float]] = (),
) -> Stick:
    """Assemble a stick from its floors.

    Each floor has three nodes (lower edge of the cross beams, mass centre, upper edge); rigid
    links tie the edges to the mass centre by transformation, so that no large stiffness enters.
    The storeys between the edges are massless; all mass is the floors'.

    Args:
        name: The building's name.
        floors: The floors, bottom to top.
        damping: Its law.
        axis: Plan position (x, y) of the axis [m].
        base: Elevation of the base [m].
        soil: Raft and soil under it; clamped when None.
        storey_points: Points (floor number above, relative height from floor to floor) where
            contact needs a node of its own inside the flexible part of a storey.

    ImpactfemError where a storey has no flexible length left between its rigid zones; a point is
    not inside its storey, or the damping does not grow with the stiffness, so that a node without
    mass would ring for ever.
    """
    z = base + np.cumsum([floor.height for floor in floors])
    positions = [np.array([*axis, height]) for height in z]
    masters: dict[tuple[int, float], int] = {}
    elements: list[StoreyElement] = []
    for index, floor in enumerate(floors):
        foot = z[index - 1] if index else base
        low, high = flexible_part(floor, floors[index - 1] if index else None)
        if not high > low:
            raise ImpactfemError(
                f"building {name}: the storey below floor {floor.number} has no flexible length: "
                f"its rigid zones leave {high - low:.3g} m"
            )
        # Nodes from the lower to the upper end of the flexible part: the master, -1 at the clamped
        # base, the offset from it along z, and the height above the floor below.
        nodes = [(index - 1, low, low)]
        for s in sorted({s for number, s in storey_points if number == floor.number}):
            ends = low / floor.height, high / floor.height
            _check_point(name, floor, s, ends, damping)
            masters[floor.number, s] = len(positions)
            nodes.append((len(positions), 0.0, s * floor.height))
            positions.append(np.array([*axis, foot + nodes[-1][2]]))
        nodes.append((index, high - floor.height, high))
        for lower, upper in pairwise(nodes):
            T = scipy.linalg.block_diag(*(rigid_link((0.0, 0.0, end[1])) for end in (lower, upper)))
            dofs = [
                6 * end[0] + c if end[0] >= 0 else -1 for end in (lower, upper) for c in range(6)
            ]
            L = upper[2] - lower[2]
            k = floor.section.stiffness(L, L / floor.height)
            elements.append(StoreyElement(index, np.array(dofs, dtype=np.int64), T, k))
    M, K = _matrices(floors, elements, len(positions))
    return Stick(
        name=name,
        floors=tuple(floors),
        axis=axis,
        base=base,
        positions=np.array(positions),
        M=M,
        C=damping.matrix(K, M),
        K=K,
        elements=tuple(elements),
        damping=damping,
        soil=soil,
        storey_points=masters,
    )


def flexible_part(floor: Floor, lower: Floor | None) -> tuple[float, float]:
    """Return the ends of the flexible part of the storey below a floor, above the floor below [m].

    Springs join the floors themselves; a section ends at the rigid zones of both floors.
    """
    if isinstance(floor.section, StoreySprings):
        return 0.0, floor.height
    return 0.0 if lower is None else lower.above, floor.height - floor.below


def on_floor_matrices(stick: Stick, K: Array, M: Array) -> Stick:
    """Return the stick with other matrices of its floors.

    Points inside storeys keep their elements: with no force on them, the floors have the stiffness
    K. The forces in the storeys balance the floors.

    Args:
        stick: The stick, whose elements give the motion inside storeys.
        K: Stiffness of its floors, shape (6 f, 6 f) [N/m, N m].
        M: Mass of its floors, shape (6 f, 6 f) [kg, kg m2].
    """
    n = len(K)
    floors, points = slice(None, n), slice(n, None)
    whole, mass = stick.K.copy(), stick.M.copy()
    held = whole[floors, points] @ np.linalg.solve(whole[points, points], whole[points, floors])
    whole[floors, floors] += K - (whole[floors, floors] - held)
    mass[floors, floors] = M
    damping = UNDAMPED if stick.damping is None else stick.damping
    return replace(stick, K=whole, M=mass, C=damping.matrix(whole, mass))


def _check_point(
    name: str, floor: Floor, s: float, ends: tuple[float, float], damping: DampingLaw
) -> None:
    """Refuse a point inside the storey below a floor that cannot be a node."""
    if not ends[0] < s < ends[1]:
        raise ImpactfemError(
            f"building {name}: a point inside the storey below floor {floor.number} needs a "
            f"relative height between its rigid zones, {ends[0]:.4g} to {ends[1]:.4g}, got {s:g}; "
            "its ends are points of floors"
        )
    if not damping.stiffness_part(HIGH) > 0.0:
        raise ImpactfemError(
            f"building {name}: a contact point inside the storey below floor "
            f"{floor.number} has no mass and needs damping of the storey "
            "(stiffness_coefficient above 0)"
        )


def _matrices(
    floors: Sequence[Floor], elements: Sequence[StoreyElement], nodes: int
) -> tuple[Array, Array]:
    """Mass and stiffness of a stick, shape (6 nodes, 6 nodes) each."""
    M, K = np.zeros((2, 6 * nodes, 6 * nodes))
    for index, floor in enumerate(floors):
        block = np.arange(6 * index, 6 * index + 6)
        M[block, block] = [floor.mass] * 3 + list(floor.inertia)
    for element in elements:
        k = element.T.T @ element.k @ element.T
        free = element.dofs >= 0
        at = np.ix_(element.dofs[free], element.dofs[free])
        K[at] += k[np.ix_(free, free)]
    return M, (K + K.T) / 2.0


def mass_on_spring(
    name: str,
    mass: float,
    stiffness: float | None = None,
    *,
    frequency: float | None = None,
    damping_ratio: float | None = None,
    dashpot: float = 0.0,
    position: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Stick:
    """An oscillator: a mass on a spring and a dashpot to the ground, the same in all directions.

    M = m I, K = k I, C = c I: its translations along x, y, z do not couple. Its rotations, with
    m · 1 m² and k · 1 m², keep the matrices regular; a force on the mass itself turns nothing. It
    is floor 1 of a stick, whose element is the spring.

    Args:
        name: Its name, unique in a system.
        mass: m [kg].
        stiffness: k [N/m]; 0 leaves the mass free.
        frequency: In place of it, √(k/m) / 2π [Hz].
        damping_ratio: ξ of c = 2 ξ √(k m) [-].
        dashpot: In place of it, c [N s/m].
        position: Where the mass is at rest [m].

    ImpactfemError where the mass is not positive, not one of stiffness and frequency is given, both
    damping_ratio and dashpot are, or a value is below zero.
    """
    if not mass > 0.0:
        raise ImpactfemError(f"{name}: expected a mass above 0 kg, got {mass:g}")
    if (stiffness is None) == (frequency is None):
        raise ImpactfemError(f"{name}: expected either a stiffness or a frequency")
    if damping_ratio is not None and dashpot:
        raise ImpactfemError(f"{name}: expected either damping_ratio or dashpot, not both")
    if min(stiffness or 0.0, frequency or 0.0, damping_ratio or 0.0, dashpot) < 0.0:
        raise ImpactfemError(f"{name}: expected no value below 0")
    k = mass * (2.0 * np.pi * frequency) ** 2 if frequency is not None else float(stiffness or 0.0)
    c = 2.0 * damping_ratio * np.sqrt(k * mass) if damping_ratio is not None else dashpot
    unit = Section(E=1.0, G=1.0, A=1.0, Avx=1.0, Avy=1.0, Ix=1.0, Iy=1.0, Iz=1.0)
    floor = Floor(1, mass, (mass, mass, mass), 1.0, unit)
    x, y, z = position
    ends = np.array([-1] * 6 + list(range(6)), dtype=np.int64)
    between = k * np.kron(np.array([[1.0, -1.0], [-1.0, 1.0]]), np.eye(6))
    return Stick(
        name=name,
        floors=(floor,),
        axis=(x, y),
        base=z - 1.0,
        positions=np.array([[x, y, z]]),
        M=mass * np.eye(6),
        C=c * np.eye(6),
        K=k * np.eye(6),
        elements=(StoreyElement(0, ends, np.eye(12), between),),
    )
