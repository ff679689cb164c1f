"""A march of the full model that an interruption does not lose."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from impactfem.dynamics.checkpoints import Checkpoints
from impactfem.dynamics.energy import Energy
from impactfem.dynamics.history import History, State
from impactfem.dynamics.newmark import Newmark
from impactfem.system.log import LOGGER

Array = NDArray[np.float64]
Index = NDArray[np.int64]

CHUNK = 100
"""Most steps between two reports of the progress."""


def resumable_march(
    system: Newmark,
    amplitudes: Array,
    rows: Index,
    record: Sequence[str],
    store: Checkpoints,
    every: int,
    *,
    stage: str,
    progress: Callable[[float], None] = lambda part: None,
) -> History:
    """March from rest over all steps of the loads, with checkpoints. Collective.

    A run that was interrupted goes on from its last checkpoint: on one rank with the same numbers
    to the last bit. The last step has one, too, which is of use until the results are written: to
    remove them is the caller's.

    Args:
        system: The system.
        amplitudes: Amplitudes of its loads, shape (n_t, m).
        rows: Global rows that are recorded, shape (n,).
        record: Which quantities of their motion.
        store: The checkpoints of this run.
        every: Most steps between two of them.
        stage: Name of the stage, for messages.
        progress: Called with the part of the work that is done.

    Raises:
        SolutionError: The response is not finite.
        ImpactfemError: A checkpoint cannot be written.
    """
    last = len(amplitudes) - 1
    # Checkpoints come at the end of a chunk, so that a whole number of chunks lies between them.
    chunks = math.ceil(every / CHUNK)
    chunk = every // chunks
    found = store.read()
    if found is None:
        state = system.start(amplitudes[0])
        before = system.march(state, amplitudes, last=0, probes=rows, record=record)
    else:
        state, before = found
        LOGGER.info("%s: going on from %.3f s", stage, state.step * system.time_step)
    parts = [before]

    def keep(now: State, part: History) -> None:
        parts.append(part)
        progress(now.step / last)
        if now.step % (chunks * chunk) == 0 or now.step == last:
            store.write(now, joined(parts))

    if state.step < last:
        system.march(state, amplitudes, probes=rows, record=record, each_chunk=keep, chunk=chunk)
    return joined(parts)


def joined(parts: Sequence[History]) -> History:
    """Histories one after the other; each begins a step after the one before it ends."""
    energies = {
        field.name: np.concatenate([getattr(part.energy, field.name) for part in parts])
        for field in fields(Energy)
    }
    return History(
        time=np.concatenate([part.time for part in parts]),
        motion={
            name: np.concatenate([part.motion[name] for part in parts]) for name in parts[0].motion
        },
        energy=Energy(**energies),
    )
