"""How a floor is drawn aside before its release: the state at rest that the building starts from.

With n towards the wall and the displacement d of the displaced floor,

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
from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from impactfem.building.floor import NodalLoad, floor_load
from impactfem.building.links import carried
from impactfem.building.mesh import DOFS, BuildingMesh
from impactfem.building.model import BuildingModel
from impactfem.case.wall_impact import Pull
from impactfem.dynamics.columns import product, wrapped
from impactfem.dynamics.factorisation import Factorisation

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

TOUCHED = 1e-12
"""Square of an arm [m2] up to which a rotation is not needed to hold the followers of a plate."""


@dataclass(frozen=True, eq=False)
class FloorPull:
    """What displaces a floor, at this rank's rows."""

    kind: Pull  #: How the floor is drawn aside.
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
        """The same of the building with rigid links. Collective.

        Args:
            T: Of `impactfem.building.links.linked`.
        """
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
        """The static displacement of the building for 1 m of the floor, shape (n_local,).

        It costs one factorisation. Collective.

        Args:
            K: Stiffness (AIJ), positive definite.
            centre: Row of n · u at the floor's mass centre, shape (n_local, 1), sparse.

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


def floor_pull(
    model: BuildingModel, mesh: BuildingMesh, floor: int, normal: Array, kind: Pull
) -> FloorPull:
    """What displaces a floor towards the wall.

    Args:
        model: The building.
        mesh: Its mesh.
        floor: Number of the floor.
        normal: n, unit vector towards the wall along x or y, shape (3,).
        kind: How the floor is drawn aside.

    Raises:
        KeyError: The floor has no slab or no mass centre.
    """
    even = floor_load(mesh, floor)
    at_centre = NodalLoad(np.array([mesh.centres[floor]]), np.ones(1))
    axis = int(np.argmax(np.abs(normal)))
    rows = model.rows(np.unique(mesh.triangles[mesh.slab(floor)]))
    slab = np.zeros(DOFS * len(model.nodes), dtype=bool)
    slab[rows[rows >= 0] + axis] = True
    direction = (float(normal[0]), float(normal[1]), float(normal[2]))
    if kind == "whole_floor":
        load = np.zeros(len(slab))
    else:
        load = (even if kind == "even_load" else at_centre).vector(model, direction)
    return FloorPull(kind, normal, slab, load)
