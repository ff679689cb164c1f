"""From a small mesh of shells and beams to K, M, modes, static and transient solutions.

For one process and meshes that fit it: a plate, a frame, a floor. The elements are those of the 3D
building (`impactfem.building.shell`, `impactfem.building.beam`); docs/from-a-mesh.md shows the way.

    model = shell_model(points, Shells(triangles, 0.2, concrete))
    model = model.hold(model.nodes[:, 0] == 0.0)
    frequency, shapes = model.modes(5)
    u = model.static(model.area_load((0.0, 0.0, -5e3)))

A load is an array of forces and moments on the nodes, shape (n_nodes, 6) [N, N m], in the order of
the displacements (ux, uy, uz, rx, ry, rz) [m, rad]; loads add.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import scipy.sparse
from numpy.typing import ArrayLike, NDArray

from impactfem.building.mesh import BuildingMesh, Part, area_shares, joined_cells, place, sides
from impactfem.building.parts import BuildingParts
from impactfem.building.section import BeamSection, Material, Materials, Sections, ShellSection
from impactfem.dynamics.damping import UNDAMPED, Rayleigh
from impactfem.dynamics.orientation import fields
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import ImpactfemError

if TYPE_CHECKING:
    from impactfem.building.section_forces import SectionForceField
    from impactfem.dynamics.history import History

Vector = tuple[float, float, float]
UX, UY, UZ, RX, RY, RZ = range(6)


@dataclass(frozen=True, eq=False)
class Shells:
    """Triangles of one thickness and material."""

    #: Points of each triangle, shape (m, 3): its vertices; or (m, 6): with the middles of the sides
    #: 01, 12 and 20.
    cells: Index
    thickness: float  #: t [m].
    material: Material  #: Their material.
    added_mass: float = 0.0  #: Mass on the area that does not stiffen [kg/m2].
    corners: ClassVar[int] = 3


@dataclass(frozen=True, eq=False)
class Beams:
    """Straight lines of one section and material."""

    cells: Index  #: Points of each line, shape (m, 2): its ends; or (m, 3): with the middle.
    section: BeamSection  #: Their section.
    material: Material  #: Their material.
    corners: ClassVar[int] = 2


@dataclass(frozen=True, eq=False)
class ShellModel:
    """Matrices of all nodes of a mesh, in their order, six rows for each; and what is held."""

    #: Coordinates, shape (n, 3) [m]: the points given, then the middles of sides that were added.
    nodes: Array
    K: Any  #: Stiffness of all nodes, SciPy CSR, shape (6 n, 6 n).
    M: Any  #: Mass of all nodes, SciPy CSR, shape (6 n, 6 n).
    held: NDArray[np.bool_]  #: Whether a component of a node does not move, shape (n, 6).
    #: Nodes of the triangles, in the order of the parts, shape (m, 6).
    triangles: Index = field(default_factory=lambda: np.zeros((0, 6), dtype=np.int64))
    #: Number of the part of each triangle, counted over all parts, shape (m,).
    part: Index = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    #: Nodes of the beams, shape (l, 3).
    lines: Index = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))
    parts: BuildingParts | None = None  #: What was assembled; None of matrices from elsewhere.
    #: Nodes that cells use, those of the mesh of `parts` in its order.
    used: Index = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    @property
    def free(self) -> Index:
        """Rows of K and M that move, ascending."""
        return np.flatnonzero(~self.held.ravel())

    def rows(self, nodes: ArrayLike, *components: int) -> Index:
        """Rows of K and M of components of some nodes.

        Args:
            nodes: Their numbers, or whether each node is among them, shape (n,).
            components: UX to RZ; all six when none is given.
        """
        chosen = np.array(components or range(6))
        rows: Index = (6 * self._numbers(nodes)[:, None] + chosen).ravel()
        return rows

    def hold(self, nodes: ArrayLike, *components: int) -> ShellModel:
        """The model with components of some nodes held at zero as well; arguments as of `rows`."""
        held = self.held.copy()
        held.ravel()[self.rows(nodes, *components)] = True
        return replace(self, held=held)

    def add_mass(self, nodes: ArrayLike, mass: float) -> ShellModel:
        """The model with a point mass [kg] on each of some nodes, given as for `rows`."""
        diagonal = np.zeros(self.M.shape[0])
        diagonal[self.rows(nodes, UX, UY, UZ)] = mass
        return replace(self, M=(self.M + scipy.sparse.diags(diagonal)).tocsr())

    def nodal_load(
        self, nodes: ArrayLike, force: Vector, moment: Vector = (0.0, 0.0, 0.0)
    ) -> Array:
        """A force [N] and a moment [N m] on each of some nodes, given as for `rows`."""
        load = np.zeros(self.held.shape)
        load[self._numbers(nodes)] = (*force, *moment)
        return load

    def edge_load(self, nodes: ArrayLike, force: Vector) -> Array:
        """An even line load on the sides of triangles and on the beams between some nodes.

        The nodes are given as for `rows`; each side with all three of its nodes among them is
        loaded. The force is the resultant [N].

        Raises:
            ImpactfemError: There is no such side.
        """
        here = np.zeros(len(self.nodes), dtype=bool)
        here[self._numbers(nodes)] = True
        every = np.concatenate([sides(self.triangles), self.lines])
        # A beam on a side, or two triangles at it, are one line: it has one middle.
        _, once = np.unique(every[:, 2], return_index=True)
        lines = every[once][here[every[once]].all(axis=1)]
        if not len(lines):
            raise ImpactfemError("no side of a triangle and no beam lies between these nodes")
        load = np.zeros(self.held.shape)
        load[:, :3] = np.outer(line_load(self.nodes, lines), force)
        return load

    def area_load(self, pressure: Vector, part: int | None = None) -> Array:
        """An even load along x, y, z on the area of the triangles of a part [N/m2].

        The part is its number in the order given to `shell_model`; all when None.

        Raises:
            ImpactfemError: The part has no triangles.
        """
        cells = self.triangles if part is None else self.triangles[self.part == part]
        if not len(cells):
            raise ImpactfemError(f"part {part} has no triangles: a load on an area acts on shells")
        load = np.zeros(self.held.shape)
        load[:, :3] = np.outer(area_shares(self.nodes, cells), pressure)
        return load

    def ground_load(self, acceleration: Vector) -> Array:
        """The load −M r a of a ground acceleration a [m/s2], r a rigid translation.

        Displacements are relative to the ground then. The own weight is (0, 0, 9.81) m/s².
        """
        r = np.zeros(self.held.shape)
        r[:, :3] = acceleration
        return np.asarray(-(self.M @ r.ravel()).reshape(self.held.shape))

    def static(self, load: Array) -> Array:
        """Displacement under a load, of the shape of the load, (n, 6) or (6 n,) [m, rad].

        Raises:
            SingularMatrixError: The model is a mechanism: hold more of it.
        """
        from impactfem.dynamics.factorisation import Factorisation

        K, _ = self._matrices()
        u = np.zeros(self.held.size)
        with Factorisation(K, name="the stiffness matrix") as factor:
            u[self.free] = factor.solve_block(load.reshape(-1, 1)[self.free])[:, 0]
        K.destroy()
        return u.reshape(load.shape)

    def section_forces(self, displacement: Array) -> SectionForceField:
        """Section forces of the shells under a displacement, shape (n, 6) or (6 n,) [m, rad].

        Raises:
            ImpactfemError: The model was made of matrices alone.
        """
        from impactfem.building.section_forces import section_forces

        if self.parts is None:
            raise ImpactfemError("a model made of matrices alone has no shells to cut")
        return section_forces(self.parts, displacement.reshape(-1, 6)[self.used])

    def prescribed(self, values: Array, given: Index) -> Array:
        """Displacement without loads where the rows `given` have their values, shape (6 n,).

        Of the values, of the same shape [m, rad], the given rows count.
        """
        known = np.zeros(len(values))
        known[given] = values[given]
        held = self.held.copy()
        held.ravel()[given] = True
        return np.asarray(known + replace(self, held=held).static(-self.K @ known))

    def modes(self, count: int, *, shift: float = 0.0) -> tuple[Array, Array]:
        """The lowest natural modes; none is missed (`impactfem.dynamics.modes`).

        Of a model that nothing holds, the shift is a frequency f₀ near that of its first elastic
        mode [Hz]: the modes of K + (2π f₀)² M are those of K, and that matrix is definite. Gives
        frequencies, ascending, shape (count,) [Hz], below zero for an eigenvalue ω² below zero, and
        shapes with φᵀ M φ = 1, shape (count, n, 6).

        Raises:
            SingularMatrixError: The model is a mechanism: hold more of it, or give a shift.
        """
        from impactfem.dynamics.modes import modes

        s = (2.0 * np.pi * shift) ** 2
        K, M = self._matrices(s)
        ends = self.nodes.min(axis=0), self.nodes.max(axis=0)
        field = fields(self.nodes, *ends).reshape(self.held.size, -1)[self.free]
        result = modes(K, M, count, fields=field)
        K.destroy()
        M.destroy()
        value = (2.0 * np.pi * result.frequency) ** 2 - s
        shapes = np.zeros((count, self.held.size))
        shapes[:, self.free] = result.shapes.T
        frequency = np.sign(value) * np.sqrt(np.abs(value)) / (2.0 * np.pi)
        return frequency, shapes.reshape(count, *self.held.shape)

    def transient(
        self,
        loads: Array | Sequence[Array],
        amplitudes: Array,
        time_step: float,
        *,
        damping: Rayleigh = UNDAMPED,
        probes: Index | None = None,
        velocity: Array | None = None,
    ) -> History:
        """Response from rest by Newmark's average acceleration, in full order.

        Args:
            loads: One load, shape (n, 6), or several of them.
            amplitudes: Their factors at each time, shape (n_t,), or (n_t, n_loads).
            time_step: Δt [s].
            damping: The damping C = α M + β K.
            probes: Rows that are recorded (`rows`); all when None.
            velocity: Velocity at the first time, shape (n, 6); zero when None [m/s, rad/s].

        Returns:
            Times, motion of the probes by quantity, shape (n_t, n_probes), and energies.

        Raises:
            SolutionError: The step is not positive, or the response is not finite.
        """
        from impactfem.dynamics.newmark import Newmark

        free = self.free
        patterns = np.reshape(loads, (-1, self.held.size))[:, free].T
        factors = np.asarray(amplitudes, dtype=np.float64)
        factors = factors.reshape(len(factors), -1)
        if factors.shape[1] != patterns.shape[1]:
            raise ImpactfemError(
                f"{patterns.shape[1]} loads with {factors.shape[1]} amplitudes at each time"
            )
        rows = np.arange(self.held.size) if probes is None else np.asarray(probes)
        moves = ~self.held.ravel()[rows]
        start = None if velocity is None else np.reshape(velocity, -1)[free]
        K, M = self._matrices()
        with Newmark(K, M, time_step, patterns, damping=damping) as system:
            state = system.start(factors[0], velocity=start)
            history = system.march(state, factors, probes=np.searchsorted(free, rows[moves]))
        K.destroy()
        M.destroy()
        motion = {}
        for name, values in history.motion.items():
            motion[name] = np.zeros((len(values), len(rows)))
            motion[name][:, moves] = values
        return replace(history, motion=motion)

    def _numbers(self, nodes: ArrayLike) -> Index:
        chosen = np.atleast_1d(np.asarray(nodes))
        if chosen.dtype == bool:
            if chosen.shape != (len(self.nodes),):
                raise ImpactfemError(
                    f"{len(chosen)} of True and False for {len(self.nodes)} nodes: middles of "
                    "sides that were added count, take `model.nodes` to choose by place"
                )
            return np.flatnonzero(chosen)
        numbers: Index = chosen.astype(np.int64)
        if numbers.size and not 0 <= numbers.min() <= numbers.max() < len(self.nodes):
            raise ImpactfemError(f"nodes {numbers.min()} to {numbers.max()} of {len(self.nodes)}")
        return numbers

    def _matrices(self, shift: float = 0.0) -> tuple[Any, Any]:
        """K + shift M and M of the free rows, PETSc AIJ on this process alone."""
        free = self.free
        K, M = (matrix[free][:, free] for matrix in (self.K, self.M))
        return petsc_matrix(K + shift * M if shift else K), petsc_matrix(M)


def shell_model(points: ArrayLike, *parts: Shells | Beams, drilling: float = 1.0) -> ShellModel:
    """Assemble shells and beams that share points, on this process alone.

    Cells of first order get middles of their sides: elements are quadratic. A point that no cell
    uses is held.

    Args:
        points: Coordinates, shape (n, 3) [m].
        parts: Shells and beams; each has its own section and material.
        drilling: Factor of the drilling stiffness of the shells.

    Raises:
        ImpactfemError: A cell names a point that is not there or has another number of points than
            it can have; a thickness is not positive; a beam is parallel to the reference of its
            section.
        SolutionError: Middles are not in the middle of their sides.
    """
    from mpi4py import MPI

    from impactfem.building.model import assemble_building

    shells = [part for part in parts if isinstance(part, Shells)]
    beams = [part for part in parts if isinstance(part, Beams)]
    order = [k for k, part in enumerate(parts) if isinstance(part, Shells)]
    given = np.asarray(points, dtype=np.float64)
    _check(given, parts)
    nodes, cells = _quadratic(given, [*shells, *beams])
    triangles, shell = joined_cells(cells[: len(shells)], 6)
    lines, beam = joined_cells(cells[len(shells) :], 3)
    used = np.unique(np.concatenate([triangles.ravel(), lines.ravel()]))
    number = np.zeros(len(nodes), dtype=np.int64)
    number[used] = np.arange(len(used))
    mesh = BuildingMesh(
        nodes=nodes[used],
        triangles=number[triangles],
        triangle_part=shell.astype(np.int32),
        lines=number[lines],
        line_part=beam.astype(np.int32),
        shell_parts=tuple(Part("floor", 1, f"part{k}") for k in range(len(shells))),
        beam_parts=tuple(Part("beam", 1, f"part{k}") for k in range(len(beams))),
        edges={},
        centres={},
        base=np.zeros(0, dtype=np.int64),
    )
    _refuse_parallel(mesh, beams)
    building = BuildingParts(
        mesh=mesh,
        sections=Sections(
            tuple(ShellSection(part.thickness) for part in shells),
            tuple(part.section for part in beams),
        ),
        materials=Materials(
            tuple(part.material for part in shells), tuple(part.material for part in beams)
        ),
        added_mass=np.array([part.added_mass for part in shells])[shell],
        drilling=drilling,
    )
    made = assemble_building(MPI.COMM_SELF, building)
    stiffness = made.stiffness()
    rows = (6 * used[made.nodes][:, None] + np.arange(6)).ravel()
    # Rows of points that no cell uses are empty; zeros of the matrices stay stored.
    K, M = (
        scipy.sparse.coo_matrix(
            (entries.data, (rows[entries.row], rows[entries.col])), shape=2 * (6 * len(nodes),)
        ).tocsr()
        for entries in (csr(matrix).tocoo() for matrix in (stiffness, made.mass))
    )
    for matrix in (stiffness, made.fixed, made.storeys, made.mass):
        matrix.destroy()
    held = np.ones((len(nodes), 6), dtype=bool)
    held[used] = False
    part = np.array(order, dtype=np.int64)[shell]
    return ShellModel(nodes, K, M, held, triangles, part, lines, building, used)


def _refuse_parallel(mesh: BuildingMesh, beams: Sequence[Beams]) -> None:
    """Refuse a beam that is parallel to the reference of its section."""
    along = np.diff(mesh.nodes[mesh.lines[:, :2]], axis=1)[:, 0]
    for k, beam in enumerate(beams):
        of_part = np.flatnonzero(mesh.line_part == k)
        without = of_part[beam.section.along_reference(along[of_part])]
        if without.size:
            raise ImpactfemError(
                f"at {place(mesh.nodes[mesh.lines[without[0], 2]])}: a beam is parallel to the "
                f"reference {beam.section.reference} of its section"
            )


def line_load(nodes: Array, lines: Index) -> Array:
    """Nodal forces of an even load of resultant 1 on lines (ends, middle), shape (n,)."""
    length = np.linalg.norm(nodes[lines[:, 1]] - nodes[lines[:, 0]], axis=1)
    forces = np.zeros(len(nodes))
    np.add.at(forces, lines, np.outer(length, (1.0, 1.0, 4.0)) / 6.0)
    return np.asarray(forces / forces.sum())


def csr(matrix: Any) -> Any:
    """A PETSc matrix (AIJ) of this process alone as SciPy's CSR."""
    return scipy.sparse.csr_matrix(matrix.getValuesCSR()[::-1], shape=matrix.getSize())


def petsc_matrix(matrix: Any) -> Any:
    """A SciPy CSR matrix as PETSc's (AIJ) on this process alone."""
    from petsc4py import PETSc

    arrays = matrix.indptr, matrix.indices, matrix.data
    return PETSc.Mat().createAIJ(matrix.shape, csr=arrays, comm=PETSc.COMM_SELF)


def _quadratic(points: Array, parts: list[Shells | Beams]) -> tuple[Array, list[Index]]:
    """The nodes with the middles of all sides that have none, and the cells of each part."""
    cells = [np.asarray(part.cells, dtype=np.int64) for part in parts]
    sides_of = {2: np.array([[0, 1]]), 3: np.array([[0, 1], [1, 2], [2, 0]])}
    # Of each part, the ends of the sides of each cell, the smaller number first.
    ends = [np.sort(c[:, sides_of[p.corners]], axis=2) for p, c in zip(parts, cells, strict=True)]
    first_order = [c.shape[1] == p.corners for p, c in zip(parts, cells, strict=True)]
    middles: dict[tuple[int, int], int] = {}
    # A side that a cell of second order has keeps its middle.
    for part, c, e, linear in zip(parts, cells, ends, first_order, strict=True):
        if not linear:
            sides = map(tuple, e.reshape(-1, 2).tolist())
            middles |= dict(zip(sides, c[:, part.corners :].ravel().tolist(), strict=True))
    added: list[tuple[int, int]] = []
    for k, e in enumerate(ends):
        if first_order[k]:
            numbers = []
            # The first sides of all cells, then the second ones.
            for a, b in e.transpose(1, 0, 2).reshape(-1, 2).tolist():
                if (a, b) not in middles:
                    middles[a, b] = len(points) + len(added)
                    added.append((a, b))
                numbers.append(middles[a, b])
            cells[k] = np.hstack([cells[k], np.array(numbers).reshape(-1, len(cells[k])).T])
    new = points[np.array(added, dtype=np.int64).reshape(-1, 2)].mean(axis=1)
    return np.concatenate([points, new]), cells


def _check(points: Array, parts: Sequence[Shells | Beams]) -> None:
    """Refuse what would fail later without words."""
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise ImpactfemError(f"expected finite points of shape (n, 3), got {points.shape}")
    if not parts:
        raise ImpactfemError("expected shells or beams, got none")
    for k, part in enumerate(parts):
        cells, corners = np.asarray(part.cells), part.corners
        widths = (3, 6) if corners == 3 else (2, 3)
        what = f"part {k}, {'shells' if corners == 3 else 'beams'}"
        if cells.ndim != 2 or cells.shape[1] not in widths or not len(cells):
            expected = f"cells of shape (m, {widths[0]}) or (m, {widths[1]})"
            raise ImpactfemError(f"{what}: expected {expected}, got {cells.shape}")
        if not 0 <= cells.min() <= cells.max() < len(points):
            points_of = f"points {cells.min()} to {cells.max()}"
            raise ImpactfemError(f"{what}: {points_of}; there are {len(points)}, counted from 0")
        if isinstance(part, Shells) and not part.thickness > 0.0:
            raise ImpactfemError(f"{what}: expected a thickness above 0 m, got {part.thickness:g}")
