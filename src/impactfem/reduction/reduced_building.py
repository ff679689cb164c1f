"""The one reduced model of a building: for its loads, its wall, its devices, and any damping.

The devices' base plates are tied first. Then one factorisation of K + σ0 M gives one Krylov basis
under the union of all load patterns (`krylov`), which is completed for contacts and anchors
(`galerkin`). Of it are kept:

- `basis`: the models of the Krylov space with their error band and bound, and its vectors at the
  nodes whose motion is wanted;
- `complete`: Galerkin's model on all vectors, for what touches or stands on the building;
- `fine`: what gives the error of the whole Krylov space for another damping.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from impactfem.building.facade import facades
from impactfem.building.links import BasePlate, Displacements, RigidLink, carried, linked
from impactfem.building.mesh import DOFS, BuildingMesh, rigid_body
from impactfem.building.model import BuildingModel
from impactfem.case.transient import LARGEST_BASIS, SHIFT
from impactfem.dynamics.damping import DampingLaw
from impactfem.dynamics.soil import Soil
from impactfem.reduction.archive import from_arrays, to_arrays
from impactfem.reduction.edge_force import EdgeForce, even, inward, smooth
from impactfem.reduction.foundation import GROUND, Foundation
from impactfem.reduction.galerkin import (
    GalerkinModes,
    append_chain,
    append_contacts,
    append_forces,
    append_responses,
    independent,
)
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.loads import Loads
from impactfem.reduction.modal_response import ModalHistory, modal_response
from impactfem.reduction.reduced import ReducedModel
from impactfem.reduction.reduced_basis import (
    Accuracy,
    BasisPlan,
    Grown,
    LocalLoads,
    NestedModels,
    ReducedBasis,
    completed,
    grow_basis,
    reduced_basis,
)
from impactfem.reduction.wall import Wall, WallModel, WallPatterns
from impactfem.system.arrays import Array, Index
from impactfem.system.files import read_archive, write_archive
from impactfem.system.log import LOGGER, Steps
from impactfem.system.memory import give_back
from impactfem.system.quantity import quantity, results, si

STEPS = "loads", "factor", "basis", "contacts and anchors", "modes", "shapes"
"""Names of the steps of a reduction."""
PUSH = "push"
"""Name of the load pattern that holds the displaced floor of the wall experiment."""
FURTHER_SHIFTS = (3.0, 9.0, 27.0)
"""Further frequencies, over that of the shift, at which the basis has the response to the force of
each point that touches another building. With the first alone, that at the shift, spectra were off
by 8 to 10 % at 100 Hz (`pounding_reduced_against_full`)."""
SMOOTH_DEGREE, SMOOTH_RESPONSES = 6, 8
"""Highest degree of what varies smoothly along a line of such points, and vectors for each of them:
what these do together reaches far. Without them spectra of floors were off by 1.8 % at 100 Hz."""


@dataclass(frozen=True, eq=False)
class ReductionPlan:
    """Purpose and accuracy of a reduction."""

    probes: Index  #: nodes where the transfer functions must be accurate, ascending
    nodes: Index  #: nodes whose motion is wanted, probes included, ascending
    #: Accuracies, first of the model of `ReducedBasis`, then of the whole space.
    accuracies: tuple[Accuracy, ...]
    #: Components in which the ground, or on soil the base, moves: 0 to 2, or 5.
    directions: tuple[int, ...] = ()
    edges: tuple[EdgeForce, ...] = ()  #: patterns of the forces that may act
    base_plates: tuple[BasePlate, ...] = ()  #: of the devices, in the order of their anchors
    points: tuple[int, ...] = ()  #: nodes whose six components the complete model keeps
    wall: Wall | None = None  #: the wall that the building may hit; None without one
    #: Forces of the points along the edges that may touch those of other buildings.
    contacts: tuple[EdgeForce, ...] = ()
    shift: float = SHIFT  #: frequency that the basis is expanded about [Hz]
    largest: int = LARGEST_BASIS  #: most vectors of the Krylov space
    larger: bool = False  #: make larger models, for the error band

    @property
    def loads(self) -> tuple[str, ...]:
        """Names of the load patterns in their order."""
        names = [GROUND[c] for c in self.directions]
        names += [edge.name for edge in self.edges]
        if self.wall is None:
            return tuple(names)
        # The wall is flat: it pushes evenly, and the edges that may hit it count, too.
        walls = [f"floor {floor}" for floor in self.wall.floors]
        return (*names, PUSH, *(name for name in walls if name not in names))

    @property
    def basis(self) -> BasisPlan:
        """Requirements of the Krylov space."""
        return BasisPlan(
            loads=self.loads,
            probes=self.probes,
            nodes=self.nodes,
            accuracies=self.accuracies,
            shift=self.shift,
            largest=self.largest,
            larger=self.larger,
        )


@dataclass(frozen=True, eq=False)
class CompleteModel:
    """Modal equations z̈ + d ż + λ z = b p for any damping."""

    eigenvalue: Array  #: λ, shape (r,) [1/s2]
    ground: Array  #: b of a unit acceleration of the base about the origin, shape (r, 6)
    #: Of the patterns of forces, those of contacts in 3D last, shape (n_patterns,).
    names: NDArray[np.str_]
    edges: Array  #: b of each of them for the amplitude 1, shape (r, n_patterns)
    anchors: Array  #: Φ of the anchors' six components, shape (n_anchors, 6, r)
    points: Array  #: Φ of the six components of further points, shape (n_points, 6, r)
    difference: float  #: estimated error of the transfer functions of the free building
    wall: WallModel | None  #: model of the wall experiment; None without one
    rigid_mass: Array  #: of the building about the origin, shape (6, 6) [kg, kg m, kg m2]
    wrench: Array  #: resultant of each pattern of forces about the origin, shape (n_patterns, 6)
    anchors_carried: Array  #: R of the anchors by a motion of the base, shape (n_anchors, 6, 6)
    points_carried: Array  #: R of the further points, shape (n_points, 6, 6)
    base: Array  #: middle of the base [m], shape (3,)
    foundation: Foundation | None = None  #: raft and soil; None for a clamped building

    def load(self, loads: Loads) -> Array:
        """The b of the patterns of loads, shape (r, n_patterns); KeyError for others."""
        column = {str(name): k for k, name in enumerate(self.names)}
        edges = [self.edges[:, column[edge.name]] for edge in loads.edges]
        return np.column_stack([*(self.ground[:, c] for c in loads.directions), *edges])

    def response(self, loads: Loads, damping: DampingLaw) -> ModalHistory:
        """Modal coordinates under loads; on soil the six coordinates of the base follow them."""
        r = len(self.eigenvalue)

        def model(load: Array) -> ReducedModel:
            return ReducedModel(self.eigenvalue, load, np.eye(r), 0.0, np.zeros((0, r)))

        if self.foundation is None:
            return modal_response(
                model(self.load(loads)), loads.amplitudes, loads.time_step, damping
            )
        names = (*GROUND, *map(str, self.names))
        return self.foundation.history(
            model(np.hstack([self.ground, self.edges])), names, loads, damping
        )

    def shapes(self, anchors: bool = True) -> Array:
        """Φ of anchors or points, shape (n, 6, r); on soil with R of the base, (n, 6, r + 6)."""
        Φ, R = (
            (self.anchors, self.anchors_carried) if anchors else (self.points, self.points_carried)
        )
        return Φ if self.foundation is None else np.dstack([Φ, R])


@results
class ReducedBuilding:
    """The reduced model of a building."""

    basis: ReducedBasis  #: the Krylov space as accurate as the first accuracy asks, at nodes
    complete: CompleteModel  #: Galerkin's model on all vectors
    fine: NestedModels  #: the whole Krylov space at the probes
    errors: tuple[float, ...] = si(
        "-", "estimated error, by nested models", dims="accuracy", name="error"
    )

    @property
    @quantity("", "basis vectors for the first accuracy")
    def vectors(self) -> int:
        """Number of vectors of the basis."""
        return len(self.basis.model.eigenvalue)

    @property
    @quantity("", "vectors of the largest Krylov basis")
    def krylov_vectors(self) -> int:
        """Number of vectors of the whole Krylov space."""
        return len(self.fine.models[0].eigenvalue)

    @property
    @quantity("", "basis vectors with those of contacts and anchors")
    def complete_vectors(self) -> int:
        """Number of all vectors."""
        return len(self.complete.eigenvalue)

    def serving(self, plan: ReductionPlan) -> tuple[ReducedBuilding | None, str]:
        """Return the reduced building for another plan, or None and the reason.

        Building, wall and devices are the same, and there is no new basis. Errors are those at the
        accuracies of the plan; that of the whole space is at the probes of the first plan.
        """
        basis = self.basis
        wanted = {*plan.loads, *(one.name for one in plan.contacts)}
        lacking = sorted(wanted - set(basis.loads))
        if lacking:
            return None, f"without {', '.join(lacking)}"
        if not np.isin(plan.nodes, basis.nodes).all():
            return None, "without some of the nodes whose motion is wanted"
        if plan.larger and not basis.larger:
            return None, "without the larger models that give its error band"
        first, *others = plan.accuracies
        errors = (
            basis.error(plan.probes, first.damping, first.maximum_frequency),
            *(self.fine.error(one.damping, one.maximum_frequency) for one in others),
        )
        for error, accuracy in zip(errors, plan.accuracies, strict=True):
            if error > accuracy.tolerance:
                return None, f"with an error of {error:.2%} for this damping"
        wall = self.complete.wall
        if wall is not None:
            wall = replace(wall, difference=errors[0])
        return replace(
            self,
            basis=replace(basis, difference=errors[0]),
            complete=replace(self.complete, difference=max(errors), wall=wall),
            errors=errors,
        ), ""

    def on(self, soil: Soil) -> ReducedBuilding:
        """Return the building on soil, which is about the middle of the base."""
        one = self.complete
        foundation = Foundation(
            soil.moved(rigid_body(one.base[None], np.zeros(3))),
            one.rigid_mass,
            dict(zip(map(str, one.names), one.wrench, strict=True)),
        )
        return replace(
            self,
            basis=replace(self.basis, foundation=foundation),
            complete=replace(one, foundation=foundation),
        )

    def write(self, path: Path, key: str) -> None:
        """Write the model as NumPy's archive, in one piece.

        Raises:
            ImpactfemError: The file cannot be written.
        """
        # Foundations are not part of the building.
        building = replace(
            self,
            basis=replace(self.basis, foundation=None),
            complete=replace(self.complete, foundation=None),
        )
        write_archive(path, key, to_arrays(building))

    @classmethod
    def read(cls, path: Path, key: str) -> ReducedBuilding | None:
        """Read the model of a file; None without one with this key, or if it is damaged."""
        content = read_archive(path, key)
        if content is None:
            return None
        return from_arrays(cls, content)


def reduce_building(
    building: BuildingModel,
    mesh: BuildingMesh,
    storey_factor: float,
    plan: ReductionPlan,
    steps: Steps | None = None,
) -> ReducedBuilding:
    """Reduce a building with its devices' base plates. Collective.

    Args:
        building: The building; its matrices are gone afterwards.
        mesh: Its mesh.
        storey_factor: Factor on walls and columns.
        plan: Purpose of the reduction.
        steps: Shows the progress of its `STEPS`.

    Raises:
        SolutionError: An accuracy is not reached with the largest number of vectors; base plates
            overlap.
    """
    steps = steps or Steps(dict.fromkeys(STEPS, 1.0), quiet=True)
    with steps.step("loads"):
        # Tie the base plates, and gather the patterns of all loads.
        reduction = _Reduction.of(building, mesh, storey_factor, plan)
    with steps.step("factor"):
        basis = KrylovBasis(reduction.K, reduction.model.mass, (2.0 * math.pi * plan.shift) ** 2)
    with basis:
        with steps.step("basis"):
            # The Krylov space of (K + σ0 M)⁻¹ M under the union of the patterns.
            grown = reduction.grow(basis, lambda part: steps.within("basis", part))
        with steps.step("contacts and anchors"):
            # Vectors for what touches or stands on the building; the factor is gone afterwards.
            reduction.complete(basis, lambda part: steps.within("contacts and anchors", part))
    with steps.step("modes"):
        modes = GalerkinModes.of(basis)
    with steps.step("shapes"):
        return reduction.result(basis, grown, modes)


@dataclass(frozen=True, eq=False)
class _Reduction:
    """A building with its base plates tied, and the patterns of its loads at this rank's rows."""

    model: BuildingModel
    mesh: BuildingMesh
    plan: ReductionPlan
    K: Any  #: its stiffness
    links: list[RigidLink]  #: of the base plates
    edges: dict[str, Array]  #: patterns of the forces on edges, shape (n_local,) each
    touching: scipy.sparse.csr_matrix  #: forces of single points of contact, (n_local, n_points)
    smooth: scipy.sparse.csr_matrix  #: what varies smoothly along them, (n_points, k)
    wrench: Array  #: resultants of edges and points about the origin, shape (n, 6)
    wall: WallPatterns | None
    state: Array | None  #: the building that is held before the wall, shape (n_local,)
    push: Array | None  #: forces that hold it, shape (n_local,)

    @classmethod
    def of(
        cls, building: BuildingModel, mesh: BuildingMesh, storey_factor: float, plan: ReductionPlan
    ) -> _Reduction:
        """Tie the base plates of a building; its matrices are gone afterwards. Collective."""
        links = [plate.link for plate in plan.base_plates]
        model, T = linked(building, links, mesh.nodes)
        for matrix in (building.fixed, building.storeys, building.mass):
            matrix.destroy()
        give_back()
        K = model.take_stiffness(storey_factor)
        edges = {edge.name: edge.vector(building, mesh) for edge in plan.edges}
        if plan.wall is not None:
            for floor in plan.wall.floors:
                facade, _ = facades(mesh, floor, "")[""]
                pressed = even(floor, facade, inward(facade))
                edges.setdefault(pressed.name, pressed.vector(building, mesh))
        edges = {name: carried(T, load[:, None])[:, 0] for name, load in edges.items()}
        touching = _carried_forces(building, mesh, plan.contacts, T)
        # Resultants Rᵀ f of all patterns, R the rigid motions about the origin.
        R = model.rigid_body()
        resultants = [*(R.T @ load for load in edges.values()), *(touching.T @ R)]
        wrench = np.array(model.comm.allreduce(np.array(resultants).reshape(-1, 6)))
        wall = state = push = None
        if plan.wall is not None:
            wall = WallPatterns.of(building, mesh, plan.wall).carried(T)
            # Before the basis: the memory of its factorisation is free again then.
            state, push = wall.held(K)
        T.destroy()
        smoothly = scipy.sparse.csr_matrix(smooth(plan.contacts, SMOOTH_DEGREE))
        return cls(
            model=model,
            mesh=mesh,
            plan=plan,
            K=K,
            links=links,
            edges=edges,
            touching=touching,
            smooth=smoothly,
            wrench=wrench,
            wall=wall,
            state=state,
            push=push,
        )

    def displacements(self, nodes: Index, *, rotations: bool = False) -> Displacements:
        """Displacements or rotations of nodes, those of base plates by their masters."""
        return Displacements(self.model, nodes, self.links, self.mesh.nodes, rotations=rotations)

    @cached_property
    def anchors(self) -> scipy.sparse.csr_matrix:
        """Six components of the anchors at this rank's rows."""
        return _components(self.model, [(p.master, p.carried) for p in self.plan.base_plates])

    def shifts(self, basis: KrylovBasis) -> tuple[float, ...]:
        """Shifts σ at which the basis has the response to each point of contact [1/s2]."""
        return tuple(basis.shift * ratio**2 for ratio in (1.0, *FURTHER_SHIFTS))

    def grow(self, basis: KrylovBasis, progress: Callable[[float], None]) -> Grown:
        """Grow the Krylov space until it meets all accuracies."""
        patterns = {name: -self.model.ground[:, c] for c, name in enumerate(GROUND)}
        patterns |= self.edges
        if self.push is not None:
            patterns[PUSH] = self.push
        basis.add(np.column_stack([patterns[name] for name in self.plan.loads]))
        probes = self.displacements(self.plan.probes)
        bounded = not self.plan.contacts
        grown = grow_basis(basis, probes, self.plan.basis, bounded=bounded, progress=progress)
        LOGGER.debug(
            "reduce: basis of %d vectors for %s; of these %d within %.2g %%",
            basis.size,
            ", ".join(self.plan.loads),
            len(grown.coarse.models[0].eigenvalue),
            100.0 * grown.differences[0],
        )
        return grown

    def complete(self, basis: KrylovBasis, progress: Callable[[float], None]) -> None:
        """Append the vectors of contacts, anchors and the state before the wall."""
        if self.plan.contacts:
            append_chain(basis, self.touching @ self.smooth, steps=SMOOTH_RESPONSES)
        elif self.wall is not None:
            append_contacts(basis, self.wall.contact)
        append_responses(basis, self.anchors)
        if self.state is not None:
            basis.vectors.append(np.asfortranarray(self.state[:, None]))
        if self.plan.contacts:
            walls = [] if self.wall is None else [self.wall.contact]
            comm = self.model.mass.getComm().tompi4py()
            contacts = independent([*walls, self.touching], comm)
            append_forces(basis, contacts, basis.shift)
            # The factor goes now: there may not be room for it and those that follow.
            basis.destroy()
            shifts = self.shifts(basis)
            for k, shift in enumerate(shifts[1:], 1):
                progress(k / len(shifts))
                append_forces(basis, contacts, shift)

    def result(self, basis: KrylovBasis, grown: Grown, modes: GalerkinModes) -> ReducedBuilding:
        """Return what is kept: models, and shapes at nodes, anchors and points."""
        plan, nodes = self.plan, self.mesh.nodes
        R = rigid_body(nodes[plan.nodes], np.zeros(3)).reshape(-1, DOFS, DOFS)[:, :3]
        known = reduced_basis(
            basis,
            grown,
            plan.basis,
            self.displacements(plan.nodes),
            self.displacements(plan.probes, rotations=True),
            R,
            every=bool(plan.contacts),
        )
        complete = self._complete_model(modes, grown)
        if not plan.contacts:
            return ReducedBuilding(known, complete, grown.fine, grown.differences)
        # Local forces are many: not the Krylov space holds them, but what it was completed by.
        b = dict(
            zip((*GROUND, *complete.names), (*complete.ground.T, *complete.edges.T), strict=True)
        )
        if self.push is not None:
            b[PUSH] = modes.rows(self.push[:, None])[:, 0]
        names = tuple(dict.fromkeys([*plan.loads, *(force.name for force in plan.contacts)]))
        single = complete.edges[:, len(self.edges) :]
        local = LocalLoads(
            names=names,
            b=np.column_stack([b[name] for name in names]),
            single=single,
            shifts=self.shifts(basis),
            smooth=single @ self.smooth,
            steps=SMOOTH_RESPONSES,
        )
        known = completed(known, modes, local)
        reduced = ReducedBuilding(known, complete, grown.fine, grown.differences)
        # The vectors of contacts make the models better: errors are theirs, as where they are read.
        return reduced.serving(plan)[0] or reduced

    def _complete_model(self, modes: GalerkinModes, grown: Grown) -> CompleteModel:
        """Galerkin's model, at anchors and points."""
        plan, nodes, wall = self.plan, self.mesh.nodes, None
        # A point that follows a base plate moves as its master does, one of the base does not move.
        points = []
        for node in plan.points:
            plates = (plate.master for plate in plan.base_plates if node in plate.nodes)
            master = next(plates, node)
            points.append((master, rigid_body(nodes[[node]], nodes[master])))
        rows = _components(self.model, points)
        r = len(modes.eigenvalue)
        at_anchors, at_points = (
            np.ascontiguousarray(modes.rows(L).T.reshape(-1, DOFS, r)) for L in (self.anchors, rows)
        )
        anchors = [(plate.master, plate.carried) for plate in plan.base_plates]
        anchors_carried, points_carried = (
            np.array(
                [motion @ rigid_body(nodes[[node]], np.zeros(3)) for node, motion in places]
            ).reshape(-1, DOFS, DOFS)
            for places in (anchors, points)
        )
        none = np.zeros((rows.shape[0], 0))
        loads = modes.rows(np.column_stack(list(self.edges.values()) or [none]))
        if plan.contacts:
            loads = np.hstack([loads, modes.rows(self.touching)])
        if self.wall is not None and self.push is not None:
            wall = WallModel.of(modes, self.wall, self.push, grown.differences[0])
        base = nodes[np.unique(self.mesh.base)]
        names = [*self.edges, *(force.name for force in plan.contacts)]
        return CompleteModel(
            eigenvalue=modes.eigenvalue,
            ground=modes.rows(-self.model.ground),
            names=np.array(names, dtype=np.str_),
            edges=loads,
            anchors=at_anchors,
            points=at_points,
            difference=max(grown.differences),
            wall=wall,
            rigid_mass=self.model.total,
            wrench=self.wrench,
            anchors_carried=anchors_carried,
            points_carried=points_carried,
            base=0.5 * (base.min(axis=0) + base.max(axis=0)),
        )


def _carried_forces(
    building: BuildingModel, mesh: BuildingMesh, forces: Sequence[EdgeForce], T: Any
) -> scipy.sparse.csr_matrix:
    """Columns of forces at this rank's rows with the rigid links of T, sparse. Collective."""
    # One by one: all of them are too many for a dense array of the building's size.
    found = [
        scipy.sparse.csr_matrix(carried(T, one.vector(building, mesh)[:, None])) for one in forces
    ]
    none = scipy.sparse.csr_matrix((T.getLocalSize()[1], 0))
    return scipy.sparse.csr_matrix(scipy.sparse.hstack([none, *found]))


def _components(
    model: BuildingModel, places: Sequence[tuple[int, Array]]
) -> scipy.sparse.csr_matrix:
    """Six components of places at this rank's rows, shape (n_local, 6 n).

    Each is a node with the motion of the place by that of the node, shape (6, 6); a clamped node,
    or one of another rank, has no rows.
    """
    columns = scipy.sparse.lil_matrix((DOFS * len(model.nodes), DOFS * len(places)))
    for k, (node, motion) in enumerate(places):
        row = int(model.rows(np.array([node]))[0])
        if row >= 0:
            columns[row : row + DOFS, DOFS * k : DOFS * (k + 1)] = motion.T
    return scipy.sparse.csr_matrix(columns)
