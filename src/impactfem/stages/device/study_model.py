"""One reduced model of the building for all of a study: impacts, wall, devices, dampings."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from impactfem.building.floor import edge_load
from impactfem.building.links import BasePlate, carried, linked
from impactfem.building.mesh import DOFS, BuildingMesh, outward_normal
from impactfem.building.model import BuildingModel
from impactfem.case.transient import SHIFT
from impactfem.case.wall_impact import Pull
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.enrichment import append_contacts, append_responses
from impactfem.reduction.galerkin import GalerkinModes, galerkin_modes
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.loads import Loads
from impactfem.reduction.reduced import ReducedModel
from impactfem.reduction.reduced_basis import grow_until_accurate
from impactfem.stages.calibrate.building_model import (
    WallModel,
    wall_model,
    wall_patterns,
)
from impactfem.stages.device.covered_points import moving_node, point_rows
from impactfem.system.files import read_archive, write_archive
from impactfem.system.memory import give_back

Array = NDArray[np.float64]
Index = NDArray[np.int64]

OF_WALL = "wall."
"""Begins the names of the wall's fields in an archive."""


@dataclass(frozen=True, eq=False)
class Accuracy:
    """How good a basis has to be.

    Args:
        damping: The damping.
        maximum_frequency: Up to which the transfer functions must be accurate [Hz].
        tolerance: Their largest relative error.
    """

    damping: Rayleigh
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
        anchors: Φ of the anchors' six components, shape (n_anchors, 6, r).
        points: Φ of the six components of further points, shape (n_points, 6, r).
        difference: Estimated error of the transfer functions of the free building.
        wall: The same with the contacts of the wall experiment; None without one.
    """

    eigenvalue: Array
    ground: Array
    floors: Index
    edges: Array
    anchors: Array
    points: Array
    difference: float
    wall: WallModel | None

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
        own = {field.name: getattr(self, field.name) for field in fields(self)}
        wall = own.pop("wall")
        of_wall = {} if wall is None else {OF_WALL + k: v for k, v in wall.content.items()}
        write_archive(path, key, own | of_wall)

    @classmethod
    def read(cls, path: Path, key: str) -> StudyModel | None:
        """The model of a file; None where there is none with this key, or it is damaged."""
        content = read_archive(path, key)
        if content is None:
            return None
        del content["key"]
        of_wall = {
            name.removeprefix(OF_WALL): content.pop(name)
            for name in list(content)
            if name.startswith(OF_WALL)
        }
        wall = WallModel.of_content(of_wall) if of_wall else None
        return cls(**content | {"difference": float(content["difference"]), "wall": wall})


def study_model(
    building: BuildingModel,
    mesh: BuildingMesh,
    storey_factor: float,
    base_plates: Sequence[BasePlate],
    points: Sequence[int] = (),
    *,
    directions: Sequence[int],
    hit: Sequence[int],
    eccentricity: float,
    wall: tuple[tuple[int, ...], int, Pull] | None,
    accuracies: Sequence[Accuracy],
    largest: int,
    progress: Callable[[float], None] = lambda part: None,
) -> StudyModel:
    """Reduce a building with its devices' base plates. Collective.

    The basis of the free building grows under the ground motion, even loads on the edges that are
    hit and the forces that hold the displaced floor of the wall experiment, until it is as accurate
    as asked. Then come the vectors of the contacts with the wall, the responses to forces and
    moments on the anchors, and the state before the release.

    Args:
        building: The building; its matrices are gone afterwards.
        mesh: Its mesh.
        storey_factor: Factor on walls and columns.
        base_plates: Of the anchors of the devices.
        points: Nodes of further points that are looked at.
        directions: Components (0, 1, 2) in which the ground moves.
        hit: Numbers of the floors that are hit; forces on other edges are in the model, too, and
            less accurate.
        eccentricity: Of the loads on edges, along them [m].
        wall: Floors that may hit the wall, the displaced one and how it is drawn aside; None
            without a wall.
        accuracies: How good it has to be, one damping after the other.
        largest: Most vectors of the free building.
        progress: Called with the part of the work that is done.

    Raises:
        SolutionError: The accuracy is not reached with the most vectors; base plates overlap.
    """
    model, T = linked(building, [one.link for one in base_plates], mesh.nodes)
    for matrix in (building.fixed, building.storeys, building.mass):
        matrix.destroy()
    give_back()
    K = model.take_stiffness(storey_factor)
    edges = {
        floor: carried(T, load[:, None])[:, 0]
        for floor, load in _edges(building, mesh, eccentricity).items()
    }
    anchors = np.hstack([_anchor(model, one) for one in base_plates])
    patterns = None if wall is None else wall_patterns(building, mesh, *wall).carried(T)
    T.destroy()
    loads = [-model.ground[:, c] for c in directions]
    loads += [edges[floor] for floor in hit]
    state, push = (None, None) if patterns is None else patterns.held(K)
    if push is not None:
        loads.append(push)
    moving = [moving_node(node, base_plates) for node in points]
    probes = np.unique(
        [one.master for one in base_plates]
        + [node for node in moving if node not in mesh.base]
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
        if state is not None:
            basis.vectors.append(np.asfortranarray(state[:, None]))
        modes = galerkin_modes(basis)
    of_wall = None
    if patterns is not None and push is not None:
        of_wall = wall_model(modes, patterns, push, difference)
    seen = point_rows(model, mesh, points, base_plates)
    return _rows(modes, model, edges, anchors, seen, of_wall, difference)


def _edges(model: BuildingModel, mesh: BuildingMesh, eccentricity: float) -> dict[int, Array]:
    """The load of 1 N on the edge of each floor, into the building."""
    loads = {}
    for floor in sorted(mesh.edges):
        x, y, z = (-float(c) for c in outward_normal(mesh, floor))
        loads[floor] = edge_load(mesh, floor, eccentricity).vector(model, (x, y, z))
    return loads


def _anchor(model: BuildingModel, base_plate: BasePlate) -> Array:
    """Unit forces and moments on an anchor at this rank's rows, shape (n_local, 6)."""
    loads = np.zeros((DOFS * len(model.nodes), DOFS))
    row = int(model.rows(np.array([base_plate.master]))[0])
    if row >= 0:
        loads[row : row + DOFS] = base_plate.carried.T
    return loads


def _rows(
    modes: GalerkinModes,
    model: BuildingModel,
    edges: dict[int, Array],
    anchors: Array,
    points: scipy.sparse.csr_matrix,
    wall: WallModel | None,
    difference: float,
) -> StudyModel:
    r = len(modes.eigenvalue)
    at_anchors, at_points = (modes.rows(one).T.reshape(-1, DOFS, r) for one in (anchors, points))
    return StudyModel(
        eigenvalue=modes.eigenvalue,
        ground=modes.rows(-model.ground[:, :3]),
        floors=np.array(list(edges), dtype=np.int64),
        edges=modes.rows(np.column_stack(list(edges.values()))),
        anchors=np.ascontiguousarray(at_anchors),
        points=np.ascontiguousarray(at_points),
        difference=difference,
        wall=wall,
    )
