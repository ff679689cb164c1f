"""The stage `device`: devices in the 3D model and by response spectra, for every damping case."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.model import assemble_building
from impactfem.building.parts import BuildingParts
from impactfem.building.read_parts import read_parts
from impactfem.case import Case, DampingCase, DeviceAnalysis
from impactfem.case.calibrated import CALIBRATED
from impactfem.case.damping_cases import OWN
from impactfem.case.transient import Transient
from impactfem.device.combination import Combination
from impactfem.device.device import Device
from impactfem.device.from_case import checked_devices, rules_of
from impactfem.device.rules import Rules
from impactfem.equipment.analysis import Analyst, DeviceResult
from impactfem.equipment.pounding import damped_case, impact_forces
from impactfem.equipment.rosette import Rosette, find_rosette
from impactfem.equipment.study_model import Accuracy, StudyModel, study_model
from impactfem.log import LOGGER
from impactfem.motion.from_case import GroundMotion, ground_motions
from impactfem.parallel import on_root
from impactfem.sticks.calibration import Calibration
from impactfem.sticks.force_history import ForceHistory, read_forces
from impactfem.sticks.from_case import calibration_of
from impactfem.transient.forces import checked_forces
from impactfem.transient.loads import Loads, make_loads
from impactfem.wall.building_run import run_reduced
from impactfem.wall.impact import floor_impacts
from impactfem.wall.penalty import penalty_parameters
from impactfem.wall.stage import Prepared as WallPrepared
from impactfem.wall.stage import prepare as prepare_wall

Array = NDArray[np.float64]
Step = Callable[[str], AbstractContextManager[None]]
Progress = Callable[[str, float], None]

MODEL = "device_model.npz"
LIGHT_FREQUENCY = 100.0
"""Up to which the basis is good with the lightest damping case [Hz]; with the building's own
damping it is as good as that of the stage `transient`. Measured on the paper's building with 63,000
degrees of freedom: a basis for the own damping alone (352 vectors) gives the largest force of the
paper's device with a fifth of β within 0.15 % of a basis for that damping up to 450 Hz (892)."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """What a run needs beside the matrices.

    Args:
        parts: The building.
        storey_factor: Factor on walls and columns.
        devices: The devices.
        rosettes: Where they are anchored.
        rules: Rules of the response spectrum analysis of each, by combination.
        own: Damping of the building, α [1/s] and β [s].
        forces: Impact forces with the building's own damping.
        loads: They and the ground motion, at the step of the 3D model.
        motions: The ground motions.
        wall: The wall experiment; None where there is none.
    """

    parts: BuildingParts
    storey_factor: float
    devices: tuple[Device, ...]
    rosettes: tuple[Rosette, ...]
    rules: tuple[Mapping[Combination, Rules], ...]
    own: tuple[float, float]
    forces: ForceHistory
    loads: Loads
    motions: tuple[GroundMotion, ...]
    wall: WallPrepared | None


@dataclass(frozen=True, eq=False)
class DampedStudy:
    """The devices with one damping of the buildings.

    Args:
        name: Name of the damping case.
        damping: α [1/s] and β [s].
        epsilon: Restitution of the pounding; None where the laws kept theirs.
        calibrated: Whether it comes from the wall experiment with this damping.
        loads: Ground motion and impacts.
        no_impact: The devices without the impacts.
        impact: The devices with them.
    """

    name: str
    damping: tuple[float, float]
    epsilon: float | None
    calibrated: bool
    loads: Loads
    no_impact: tuple[DeviceResult, ...]
    impact: tuple[DeviceResult, ...]


@dataclass(frozen=True, eq=False)
class DeviceStudy:
    """What the stage computed.

    Args:
        case: The case.
        prepared: What it was given.
        model: The reduced model.
        cases: The devices by damping; that of the building's own first.
    """

    case: Case
    prepared: Prepared
    model: StudyModel
    cases: tuple[DampedStudy, ...]

    @property
    def direction(self) -> int:
        """Component of the first ground motion."""
        return "xyz".index(self.case.motions[0].direction)


def prepare(case: Case, mesh_file: Path, forces_file: Path, storey_factor: float) -> Prepared:
    """Read mesh, motions and forces, and build the devices. Not collective.

    Args:
        case: The case; it has a structure, a transient part and devices.
        mesh_file: The mesh of the building.
        forces_file: The impact forces of the sticks, where the case names none of its own.
        storey_factor: Factor on walls and columns.

    Raises:
        InputError: The mesh, the forces or a device are not usable.
        SolutionError: An anchor stands on no node of a floor.
    """
    structure, transient, analysis = case.structure, _transient(case), _analysis(case)
    if structure is None:
        raise ValueError("the case has no structure")
    parts, _, _ = read_parts(case, mesh_file)
    path = transient.forces or forces_file
    forces = read_forces(path)
    motions = tuple(ground_motions(case.motions))
    devices = tuple(checked_devices(case))
    return Prepared(
        parts=parts,
        storey_factor=storey_factor,
        devices=devices,
        rosettes=tuple(find_rosette(parts.mesh, d.name, d.point, d.radius) for d in case.devices),
        rules=tuple(rules_of(analysis, d.maximum_frequency) for d in case.devices),
        own=case.building(structure.building).damping.coefficients,
        forces=forces,
        loads=_loads(
            case, parts, motions, forces, path, transient.duration or float(forces.time[-1])
        ),
        motions=motions,
        wall=None if case.wall_impact is None else prepare_wall(case, mesh_file, storey_factor),
    )


def run_devices(
    case: Case,
    prepared: Prepared,
    folder: Path,
    comm: Any,
    step: Step,
    *,
    model_key: str,
    within: Progress = lambda name, part: None,
) -> DeviceStudy | None:
    """Run the stage. Collective.

    Args:
        case: The case, with the targets of its sticks and the numbers of its contact laws.
        prepared: What `prepare` gave, the same on all ranks.
        folder: Where the reduced model is kept.
        comm: Communicator of the matrices.
        step: Called with the name of each step ("matrices", "basis", "damping cases"), which runs
            inside its context.
        model_key: Hash of what the reduced model depends on.
        within: Called with the name of a step and the part of it that is done.

    Returns:
        The results on rank 0, None on the others.

    Raises:
        ImpactfemError: A spectrum does not reach a mode of a device.
        SolutionError: The basis does not reach its tolerance; a response is not finite; an impact
            on the wall cannot be evaluated.
    """
    # On rank 0 alone: the others have no use for it.
    stored = StudyModel.read(folder / MODEL, model_key) if comm.rank == 0 else None
    if comm.bcast(stored is None):
        model = _reduced(case, prepared, comm, step, within)
        on_root(lambda: model.write(folder / MODEL, model_key))
    else:
        LOGGER.info("device: the reduced model of %s is used again", MODEL)
    kept: list[DeviceStudy] = []

    def evaluate() -> None:
        with step("damping cases"):
            found = model if stored is None else stored
            kept.append(_study(case, prepared, found, lambda part: within("damping cases", part)))

    on_root(evaluate)
    return kept[0] if kept else None


def _transient(case: Case) -> Transient:
    if case.transient is None:
        raise ValueError("the case has no transient part")
    return case.transient


def _analysis(case: Case) -> DeviceAnalysis:
    if case.device_analysis is None:
        raise ValueError("the case has no devices")
    return case.device_analysis


def _loads(
    case: Case,
    parts: BuildingParts,
    motions: tuple[GroundMotion, ...],
    forces: ForceHistory,
    path: Path,
    duration: float,
) -> Loads:
    transient = _transient(case)
    own, edges = checked_forces(forces, path, case, parts.mesh, duration)
    n_steps = math.floor(duration / transient.time_step * (1.0 + 1e-9))
    along = [
        ("xyz".index(m.direction), m.accelerogram.time_step, m.accelerogram.acceleration)
        for m in motions
    ]
    return make_loads(along, own, edges, transient.time_step, n_steps)


def _reduced(case: Case, prepared: Prepared, comm: Any, step: Step, within: Progress) -> StudyModel:
    transient, loads = _transient(case), prepared.loads
    with step("matrices"):
        building = assemble_building(comm, prepared.parts)
    accuracies = [Accuracy(prepared.own, transient.maximum_frequency, transient.tolerance)]
    if case.damping_cases:
        frequency = min(LIGHT_FREQUENCY, transient.maximum_frequency)
        lightest = min(case.damping_cases, key=lambda one: one.ratio_at(frequency))
        accuracies.append(Accuracy(lightest.coefficients, frequency, transient.tolerance))
    wall = prepared.wall
    with step("basis"):
        found = study_model(
            building,
            prepared.parts.mesh,
            prepared.storey_factor,
            prepared.rosettes,
            directions=loads.directions,
            hit=[edge.floor for edge in loads.edges],
            eccentricity=transient.eccentricity,
            wall=None
            if wall is None
            else (wall.experiment.floors, wall.experiment.displaced_floor),
            accuracies=accuracies,
            largest=transient.largest_basis,
            progress=lambda part: within("basis", part),
        )
    LOGGER.info(
        "device: reduced model of %d vectors; error of the transfer functions at most %.2g %%",
        len(found.eigenvalue),
        100.0 * found.difference,
    )
    return found


def _study(
    case: Case, prepared: Prepared, model: StudyModel, progress: Callable[[float], None]
) -> DeviceStudy:
    transient, analysis = _transient(case), _analysis(case)
    step = analysis.time_step or transient.time_step
    analyst = Analyst(
        model=model,
        devices=prepared.devices,
        rules=prepared.rules,
        spectra=case.spectra,
        rotations=analysis.rotations,
        broadening=analysis.broadening,
        substeps=max(1, math.ceil(transient.time_step / step * (1.0 - 1e-9))),
    )
    calibration = calibration_of(case) if case.damping_cases else None
    count = 1 + len(case.damping_cases)
    cases = [_damped(analyst, OWN, prepared.own, None, calibrated=False, loads=prepared.loads)]
    progress(1.0 / count)
    for number, one in enumerate(case.damping_cases, 2):
        cases.append(_damping_case(case, prepared, analyst, one, calibration))
        progress(number / count)
    return DeviceStudy(case, prepared, model, tuple(cases))


def _damping_case(
    case: Case,
    prepared: Prepared,
    analyst: Analyst,
    one: DampingCase,
    calibration: Calibration | None,
) -> DampedStudy:
    """Restitution, sticks, 3D model and devices again with another damping."""
    transient = _transient(case)
    if transient.forces is not None:
        # Nothing is known of what another damping would do to forces from elsewhere.
        LOGGER.info("device: damping case %s with the forces of %s", one.name, transient.forces)
        return _damped(
            analyst, one.name, one.coefficients, None, calibrated=False, loads=prepared.loads
        )
    calibrated = one.restitution == CALIBRATED and analyst.model.wall is not None
    epsilon = None if one.restitution == CALIBRATED else float(one.restitution)
    if calibrated:
        epsilon = _epsilon(prepared, analyst.model, one.coefficients)
    damped = damped_case(case, one, epsilon)
    duration = prepared.loads.time_step * (len(prepared.loads.ground) - 1)
    forces = impact_forces(damped, calibration, prepared.motions, duration)
    loads = _loads(damped, prepared.parts, prepared.motions, forces, case.path, duration)
    LOGGER.debug("device: damping case %s with the restitution %s", one.name, epsilon)
    return _damped(analyst, one.name, one.coefficients, epsilon, calibrated=calibrated, loads=loads)


def _damped(
    analyst: Analyst,
    name: str,
    damping: tuple[float, float],
    epsilon: float | None,
    *,
    calibrated: bool,
    loads: Loads,
) -> DampedStudy:
    quiet = replace(loads, edges=(), force=loads.force[:, :0])
    return DampedStudy(
        name=name,
        damping=damping,
        epsilon=epsilon,
        calibrated=calibrated,
        loads=loads,
        no_impact=tuple(analyst.analyse(quiet, damping)),
        impact=tuple(analyst.analyse(loads, damping)),
    )


def _epsilon(prepared: Prepared, model: StudyModel, damping: tuple[float, float]) -> float:
    """Restitution by equation 5 of the wall experiment with another damping."""
    wall, reduced = prepared.wall, model.wall
    if wall is None or reduced is None:
        raise ValueError("the study has no wall experiment")
    run = run_reduced(reduced, wall.experiment, wall.mass, damping, theta=wall.theta)
    top = floor_impacts(run.history, wall.experiment.floors[-1], separation=wall.separation)
    return penalty_parameters(top.first_complete()).epsilon
