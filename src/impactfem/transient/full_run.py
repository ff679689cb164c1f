"""The 3D building step by step in full order, with checkpoints."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.model import BuildingModel
from impactfem.dynamics.energy import Energy
from impactfem.dynamics.history import History
from impactfem.dynamics.newmark import Newmark
from impactfem.dynamics.state import State
from impactfem.files import atomic, write_json
from impactfem.log import LOGGER
from impactfem.transient.loads import Loads
from impactfem.transient.response import NodeResponse

Array = NDArray[np.float64]
Index = NDArray[np.int64]

RECORDED = ("displacement", "acceleration")
CHUNK = 100


@dataclass(frozen=True, eq=False)
class FullRun:
    """The result of the full model.

    Args:
        response: Histories at the nodes.
        energy: Energies at each step.
        factor_memory: Memory of the factorisation [B].
    """

    response: NodeResponse
    energy: Energy
    factor_memory: float


def run_full(
    model: BuildingModel,
    K: Any,
    loads: Loads,
    patterns: Array,
    damping: tuple[float, float],
    nodes: Index,
    *,
    checkpoints: Path,
    key: str,
    every: int,
    progress: Callable[[float], None] = lambda part: None,
) -> FullRun:
    """Newmark's average acceleration from rest over all steps of the loads. Collective.

    A run that was interrupted goes on from its last checkpoint: on one rank with the same numbers
    to the last bit.

    Args:
        model: The building.
        K: Its stiffness.
        loads: The loads.
        patterns: Their patterns, shape (n_local, n_patterns).
        damping: α [1/s] and β [s].
        nodes: Nodes to record, not clamped, shape (n,).
        checkpoints: Folder of the checkpoints; removed when the run is done.
        key: Hash of what the run depends on.
        every: Steps between two checkpoints.
        progress: Called with the part of the work that is done.
    """
    amplitudes = loads.amplitudes
    last = len(amplitudes) - 1
    rows = model.global_rows(nodes)[:, None] + np.arange(3)
    store = _Checkpoints(model.comm, checkpoints, key)
    alpha, beta = damping
    with Newmark(K, model.mass, loads.time_step, patterns, alpha=alpha, beta=beta) as system:
        found = store.read()
        if found is None:
            state, before = system.start(amplitudes[0]), None
        else:
            state, before = found
            LOGGER.info("transient: going on from %.3f s", state.step * loads.time_step)
        parts: list[History] = []

        def keep(now: State, part: History) -> None:
            parts.append(part)
            progress(now.step / last)
            if now.step % every == 0 and now.step < last:
                store.write(now, joined([before, *parts]))

        history = system.march(
            state,
            amplitudes,
            probes=rows.ravel(),
            record=RECORDED,
            each_chunk=keep,
            chunk=min(CHUNK, every),
        )
        memory = system.memory
    whole = joined([before, history])
    store.remove()
    shape = (len(whole.step), len(nodes), 3)
    return FullRun(
        response=NodeResponse(
            time_step=loads.time_step,
            displacement=whole.motion["displacement"].reshape(shape),
            acceleration=whole.motion["acceleration"].reshape(shape) + loads.ground[:, None, :],
        ),
        energy=whole.energy,
        factor_memory=memory,
    )


def joined(parts: list[History | None]) -> History:
    """Histories one after the other; where two have the same step, the first one counts."""
    given = [part for part in parts if part is not None and len(part.step)]
    step = np.concatenate([part.step for part in given])
    _, first = np.unique(step, return_index=True)

    def of(name: str, source: Callable[[History], Any]) -> Array:
        values = np.concatenate([getattr(source(part), name) for part in given])
        return np.asarray(values[first])

    energy = Energy(*(of(field.name, lambda part: part.energy) for field in fields(Energy)))
    motion = {
        name: np.concatenate([part.motion[name] for part in given])[first] for name in RECORDED
    }
    return History(step[first], motion, energy)


class _Checkpoints:
    """States of all ranks at one step, with what was recorded until then.

    Each rank writes its own file; the list that names the step is written last of all.
    """

    def __init__(self, comm: Any, folder: Path, key: str) -> None:
        self.comm, self.folder, self.key = comm, folder, key
        self.index = folder / "checkpoint.json"

    def write(self, state: State, history: History) -> None:
        """Write a checkpoint. Collective."""
        step = state.step
        if self.comm.rank == 0:
            self.folder.mkdir(parents=True, exist_ok=True)
        self.comm.barrier()
        with atomic(self._state(step)) as temporary, temporary.open("wb") as stream:
            np.savez(stream, **{f.name: getattr(state, f.name) for f in fields(State)})
        if self.comm.rank == 0:
            content = {f.name: getattr(history.energy, f.name) for f in fields(Energy)}
            content |= history.motion | {"step": history.step}
            with atomic(self._history(step)) as temporary, temporary.open("wb") as stream:
                np.savez(stream, **content)
        self.comm.barrier()
        if self.comm.rank == 0:
            write_json(self.index, {"step": step, "key": self.key, "ranks": self.comm.size})
            for path in self.folder.glob("*.npz"):
                if not path.stem.endswith(f"_{step}"):
                    path.unlink()
        self.comm.barrier()

    def read(self) -> tuple[State, History] | None:
        """The last checkpoint, or None where there is none of this run and these ranks. Collective.

        Only the first rank has the history that was recorded; the others need none of it.
        """
        listed = self.comm.bcast(self._listed() if self.comm.rank == 0 else None)
        if listed is None:
            return None
        state = self._read_state(listed)
        history = self.comm.bcast(self._read_history(listed) if self.comm.rank == 0 else None)
        if history is None or not self.comm.allreduce(state is not None, op=_both):
            return None
        return (state, history) if state is not None else None

    def remove(self) -> None:
        """Remove all checkpoints. Collective."""
        if self.comm.rank == 0 and self.folder.is_dir():
            for path in self.folder.iterdir():
                path.unlink()
            self.folder.rmdir()
        self.comm.barrier()

    def _listed(self) -> int | None:
        try:
            found = json.loads(self.index.read_text(encoding="utf-8"))
            same = found["key"] == self.key and found["ranks"] == self.comm.size
            return int(found["step"]) if same else None
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError) as error:
            LOGGER.warning("%s cannot be read (%s); started again", self.index, error)
            return None

    def _read_state(self, step: int) -> State | None:
        content = _archive(self._state(step))
        if content is None:
            return None
        numbers = {"step": int(content["step"])}
        totals = {name: float(content[name]) for name in ("damped", "input")}
        return State(**(content | numbers | totals))

    def _read_history(self, step: int) -> History | None:
        content = _archive(self._history(step))
        if content is None:
            return None
        energy = Energy(*(content[field.name] for field in fields(Energy)))
        return History(content["step"], {name: content[name] for name in RECORDED}, energy)

    def _state(self, step: int) -> Path:
        return self.folder / f"state_{self.comm.rank}_{step}.npz"

    def _history(self, step: int) -> Path:
        return self.folder / f"history_{step}.npz"


def _archive(path: Path) -> dict[str, Any] | None:
    try:
        with np.load(path, allow_pickle=False) as content:
            return dict(content)
    except (OSError, ValueError, EOFError) as error:
        LOGGER.warning("%s cannot be read (%s); started again", path, error)
        return None


def _both(one: bool, other: bool) -> bool:
    return one and other
