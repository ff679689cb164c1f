"""The stage `building`: mesh, matrices, storey factor and modes of the 3D model."""

import math
import resource
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.linalg

from impactfem.building.condensation import floor_flexibility
from impactfem.building.floor_properties import floor_properties
from impactfem.building.from_case import geometry_of, read_parts
from impactfem.building.generate import generate
from impactfem.building.mesh import BuildingMesh, place
from impactfem.building.mesh_report import MeshReport
from impactfem.building.model import BuildingModel, assemble_building
from impactfem.building.parts import BuildingParts, FloorMasses
from impactfem.case import Building3D
from impactfem.case.buildings import FileMesh, Structure
from impactfem.dynamics.columns import inner, product
from impactfem.dynamics.factorisation import SingularMatrixError
from impactfem.dynamics.modes import Modes, modes
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.reduced import modes_near, reduced_model
from impactfem.stages.building.study import BuildingStudy
from impactfem.stages.building.targets import ECCENTRIC, bending_modes
from impactfem.sticks.condensed import CondensedStick, condensed_stick, floor_mass
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError
from impactfem.system.least_squares import minima
from impactfem.system.log import LOGGER, Step
from impactfem.system.parallel import on_root

MESH = "building.msh"
MOST_ROUNDS = 8
TOLERANCE = 1e-6
"""Relative error of the frequency that is reached."""
KRYLOV_STEPS, CHANGE_STEPS = 12, 4
"""Vectors of the ground motion, and of the change of the bending mode, in the first space."""
FARTHEST = 100.0
"""Largest change of the factor in a round, to either side."""


@dataclass(frozen=True, eq=False)
class Known:
    """What is known of a model on the same mesh."""

    mesh: BuildingMesh  #: The mesh.
    shapes: Array | None = None  #: Its modes, shape (n_local, k), as of `Modes`.


def analysed(
    building: Building3D, folder: Path, comm: Any, step: Step, known: Known | None = None
) -> tuple[BuildingStudy, BuildingModel, Modes]:
    """The results of the stage, with the matrices and all degrees of freedom. Collective.

    The mesh is written into the folder, unless it is known. Each step ("mesh", "matrices", "modes",
    "stick") runs inside the context that `step` gives for its name. InputError where the mesh is
    not usable, SolutionError where the structure is a mechanism, or no factor gives the frequency.
    """
    structure, path = building.structure, mesh_of_run(building, folder)

    def read() -> tuple[BuildingParts, FloorMasses, MeshReport]:
        if known is None and path == folder / MESH:
            generate(geometry_of(building), path, source=str(building.case.path))
        parts, masses = read_parts(building, path, None if known is None else known.mesh)
        return parts, masses, MeshReport.of(parts.mesh, parts.sections)

    with step("mesh"):
        parts, masses, report = on_root(read)
        LOGGER.debug("\n%s", report)
        for text in report.warnings:
            LOGGER.warning("warning: mesh: %s", text)
    with step("matrices"):
        model = assemble_building(comm, parts)
        _log_memory(comm, f"{model.n_free} free degrees of freedom, {comm.size} ranks")
    mesh = parts.mesh
    with step("modes"):
        try:
            factor, result = _modes(model, structure, None if known is None else known.shapes)
        except SingularMatrixError as error:
            # Which part of a mechanism moves.
            node = model.node_of(error.row)
            shells = mesh.triangle_part[(mesh.triangles == node).any(axis=1)]
            beams = mesh.line_part[(mesh.lines == node).any(axis=1)]
            groups = {mesh.shell_parts[k].group for k in shells}
            groups |= {mesh.beam_parts[k].group for k in beams}
            raise SolutionError(
                f"the structure is a mechanism: its node at {place(mesh.nodes[node])} in "
                f"{', '.join(sorted(groups))} moves most without any force ({error})"
            ) from error
        _log_memory(comm, f"{structure.modes} modes")
    ground, total = model.about(mesh.base_middle)
    # Displacements of all nodes on rank 0.
    count = len(result.frequency)
    local = result.shapes.reshape(len(model.nodes), 6, count)[:, :3].astype(np.float32)
    gathered = comm.gather((model.nodes, local), root=0) or []
    shapes = np.zeros((count, model.n_nodes if gathered else 0, 3), dtype=np.float32)
    for nodes, part in gathered:
        shapes[:, nodes] = part.transpose(2, 0, 1)
    participation = comm.allreduce(result.shapes.T @ ground)
    stick = None
    if building.name in building.case.sticks_on_models:
        with step("stick"):
            effective = participation**2 / np.diag(total)
            stick = _stick(model, parts, masses, factor, result, effective)
    study = BuildingStudy(
        structure=structure,
        parts=parts,
        masses=masses,
        report=report,
        factor=factor,
        frequency=result.frequency,
        shapes=shapes,
        participation=participation,
        total=np.diag(total).copy(),
        residual=result.residual,
        stick=stick,
    )
    return study, model, result


def _stick(
    model: BuildingModel,
    parts: BuildingParts,
    masses: FloorMasses,
    factor: float,
    result: Modes,
    effective: Array,
) -> CondensedStick:
    """The stick of the 3D model with a storey factor. Collective.

    Args:
        model: Matrices of the 3D model.
        parts: Its parts.
        masses: Masses of its floors.
        factor: Storey factor.
        result: Its modes.
        effective: Their effective masses over the total mass, shape (n_modes, 6).
    """
    mesh = parts.mesh
    found = floor_flexibility(model, mesh, factor, result.shapes)
    properties = floor_properties(parts, masses)
    centre = np.column_stack([properties["ex"], properties["ey"]])
    # A small eccentricity is one of the mesh: it would couple the motions of a symmetric building.
    plan = np.ptp(mesh.nodes[:, :2], axis=0)
    centre[np.abs(centre / plan).max(axis=1) <= ECCENTRIC] = 0.0
    inertia = np.column_stack([properties[f"J{axis}"] for axis in "xyz"])
    return condensed_stick(
        found.F,
        floor_mass(masses.floors, inertia, centre),
        result.frequency,
        found.shapes,
        effective,
    )


def _modes(model: BuildingModel, structure: Structure, known: Array | None) -> tuple[float, Modes]:
    """The storey factor, given or fitted, and the modes with it. Collective."""
    factor, fit = structure.storey_stiffness_factor, structure.calibration
    if fit is not None:
        direction = "xy".index(fit.direction)
        factor, result, rounds = fit_storey_factor(
            model, fit.frequency, direction, factor, structure.modes
        )
        text = "building: storey factor %.4g gives %.4g Hz (%d modal analyses)"
        LOGGER.debug(text, factor, fit.frequency, rounds)
        return factor, result
    K = model.stiffness(factor)
    if known is None:
        result = modes(K, model.mass, structure.modes, fields=model.orientation())
    else:
        result = modes_near(K, model.mass, known, structure.modes, fields=model.orientation())
    K.destroy()
    return factor, result


def mesh_of_run(building: Building3D, folder: Path) -> Path:
    """The mesh file of a building: the user's own, or the one generated into its folder."""
    mesh = building.structure.mesh
    return mesh.file if isinstance(mesh, FileMesh) else folder / MESH


def _log_memory(comm: Any, what: str) -> None:
    """Log the peak memory of all ranks together. Collective."""
    peak = comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    LOGGER.debug("building: %s, peak memory %.1f GB", what, peak / 1024.0**2)


def fit_storey_factor(
    model: BuildingModel, frequency: float, direction: int, start: float, count: int
) -> tuple[float, Modes, int]:
    """Find the factor f with which the first bending mode has a frequency. Collective.

    A factor is found in a small space V, (Vᵀ K_fixed V + f Vᵀ K_storeys V) a = λ a: first in one
    that costs little, of Krylov vectors of the ground motion and of how the bending mode φ changes
    with f, the response to K_storeys φ; then, should the frequency of the modes that follow not be
    near enough, in the space of these modes. Its error is of the second order in that of V.

    Args:
        model: The building.
        frequency: Frequency to reach [Hz].
        direction: 0 or 1, along x or y: the direction in which the mode moves.
        start: First value of f.
        count: Number of modes.

    Returns:
        The factor, the modes with it, and the number of modal analyses that it took.

    Raises:
        SolutionError: There is no such mode among them, or no factor gives the frequency, as when
            the slabs alone are too soft.
    """
    K = model.stiffness(start)
    with KrylovBasis(K, model.mass, 0.0) as basis:
        basis.add(model.ground[:, [direction]])
        basis.grow(KRYLOV_STEPS)
        shapes = basis.V @ reduced_model(basis).coordinates
        bending = _bending(model, shapes, direction)
        if bending.size:
            basis.add(product(model.storeys, shapes[:, bending[:1]]))
            basis.grow(CHANGE_STEPS)
        V = np.array(basis.V)
    K.destroy()
    factor = _reduced_fit(model, V, frequency, direction, start)
    del basis, shapes, V  # beside the factors of the modal analyses memory may be short
    for rounds in range(1, MOST_ROUNDS + 1):
        K = model.stiffness(factor)
        result = modes(K, model.mass, count, fields=model.orientation())
        K.destroy()
        bending = _bending(model, result.shapes, direction)
        if bending.size == 0:
            raise SolutionError(
                f"none of the {result.frequency.size} lowest modes bends along {'xy'[direction]}: "
                f"they reach {result.frequency[-1]:.4g} Hz at the storey factor {factor:.4g}"
            )
        reached = float(result.frequency[bending[0]])
        LOGGER.debug("storey factor %.6g: first bending mode at %.8g Hz", factor, reached)
        if abs(reached / frequency - 1.0) < TOLERANCE:
            return factor, result, rounds
        factor = _reduced_fit(model, result.shapes, frequency, direction, factor)
    raise SolutionError(
        f"no storey factor gives the first bending mode {frequency:g} Hz: after {MOST_ROUNDS} "
        f"modal analyses it is {reached:.6g} Hz"
    )


def _bending(model: BuildingModel, shapes: Array, direction: int) -> Index:
    """Numbers of the shapes Φ, Φᵀ M Φ = I, that bend along a direction, from the lowest."""
    gamma = model.comm.allreduce(shapes.T @ model.ground[:, direction])
    return bending_modes(gamma**2, float(model.total[direction, direction]))


def _reduced_fit(
    model: BuildingModel, V: Array, frequency: float, direction: int, factor: float
) -> float:
    """The factor that gives the frequency in the space of V, shape (n_local, k), Vᵀ M V = I."""
    fixed, storeys = (inner(A, V, product(A, V)) for A in (model.fixed, model.storeys))
    gamma = model.comm.allreduce(V.T @ model.ground[:, direction])

    def bending(x: Array) -> Array:
        f = factor * math.exp(x[0])
        values, vectors = scipy.linalg.eigh(fixed + f * storeys)
        among = bending_modes((vectors.T @ gamma) ** 2, model.total[direction, direction])
        λ, φ = values[k := among[0] if among.size else 0], vectors[:, k]
        # log(λ / λ_target), and its slope by x = log f: dλ = φᵀ (f K_storeys) φ dx.
        error = math.log(λ / (2.0 * math.pi * frequency) ** 2)
        return np.array([error, f * (φ @ storeys @ φ) / λ])

    far, slope = np.log([FARTHEST]), lambda x: bending(x)[1:, None]
    best = minima(lambda x: bending(x)[:1], [0.0 * far], -far, far, jacobian=slope)[0]
    if best.cost > TOLERANCE**2:
        raise SolutionError(
            f"no storey factor from {factor / FARTHEST:.3g} to {factor * FARTHEST:.3g} gives the "
            f"first bending mode {frequency:g} Hz: the slabs and beams are too soft or too stiff"
        )
    return factor * math.exp(best.x[0])
