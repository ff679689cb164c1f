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
from impactfem.reduction.reduced_building import CompleteModel
from impactfem.stages.device.analysis import Analyst
from impactfem.stages.device.damping_study import DeviceStudy, device_study
from impactfem.stages.device.full_run import FullHistories, full_histories
from impactfem.stages.device.full_system import full_system
from impactfem.stages.device.prepared import Prepared, analysis_of, substeps_of
from impactfem.stages.transient.prepared import transient_of
from impactfem.system.log import LOGGER
from impactfem.system.parallel import on_root

Step = Callable[[str], AbstractContextManager[None]]
Progress = Callable[[str, float], None]


def run_devices(
    case: Case,
    prepared: Prepared,
    folder: Path,
    comm: Any,
    step: Step,
    *,
    model: CompleteModel | None,
    key: str,
    within: Progress = lambda name, part: None,
) -> DeviceStudy | None:
    """Run the stage. Collective.

    Args:
        case: The case, with the targets of its sticks and the numbers of its contact laws.
        prepared: What `prepare` gave, the same on all ranks.
        folder: Where checkpoints are kept.
        comm: Communicator of the matrices.
        step: Called with the name of each step ("matrices", "time steps", "damping cases"), which
            runs inside its context.
        model: The reduced building on rank 0.
        key: Hash of what the stage depends on.
        within: Called with the name of a step and the part of it that is done.

    Returns:
        The results on rank 0, None on the others.

    Raises:
        ImpactfemError: A spectrum does not reach a mode of a device.
        SolutionError: A response is not finite.
    """
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


def analyst_of(case: Case, prepared: Prepared, model: CompleteModel) -> Analyst:
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
