"""One reduced model of the building for all of a study: impacts, wall, devices, dampings."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from impactfem.building.edge_load import edge_load
from impactfem.building.edge_normal import outward_normal
from impactfem.building.links import linked
from impactfem.building.local import DOFS
from impactfem.building.mesh import BuildingMesh
from impactfem.building.model import BuildingModel
from impactfem.dynamics.enrichment import append_contacts, append_responses
from impactfem.dynamics.galerkin import GalerkinModes, galerkin_modes
from impactfem.dynamics.krylov import KrylovBasis
from impactfem.dynamics.reduced import ReducedModel
from impactfem.equipment.rosette import Rosette
from impactfem.transient.archive import read_archive, write_archive
from impactfem.transient.loads import Loads
from impactfem.transient.reduced_basis import grow_until_accurate
from impactfem.wall.building_model import WallModel, WallPatterns, wall_patterns

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SHIFT = 30.0
"""Frequency that the basis is expanded about [Hz]."""


@dataclass(frozen=True, eq=False)
class Accuracy:
    """How good a basis has to be.

    Args:
        damping: α [1/s] and β [s].
        maximum_frequency: Up to which the transfer functions must be accurate [Hz].
        tolerance: Their largest relative error.
    """

    damping: tuple[float, float]
    maximum_frequency: float
    tolerance: float


@dataclass(frozen=True, eq=False)
class StudyModel:
    """Modal equations z̈ + (α + β λ) ż + λ z = b p for any damping.

    Args:
        eigenvalue: λ, shape (r,) [1/s2].
        ground: b of a unit ground acceleration along x, y, z, shape (r, 3).
        floors: Numbers of the floors with an edge, shape (n_floors,).
        edges: b of 1 N on the edge of each, into the building, shape (r, n_floors).
        anchors: Φ of the anchors' six components, shape (n_devices, 6, r).
        contact: Γ of the wall, shape (r, m); m = 0 without a wall.
        push: b of the push of the wall experiment, shape (r,).
        seen: Of the wall experiment, shape (r, n + 1).
        wall_floors: Floors that may hit the wall, shape (n,).
        floor_of: Index into `wall_floors` of each constraint, shape (m,).
        difference: Estimated error of the transfer functions of the free building.
    """

    eigenvalue: Array
    ground: Array
    floors: Index
    edges: Array
    anchors: Array
    contact: Array
    push: Array
    seen: Array
    wall_floors: Index
    floor_of: Index
    difference: float

    @property
    def wall(self) -> WallModel | None:
        """The model of the wall experiment; None where there is none."""
        if not self.wall_floors.size:
            return None
        return WallModel(
            eigenvalue=self.eigenvalue,
            contact=self.contact,
            push=self.push,
            seen=self.seen,
            floors=self.wall_floors,
            floor_of=self.floor_of,
            difference=self.difference,
        )

    def load(self, loads: Loads) -> Array:
        """The b of the patterns of loads, in their order, shape (r, n_patterns).

        Args:
            loads: The loads.

        Raises:
            KeyError: A floor has no edge.
        """
        column = {int(floor): k for k, floor in enumerate(self.floors)}
        edges = [self.edges[:, column[edge.floor]] for edge in loads.edges]
        return np.column_stack([*(self.ground[:, c] for c in loads.directions), *edges])

    def model(self, loads: Loads) -> ReducedModel:
        """The modal equations under these loads."""
        r = len(self.eigenvalue)
        return ReducedModel(
            eigenvalue=self.eigenvalue,
            load=self.load(loads),
            coordinates=np.eye(r),
            shift=(2.0 * math.pi * SHIFT) ** 2,
            tail=np.zeros((0, r)),
        )

    def write(self, path: Path, key: str) -> None:
        """Write it as NumPy's archive, in one piece.

        Raises:
            ImpactfemError: The file cannot be written.
        """
        write_archive(path, key, {field.name: getattr(self, field.name) for field in fields(self)})

    @classmethod
    def read(cls, path: Path, key: str) -> StudyModel | None:
        """The model of a file; None where there is none with this key, or it is damaged."""
        content = read_archive(path, key)
        if content is None:
            return None
        values = {field.name: content[field.name] for field in fields(cls)}
        return cls(**values | {"difference": float(values["difference"])})


def study_model(
    building: BuildingModel,
    mesh: BuildingMesh,
    storey_factor: float,
    rosettes: Sequence[Rosette],
    *,
    directions: Sequence[int],
    hit: Sequence[int],
    eccentricity: float,
    wall: tuple[tuple[int, ...], int] | None,
    accuracies: Sequence[Accuracy],
    largest: int,
    progress: Callable[[float], None] = lambda part: None,
) -> StudyModel:
    """Reduce a building with its devices' rosettes. Collective.

    The basis of the free building grows under the ground motion, even loads on the edges that are
    hit and the push of the wall experiment, until it is as accurate as asked. Then come the
    vectors of the contacts with the wall, and the responses to forces and moments on the anchors.

    Args:
        building: The building; its matrices are gone afterwards.
        mesh: Its mesh.
        storey_factor: Factor on walls and columns.
        rosettes: Of the devices.
        directions: Components (0, 1, 2) in which the ground moves.
        hit: Numbers of the floors that are hit; forces on other edges are in the model, too, and
            less accurate.
        eccentricity: Of the loads on edges, along them [m].
        wall: Floors that may hit the wall and the displaced one; None without a wall.
        accuracies: How good it has to be, one damping after the other.
        largest: Most vectors of the free building.
        progress: Called with the part of the work that is done.

    Raises:
        SolutionError: The accuracy is not reached with the most vectors; rosettes overlap.
    """
    model, _ = linked(building, [one.link for one in rosettes], mesh.nodes)
    for matrix in (building.fixed, building.storeys, building.mass):
        matrix.destroy()
    K = model.take_stiffness(storey_factor)
    edges = _edges(model, mesh, eccentricity)
    anchors = np.hstack([_anchor(model, one) for one in rosettes])
    patterns = None if wall is None else wall_patterns(model, mesh, *wall)
    loads = [-model.ground[:, c] for c in directions]
    loads += [edges[floor] for floor in hit]
    if patterns is not None:
        loads.append(patterns.push)
    probes = np.unique(
        [one.master for one in rosettes]
        + [mesh.centres[floor] for floor in hit]
        + [int(np.sort(np.unique(mesh.edges[floor]))[0]) for floor in hit]
    )
    difference = 0.0
    with KrylovBasis(K, model.mass, (2.0 * math.pi * SHIFT) ** 2) as basis:
        basis.add(np.column_stack(loads))
        for accuracy in accuracies:
            _, found = grow_until_accurate(
                basis,
                model,
                probes,
                damping=accuracy.damping,
                maximum_frequency=accuracy.maximum_frequency,
                tolerance=accuracy.tolerance,
                largest=largest,
                progress=progress,
            )
            difference = max(difference, found)
        if patterns is not None:
            append_contacts(basis, patterns.contact)
        append_responses(basis, anchors)
        modes = galerkin_modes(basis)
    return _rows(modes, model, edges, anchors, patterns, len(rosettes), difference)


def _edges(model: BuildingModel, mesh: BuildingMesh, eccentricity: float) -> dict[int, Array]:
    """The load of 1 N on the edge of each floor, into the building."""
    loads = {}
    for floor in sorted(mesh.edges):
        x, y, z = (-float(c) for c in outward_normal(mesh, floor))
        loads[floor] = edge_load(mesh, floor, eccentricity).vector(model, (x, y, z))
    return loads


def _anchor(model: BuildingModel, rosette: Rosette) -> Array:
    """Unit forces and moments on an anchor at this rank's rows, shape (n_local, 6)."""
    loads = np.zeros((DOFS * len(model.nodes), DOFS))
    row = int(model.rows(np.array([rosette.master]))[0])
    if row >= 0:
        loads[row : row + DOFS] = rosette.carried.T
    return loads


def _rows(
    modes: GalerkinModes,
    model: BuildingModel,
    edges: dict[int, Array],
    anchors: Array,
    patterns: WallPatterns | None,
    devices: int,
    difference: float,
) -> StudyModel:
    r, n_local = len(modes.eigenvalue), len(anchors)
    none = scipy.sparse.csr_matrix((n_local, 0))
    at_anchors = modes.rows(anchors).T.reshape(devices, DOFS, r)
    seen = np.zeros((r, 0)) if patterns is None else modes.rows(patterns.seen)
    push = np.zeros(r) if patterns is None else modes.rows(patterns.push[:, None])[:, 0]
    return StudyModel(
        eigenvalue=modes.eigenvalue,
        ground=modes.rows(-model.ground[:, :3]),
        floors=np.array(list(edges), dtype=np.int64),
        edges=modes.rows(np.column_stack(list(edges.values()))),
        anchors=np.ascontiguousarray(at_anchors),
        contact=modes.rows(none if patterns is None else patterns.contact),
        push=push,
        seen=seen,
        wall_floors=np.array([] if patterns is None else patterns.floors, dtype=np.int64),
        floor_of=np.zeros(0, dtype=np.int64) if patterns is None else patterns.floor_of,
        difference=difference,
    )
