"""The building with its devices in it, in full order: all unknowns and no basis, step by step.

This is what the reduced model is held against.

The devices act on the building by their anchors' motions a = S u_m, carried rigidly by the masters
of their base plates, and by their modes ζ. With y = (a, ζ) = W (u, ζ), W = blkdiag(S, 1), and the
matrices of the devices (equation 1 of :mod:`impactfem.device.mounted`),

    M = blkdiag(M_b, 0) + Wᵀ M_d W,    K = blkdiag(K_b, 0) + Wᵀ K_d W,
    C = blkdiag(α M_b + β K_b, 0) + Wᵀ C_d W = α M + β K + C₊,
    C₊ = Wᵀ (C_d − α M_d − β K_d) W,

and the ground acts on the devices by −Wᵀ M_d (R, 0) g̈. The rows of ζ come last.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse
from petsc4py import PETSc

from impactfem.building.links import BasePlate, carried, linked
from impactfem.building.mesh import DOFS, BuildingMesh
from impactfem.building.model import BuildingModel
from impactfem.coupling.links import Attached
from impactfem.device.mounted import MountedDevice, MountedHistory, mounted_histories
from impactfem.dynamics.checkpoints import Checkpoints, resumable_march
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.factorisation import Held
from impactfem.dynamics.history import QUANTITIES
from impactfem.dynamics.newmark import Newmark
from impactfem.reduction.loads import Loads
from impactfem.system.arrays import Array, Index

FullHistories = tuple[tuple[MountedHistory, ...], tuple[MountedHistory, ...]]
"""The devices without impacts, and with them."""
RUNS = ("no_impact", "impact")


@dataclass(frozen=True, eq=False)
class FullSystem(Held):
    """Matrices of a building with its devices. A context manager that frees their memory."""

    K: Any  #: stiffness, PETSc AIJ
    M: Any  #: mass, PETSc AIJ
    C: Any  #: C₊, PETSc AIJ
    patterns: Array  #: patterns of the loads at this rank's rows, shape (n_local, n_patterns)
    devices: tuple[MountedDevice, ...]
    attached: Attached  #: their matrices
    rows: Index  #: global rows that W has columns for, shape (N,)
    W: Array  #: from these rows to y, shape (N, N)

    def destroy(self) -> None:
        """Free the matrices. Collective."""
        for matrix in (self.K, self.M, self.C):
            matrix.destroy()


def full_system(
    building: BuildingModel,
    mesh: BuildingMesh,
    storey_factor: float,
    base_plates: Sequence[BasePlate],
    devices: Sequence[MountedDevice],
    loads: Loads,
    *,
    damping: Rayleigh,
) -> FullSystem:
    """Put devices into a building, whose matrices are gone afterwards. Collective.

    Base plates are those of all anchors, device by device; of the loads the patterns count.

    Raises:
        ImpactfemError: A device cannot be mounted.
        SolutionError: Base plates overlap.
    """
    attached = Attached.alone([one.mount for one in devices])
    model, T = linked(building, [one.link for one in base_plates], mesh.nodes)
    own = carried(T, loads.patterns(building, mesh))
    T.destroy()
    for matrix in (building.fixed, building.storeys, building.mass):
        matrix.destroy()
    modes = len(attached.M) - DOFS * len(base_plates)
    W = scipy.linalg.block_diag(*(one.carried for one in base_plates), np.eye(modes))
    masters = model.global_rows(np.array([one.master for one in base_plates]))
    n = model.n_free
    rows = np.concatenate([(masters[:, None] + np.arange(DOFS)).ravel(), n + np.arange(modes)])
    room = _Room(model.mass, modes, rows)
    shaken = (W.T @ attached.push)[room.mine]
    patterns = np.zeros((room.local, len(loads.names)))
    patterns[: room.building] = own
    patterns[room.places, : len(loads.directions)] += shaken[:, list(loads.directions)]
    return FullSystem(
        K=room.joined(model.take_stiffness(storey_factor), W.T @ attached.K @ W),
        M=room.joined(model.mass, W.T @ attached.M @ W),
        C=room.matrix(W.T @ (attached.C - damping.matrix(attached.K, attached.M)) @ W),
        patterns=patterns,
        devices=tuple(devices),
        attached=attached,
        rows=rows,
        W=W,
    )


class _Room:
    """The rows of a building with those of the devices' modes behind them, on the last rank."""

    def __init__(self, A: PETSc.Mat, modes: int, rows: Index) -> None:
        self.comm = A.getComm()
        self.start, end = A.getOwnershipRange()
        self.building = end - self.start
        last = self.comm.getRank() == self.comm.getSize() - 1
        self.local = self.building + (modes if last else 0)
        self.size = A.getSize()[0] + modes
        self.rows = rows
        # Those of the devices' rows that are this rank's, and their places among its rows.
        self.mine = np.flatnonzero((rows >= self.start) & (rows < self.start + self.local))
        self.places = rows[self.mine] - self.start

    def matrix(self, D: Array) -> PETSc.Mat:
        """A matrix (N, N) of the devices' rows. Collective."""
        N = len(self.rows)
        # With its zeros: the pattern of the mass has to be part of the stiffness's.
        entries = D[self.mine].ravel()
        i = np.repeat(self.places, N)
        j = np.tile(self.rows, len(self.mine))
        shape = (self.local, self.size)
        return self._created(scipy.sparse.csr_matrix((entries, (i, j)), shape=shape), self.local)

    def joined(self, A: PETSc.Mat, D: Array) -> PETSc.Mat:
        """blkdiag(A, 0) + D; A is destroyed. Collective."""
        columns = self.start + np.arange(self.building)
        entries = (np.ones(self.building), (np.arange(self.building), columns))
        shape = (self.building, self.size)
        P = self._created(scipy.sparse.csr_matrix(entries, shape=shape), self.building)
        whole, own = A.ptap(P), self.matrix(D)
        whole.axpy(1.0, own, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        for matrix in (A, P, own):
            matrix.destroy()
        return whole

    def _created(self, rows: scipy.sparse.csr_matrix, count: int) -> PETSc.Mat:
        csr = rows.indptr.astype(PETSc.IntType), rows.indices.astype(PETSc.IntType), rows.data
        size = ((count, None), (self.local, None))
        return PETSc.Mat().createAIJ(size, csr=csr, comm=self.comm)


def full_checkpoints(folder: Path) -> tuple[Path, ...]:
    """Folders of the checkpoints of both runs, without and with impacts, in a run's folder."""
    return tuple(folder / f"device_checkpoints_{name}" for name in RUNS)


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

    By the average acceleration rule, as the reduced model, in `substeps` steps a load, with loads
    that are straight between their samples. A run that was interrupted goes on from its last
    checkpoint in the run's folder, `every` steps at most before; `key` is the hash of what it
    depends on, and `progress` is called with the part of the work that is done.

    Raises:
        SolutionError: A response is not finite, the energies do not balance, or action and
            reaction at a base differ.
        ImpactfemError: A checkpoint cannot be written.
    """
    without = np.zeros_like(loads.force) if loads.external is None else loads.external
    dt = loads.time_step / substeps
    comm = system.M.getComm().tompi4py()
    # Loads are straight between their samples.
    samples = np.arange(len(loads.ground), dtype=np.float64)
    steps = np.arange((len(samples) - 1) * substeps + 1, dtype=np.float64) / substeps
    found = []
    with Newmark(system.K, system.M, dt, system.patterns, damping=damping, C=system.C) as newmark:
        for number, place in enumerate(full_checkpoints(folder)):
            load = loads if number else replace(loads, force=without)

            def after(part: float, done: int = number) -> None:
                progress((done + part) / len(RUNS))

            history = resumable_march(
                newmark,
                np.column_stack([np.interp(steps, samples, p) for p in load.amplitudes.T]),
                system.rows,
                QUANTITIES,
                Checkpoints(comm, place, f"{key}, {dt} s"),
                every,
                stage="device",
                progress=after,
            )
            # Equation 1 of `device.mounted` for the forces at the anchors, once y is known.
            one, ground = system.attached, load.ground
            y, v, a = (system.W @ history.motion[name][::substeps].T for name in QUANTITIES)
            F = one.push @ ground.T - (one.M @ a + one.C @ v + one.K @ y)
            found.append(mounted_histories(system.devices, one, y, v, a, F, history.energy, ground))
    return found[0], found[1]
