"""The 3D model of a building that hits a rigid wall with the edges of its floors.

It starts from rest, with one floor drawn aside. With n towards the wall and the displacement d of
the displaced floor,

- `whole_floor`: n · u = d at every node of its slab. With the rows s of these displacements and the
  rows f of all others, K_ff u_f = −K_fs u_s; the constraint forces K_sf u_f + K_ss u_s hold it.
- `even_load`: K u = q, q an even load in the plane of the slab, scaled so that n · u = d at the
  mass centre. The slab arrives bowed: it yields in its plane between the walls that hold it back.
- `mass_centre`: the same with one force at the mass centre, which also draws out the slab about it.

A slab is flat: with n · u = d at all of its nodes it neither deforms along n nor turns about the
vertical, but may tilt and yield across n. The floor of a stick is rigid, and force and turning are
not coupled about its axis: its three states are one (see `static_state` of the stage `calibrate`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import scipy.sparse
from numpy.typing import NDArray
from petsc4py import PETSc

from impactfem.building.floor import contact_edge, floor_load
from impactfem.building.links import carried
from impactfem.building.mesh import DOFS, BuildingMesh, outward_normal
from impactfem.building.model import BuildingModel
from impactfem.case.calibration import Pull
from impactfem.dynamics.columns import product, wrapped
from impactfem.dynamics.factorisation import Factorisation
from impactfem.reduction.galerkin import GalerkinModes
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import Fault, InputError

Flags = NDArray[np.bool_]
Side = Literal["x-", "x+", "y-", "y+"]

IN_PLANE = 1e-4
"""Largest distance of the nodes of edges from one plane [m]: 1 % of the paper's gap."""
TOUCHED = 1e-12
"""Square of an arm [m2] up to which a rotation is not needed to hold the followers of a plate."""


def wall_side(mesh: BuildingMesh, floors: tuple[int, ...], file: Path | str) -> Side:
    """The side that the edges of floors face, where one plane wall can stand. Not collective.

    Raises:
        InputError: With every fault, of the mesh's file: a floor without an edge, an edge that is
            not straight along x or y, edges on different sides or not in one plane.
    """
    expected = "no lines; expected those of the slab's edge that may hit the wall"
    faults = [
        Fault(file, f"edge_{k}", None, expected) for k in floors if not len(mesh.edges.get(k, ()))
    ]
    if faults:
        raise InputError(faults)
    # The side that each edge is on, and its outermost position along the normal.
    sides: dict[int, tuple[Side, float]] = {}
    for k in floors:
        normal = outward_normal(mesh, k)
        axis = int(np.argmax(np.abs(normal)))
        along = np.sign(normal[axis]) * mesh.nodes[np.unique(mesh.edges[k]), axis]
        names: tuple[Side, ...] = ("x-", "x+", "y-", "y+")
        sides[k] = names[2 * axis + (normal[axis] > 0.0)], float(along.max())
        if (spread := float(np.ptp(along))) > IN_PLANE:
            expected = (
                f"the edge is not straight along x or y, its nodes are up to {spread:.4g} m off; "
                "expected one that lies flat against a plane wall"
            )
            faults.append(Fault(file, f"edge_{k}", None, expected))
    if faults:
        raise InputError(faults)
    top = max(floors)
    side, position = sides[top]
    for k, (other, own) in sides.items():
        if other != side:
            expected = f"faces {other}, edge_{top} {side}; expected all on the side of the wall"
            faults.append(Fault(file, f"edge_{k}", None, expected))
        elif abs(own - position) > IN_PLANE:
            expected = (
                f"is {abs(own - position):.4g} m {'before' if own > position else 'behind'} "
                f"edge_{top}; expected the edges of all floors that may hit the wall in one plane"
            )
            faults.append(Fault(file, f"edge_{k}", None, expected))
    if faults:
        raise InputError(faults)
    return side


@dataclass(frozen=True, eq=False)
class FloorPull:
    """Load or constraint that displaces a floor, at this rank's rows."""

    kind: Pull  #: How the floor is displaced.
    normal: Array  #: n, unit vector towards the wall along x or y, shape (3,).
    #: Rows of the displacements along n of the slab's nodes; with rigid links also the rotations of
    #: masters that turn followers of the slab along n; shape (n_local,).
    slab: Flags
    #: Load with the resultant 1 N along n; zero where the whole floor is held, shape (n_local,).
    load: Array

    @property
    def unit(self) -> Array:
        """Values of the rows of the slab when it moves by 1 m along n, else 0, shape (n_local,)."""
        of_row = np.tile(np.pad(self.normal, (0, DOFS - 3)), len(self.slab) // DOFS)
        return np.asarray(np.where(self.slab, of_row, 0.0), dtype=np.float64)

    def carried(self, T: Any) -> FloorPull:
        """Return the pull of the building with the rigid links T of `linked`. Collective."""
        # The diagonal of Tᵀ S T, S the rows of the slab: Σ T_ij², positive where j moves one.
        S = PETSc.Mat().createAIJ(
            ((T.getLocalSize()[0], None),) * 2, nnz=1, comm=T.getComm(), bsize=DOFS
        )
        S.setDiagonal(wrapped(S, self.slab.astype(np.float64)))
        S.assemble()
        moved = S.ptap(T)
        diagonal = moved.getDiagonal()
        slab = np.array(diagonal.getArray() > TOUCHED)
        for made in (S, moved, diagonal):
            made.destroy()
        return replace(self, slab=slab, load=carried(T, self.load[:, None])[:, 0])

    def state(self, K: Any, centre: Any) -> Array:
        """The static displacement for 1 m of the floor, shape (n_local,). Collective.

        It costs one factorisation of K (AIJ); `centre` is the row of n · u at the mass centre.

        Raises:
            SolutionError: The stiffness is not positive definite.
        """
        comm = K.getComm().tompi4py()
        if self.kind != "whole_floor":
            with Factorisation(K, name="the stiffness matrix") as factor:
                u = factor.solve_block(self.load[:, None])[:, 0]
            return np.asarray(u / comm.allreduce(float((centre.T @ u)[0])), dtype=np.float64)
        u = self.unit
        free = np.flatnonzero(~self.slab)
        first = K.getOwnershipRange()[0]
        rows = PETSc.IS().createGeneral((first + free).astype(PETSc.IntType), comm=K.getComm())
        K_ff = K.createSubMatrix(rows, rows)
        K_ff.setOption(PETSc.Mat.Option.SPD, True)
        with Factorisation(K_ff, name="the stiffness matrix of all but the floor") as factor:
            u[free] = factor.solve_block(-product(K, u[:, None])[free])[:, 0]
        K_ff.destroy()
        rows.destroy()
        return u


@dataclass(frozen=True)
class Wall:
    """A rigid wall, and the floor that is displaced and released."""

    floors: tuple[int, ...]  #: Floors that may hit the wall.
    displaced_floor: int  #: The floor that is displaced.
    pull: Pull  #: How it is displaced.
    spacing: float | None = None  #: Least distance of points of contact along an edge [m].


@dataclass(frozen=True, eq=False)
class WallPatterns:
    """Columns of a wall experiment at this rank's rows."""

    floors: tuple[int, ...]  #: Floors that may hit the wall.
    floor_of: Index  #: Index into `floors` of each constraint, shape (m,).
    #: G: Gᵀ u is the displacement towards the wall of each constraint, shape (n_local, m), sparse.
    contact: scipy.sparse.csr_matrix
    pull: FloorPull  #: Load or constraint that displaces the floor.
    #: Rows of n · u at the mass centre of each floor, then of the displaced one, shape (n_local,
    #: n_floors + 1), sparse.
    seen: scipy.sparse.csr_matrix

    @classmethod
    def of(cls, model: BuildingModel, mesh: BuildingMesh, wall: Wall) -> WallPatterns:
        """Make the columns of an experiment, with edges that lie in one plane (see `wall_side`).

        Raises:
            KeyError: A floor has no edge, no slab or no mass centre.
        """
        floors, displaced = wall.floors, wall.displaced_floor
        normal = outward_normal(mesh, floors[-1])
        edges = [contact_edge(mesh, floor, wall.spacing) for floor in floors]
        contacts = [edge.columns(model, normal) for edge in edges]
        watched = np.array([*(mesh.centres[floor] for floor in floors), mesh.centres[displaced]])
        counts = [columns.shape[1] for columns in contacts]
        rows = model.rows(np.unique(mesh.triangles[mesh.slab(displaced)]))
        slab = np.zeros(DOFS * len(model.nodes), dtype=bool)
        slab[rows[rows >= 0] + int(np.argmax(np.abs(normal)))] = True
        load = np.zeros(len(slab))
        if wall.pull == "mass_centre":
            load = model.along(watched[-1:], normal).toarray()[:, 0]
        elif wall.pull == "even_load":
            load = floor_load(mesh, displaced).vector(model, normal)
        return cls(
            floors=floors,
            floor_of=np.repeat(np.arange(len(floors), dtype=np.int64), counts),
            contact=scipy.sparse.csr_matrix(scipy.sparse.hstack(contacts)),
            pull=FloorPull(wall.pull, normal, slab, load),
            seen=model.along(watched, normal),
        )

    def held(self, K: Any) -> tuple[Array, Array]:
        """The state at rest for 1 m of the displaced floor, and what holds it. Collective.

        Of the stiffness K: u with n · u = 1 at the mass centre, and K u, each of shape (n_local,).

        Raises:
            SolutionError: The stiffness is not positive definite.
        """
        state = self.pull.state(K, self.seen[:, -1])
        push = product(K, state[:, None])[:, 0]
        if self.pull.kind == "whole_floor":
            push[~self.pull.slab] = 0.0  # there K u is the rounding of the solution
        return state, push

    def carried(self, T: Any) -> WallPatterns:
        """The columns of the building with rigid links, forces on followers on their masters."""
        contact, seen = (_carried(T, columns) for columns in (self.contact, self.seen))
        return replace(self, contact=contact, pull=self.pull.carried(T), seen=seen)


def _carried(T: Any, columns: scipy.sparse.csr_matrix) -> scipy.sparse.csr_matrix:
    # One by one: all of them are too many for a dense array of the building's size.
    found = [
        scipy.sparse.csr_matrix(carried(T, columns[:, [k]].toarray()))
        for k in range(columns.shape[1])
    ]
    return scipy.sparse.csr_matrix(scipy.sparse.hstack(found))


@dataclass(frozen=True, eq=False)
class WallModel:
    """Modal equations of a building and its wall, for any damping, gap and displacement."""

    eigenvalue: Array  #: λ, shape (r,) [1/s2].
    contact: Array  #: Γ = Φᵀ G, shape (r, m).
    push: Array  #: Φᵀ f of the forces that hold the floor at 1 m, shape (r,).
    #: Φᵀ L of the mass centres, then of the displaced floor's, shape (r, n_floors + 1).
    seen: Array
    floors: Index  #: Floors that may hit, shape (n_floors,).
    floor_of: Index  #: Index into `floors` of each constraint, shape (m,).
    difference: float  #: Estimated error of the basis under even loads on the edges.
    #: Largest departure of the displaced floor's slab from its displacement along n, over it,
    #: before the release.
    uneven: float

    @classmethod
    def of(
        cls, modes: GalerkinModes, patterns: WallPatterns, push: Array, difference: float
    ) -> WallModel:
        """The modal equations of a wall experiment. Collective.

        The modes are those on a basis that is complete for the contacts and has the state before
        the release; `push` are the forces that hold the floor at 1 m, shape (n_local,).
        """
        b = modes.rows(push[:, None])[:, 0]
        z = b / modes.eigenvalue
        slab = np.flatnonzero(patterns.pull.slab)
        moved = modes.vectors.combination((modes.coordinates @ z)[:, None])[slab, 0]
        away = np.abs(moved - patterns.pull.unit[slab]).max(initial=0.0)
        return cls(
            eigenvalue=modes.eigenvalue,
            contact=modes.rows(patterns.contact),
            push=b,
            seen=modes.rows(patterns.seen),
            floors=np.array(patterns.floors, dtype=np.int64),
            floor_of=patterns.floor_of,
            difference=difference,
            uneven=max(modes.vectors.M.getComm().tompi4py().allgather(float(away))),
        )

    def start(self, displacement: float) -> Array:
        """z₀ = λ⁻¹ b d, b of the forces that hold the floor at 1 m, shape (r,).

        The state that they hold is in the basis: z₀ is that state, not an approximation of it. d is
        the displacement of the floor's mass centre, towards the wall [m].
        """
        z = self.push / self.eigenvalue
        return np.asarray(displacement * z / (self.seen[:, -1] @ z), dtype=np.float64)
