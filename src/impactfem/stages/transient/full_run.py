"""The 3D building step by step in full order, with checkpoints."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.links import Displacements
from impactfem.building.model import BuildingModel
from impactfem.dynamics.checkpoints import Checkpoints, resumable_march
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.energy import Energy
from impactfem.dynamics.newmark import ModalPart, Newmark
from impactfem.reduction.loads import Loads
from impactfem.reduction.response import NodeResponse

Array = NDArray[np.float64]

RECORDED = ("displacement", "acceleration")


@dataclass(frozen=True, eq=False)
class FullRun:
    """The result of the full model."""

    response: NodeResponse  #: histories at the nodes
    energy: Energy  #: energies at each step
    factor_memory: float  #: memory of the factorisation; 0 when all steps had been made before [B]


def run_full(
    model: BuildingModel,
    K: Any,
    loads: Loads,
    patterns: Array,
    damping: Rayleigh,
    probes: Displacements,
    *,
    C: Any | None = None,
    modal: ModalPart | None = None,
    checkpoints: Path,
    key: str,
    every: int,
    progress: Callable[[float], None] = lambda part: None,
) -> FullRun:
    """Newmark's average acceleration from rest over all steps of the loads. Collective.

    A run that was interrupted goes on from its last checkpoint: on one rank with the same numbers
    to the last bit. The last step has one, too, which is of use until the results are written:
    `remove_checkpoints` is the caller's.

    Args:
        model: The building.
        K: Its stiffness.
        loads: The loads.
        patterns: Their patterns, shape (n_local, n_patterns).
        damping: The damping.
        probes: What is recorded; clamped nodes move with the ground.
        C: Damping in addition, by part (see `damping_matrix`).
        modal: Damping in addition, of single modes (see `in_full_order`).
        checkpoints: Folder of the checkpoints.
        key: Hash of what the run depends on, C included; loads, other damping and probes are added.
        every: Most steps between two checkpoints.
        progress: Called with the part of the work that is done.

    Raises:
        SolutionError: The response is not finite.
        ImpactfemError: A checkpoint cannot be written.
    """
    free = np.flatnonzero(probes.rows >= 0)
    seen: list[Any] = [(loads.time_step, *astuple(damping)), loads.amplitudes]
    seen += [probes.rows, probes.motion.data, *(() if modal is None else (modal.excess,))]
    digest = hashlib.sha256(b"".join(np.asarray(part).tobytes() for part in seen)).hexdigest()
    store = Checkpoints(model.comm, checkpoints, f"{key}, {digest}")
    step = loads.time_step
    with Newmark(K, model.mass, step, patterns, damping=damping, C=C, modal=modal) as system:
        whole = resumable_march(
            system,
            loads.amplitudes,
            probes.rows[free],
            RECORDED,
            store,
            every,
            stage="transient",
            progress=progress,
        )
        memory = system.memory
    count = len(loads.ground)
    motion = {
        name: (probes.motion[:, free] @ values.T).T.reshape(count, -1, 3)
        for name, values in whole.motion.items()
    }
    return FullRun(
        response=NodeResponse(
            time_step=loads.time_step,
            displacement=motion["displacement"],
            acceleration=motion["acceleration"] + loads.ground[:, None, :],
        ),
        energy=whole.energy,
        factor_memory=memory,
    )
