"""The stage `device`: devices in the 3D model and by response spectra, for every damping case."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np

from impactfem.building.model import assemble_building
from impactfem.case import Case
from impactfem.device.mounted import MountedDevice
from impactfem.stages.device.analysis import Analyst
from impactfem.stages.device.damping_study import DeviceStudy, device_study
from impactfem.stages.device.full_run import FullHistories, full_histories
from impactfem.stages.device.full_system import full_system
from impactfem.stages.device.prepared import Prepared, analysis_of, substeps_of
from impactfem.stages.device.study_model import Accuracy, StudyModel, study_model
from impactfem.stages.transient.prepared import transient_of
from impactfem.system.log import LOGGER
from impactfem.system.parallel import on_root

Step = Callable[[str], AbstractContextManager[None]]
Progress = Callable[[str, float], None]

MODEL = "device_model.npz"
LIGHT_FREQUENCY = 100.0
"""Up to which the basis is good with the lightest damping case [Hz]; with the building's own
damping it is as good as that of the stage `transient`. Measured on the paper's building with 63,000
degrees of freedom: a basis for the own damping alone (352 vectors) gives the largest force of the
paper's device with a fifth of β within 0.15 % of a basis for that damping up to 450 Hz (892)."""


def run_devices(
    case: Case,
    prepared: Prepared,
    folder: Path,
    comm: Any,
    step: Step,
    *,
    model_key: str,
    key: str,
    within: Progress = lambda name, part: None,
) -> DeviceStudy | None:
    """Run the stage. Collective.

    Args:
        case: The case, with the targets of its sticks and the numbers of its contact laws.
        prepared: What `prepare` gave, the same on all ranks.
        folder: Where the reduced model is kept.
        comm: Communicator of the matrices.
        step: Called with the name of each step ("matrices", "basis", "time steps", "damping
            cases"), which runs inside its context.
        model_key: Hash of what the reduced model depends on; the floors that are hit and the
            directions of the ground are added to it.
        key: Hash of what the stage depends on.
        within: Called with the name of a step and the part of it that is done.

    Returns:
        The results on rank 0, None on the others.

    Raises:
        ImpactfemError: A spectrum does not reach a mode of a device.
        SolutionError: The basis does not reach its tolerance; a response is not finite; an impact
            on the wall cannot be evaluated.
    """
    model = device_model(case, prepared, folder, comm, step, model_key=model_key, within=within)
    full = None
    if analysis_of(case).solver == "full":
        full = _full(case, prepared, folder, comm, step, key, within)
    kept: list[DeviceStudy] = []

    def progress(part: float) -> None:
        within("damping cases", part)

    def evaluate() -> None:
        if model is None:
            raise ValueError("rank 0 has no reduced model")
        with step("damping cases"):
            analyst = analyst_of(case, prepared, model)
            kept.append(device_study(case, prepared, analyst, full, progress))

    on_root(evaluate)
    return kept[0] if kept else None


def device_model(
    case: Case,
    prepared: Prepared,
    folder: Path,
    comm: Any,
    step: Step,
    *,
    model_key: str,
    within: Progress = lambda name, part: None,
) -> StudyModel | None:
    """The reduced model of a run: read where it is kept, else made and kept. Collective.

    Args: as of `run_devices`.

    Returns:
        The model on rank 0; the others have no use for it.

    Raises:
        SolutionError: The basis does not reach its tolerance.
    """
    loads = prepared.loads
    hit = ", ".join(str(edge.floor) for edge in loads.edges)
    model_key = f"{model_key}, ground {loads.directions}, floors {hit}"
    stored = StudyModel.read(folder / MODEL, model_key) if comm.rank == 0 else None
    if comm.bcast(stored is None):
        model = _reduced(case, prepared, comm, step, within)
        on_root(lambda: model.write(folder / MODEL, model_key))
        return model if comm.rank == 0 else None
    LOGGER.info("device: the reduced model of %s is used again", MODEL)
    return stored


def _reduced(case: Case, prepared: Prepared, comm: Any, step: Step, within: Progress) -> StudyModel:
    transient, loads = transient_of(case), prepared.loads
    with step("matrices"):
        building = assemble_building(comm, prepared.parts)
    accuracies = [Accuracy(prepared.own, transient.maximum_frequency, transient.tolerance)]
    if case.damping_cases:
        frequency = min(LIGHT_FREQUENCY, transient.maximum_frequency)
        lightest = min(case.damping_cases, key=lambda one: one.rayleigh.ratio(frequency))
        accuracies.append(Accuracy(lightest.rayleigh, frequency, transient.tolerance))
    wall = prepared.wall
    with step("basis"):
        found = study_model(
            building,
            prepared.parts.mesh,
            prepared.storey_factor,
            prepared.base_plates,
            prepared.points.nodes,
            directions=loads.directions,
            hit=[edge.floor for edge in loads.edges],
            eccentricity=transient.eccentricity,
            wall=None
            if wall is None
            else (
                wall.experiment.floors,
                wall.experiment.displaced_floor,
                wall.experiment.pull,
            ),
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


def _full(
    case: Case,
    prepared: Prepared,
    folder: Path,
    comm: Any,
    step: Step,
    key: str,
    within: Progress,
) -> FullHistories:
    """The devices with the building's own damping in full order. Collective."""
    transient, loads = transient_of(case), prepared.loads
    substeps = substeps_of(case)
    with step("time steps"):
        building = assemble_building(comm, prepared.parts)
        with full_system(
            building,
            prepared.parts.mesh,
            prepared.storey_factor,
            prepared.base_plates,
            [MountedDevice(one.name, one) for one in prepared.devices],
            loads,
            eccentricity=transient.eccentricity,
            damping=prepared.own,
        ) as system:
            LOGGER.info(
                "device: %d unknowns in full order, %d steps without and with impacts",
                system.M.getSize()[0],
                (len(loads.ground) - 1) * substeps,
            )
            return full_histories(
                system,
                loads,
                prepared.own,
                substeps,
                folder,
                key=key,
                every=max(1, round(transient.checkpoint_every / loads.time_step * substeps)),
                progress=lambda part: within("time steps", part),
            )


def analyst_of(case: Case, prepared: Prepared, model: StudyModel) -> Analyst:
    """What analyses the devices under any load, as the case asks.

    Args:
        case: The case.
        prepared: What `prepare` gave.
        model: The reduced model.
    """
    return Analyst(
        model=model,
        plans=prepared.plans,
        positions=np.array([one.point for one in prepared.base_plates]),
        covered=prepared.points.of_anchor,
        spectra=case.spectra,
        substeps=substeps_of(case),
    )
