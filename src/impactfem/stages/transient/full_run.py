"""The 3D model in full order under the loads, by Newmark, with checkpoints."""

import hashlib
from collections.abc import Callable
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from impactfem.building.links import Displacements, carried, linked
from impactfem.building.model import BuildingModel, assemble_building, damping_matrix
from impactfem.case import Spectra
from impactfem.case.transient import Transient
from impactfem.dynamics.checkpoints import Checkpoints, resumable_march
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.energy import Energy
from impactfem.dynamics.newmark import ModalPart, Newmark, in_full_order
from impactfem.reduction.loads import Loads
from impactfem.reduction.response import Band, NodeResponse, node_spectra
from impactfem.stages.transient.node_results import NodeResults
from impactfem.stages.transient.prepared import Prepared
from impactfem.system.arrays import Array
from impactfem.system.log import LOGGER, Steps
from impactfem.system.parallel import communicator

RECORDED = ("displacement", "acceleration")
CHECKPOINTS = "transient_checkpoints"


@dataclass(frozen=True, eq=False)
class FullModel:
    """The matrices of a building and its damping, distributed over the ranks."""

    building: BuildingModel
    K: Any  #: stiffness
    damping: Rayleigh
    C: Any | None = None  #: damping in addition, by part (see `damping_matrix`)
    modal: ModalPart | None = None  #: damping in addition, of single modes (see `in_full_order`)


@dataclass(frozen=True)
class Resumption:
    """Checkpoints of a run."""

    folder: Path
    key: str  #: hash of the inputs of the run, C included; loads, damping and probes are added
    every: int  #: largest number of steps between two checkpoints


@dataclass(frozen=True, eq=False)
class FullRun:
    """The result of the full model."""

    response: NodeResponse  #: histories at the nodes
    energy: Energy  #: energies at each step

    def results(self, spectra: Spectra, highest: float) -> NodeResults:
        """Return the results at the nodes, valid up to `highest` [Hz], without an error band."""
        found = node_spectra(self.response, spectra)
        band = Band(np.zeros_like(found.psa), np.zeros(self.response.acceleration.shape[1:]))
        return NodeResults.of(self.response, found, highest, band)


def run_full(
    model: FullModel,
    loads: Loads,
    patterns: Array,
    probes: Displacements,
    resumption: Resumption,
    progress: Callable[[float], None] = lambda part: None,
) -> FullRun:
    """Integrate from rest over all steps of the loads: Newmark, average acceleration. Collective.

    An interrupted run is resumed (see `resumable_march`); the caller removes the checkpoints.

    Args:
        model: The building.
        loads: The loads.
        patterns: Their patterns, shape (n_local, n_patterns).
        probes: The recorded nodes; clamped nodes move with the ground.
        resumption: The checkpoints.
        progress: Called with the completed part of the work.

    Raises:
        SolutionError: The response is not finite.
        ImpactfemError: A checkpoint cannot be written.
    """
    free = np.flatnonzero(probes.rows >= 0)
    hashed: list[Any] = [(loads.time_step, *astuple(model.damping)), loads.amplitudes]
    hashed += [probes.rows, probes.motion.data]
    hashed += [] if model.modal is None else [model.modal.excess]
    digest = hashlib.sha256(b"".join(np.asarray(part).tobytes() for part in hashed)).hexdigest()
    store = Checkpoints(model.building.comm, resumption.folder, f"{resumption.key}, {digest}")
    with Newmark(
        model.K,
        model.building.mass,
        loads.time_step,
        patterns,
        damping=model.damping,
        C=model.C,
        modal=model.modal,
    ) as system:
        whole = resumable_march(
            system,
            loads.amplitudes,
            probes.rows[free],
            RECORDED,
            store,
            resumption.every,
            progress=progress,
        )
    shape = (len(loads.ground), -1, 3)
    motion = {
        name: (probes.motion[:, free] @ values.T).T.reshape(shape)
        for name, values in whole.motion.items()
    }
    return FullRun(
        response=NodeResponse(
            time_step=loads.time_step,
            displacement=motion["displacement"],
            acceleration=motion["acceleration"] + loads.ground[:, None, :],
        ),
        energy=whole.energy,
    )


def run_prepared(
    transient: Transient, prepared: Prepared, folder: Path, steps: Steps, key: str
) -> FullRun:
    """Run a case in full order, with its base plates tied as in the reduced model. Collective.

    `prepared` is the same on all ranks; `folder` is that of the run, `key` the hash of the inputs.
    SolutionError: the response is not finite. ImpactfemError: a checkpoint cannot be written.
    """
    loads, mesh = prepared.loads, prepared.parts.mesh
    links = [plate.link for plate in prepared.base_plates]
    comm = communicator()
    with steps.step("matrices"):
        building = assemble_building(comm, prepared.parts)
        model, T = linked(building, links, mesh.nodes)
        patterns = carried(T, loads.patterns(building, mesh))
        for matrix in (building.fixed, building.storeys, building.mass):
            matrix.destroy()
        K, C, dampings = model.take_stiffness(prepared.storey_factor), None, prepared.parts.dampings
        if dampings is not None:
            # Difference between the damping of the parts and that of the building.
            every = (*dampings.shells, *dampings.beams)
            count = sum(one is not None for one in every)
            LOGGER.debug("transient: %d of %d parts have a damping of their own", count, len(every))
            C = damping_matrix(
                comm, prepared.parts, dampings, prepared.storey_factor, prepared.damping.rayleigh
            ).ptap(T)
        T.destroy()
    with steps.step("time steps"):
        base, modal = in_full_order(prepared.damping, K, model.mass, transient.maximum_frequency)
        every_steps = max(1, round(transient.checkpoint_every / loads.time_step))
        return run_full(
            FullModel(model, K, base, C, modal),
            loads,
            patterns,
            Displacements(model, prepared.probe_nodes, links, mesh.nodes),
            Resumption(folder / CHECKPOINTS, key, every_steps),
            lambda part: steps.within("time steps", part),
        )
