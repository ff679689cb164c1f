"""Checkpoints: states of all ranks at one step, and a march that an interruption does not lose."""

import json
import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import Any

from impactfem.dynamics.energy import Energy
from impactfem.dynamics.history import History, State, joined
from impactfem.dynamics.newmark import CHUNK, Newmark
from impactfem.system.arrays import Array, Index
from impactfem.system.files import read_archive, write_archive, write_json
from impactfem.system.log import LOGGER

INDEX = "checkpoint.json"


class Checkpoints:
    """The last checkpoint of a run, in a folder, with the hash `key` of what the run depends on.

    Each rank writes a file of its own; the list that names the step is written last of all, so that
    a kill leaves the checkpoint before, or this one.
    """

    def __init__(self, comm: Any, folder: Path, key: str) -> None:
        self._comm, self._folder = comm, folder
        # The rows of a rank, and the order of sums, change with the number of ranks.
        self._key = f"{key}, {comm.size} ranks"
        self._index = folder / INDEX

    def write(self, state: State, history: History) -> None:
        """Write a checkpoint of a state, each rank its rows; those before go. Collective.

        The history, of which that of rank 0 counts, goes from step 0 up to this step.
        ImpactfemError where a file cannot be written.
        """
        step = state.step
        if self._comm.rank == 0:
            self._folder.mkdir(parents=True, exist_ok=True)
        self._comm.barrier()
        numbers = {field.name: getattr(state, field.name) for field in fields(State)}
        write_archive(self._state(step), self._key, numbers)
        if self._comm.rank == 0:
            energy = {f.name: getattr(history.energy, f.name) for f in fields(Energy)}
            content = energy | history.motion | {"time": history.time}
            write_archive(self._history(step), self._key, content)
        self._comm.barrier()
        if self._comm.rank == 0:
            write_json(self._index, {"step": step, "key": self._key})
            for path in self._folder.glob("*.npz"):
                if not path.stem.endswith(f"_{step}"):
                    path.unlink()
        self._comm.barrier()

    def read(self) -> tuple[State, History] | None:
        """The last checkpoint of this run on so many ranks; a damaged one goes. Collective."""
        step = self._comm.bcast(self._listed() if self._comm.rank == 0 else None)
        state = self._read_state(step) if step is not None else None
        history = self._read_history(step) if step is not None and self._comm.rank == 0 else None
        history = self._comm.bcast(history)
        whole = all(self._comm.allgather(state is not None and history is not None))
        if state is None or history is None or not whole:
            if self._comm.rank == 0:
                remove_checkpoints(self._folder)
            self._comm.barrier()
            return None
        return state, history

    def _listed(self) -> int | None:
        try:
            found = json.loads(self._index.read_text(encoding="utf-8"))
            return int(found["step"]) if found["key"] == self._key else None
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError) as error:
            LOGGER.warning("warning: %s is damaged (%s); computed again", self._index, error)
            return None

    def _read_state(self, step: int) -> State | None:
        content = read_archive(self._state(step), self._key)
        if content is None:
            return None
        numbers = {field.name: content[field.name] for field in fields(State)}
        # Plain numbers come back as arrays without an axis.
        return State(**{k: v if v.ndim else v.item() for k, v in numbers.items()})

    def _read_history(self, step: int) -> History | None:
        content = read_archive(self._history(step), self._key)
        if content is None:
            return None
        del content["key"]
        energy = Energy(*(content.pop(field.name) for field in fields(Energy)))
        return History(content.pop("time"), content, energy)

    def _state(self, step: int) -> Path:
        return self._folder / f"state_{self._comm.rank}_{step}.npz"

    def _history(self, step: int) -> Path:
        return self._folder / f"history_{step}.npz"


def remove_checkpoints(folder: Path) -> None:
    """Remove the checkpoints of a run, and what a kill left of one. Not collective."""
    if folder.is_dir():
        for path in folder.iterdir():
            if path.suffix in (".npz", ".part") or path.name == INDEX:
                path.unlink()
        with suppress(OSError):  # files of somebody else are in it
            folder.rmdir()


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

    The amplitudes of the loads have the shape (n_t, m), the global rows that are recorded (n,).
    `every` is the most steps between two checkpoints, `stage` names the stage in messages, and
    `progress` is called with the part of the work that is done. SolutionError where the response is
    not finite; ImpactfemError where a checkpoint cannot be written.
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
