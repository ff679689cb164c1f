"""The stage `transient`: ground motion and impacts on the 3D building."""

import hashlib
from collections.abc import Callable
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.building.links import Displacements, carried, linked
from impactfem.building.model import BuildingModel, assemble_building, damping_matrix
from impactfem.case import Case
from impactfem.coupling.force_history import around_peak
from impactfem.dynamics.checkpoints import Checkpoints, resumable_march
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.energy import Energy
from impactfem.dynamics.newmark import ModalPart, Newmark, in_full_order
from impactfem.reduction.loads import Loads
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.reduction.response import (
    Analysis,
    NodeResponse,
    modal_histories,
    node_response,
    node_spectra,
    response_band,
)
from impactfem.spectra import ResponseSpectra
from impactfem.stages.transient.maps import floor_maps
from impactfem.stages.transient.prepared import Prepared, transient_of
from impactfem.system.arrays import Array, Index
from impactfem.system.log import LOGGER, Steps
from impactfem.system.parallel import communicator

RECORDED = ("displacement", "acceleration")
CHECKPOINTS = "transient_checkpoints"
TURNING = ("centre", "point")
"""Kinds of probes whose rotations are recorded, too."""


@dataclass(frozen=True, eq=False)
class FullRun:
    """The result of the full model."""

    response: NodeResponse  #: histories at the nodes
    energy: Energy  #: energies at each step


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

    A run that was interrupted goes on as of `resumable_march`; `remove_checkpoints` is the
    caller's.

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
            progress=progress,
        )
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
    )


@dataclass(frozen=True, eq=False)
class Rotations:
    """Rotations of the nodes of some probes, n of them."""

    probes: Index  #: their places among all probes, shape (n,)
    response: NodeResponse  #: histories [rad, rad/s2]
    spectra: ResponseSpectra
    #: Half width of the error band of each PSa, shape (n_dampings, n, 3, n_frequencies) [rad/s2].
    band: Array
    pfa_band: Array  #: of each peak acceleration, shape (n, 3) [rad/s2]


@dataclass(frozen=True, eq=False)
class TransientStudy:
    """What the stage computed; on rank 0."""

    case: Case
    prepared: Prepared  #: building, probes, loads and damping
    response: NodeResponse  #: histories at the probes by the solver that was requested
    spectra: ResponseSpectra  #: their floor response spectra
    #: Half width of the error band of each PSa, shape (n_dampings, n_probes, 3, n_frequencies)
    #: [m/s2]; zero for the full model.
    band: Array
    pfa_band: Array  #: of each peak acceleration, shape (n_probes, 3) [m/s2]
    basis: ReducedBasis | None  #: the reduced basis; None for the full model alone
    rotations: Rotations | None  #: by the reduced model; None for the full model alone
    maps: xr.Dataset | None  #: fields over the floors, for `transient_maps.nc`; None without
    full: FullRun | None  #: the run in full order; None for the reduced model alone
    #: With both solvers the largest relative difference of a spectrum by the reduced model from the
    #: full one's, both at the same step; None otherwise.
    full_error: float | None


def by_probe(values: Array, probes: int) -> Array:
    """Spectra of records as (n_dampings, n_probes, 3, n_frequencies)."""
    return values.reshape(values.shape[0], probes, 3, -1)


def main_impact(loads: Loads, *, external: bool = False) -> tuple[float, float] | None:
    """Start and end of the impact with the largest force on a side [s]; None without one.

    With `external`, of the largest of all forces on a side, those of the case among them.
    """
    forces = loads.resultants[0] if external else loads.impact_force
    if not forces.any():
        return None
    first, behind = around_peak(forces[:, int(np.argmax(np.abs(forces).max(axis=0)))])
    return first * loads.time_step, (behind - 1) * loads.time_step


def run_transient(
    case: Case,
    prepared: Prepared,
    folder: Path,
    steps: Steps,
    *,
    basis: ReducedBasis | None,
    key: str,
) -> TransientStudy | None:
    """Run the stage; the results on rank 0, None on the others. Collective.

    `prepared` is the same on all ranks, the basis on rank 0; None for the full model alone. The
    key is the hash of what the stage depends on; checkpoints are kept in the folder.

    Raises:
        SolutionError: The response is not finite.
        InputError: A floor is hit that the building was not reduced for.
    """
    transient, loads, damping = transient_of(case), prepared.loads, prepared.damping
    run = None
    if transient.solver != "reduced":
        run = _full(case, prepared, folder, steps, key)
    if communicator().rank != 0:
        return None
    nodes = np.array([probe.node for probe in prepared.probes])
    wanted = bool(transient.fields) or transient.snapshots
    maps = full_error = rotations = None
    with steps.step("spectra"):
        if basis is not None:
            history = modal_histories(basis, loads, damping)
            kinds = np.array([probe.kind in TURNING for probe in prepared.probes])
            known = kinds & np.isin(nodes, basis.certified)
            turning = np.flatnonzero(known)
            if lacking := [prepared.probes[k].name for k in np.flatnonzero(kinds & ~known)]:
                LOGGER.warning(
                    "warning: transient: no rotations of %s: the reduced building of an earlier run"
                    " serves, which was made without them; run with --fresh for these",
                    ", ".join(lacking),
                )
            found = []
            for at, turned in ((nodes, False), (nodes[turning], True)):
                of_nodes = node_response(basis, history, loads, at, rotations=turned)
                of_oscillators = node_spectra(of_nodes, case.spectra)
                error = response_band(
                    Analysis(basis, loads, damping),
                    at,
                    of_nodes,
                    of_oscillators.psa,
                    case.spectra,
                    kind=transient.band,
                    rotations=turned,
                )
                band = by_probe(error.psa, len(at))
                found.append((of_nodes, of_oscillators, band, error.acceleration))
            response, spectra, band, pfa_band = found[0]
            rotations = Rotations(turning, *found[1])
            if run is not None:
                # The largest relative difference, both solvers with Newmark at the same step.
                newmark = modal_histories(basis, loads, damping, scheme="newmark")
                same = node_spectra(node_response(basis, newmark, loads, nodes), case.spectra)
                truth = node_spectra(run.response, case.spectra)
                meant = same.frequency <= transient.maximum_frequency
                moved = truth.zpa > 1e-3 * truth.zpa.max()
                ratio = same.psa[:, moved][..., meant] / truth.psa[:, moved][..., meant]
                full_error = float(np.abs(ratio - 1.0).max())
        elif run is not None:
            response, spectra = run.response, node_spectra(run.response, case.spectra)
            band = np.zeros_like(by_probe(spectra.psa, len(nodes)))
            pfa_band = np.zeros((len(nodes), 3))
        else:
            raise ValueError("neither a basis nor a full run")
    if basis is None and wanted:
        LOGGER.info("transient: the full model records its probes only; no maps and no waves")
    if basis is not None and wanted:
        with steps.step("maps"):
            maps = floor_maps(
                prepared.parts,
                basis,
                history,
                loads,
                case.spectra,
                main_impact=main_impact(loads) if transient.snapshots else None,
                direction="xyz".index(case.shown_direction),
                floor=case.wave_floor,
                progress=lambda part: steps.within("maps", part),
            )
    return TransientStudy(
        case, prepared, response, spectra, band, pfa_band, basis, rotations, maps, run, full_error
    )


def _full(case: Case, prepared: Prepared, folder: Path, steps: Steps, key: str) -> FullRun:
    """The run in full order, with the base plates tied as in the reduced building. Collective."""
    transient, loads, mesh = transient_of(case), prepared.loads, prepared.parts.mesh
    links = [plate.link for plate in prepared.base_plates]
    nodes, comm = np.array([probe.node for probe in prepared.probes]), communicator()
    with steps.step("matrices"):
        building = assemble_building(comm, prepared.parts)
        model, T = linked(building, links, mesh.nodes)
        patterns = carried(T, loads.patterns(building, mesh))
        for matrix in (building.fixed, building.storeys, building.mass):
            matrix.destroy()
        K, C, dampings = model.take_stiffness(prepared.storey_factor), None, prepared.parts.dampings
        if dampings is not None:
            # What the parts' own dampings add to that of the building.
            every = (*dampings.shells, *dampings.beams)
            own = sum(one is not None for one in every)
            LOGGER.debug("transient: %d of %d parts have a damping of their own", own, len(every))
            C = damping_matrix(
                comm, prepared.parts, dampings, prepared.storey_factor, prepared.damping.rayleigh
            ).ptap(T)
        T.destroy()
    with steps.step("time steps"):
        highest = transient.maximum_frequency
        base, modal = in_full_order(prepared.damping, K, model.mass, highest)
        return run_full(
            model,
            K,
            loads,
            patterns,
            base,
            Displacements(model, nodes, links, mesh.nodes),
            C=C,
            modal=modal,
            checkpoints=folder / CHECKPOINTS,
            key=key,
            every=max(1, round(transient.checkpoint_every / loads.time_step)),
            progress=lambda part: steps.within("time steps", part),
        )
