"""Devices in the building step by step in full order: what the reduced model is held against."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from impactfem.device.mounted import MountedHistory, mounted_histories
from impactfem.dynamics.checkpoints import Checkpoints, remove_checkpoints, resumable_march
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.history import QUANTITIES, History
from impactfem.dynamics.newmark import Newmark
from impactfem.reduction.loads import Loads
from impactfem.stages.device.full_system import FullSystem

Array = NDArray[np.float64]

FullHistories = tuple[tuple[MountedHistory, ...], tuple[MountedHistory, ...]]
"""The devices without impacts, and with them."""
RUNS = ("no_impact", "impact")


def full_checkpoints(folder: Path) -> tuple[Path, ...]:
    """Folders of the checkpoints of both runs, without and with impacts, in a run's folder."""
    return tuple(folder / f"device_checkpoints_{name}" for name in RUNS)


def remove_full_checkpoints(folder: Path) -> None:
    """Remove the checkpoints of both runs. Not collective."""
    for place in full_checkpoints(folder):
        remove_checkpoints(place)


def full_histories(
    system: FullSystem,
    loads: Loads,
    damping: Rayleigh,
    substeps: int,
    folder: Path,
    *,
    key: str,
    every: int,
    progress: Callable[[float], None] = lambda part: None,
) -> FullHistories:
    """March the building with its devices without and with the impacts. Collective.

    By the average acceleration rule, as the reduced model, with loads that are straight between
    their samples. A run that was interrupted goes on from its last checkpoint.

    Args:
        system: Building and devices.
        loads: The loads.
        damping: α [1/s] and β [s] of the building.
        substeps: Steps in one of the loads.
        folder: The run's folder, for the checkpoints.
        key: Hash of what the runs depend on.
        every: Most steps between two checkpoints.
        progress: Called with the part of the work that is done.

    Returns:
        The devices at the samples of the loads, without impacts and with them.

    Raises:
        SolutionError: A response is not finite, the energies do not balance, or action and
            reaction at a base differ.
        ImpactfemError: A checkpoint cannot be written.
    """
    own = np.zeros_like(loads.force) if loads.external is None else loads.external
    quiet = replace(loads, force=own)
    dt = loads.time_step / substeps
    comm = system.M.getComm().tompi4py()
    found = []

    def after(done: int) -> Callable[[float], None]:
        return lambda part: progress((done + part) / len(RUNS))

    with Newmark(system.K, system.M, dt, system.patterns, damping=damping, C=system.C) as newmark:
        for number, (place, load) in enumerate(
            zip(full_checkpoints(folder), (quiet, loads), strict=True)
        ):
            history = resumable_march(
                newmark,
                _refined(load.amplitudes, substeps),
                system.rows,
                QUANTITIES,
                Checkpoints(comm, place, f"{key}, {dt} s"),
                every,
                stage="device",
                progress=after(number),
            )
            found.append(_histories(system, load, history, substeps))
    return found[0], found[1]


def _refined(amplitudes: Array, substeps: int) -> Array:
    """Amplitudes at the steps of the march, straight between their samples."""
    samples = np.arange(len(amplitudes), dtype=np.float64)
    steps = np.arange((len(amplitudes) - 1) * substeps + 1, dtype=np.float64) / substeps
    return np.column_stack([np.interp(steps, samples, column) for column in amplitudes.T])


def _histories(
    system: FullSystem, loads: Loads, history: History, substeps: int
) -> tuple[MountedHistory, ...]:
    """Equation 1 of `device.mounted` for the forces at the anchors, once y is known."""
    one = system.attached
    y, v, a = (system.W @ history.motion[name][::substeps].T for name in QUANTITIES)
    F = one.push @ loads.ground.T - (one.M @ a + one.C @ v + one.K @ y)
    return mounted_histories(system.devices, one, y, v, a, F, history.energy, loads.ground)
