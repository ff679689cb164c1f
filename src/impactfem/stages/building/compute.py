"""The stage `building`: mesh, matrices, storey factor and modes of the 3D model."""

from __future__ import annotations

import resource
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.from_case import geometry_of
from impactfem.building.generate import generate
from impactfem.building.masses import FloorMasses
from impactfem.building.mesh import place
from impactfem.building.mesh_report import MeshReport
from impactfem.building.model import BuildingModel, assemble_building
from impactfem.building.parts import BuildingParts
from impactfem.building.read_parts import read_parts
from impactfem.case import Case
from impactfem.case.file_mesh import FileMesh
from impactfem.case.structure import Structure
from impactfem.dynamics.factorisation import SingularMatrixError
from impactfem.dynamics.modes import Modes, modes
from impactfem.stages.building.storey_factor import fit_storey_factor
from impactfem.system.errors import SolutionError
from impactfem.system.log import LOGGER
from impactfem.system.parallel import on_root

Array = NDArray[np.float64]
Step = Callable[[str], AbstractContextManager[None]]

MESH = "building.msh"


@dataclass(frozen=True, eq=False)
class BuildingStudy:
    """What the stage computed; on rank 0 it has the shapes at all nodes.

    Args:
        structure: The structure of the case.
        parts: Mesh, sections and material.
        masses: Masses of the floors.
        report: Report of the mesh.
        factor: Storey stiffness factor.
        n_free: Number of free degrees of freedom.
        frequency: Of the modes, shape (n_modes,) [Hz].
        shapes: Displacements of all nodes in each mode with φᵀ M φ = 1, shape
            (n_modes, n_nodes, 3); without nodes on other ranks than 0.
        participation: Γ = φᵀ M r for the six rigid-body motions about the base's middle, shape
            (n_modes, 6).
        total: rᵀ M r of the same motions, shape (6,) [kg, kg m2].
        residual: Relative residual of each mode, shape (n_modes,).
    """

    structure: Structure
    parts: BuildingParts
    masses: FloorMasses
    report: MeshReport
    factor: float
    n_free: int
    frequency: Array
    shapes: NDArray[np.float32]
    participation: Array
    total: Array
    residual: Array

    @property
    def effective_mass(self) -> Array:
        """Γ², shape (n_modes, 6) [kg, kg m2]."""
        return self.participation**2


def run_building(case: Case, folder: Path, comm: Any, step: Step) -> BuildingStudy:
    """Run the stage. Collective.

    Args:
        case: The case; it has a structure.
        folder: Where the mesh is written.
        comm: Communicator of the matrices.
        step: Called with the name of each step ("mesh", "matrices", "modes"),
            which runs inside its context.

    Raises:
        InputError: The mesh is not usable.
        SolutionError: The structure is a mechanism, or no factor gives the frequency.
    """
    structure = _structure(case)
    with step("mesh"):
        parts, masses, report = on_root(lambda: read_parts(case, _mesh_file(case, folder)))
        LOGGER.debug("\n%s", report)
        for text in report.warnings:
            LOGGER.warning("warning: mesh: %s", text)
    with step("matrices"):
        model = assemble_building(comm, parts)
        _log_memory(comm, f"{model.n_free} free degrees of freedom, {comm.size} ranks")
    with step("modes"):
        try:
            factor, found = _modes(model, structure)
        except SingularMatrixError as error:
            raise _mechanism(parts, model, error) from error
        _log_memory(comm, f"{structure.modes} modes")
    ground, total = model.about(_base_middle(parts))
    return BuildingStudy(
        structure=structure,
        parts=parts,
        masses=masses,
        report=report,
        factor=factor,
        n_free=model.n_free,
        frequency=found.frequency,
        shapes=_gathered(model, found.shapes),
        participation=comm.allreduce(found.shapes.T @ ground),
        total=np.diag(total).copy(),
        residual=found.residual,
    )


def _modes(model: BuildingModel, structure: Structure) -> tuple[float, Modes]:
    """The storey factor, given or fitted, and the modes with it. Collective."""
    factor, asked = structure.storey_stiffness_factor, structure.calibration
    if asked is not None:
        direction = "xy".index(asked.direction)
        fitted = fit_storey_factor(model, asked.frequency, direction, factor, structure.modes)
        LOGGER.info(
            "building: storey factor %.4g gives %.4g Hz (%d modal analyses)",
            fitted.factor,
            asked.frequency,
            fitted.rounds,
        )
        return fitted.factor, fitted.modes
    K = model.stiffness(factor)
    found = modes(K, model.mass, structure.modes)
    K.destroy()
    return factor, found


def _mechanism(parts: BuildingParts, model: BuildingModel, error: SingularMatrixError) -> Exception:
    """Say which part of a mechanism moves. Collective."""
    mesh = parts.mesh
    node = model.node_of(error.row)
    groups = {mesh.shell_parts[k].group for k in mesh.triangle_part[_with(mesh.triangles, node)]}
    groups |= {mesh.beam_parts[k].group for k in mesh.line_part[_with(mesh.lines, node)]}
    return SolutionError(
        f"the structure is a mechanism: its node at {place(mesh.nodes[node])} in "
        f"{', '.join(sorted(groups))} moves most without any force ({error})"
    )


def _with(cells: NDArray[np.int64], node: int) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = (cells == node).any(axis=1)
    return found


def _structure(case: Case) -> Structure:
    if case.structure is None:
        raise ValueError("the case has no structure")
    return case.structure


def mesh_of_run(case: Case, folder: Path) -> Path:
    """The mesh file of a run: the user's own, or the one generated into its folder."""
    mesh = _structure(case).mesh
    return mesh.file if isinstance(mesh, FileMesh) else folder / MESH


def _mesh_file(case: Case, folder: Path) -> Path:
    path = mesh_of_run(case, folder)
    if path == folder / MESH:
        generate(geometry_of(case), path, source=str(case.path))
    return path


def _base_middle(parts: BuildingParts) -> Array:
    base = parts.mesh.nodes[parts.mesh.base]
    return np.asarray(0.5 * (base.min(axis=0) + base.max(axis=0)), dtype=np.float64)


def _gathered(model: BuildingModel, shapes: Array) -> NDArray[np.float32]:
    """Displacements of all nodes on rank 0, shape (n_modes, n_nodes, 3). Collective."""
    n_modes = shapes.shape[1]
    own = shapes.reshape(len(model.nodes), 6, n_modes)[:, :3]
    gathered = model.comm.gather((model.nodes, own.astype(np.float32)), root=0)
    if gathered is None:
        return np.zeros((n_modes, 0, 3), dtype=np.float32)
    everywhere = np.zeros((n_modes, model.n_nodes, 3), dtype=np.float32)
    for nodes, part in gathered:
        everywhere[:, nodes] = part.transpose(2, 0, 1)
    return everywhere


def _log_memory(comm: Any, what: str) -> None:
    """Log the peak memory of all ranks together. Collective."""
    peak = comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    LOGGER.info("building: %s, peak memory %.1f GB", what, peak / 1024.0**2)
