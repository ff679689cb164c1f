"""States and histories of a response in time: what is recorded, summed over the ranks."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from petsc4py import PETSc

from impactfem.dynamics.energy import Energy
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError

QUANTITIES = ("displacement", "velocity", "acceleration")


@dataclass
class State:
    """A response at one time, on this rank: all that is needed to go on, bitwise on one rank."""

    step: int  #: Number of the time, 0 at the start.
    displacement: Array  #: u, shape (n_local,) [m, rad].
    velocity: Array  #: v, shape (n_local,).
    acceleration: Array  #: a, shape (n_local,).
    momentum: Array  #: M v, shape (n_local,).
    restoring: Array  #: K u, shape (n_local,).
    damped: float = 0.0  #: Energy that the damping has taken, of all ranks [J].
    input: float = 0.0  #: Work of the loads, of all ranks [J].


@dataclass(frozen=True)
class History:
    """Recorded histories, the same on all ranks."""

    time: Array  #: The times, shape (n_t,) [s].
    #: By quantity (of QUANTITIES), the motion of the probes, shape (n_t, n_probes).
    motion: dict[str, Array]
    energy: Energy  #: The energies.


class Recorder:
    """Numbers of this rank, one row a time, summed over the ranks chunk by chunk.

    Probes are global rows of the matrix A, `record` some of QUANTITIES. SolutionError of an
    unknown quantity, a row that does not exist.
    """

    def __init__(
        self,
        A: PETSc.Mat,
        probes: Sequence[int] | Index,
        record: Sequence[str],
        chunk: int,
        time_step: float,
    ) -> None:
        rows = np.asarray(probes, dtype=np.int64)
        wrong = [name for name in record if name not in QUANTITIES]
        outside = rows[(rows < 0) | (rows >= A.getSize()[0])]
        if wrong or outside.size:
            raise SolutionError(f"cannot record {', '.join(wrong) or f'row {outside[0]}'}")
        start, end = A.getOwnershipRange()
        self.comm = A.getComm().tompi4py()
        self.time_step = time_step
        self.record = tuple(record)
        self.place = np.flatnonzero((rows >= start) & (rows < end))
        self.local = rows[self.place] - start
        self.probes = rows.size
        self.buffer = np.zeros((chunk, 4 + len(self.record) * rows.size))
        self.filled = 0
        self.parts: list[History] = []

    def put(self, state: State, energies: tuple[float, float, float, float]) -> None:
        """Keep the motion of the probes, and this rank's energies as the stepper gives them."""
        row = self.buffer[self.filled]
        row[:4] = energies
        for k, name in enumerate(self.record):
            row[4 + k * self.probes + self.place] = getattr(state, name)[self.local]
        self.filled += 1

    def reduce(self, state: State) -> History:
        """Sum over the ranks what was put since the last call. Collective.

        Sets the energies of the state. SolutionError where not all numbers are finite.
        """
        total = self.comm.allreduce(self.buffer[: self.filled])
        if not np.all(np.isfinite(total)):
            raise SolutionError(f"the response is not finite before step {state.step}")
        # One by one from the first step on, so that it does not matter where chunks begin.
        damped = np.cumsum(np.append(state.damped, total[:, 2]))[1:]
        work = np.cumsum(np.append(state.input, total[:, 3]))[1:]
        state.damped, state.input = float(damped[-1]), float(work[-1])
        motion = np.split(total[:, 4:], len(self.record), axis=1) if self.record else []
        part = History(
            time=self.time_step * np.arange(state.step + 1 - self.filled, state.step + 1),
            motion=dict(zip(self.record, motion, strict=True)),
            energy=Energy(total[:, 0], total[:, 1], damped, work),
        )
        self.filled = 0
        self.parts.append(part)
        return part


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
