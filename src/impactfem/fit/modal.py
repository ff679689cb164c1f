"""A 3D model in a fit: its floors, its modes, and their derivatives by keys that keep its mesh."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from mpi4py import MPI

from impactfem.building.floor_properties import floor_properties
from impactfem.building.from_case import geometry_of, read_parts
from impactfem.building.generate import generate
from impactfem.building.mesh import DOFS, rigid_body
from impactfem.building.model import Actions, action_of_cells
from impactfem.building.parts import BuildingParts, FloorMasses
from impactfem.case import Building3D, Case
from impactfem.case.buildings import FileMesh
from impactfem.dynamics.mode_derivatives import mode_derivatives
from impactfem.fit.pieces import Pieces, paired
from impactfem.fit.problem import Problem, sensor_nodes
from impactfem.stages.building.compute import Known, analysed, mesh_of_run
from impactfem.stages.building.store import study_scalars
from impactfem.stages.building.study import BuildingStudy
from impactfem.stages.building.targets import SHOWN_BENDING
from impactfem.system.arrays import Array
from impactfem.system.scalar import of_building

_KNOWN: dict[tuple[str, bool], tuple[str, Building3D, Known]] = {}
"""Of each building, on its own mesh and on that of `coarse`, the last model in this process: the
digest of its problem, the building, and what is known of it."""


def known_of(problem: Problem, building: Building3D) -> Known | None:
    """What is known of the last model of a building in this process, had it the same mesh."""
    digest, last, known = _KNOWN.get((building.name, not problem.fixed), ("", building, None))
    return known if digest == problem.digest and same_mesh(building, last) else None


def remember(problem: Problem, building: Building3D, known: Known) -> None:
    """Remember a model for `known_of`."""
    _KNOWN[building.name, not problem.fixed] = problem.digest, building, known


def mesh_floors(
    building: Building3D, folder: Path, problem: Problem | None = None
) -> dict[str, Array]:
    """The floor table of the mesh of a building, which is generated unless it is there or known.

    Raises:
        InputError: The mesh is not usable.
    """
    path = mesh_of_run(building, folder)
    known = None if problem is None else known_of(problem, building)
    if known is None and not path.is_file():
        generate(geometry_of(building), path, source=str(building.case.path))
    parts, masses = read_parts(building, path, None if known is None else known.mesh)
    if problem is not None:
        remember(problem, building, Known(parts.mesh))
    return floor_properties(parts, masses)


def same_mesh(one: Building3D, other: Building3D) -> bool:
    """Whether the mesh of two buildings is the same; thicknesses do not count."""
    files = [
        mesh.file if isinstance(mesh, FileMesh) else None
        for mesh in (one.structure.mesh, other.structure.mesh)
    ]
    if files != [None, None]:
        return files[0] == files[1]
    plain = [
        replace(
            geometry,
            slab_thickness=1.0,
            slabs={},
            parapet=geometry.parapet and replace(geometry.parapet, thickness=1.0),
        )
        for geometry in (geometry_of(one), geometry_of(other))
    ]
    return plain[0] == plain[1]


@dataclass(eq=False)
class Change:
    """What a key changes, from the differences of two models on the mesh of a third one.

    dK and dM are slopes by the key on the scale of the fit.
    """

    ends: tuple[float, float]  #: places of the two on the scale of the fit, less that of the third
    parts: tuple[BuildingParts, ...]
    masses: tuple[FloorMasses, ...]
    total: Array  #: diagonal of rᵀ dM r, shape (6,)
    K: Array  #: dK φ of the modes that count, shape (n, k)
    M: Array  #: dM φ
    ground: Array  #: dM r, shape (n, 6)


class View:
    """The modes of the 3D model of a building in an evaluation.

    They start from those of the last one in this process, where it had the same mesh.

    Args:
        building: The building.
        folder: A folder for its mesh.
        problem: The problem.

    Raises:
        InputError: The mesh is not usable, or a sensor is outside the building.
        SolutionError: The structure is a mechanism, or no factor gives the frequency.
    """

    def __init__(self, building: Building3D, folder: Path, problem: Problem) -> None:
        self.building, self.name = building, building.name
        self.floors, self.target = problem.of_floors(self.name), problem.measured(self.name)
        self.file = mesh_of_run(building, folder)
        known = known_of(problem, building)
        self.study, self.model, self.result = analysed(
            building, folder, MPI.COMM_SELF, lambda name: nullcontext(), known
        )
        self.mesh = self.study.parts.mesh
        remember(problem, building, Known(self.mesh, self.result.shapes))
        # The modes whose derivatives count: bending ones in the summary, and measured ones.
        numbers = {int(k) for k in self.study.bending[:SHOWN_BENDING]}
        self.rows = np.zeros(0, dtype=np.int64)  #: of the sensors; −1 of a clamped one
        if self.target is not None:
            rows = self.model.rows(sensor_nodes(problem.path, problem.fit, self.target, self.mesh))
            self.rows = np.where(rows < 0, -1, rows + self.target.along)
            at = self._at(self.result.shapes)
            numbers |= {k for k, _ in paired(self.target, self.study.frequency, at)}
        self.numbers = sorted(numbers)
        self.actions: Actions = {}  #: products with these modes and the rigid motions

    def _at(self, shapes: Array) -> Array:
        return np.where(self.rows < 0, 0.0, shapes[self.rows].T)

    def into(self, pieces: Pieces) -> None:
        """Add its results."""
        self._add(pieces, self.study, self._at(self.result.shapes))

    def _add(self, pieces: Pieces, study: BuildingStudy, at: Array) -> None:
        if self.floors:
            pieces.floors[self.name] = floor_properties(study.parts, study.masses)
        for one in study_scalars(study):
            name = of_building(one.name, self.building.part)
            pieces.scalars[name] = replace(one, name=name)
        pieces.modes[self.name] = study.frequency, at

    def change(self, cases: tuple[Case, Case], ends: tuple[float, float]) -> Change | None:
        """What changes between two cases; None where the mesh does, or the factor is fitted."""
        both = [case.modelled[self.name] for case in cases]
        if self.building.structure.calibration is not None or not all(
            same_mesh(self.building, one) for one in both
        ):
            return None
        read = [read_parts(one, self.file, self.mesh) for one in both]
        parts = tuple(one for one, _ in read)
        factors = [one.structure.storey_stiffness_factor for one in both]
        cells = parts[0].changed(parts[1], storeys=factors[0] != factors[1])
        free = (DOFS * self.model.nodes[:, None] + np.arange(DOFS)).ravel()
        r = rigid_body(self.mesh.nodes, self.mesh.base_middle)
        φ = np.zeros((len(r), len(self.numbers)))
        φ[free] = self.result.shapes[:, self.numbers]
        low, high = (
            action_of_cells(one, cells, factor, np.hstack([φ, r]), self.actions)
            for one, factor in zip(parts, factors, strict=True)
        )
        K, M = ((b - a) / (ends[1] - ends[0]) for a, b in zip(low, high, strict=True))
        k = len(self.numbers)
        return Change(
            ends,
            parts,
            masses=tuple(masses for _, masses in read),
            total=np.einsum("ij,ij->j", r, M[:, k:]),
            K=K[free, :k],
            M=M[free, :k],
            ground=M[free, k:],
        )

    def moved(self, changes: Sequence[Change], pieces: Sequence[tuple[Pieces, Pieces]]) -> None:
        """Add the results at both ends of each change, linear in the modes. Not collective."""
        study, numbers = self.study, self.numbers
        K = self.model.stiffness(study.factor)
        dλ, dφ = mode_derivatives(
            K, self.model.mass, self.result, numbers, [(one.K, one.M) for one in changes]
        )
        K.destroy()
        ground, _ = self.model.about(self.mesh.base_middle)
        φ = self.result.shapes[:, numbers]
        for p, (change, both) in enumerate(zip(changes, pieces, strict=True)):
            slope_f = dλ[p] / (8.0 * np.pi**2 * study.frequency[numbers])
            slope_Γ = dφ[p].T @ ground + φ.T @ change.ground
            for end, w in enumerate(change.ends):
                frequency, Γ = study.frequency.copy(), study.participation.copy()
                frequency[numbers] += w * slope_f
                Γ[numbers] += w * slope_Γ
                at = self._at(self.result.shapes)
                at[numbers] += w * self._at(dφ[p])
                moved = replace(
                    study,
                    frequency=frequency,
                    participation=Γ,
                    total=study.total + w * change.total,
                    parts=change.parts[end],
                    masses=change.masses[end],
                )
                self._add(both[end], moved, at)

    def destroy(self) -> None:
        """Free the matrices."""
        for matrix in (self.model.fixed, self.model.storeys, self.model.mass):
            matrix.destroy()
