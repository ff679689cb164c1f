"""Checkpoints of a march: each rank writes its state, rank 0 the recorded history as well."""

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
from impactfem.system.files import read_archive, write_archive
from impactfem.system.log import LOGGER


class Checkpoints:
    """The last checkpoint of a run, in a folder, with the hash `key` of its inputs.

    A rank removes its earlier file after all ranks have written, so that a kill leaves one step
    that all of them have.
    """

    def __init__(self, comm: Any, folder: Path, key: str) -> None:
        self._comm, self._folder = comm, folder
        # The rows of a rank, and the order of sums, change with the number of ranks.
        self._key = f"{key}, {comm.size} ranks"

    def write(self, state: State, history: History) -> None:
        """Write a state, each rank its rows, and the history from step 0 on. Collective.

        ImpactfemError where a file cannot be written.
        """
        self._folder.mkdir(parents=True, exist_ok=True)
        content = {f"state.{f.name}": getattr(state, f.name) for f in fields(State)}
        if self._comm.rank == 0:
            content |= {f"energy.{f.name}": getattr(history.energy, f.name) for f in fields(Energy)}
            content |= {f"motion.{name}": values for name, values in history.motion.items()}
            content["time"] = history.time
        target = self._folder / f"rank_{self._comm.rank}_{state.step}.npz"
        write_archive(target, self._key, content)
        self._comm.barrier()
        for path in self._files():
            if path != target:
                path.unlink()

    def read(self) -> tuple[State, History] | None:
        """Return the last checkpoint that all ranks have; remove the files without. Collective."""
        contents = [content for p in self._files() if (content := read_archive(p, self._key))]
        own = {int(content["state.step"]): content for content in contents}
        steps = set.intersection(*self._comm.allgather(set(own)))
        if not steps:
            if self._comm.rank == 0:
                remove_checkpoints(self._folder)
            self._comm.barrier()
            return None
        content = own[max(steps)]
        # Plain numbers come back as arrays without an axis.
        parts = {name: v if v.ndim else v.item() for name, v in content.items()}
        state = State(**{f.name: parts[f"state.{f.name}"] for f in fields(State)})
        history = None
        if self._comm.rank == 0:
            motion = {k.removeprefix("motion."): v for k, v in parts.items() if "motion." in k}
            energy = Energy(*(parts[f"energy.{f.name}"] for f in fields(Energy)))
            history = History(parts["time"], motion, energy)
        return state, self._comm.bcast(history)

    def _files(self) -> list[Path]:
        return list(self._folder.glob(f"rank_{self._comm.rank}_*.npz"))


def remove_checkpoints(folder: Path) -> None:
    """Remove the checkpoints of a run, and the parts that a kill left. Not collective."""
    if folder.is_dir():
        for path in folder.iterdir():
            if path.suffix in (".npz", ".part"):
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
    progress: Callable[[float], None] = lambda part: None,
) -> History:
    """March from rest over all steps of the loads, with checkpoints. Collective.

    An interrupted run continues from its last checkpoint: on one rank with the same numbers to the
    last bit. The last step has a checkpoint, too; the caller removes it with the results written.

    The amplitudes of the loads have the shape (n_t, m), the recorded global rows (n,). `every` is
    the largest number of steps between two checkpoints; `progress` receives the completed part.
    SolutionError where the response is not finite; ImpactfemError where a file cannot be written.
    """
    last = len(amplitudes) - 1
    # Checkpoints come at the end of a chunk, so that a whole number of chunks lies between them.
    chunks = math.ceil(every / CHUNK)
    chunk = every // chunks
    known = store.read()
    if known is None:
        state = system.start(amplitudes[0])
        before = system.march(state, amplitudes, last=0, probes=rows, record=record)
    else:
        state, before = known
        LOGGER.info("transient: going on from %.3f s", state.step * system.time_step)
    parts = [before]

    def keep(now: State, part: History) -> None:
        parts.append(part)
        progress(now.step / last)
        if now.step % (chunks * chunk) == 0 or now.step == last:
            store.write(now, joined(parts))

    if state.step < last:
        system.march(state, amplitudes, probes=rows, record=record, each_chunk=keep, chunk=chunk)
    return joined(parts)
