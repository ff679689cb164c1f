"""The 3D model of a building that hits a rigid wall with the edges of its floors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from impactfem.building.floor import contact_edge
from impactfem.building.links import carried
from impactfem.building.mesh import DOFS, BuildingMesh, outward_normal
from impactfem.building.model import BuildingModel
from impactfem.case.wall_impact import Pull
from impactfem.dynamics.columns import product
from impactfem.reduction.galerkin import GalerkinModes
from impactfem.reduction.pull import FloorPull, floor_pull

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Wall:
    """A rigid wall, and what is drawn aside before it hits."""

    floors: tuple[int, ...]  #: Floors that may hit the wall.
    displaced_floor: int  #: The floor that is displaced.
    pull: Pull  #: How it is drawn aside.


@dataclass(frozen=True, eq=False)
class WallPatterns:
    """What a wall experiment needs of a building's matrices, as columns at this rank's rows."""

    floors: tuple[int, ...]  #: Floors that may hit the wall.
    normal: Array  #: Unit vector towards the wall, shape (3,).
    floor_of: Index  #: Index into `floors` of each constraint, shape (m,).
    #: G: Gᵀ u is the displacement towards the wall of each constraint, shape (n_local, m), sparse.
    contact: scipy.sparse.csr_matrix
    pull: FloorPull  #: What displaces the floor.
    #: Rows of n · u at the mass centre of each floor, then of the displaced one, shape (n_local,
    #: n_floors + 1), sparse.
    seen: scipy.sparse.csr_matrix

    def held(self, K: Any) -> tuple[Array, Array]:
        """The state at rest for 1 m of the displaced floor, and what holds it. Collective.

        Args:
            K: Stiffness (AIJ), positive definite.

        Returns:
            u with n · u = 1 at the floor's mass centre, and K u, each of shape (n_local,).

        Raises:
            SolutionError: The stiffness is not positive definite.
        """
        state = self.pull.state(K, self.seen[:, -1])
        push = product(K, state[:, None])[:, 0]
        if self.pull.kind == "whole_floor":
            push[~self.pull.slab] = 0.0  # there K u is the rounding of the solution
        return state, push

    def carried(self, T: Any) -> WallPatterns:
        """The columns of the building with rigid links, forces on followers on their masters.

        Args:
            T: Of `impactfem.building.links.linked`.
        """
        return replace(
            self,
            contact=_carried(T, self.contact),
            pull=self.pull.carried(T),
            seen=_carried(T, self.seen),
        )


def _carried(T: Any, columns: scipy.sparse.csr_matrix) -> scipy.sparse.csr_matrix:
    # One by one: all of them are too many for a dense array of the building's size.
    found = [
        scipy.sparse.csr_matrix(carried(T, columns[:, [k]].toarray()))
        for k in range(columns.shape[1])
    ]
    return scipy.sparse.csr_matrix(scipy.sparse.hstack(found))


def wall_patterns(model: BuildingModel, mesh: BuildingMesh, wall: Wall) -> WallPatterns:
    """Make the columns of an experiment.

    Args:
        model: The building.
        mesh: Its mesh.
        wall: The wall; the edges of the floors that may hit it lie in one plane (see `wall_side`).

    Raises:
        KeyError: A floor has no edge, no slab or no mass centre.
    """
    floors, displaced = wall.floors, wall.displaced_floor
    normal = outward_normal(mesh, floors[-1])
    contacts = [contact_edge(mesh, floor).columns(model, normal) for floor in floors]
    watched = np.array([*(mesh.centres[floor] for floor in floors), mesh.centres[displaced]])
    rows = model.rows(watched)
    here = np.flatnonzero(rows >= 0)
    shape = (DOFS * len(model.nodes), len(watched))
    seen = scipy.sparse.csr_matrix(shape)
    for axis in range(3):
        entries = (np.full(len(here), normal[axis]), (rows[here] + axis, here))
        seen = seen + scipy.sparse.csr_matrix(entries, shape=shape)
    counts = [columns.shape[1] for columns in contacts]
    return WallPatterns(
        floors=floors,
        normal=normal,
        floor_of=np.repeat(np.arange(len(floors), dtype=np.int64), counts),
        contact=scipy.sparse.csr_matrix(scipy.sparse.hstack(contacts)),
        pull=floor_pull(model, mesh, displaced, normal, wall.pull),
        seen=scipy.sparse.csr_matrix(seen),
    )


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

    def start(self, displacement: float) -> Array:
        """z₀ = λ⁻¹ b d, b of the forces that hold the floor at 1 m, shape (r,).

        The state that they hold is in the basis: z₀ is that state, not an approximation of it.

        Args:
            displacement: d of the floor's mass centre, towards the wall [m].
        """
        z = self.push / self.eigenvalue
        return np.asarray(displacement * z / (self.seen[:, -1] @ z), dtype=np.float64)

    @classmethod
    def of_content(cls, content: Mapping[str, Any]) -> WallModel:
        """The model with these fields, as read from an archive."""
        values = {field.name: content[field.name] for field in fields(cls)}
        return cls(**values | {name: float(values[name]) for name in ("difference", "uneven")})


def wall_model(
    modes: GalerkinModes, patterns: WallPatterns, push: Array, difference: float
) -> WallModel:
    """The modal equations of a wall experiment. Collective.

    Args:
        modes: Modes on a basis that is complete for the contacts and has the state before the
            release.
        patterns: The columns of the experiment.
        push: The forces that hold the floor at 1 m, shape (n_local,).
        difference: Estimated error of the basis.
    """
    b = modes.rows(push[:, None])[:, 0]
    z = b / modes.eigenvalue
    slab = np.flatnonzero(patterns.pull.slab)
    moved = modes.vectors.rows(slab, 0, modes.vectors.count) @ (modes.coordinates @ z)
    away = np.abs(moved - patterns.pull.unit[slab]).max(initial=0.0)
    return WallModel(
        eigenvalue=modes.eigenvalue,
        contact=modes.rows(patterns.contact),
        push=b,
        seen=modes.rows(patterns.seen),
        floors=np.array(patterns.floors, dtype=np.int64),
        floor_of=patterns.floor_of,
        difference=difference,
        uneven=max(modes.vectors.M.getComm().tompi4py().allgather(float(away))),
    )
