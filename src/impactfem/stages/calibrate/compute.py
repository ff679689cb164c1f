"""The stage `calibrate`: the 3D model against a rigid wall, and the stick that stands for it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from impactfem.building.floor import contact_edge
from impactfem.building.from_case import read_parts
from impactfem.building.parts import BuildingParts
from impactfem.case import Case
from impactfem.case.damping import OWN
from impactfem.case.quantity import CALIBRATED
from impactfem.case.wall_impact import WallImpactSetup
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.side import wall_side
from impactfem.reduction.wall import WallModel
from impactfem.stages.calibrate.building_run import BuildingRun, run_reduced
from impactfem.stages.calibrate.experiment import WallExperiment
from impactfem.stages.calibrate.history import WallHistory
from impactfem.stages.calibrate.impact import FloorImpacts, floor_impacts
from impactfem.stages.calibrate.penalty import PenaltyParameters, penalty_parameters
from impactfem.stages.calibrate.stick_run import WallComparison, compare, run_stick
from impactfem.sticks.stick import Stick

Array = NDArray[np.float64]
Step = Callable[[str], AbstractContextManager[None]]


@dataclass(frozen=True, eq=False)
class Prepared:
    """What a run needs beside the matrices.

    Args:
        parts: The building.
        mass: Masses of the floors that may hit, shape (n_floors,) [kg].
        experiment: What is done.
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


def prepare(case: Case, mesh_file: Path) -> Prepared:
    """Read the mesh and make the experiment. Not collective.

    Args:
        case: The case; it has a structure and a wall impact.
        mesh_file: The mesh of the building.

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
    edges = [contact_edge(parts.mesh, floor) for floor in asked.floors]
    order = {floor: k for k, floor in enumerate(parts.mesh.floors)}
    own = case.building(structure.building).damping.rayleigh
    return Prepared(
        parts=parts,
        mass=np.array([masses.floors[order[floor]] for floor in asked.floors]),
        experiment=experiment,
        dampings={OWN: own}
        | {one.name: one.rayleigh for one in case.damping_cases if one.restitution == CALIBRATED},
        position=np.concatenate([edge.position for edge in edges]),
        length=np.concatenate([edge.weight for edge in edges]),
        theta=asked.theta,
        separation=asked.separation,
    )


def run_calibrate(case: Case, prepared: Prepared, model: WallModel, step: Step) -> CalibrationStudy:
    """Run the stage. Not collective.

    Args:
        case: The case, with the targets of its sticks.
        prepared: What `prepare` gave.
        model: The reduced 3D model with its contacts.
        step: Called with the name of each step ("impact", "stick"), which runs inside its context.

    Raises:
        ImpactfemError: The wall starts inside the building.
        SolutionError: No impact in the window, or none that ends in it.
    """
    with step("impact"):
        cases = tuple(
            _damping_case(case, prepared, model, name, damping)
            for name, damping in prepared.dampings.items()
        )
    with step("stick"):
        return _study(case, prepared, model, cases)


def _asked(case: Case) -> WallImpactSetup:
    if case.wall_impact is None:
        raise ValueError("the case has no wall impact")
    return case.wall_impact


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
