"""The stage `calibrate`: the 3D model against a rigid wall, and the stick that stands for it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.floor import contact_edge
from impactfem.building.from_case import read_parts
from impactfem.building.mesh import BuildingMesh, place
from impactfem.building.model import assemble_building
from impactfem.building.parts import BuildingParts
from impactfem.case import Case
from impactfem.case.damping import OWN
from impactfem.case.quantity import CALIBRATED
from impactfem.case.wall_impact import WallImpactSetup
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.dynamics.damping import Rayleigh
from impactfem.stages.calibrate.building_model import WallModel, reduced_wall_model, wall_patterns
from impactfem.stages.calibrate.building_run import BuildingRun, run_reduced
from impactfem.stages.calibrate.experiment import WallExperiment
from impactfem.stages.calibrate.history import WallHistory
from impactfem.stages.calibrate.impact import FloorImpacts, floor_impacts
from impactfem.stages.calibrate.penalty import PenaltyParameters, penalty_parameters
from impactfem.stages.calibrate.side import wall_side
from impactfem.stages.calibrate.stick_run import WallComparison, compare, run_stick
from impactfem.sticks.stick import Stick
from impactfem.system.errors import Fault, InputError
from impactfem.system.log import LOGGER
from impactfem.system.parallel import on_root

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Step = Callable[[str], AbstractContextManager[None]]
Progress = Callable[[str, float], None]

MODEL = "calibrate_model.npz"
MAXIMUM_FREQUENCY = 450.0
"""Up to which the reduced model is good with the building's own damping [Hz]. For other dampings it
is as good as needed: an impact of 10 ms has its power below 200 Hz. On the paper's building, with a
fifth of β and three times of it, 290 vectors more change no restitution by more than 0.2 %."""
TOLERANCE = 0.005
LARGEST = 1200


@dataclass(frozen=True, eq=False)
class Prepared:
    """What a run needs beside the matrices.

    Args:
        parts: The building.
        mass: Masses of the floors that may hit, shape (n_floors,) [kg].
        experiment: What is done.
        storey_factor: Factor on walls and columns.
        dampings: α [1/s] and β [s] of the building's own damping, then by the name of each damping
            case that asks for its restitution.
        position: Place of each contact constraint along its edge, shape (m,) [m].
        length: Length of edge that it stands for, shape (m,) [m].
        theta: θ of the time stepping.
        separation: Shortest time without force between two impacts [s].
    """

    parts: BuildingParts
    mass: Array
    experiment: WallExperiment
    storey_factor: float
    dampings: dict[str, Rayleigh]
    position: Array
    length: Array
    theta: float
    separation: float


@dataclass(frozen=True, eq=False)
class DampedRun:
    """The experiment with one damping of the building.

    Args:
        name: Its name.
        damping: The damping.
        run: What the 3D model did.
        impacts: Impacts of its floors that may hit, bottom to top.
        penalty: ε, ξ_c and K_Ceq from the top one of them.
    """

    name: str
    damping: Rayleigh
    run: BuildingRun
    impacts: tuple[FloorImpacts, ...]
    penalty: PenaltyParameters


@dataclass(frozen=True, eq=False)
class CalibrationStudy:
    """What the stage computed.

    Args:
        case: The case.
        prepared: What it was given.
        model: The reduced 3D model.
        cases: The experiment by damping; that of the building's own first.
        stick: Histories of the stick with the penalty parameters of the first one.
        stick_impacts: Impacts of its floors.
        comparison: Stick and 3D model at the top one of the floors that may hit.
    """

    case: Case
    prepared: Prepared
    model: WallModel
    cases: tuple[DampedRun, ...]
    stick: WallHistory
    stick_impacts: tuple[FloorImpacts, ...]
    comparison: WallComparison

    @property
    def main(self) -> DampedRun:
        """The experiment with the building's own damping."""
        return self.cases[0]


def prepare(case: Case, mesh_file: Path, storey_factor: float) -> Prepared:
    """Read the mesh and make the experiment. Not collective.

    Args:
        case: The case; it has a structure and a wall impact.
        mesh_file: The mesh of the building.
        storey_factor: Factor on walls and columns.

    Raises:
        InputError: The mesh is not usable.
        ImpactfemError: Edges and wall do not go together.
    """
    structure, asked = case.structure, _asked(case)
    if structure is None:
        raise ValueError("the case has no structure")
    parts, masses, _ = read_parts(case, mesh_file)
    experiment = WallExperiment(
        floors=asked.floors,
        displaced_floor=asked.displaced_floor,
        displacement=asked.displacement,
        gap=asked.gap,
        duration=asked.duration,
        time_step=asked.time_step,
        side=wall_side(parts.mesh, asked.floors, mesh_file),
        pull=asked.pull,
    )
    _check_pull(case, parts.mesh, asked)
    edges = [contact_edge(parts.mesh, floor) for floor in asked.floors]
    order = {floor: k for k, floor in enumerate(parts.mesh.floors)}
    own = case.building(structure.building).damping.rayleigh
    return Prepared(
        parts=parts,
        mass=np.array([masses.floors[order[floor]] for floor in asked.floors]),
        experiment=experiment,
        storey_factor=storey_factor,
        dampings={OWN: own}
        | {one.name: one.rayleigh for one in case.damping_cases if one.restitution == CALIBRATED},
        position=np.concatenate([edge.position for edge in edges]),
        length=np.concatenate([edge.weight for edge in edges]),
        theta=asked.theta,
        separation=asked.separation,
    )


def _check_pull(case: Case, mesh: BuildingMesh, asked: WallImpactSetup) -> None:
    """See that the displaced floor can be held at a displacement as a whole.

    Raises:
        InputError: A node of its slab is clamped.
    """
    slab = np.unique(mesh.triangles[mesh.slab(asked.displaced_floor)])
    clamped = np.isin(slab, mesh.base)
    if asked.pull == "whole_floor" and clamped.any():
        expected = (
            f"{clamped.sum()} of the {len(slab)} nodes of the slab of floor "
            f"{asked.displaced_floor} are clamped, at {place(mesh.nodes[slab[clamped][0]])} for "
            "example; expected a floor that is free to move, or 'even_load' or 'mass_centre'"
        )
        raise InputError([Fault(case.path, "wall_impact.pull", asked.pull, expected)])


def run_calibrate(
    case: Case,
    prepared: Prepared,
    folder: Path,
    comm: Any,
    step: Step,
    *,
    model_key: str,
    within: Progress = lambda name, part: None,
) -> CalibrationStudy | None:
    """Run the stage. Collective.

    Args:
        case: The case, with the targets of its sticks.
        prepared: What `prepare` gave, the same on all ranks.
        folder: Where the reduced model is kept.
        comm: Communicator of the matrices.
        step: Called with the name of each step ("matrices", "basis", "impact", "stick"), which
            runs inside its context.
        model_key: Hash of what the reduced model depends on.
        within: Called with the name of a step and the part of it that is done.

    Returns:
        The results on rank 0, None on the others.

    Raises:
        ImpactfemError: The wall starts inside the building.
        SolutionError: No impact in the window, or none that ends in it; the basis does not reach
            its tolerance.
    """
    # On rank 0 alone: the others have no use for it.
    stored = WallModel.read(folder / MODEL, model_key) if comm.rank == 0 else None
    if comm.bcast(stored is None):
        model = _reduced(prepared, comm, step, within)
        on_root(lambda: model.write(folder / MODEL, model_key))
    else:
        LOGGER.info("calibrate: the reduced model of %s is used again", MODEL)

    def evaluate() -> CalibrationStudy:
        found = model if stored is None else stored
        with step("impact"):
            cases = tuple(
                _damping_case(case, prepared, found, name, damping)
                for name, damping in prepared.dampings.items()
            )
        with step("stick"):
            return _study(case, prepared, found, cases)

    return _on_first(evaluate)


def _asked(case: Case) -> WallImpactSetup:
    if case.wall_impact is None:
        raise ValueError("the case has no wall impact")
    return case.wall_impact


def _reduced(prepared: Prepared, comm: Any, step: Step, within: Progress) -> WallModel:
    experiment, mesh = prepared.experiment, prepared.parts.mesh
    with step("matrices"):
        model = assemble_building(comm, prepared.parts)
        K = model.take_stiffness(prepared.storey_factor)
        patterns = wall_patterns(
            model, mesh, experiment.floors, experiment.displaced_floor, experiment.pull
        )
    with step("basis"):
        found = reduced_wall_model(
            model,
            K,
            patterns,
            wall_probes(mesh, experiment.floors),
            damping=prepared.dampings[OWN],
            maximum_frequency=MAXIMUM_FREQUENCY,
            tolerance=TOLERANCE,
            largest=LARGEST,
            progress=lambda part: within("basis", part),
        )
    LOGGER.info(
        "calibrate: reduced model of %d vectors with %d contact constraints; error of the transfer"
        " functions at most %.2g %% up to %g Hz, by nested bases",
        len(found.eigenvalue),
        len(found.floor_of),
        100.0 * found.difference,
        MAXIMUM_FREQUENCY,
    )
    return found


def wall_probes(mesh: BuildingMesh, floors: tuple[int, ...]) -> Index:
    """Nodes where the free building must be accurate: mass centres, ends and middles of edges.

    Args:
        mesh: The mesh.
        floors: Floors that may hit the wall.
    """
    nodes = [mesh.centres[floor] for floor in floors]
    for floor in floors:
        edge = np.unique(mesh.edges[floor])
        along = mesh.nodes[edge] @ np.ptp(mesh.nodes[edge], axis=0)
        nodes += [int(edge[k]) for k in np.argsort(along)[[0, len(edge) // 2, -1]]]
    return np.unique(np.array(nodes, dtype=np.int64))


def _damping_case(
    case: Case, prepared: Prepared, model: WallModel, name: str, damping: Rayleigh
) -> DampedRun:
    run = run_reduced(model, prepared.experiment, prepared.mass, damping, theta=prepared.theta)
    impacts = tuple(
        floor_impacts(run.history, floor, separation=prepared.separation)
        for floor in prepared.experiment.floors
    )
    return DampedRun(name, damping, run, impacts, penalty_parameters(impacts[-1].first_complete()))


def _study(
    case: Case, prepared: Prepared, model: WallModel, cases: tuple[DampedRun, ...]
) -> CalibrationStudy:
    asked, penalty = _asked(case), cases[0].penalty
    stick = run_stick(
        _stick(case),
        prepared.experiment,
        K=penalty.K_Ceq,
        xi=penalty.xi_c,
        tension=penalty.tension,
        update=case.pounding.update,
    )
    return CalibrationStudy(
        case=case,
        prepared=prepared,
        model=model,
        cases=cases,
        stick=stick,
        stick_impacts=tuple(
            floor_impacts(stick, floor, separation=asked.separation) for floor in asked.floors
        ),
        comparison=compare(
            stick, cases[0].run.history, asked.floors[-1], separation=asked.separation
        ),
    )


def _stick(case: Case) -> Stick:
    if case.structure is None:
        raise ValueError("the case has no structure")
    # Contacts of the pounding have no part in it, and their laws may be what is sought here.
    alone = case.model_copy(update={"contacts": ()})
    return system_of(alone, calibration_of(case)).stick(case.structure.building)


def _on_first(action: Callable[[], CalibrationStudy]) -> CalibrationStudy | None:
    """Run on rank 0, where the study stays: it is large."""
    kept: list[CalibrationStudy] = []
    on_root(lambda: kept.append(action()))
    return kept[0] if kept else None
