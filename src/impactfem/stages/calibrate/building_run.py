"""The wall experiment with the 3D model of the building."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.model import BuildingModel
from impactfem.coupling.unilateral import (
    ContactHistory,
    ModalMotion,
    body_before_walls,
    unilateral_response,
)
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.wall import WallModel, WallPatterns
from impactfem.stages.calibrate.experiment import WallExperiment
from impactfem.stages.calibrate.history import WallHistory
from impactfem.stages.calibrate.unilateral_full import FullMotion

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Progress = Callable[[float], None]


@dataclass(frozen=True, eq=False)
class BuildingRun:
    """What the 3D model did at the wall.

    Args:
        history: Histories of the floors.
        contact: Histories of the constraints, and the energies.
    """

    history: WallHistory
    contact: ContactHistory


def run_reduced(
    model: WallModel,
    experiment: WallExperiment,
    mass: Array,
    damping: Rayleigh,
    *,
    theta: float = 0.5,
    progress: Progress = lambda part: None,
) -> BuildingRun:
    """Run the experiment with the reduced model. Not collective.

    Args:
        model: The model.
        experiment: What is done.
        mass: Masses of the floors that may hit, shape (n_floors,) [kg].
        damping: The damping.
        theta: θ of the time stepping, from ½ to 1.
        progress: Called with the part of the work that is done.

    Raises:
        ImpactfemError: The wall starts inside the building.
        SolutionError: The response is not finite.
    """
    z0 = model.start(experiment.displacement)
    _check_start(experiment, model.floor_of, z0 @ model.contact)
    motion = ModalMotion(
        body_before_walls(model.eigenvalue, model.contact, damping),
        experiment.time_step,
        theta=theta,
        probes=model.seen,
    )
    return _released(motion, experiment, mass, model.floor_of, z0, progress)


def run_full(
    model: BuildingModel,
    K: Any,
    patterns: WallPatterns,
    experiment: WallExperiment,
    mass: Array,
    damping: Rayleigh,
    *,
    theta: float = 0.5,
    progress: Progress = lambda part: None,
) -> BuildingRun:
    """Run the experiment in full order: the reference of the reduced model. Collective.

    Args:
        model: The building.
        K: Its stiffness.
        patterns: The columns of the experiment.
        experiment: What is done.
        mass: Masses of the floors that may hit, shape (n_floors,) [kg].
        damping: The damping.
        theta: θ of the time stepping, from ½ to 1.
        progress: Called with the part of the work that is done.

    Raises:
        ImpactfemError: The wall starts inside the building.
        SolutionError: The response is not finite.
    """
    state, _ = patterns.held(K)
    u0 = np.ascontiguousarray(experiment.displacement * state)
    _check_start(experiment, patterns.floor_of, model.comm.allreduce(patterns.contact.T @ u0))
    with FullMotion(
        K,
        model.mass,
        patterns.contact,
        experiment.time_step,
        damping=damping,
        theta=theta,
        probes=patterns.seen,
    ) as motion:
        return _released(motion, experiment, mass, patterns.floor_of, u0, progress)


def _released(
    motion: ModalMotion | FullMotion,
    experiment: WallExperiment,
    mass: Array,
    floor_of: Index,
    start: Array,
    progress: Progress,
) -> BuildingRun:
    """The run from the displacement that the building is held in."""
    steps = experiment.n_t - 1
    contact = unilateral_response(
        motion, experiment.gap, steps, displacement=start, progress=progress
    )
    return BuildingRun(_history(experiment, mass, floor_of, contact), contact)


def _check_start(experiment: WallExperiment, floor_of: Index, displacement: Array) -> None:
    count = len(experiment.floors)
    experiment.check_start(np.array([displacement[floor_of == k].max() for k in range(count)]))


def _history(
    experiment: WallExperiment, mass: Array, floor_of: Index, contact: ContactHistory
) -> WallHistory:
    count = len(experiment.floors)
    of_floor = [floor_of == k for k in range(count)]
    return WallHistory(
        floors=experiment.floors,
        mass=mass,
        gap=experiment.gap,
        time_step=experiment.time_step,
        displacement=contact.displacement[:, :count],
        velocity=contact.velocity[:, :count],
        force=np.column_stack([contact.force[:, mine].sum(axis=1) for mine in of_floor]),
        opening=np.column_stack([contact.gap[:, mine].min(axis=1) for mine in of_floor]),
    )
