"""The stage `transient`: ground motion and impacts on the 3D building."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.model import BuildingModel, assemble_building, damping_matrix
from impactfem.building.parts import BuildingParts
from impactfem.case import Case
from impactfem.case.transient import Transient
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.band import LARGER, response_band
from impactfem.reduction.loads import Loads
from impactfem.reduction.modal_response import ModalHistory
from impactfem.reduction.probes import Probe
from impactfem.reduction.reduced_basis import ReducedBasis, build_basis
from impactfem.reduction.response import (
    NodeResponse,
    modal_histories,
    node_response,
    node_spectra,
)
from impactfem.spectra import ResponseSpectra
from impactfem.stages.transient.full_run import FullRun, run_full
from impactfem.stages.transient.maps import FloorMaps, floor_maps, looked_at
from impactfem.stages.transient.motion_grid import motion_grid
from impactfem.stages.transient.prepared import Prepared, transient_of
from impactfem.system.log import LOGGER
from impactfem.system.parallel import on_root

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Step = Callable[[str], AbstractContextManager[None]]
Progress = Callable[[str, float], None]

BASIS = "transient_basis.npz"
CHECKPOINTS = "transient_checkpoints"
QUIET = 0.01
"""Part of the largest force below which an impact has not begun, or has ended."""


@dataclass(frozen=True, eq=False)
class TransientStudy:
    """What the stage computed; on rank 0.

    Args:
        case: The case.
        parts: The building.
        probes: Where it was looked.
        loads: The loads.
        response: Histories at the probes by the solver that was asked for.
        spectra: Their floor response spectra.
        band: Half width of the error band of each PSa, shape (n_dampings, n_probes, 3,
            n_frequencies) [m/s2]; zero for the full model.
        pfa_band: Of each peak acceleration, shape (n_probes, 3) [m/s2].
        basis: The reduced basis; None for the full model alone.
        maps: Fields over the floors; None without.
        full: The run in full order; None for the reduced model alone.
        full_error: With both solvers the largest relative difference of a spectrum by the reduced
            model from the full one's, both at the same step; None otherwise.
    """

    case: Case
    parts: BuildingParts
    probes: tuple[Probe, ...]
    loads: Loads
    response: NodeResponse
    spectra: ResponseSpectra
    band: Array
    pfa_band: Array
    basis: ReducedBasis | None
    maps: FloorMaps | None
    full: FullRun | None
    full_error: float | None

    @property
    def psa(self) -> Array:
        """Pseudo-acceleration, shape (n_dampings, n_probes, 3, n_frequencies) [m/s2]."""
        return by_probe(self.spectra.psa, len(self.probes))

    @property
    def pfa(self) -> Array:
        """Peak acceleration, shape (n_probes, 3) [m/s2]."""
        largest: Array = np.abs(self.response.acceleration).max(axis=0)
        return largest

    @property
    def main_impact(self) -> tuple[float, float] | None:
        """Start and end of the impact with the largest force [s]; None without an impact."""
        return main_impact(self.loads)


def by_probe(values: Array, probes: int) -> Array:
    """Spectra of records as (n_dampings, n_probes, 3, n_frequencies)."""
    return values.reshape(values.shape[0], probes, 3, -1)


def main_impact(loads: Loads) -> tuple[float, float] | None:
    """Start and end of the impact with the largest force on an edge [s]; None without one."""
    if not loads.edges:
        return None
    force = loads.force[:, int(np.argmax(np.abs(loads.force).max(axis=0)))]
    peak = int(np.argmax(np.abs(force)))
    touching = force / force[peak] > QUIET
    start = peak
    while start > 0 and touching[start - 1]:
        start -= 1
    end = peak
    while end < len(force) - 1 and touching[end + 1]:
        end += 1
    return start * loads.time_step, end * loads.time_step


def run_transient(
    case: Case,
    prepared: Prepared,
    folder: Path,
    comm: Any,
    step: Step,
    *,
    basis_key: str,
    key: str,
    within: Progress = lambda name, part: None,
) -> TransientStudy | None:
    """Run the stage. Collective.

    Args:
        case: The case.
        prepared: What `prepare` gave, the same on all ranks.
        folder: Where the basis and checkpoints are kept.
        comm: Communicator of the matrices.
        step: Called with the name of each step ("matrices", "basis", "time steps", "spectra",
            "maps"), which runs inside its context.
        basis_key: Hash of what the reduced basis depends on.
        key: Hash of what the stage depends on.
        within: Called with the name of a step and the part of it that is done.

    Returns:
        The results on rank 0, None on the others.

    Raises:
        SolutionError: The basis does not reach its tolerance, or the response is not finite.
    """
    transient = transient_of(case)
    reduced, full = transient.solver != "full", transient.solver != "reduced"
    loads = prepared.loads
    nodes = np.array([probe.node for probe in prepared.probes])
    # On rank 0 alone: it is large, and the others have no use for it.
    basis = None
    if reduced and comm.rank == 0:
        basis = _stored_basis(folder / BASIS, basis_key, prepared, transient)
    build = comm.bcast(reduced and basis is None)
    run = None
    if full or build:
        with step("matrices"):
            model = assemble_building(comm, prepared.parts)
            K = model.take_stiffness(prepared.storey_factor)
            patterns = loads.patterns(model, prepared.parts.mesh, transient.eccentricity)
        if build:
            with step("basis"):
                basis = _build(transient, prepared, model, K, patterns, nodes, within)
                on_root(lambda: _write(basis, folder / BASIS, basis_key))
        if full:
            with step("time steps"):
                run = run_full(
                    model,
                    K,
                    loads,
                    patterns,
                    prepared.damping,
                    nodes,
                    C=_damping_by_part(prepared, comm),
                    checkpoints=folder / CHECKPOINTS,
                    key=key,
                    every=max(1, round(transient.checkpoint_every / loads.time_step)),
                    progress=lambda part: within("time steps", part),
                )
    if comm.rank != 0:
        return None
    return _results(case, prepared, basis, run, nodes, step, within)


def _damping_by_part(prepared: Prepared, comm: Any) -> Any | None:
    """What the parts' own dampings add to that of the building. Collective."""
    dampings = prepared.parts.dampings
    if dampings is None:
        return None
    every = (*dampings.shells, *dampings.beams)
    own = sum(one is not None for one in every)
    LOGGER.info("transient: %d of %d parts have a damping of their own", own, len(every))
    return damping_matrix(comm, prepared.parts, dampings, prepared.storey_factor, prepared.damping)


def _stored_basis(
    path: Path, key: str, prepared: Prepared, transient: Transient
) -> ReducedBasis | None:
    """The basis of a run before, where it serves loads, probes and damping of this one."""
    found = ReducedBasis.read(path, key)
    if found is None:
        return None
    probes = np.array([probe.node for probe in prepared.probes])
    nodes = _kept(prepared, transient, probes)
    lacking = set(prepared.loads.names) - set(found.loads)
    if lacking:
        why = f"without {', '.join(sorted(lacking))}"
    elif not np.isin(probes, found.nodes).all():
        why = "without some of the probes"
    elif not np.isin(nodes, found.nodes).all():
        why = "without some of the nodes that are exported"
    elif transient.band == LARGER and not found.larger:
        why = "without the larger ones that tell its error band"
    else:
        error = found.error(probes, prepared.lightest, transient.maximum_frequency)
        if error <= transient.tolerance:
            LOGGER.info("transient: the reduced basis of %s is used again", path.name)
            return replace(found, difference=error)
        why = f"with an error of {error:.2%} for this damping"
    LOGGER.info("transient: the reduced basis of %s is %s, and made again", path.name, why)
    return None


def _kept(prepared: Prepared, transient: Transient, probes: Index) -> Index:
    """All nodes that the basis must keep."""
    mesh = prepared.parts.mesh
    nodes = looked_at(mesh, probes, prepared.wave_floor)
    if transient.export:
        nodes = np.union1d(nodes, motion_grid(mesh, transient.export_nodes).nodes)
    return nodes


def _write(basis: ReducedBasis | None, path: Path, key: str) -> None:
    if basis is not None:
        basis.write(path, key)


def _build(
    transient: Transient,
    prepared: Prepared,
    model: BuildingModel,
    K: Any,
    patterns: Array,
    nodes: Index,
    within: Progress,
) -> ReducedBasis:
    basis = build_basis(
        model,
        K,
        patterns,
        prepared.loads.names,
        probes=nodes,
        nodes=_kept(prepared, transient, nodes),
        damping=prepared.lightest,
        maximum_frequency=transient.maximum_frequency,
        shift=transient.shift,
        tolerance=transient.tolerance,
        largest=transient.largest_basis,
        larger=transient.band == LARGER,
        spend=transient.solver == "reduced",
        progress=lambda part: within("basis", part),
    )
    LOGGER.info(
        "transient: reduced basis of %d vectors for %d loads; error of the transfer functions"
        " at most %.2g %% up to %g Hz, by nested bases; %.0f MB at %d nodes",
        len(basis.model.eigenvalue),
        len(basis.loads),
        100.0 * basis.difference,
        transient.maximum_frequency,
        1e-6 * basis.vectors.nbytes,
        len(basis.nodes),
    )
    return basis


def _results(
    case: Case,
    prepared: Prepared,
    basis: ReducedBasis | None,
    run: FullRun | None,
    nodes: Index,
    step: Step,
    within: Progress,
) -> TransientStudy:
    transient, loads, damping = transient_of(case), prepared.loads, prepared.damping
    history = maps = full_error = None
    with step("spectra"):
        if basis is None:
            seen = _seen_by_full(case, run, len(nodes))
        else:
            history = modal_histories(basis, loads, damping)
            seen = _seen_by_basis(case, prepared, basis, history, nodes)
            if run is not None:
                full_error = _against_full(case, basis, loads, damping, nodes, run)
    wanted = bool(transient.fields) or transient.snapshots
    if basis is None and wanted:
        LOGGER.info("transient: the full model records its probes only; no maps and no waves")
    if basis is not None and history is not None and wanted:
        with step("maps"):
            maps = _maps(case, prepared, basis, history, within)
    return TransientStudy(
        case=case,
        parts=prepared.parts,
        probes=prepared.probes,
        loads=loads,
        response=seen.response,
        spectra=seen.spectra,
        band=seen.band,
        pfa_band=seen.pfa_band,
        basis=basis,
        maps=maps,
        full=run,
        full_error=full_error,
    )


@dataclass(frozen=True, eq=False)
class _Seen:
    """What is seen at the probes; as in `TransientStudy`."""

    response: NodeResponse
    spectra: ResponseSpectra
    band: Array
    pfa_band: Array


def _seen_by_full(case: Case, run: FullRun | None, probes: int) -> _Seen:
    if run is None:
        raise ValueError("neither a basis nor a full run")
    spectra = node_spectra(run.response, case.spectra)
    band = np.zeros_like(by_probe(spectra.psa, probes))
    return _Seen(run.response, spectra, band, np.zeros((probes, 3)))


def _seen_by_basis(
    case: Case, prepared: Prepared, basis: ReducedBasis, history: ModalHistory, nodes: Index
) -> _Seen:
    loads = prepared.loads
    response = node_response(basis, history, loads, nodes)
    spectra = node_spectra(response, case.spectra)
    told = response_band(
        basis,
        loads,
        prepared.damping,
        nodes,
        response,
        spectra.psa,
        case.spectra,
        kind=transient_of(case).band,
    )
    return _Seen(response, spectra, by_probe(told.psa, len(nodes)), told.acceleration)


def _maps(
    case: Case,
    prepared: Prepared,
    basis: ReducedBasis,
    history: ModalHistory,
    within: Progress,
) -> FloorMaps:
    loads = prepared.loads
    return floor_maps(
        prepared.parts,
        basis,
        history,
        loads,
        case.spectra,
        main_impact=main_impact(loads) if transient_of(case).snapshots else None,
        floor=prepared.wave_floor,
        progress=lambda part: within("maps", part),
    )


def _against_full(
    case: Case,
    basis: ReducedBasis,
    loads: Loads,
    damping: Rayleigh,
    nodes: Index,
    run: FullRun,
) -> float:
    """Largest relative difference of the spectra, both solvers with Newmark at the same step."""
    transient = transient_of(case)
    history = modal_histories(basis, loads, damping, scheme="newmark")
    same = node_spectra(node_response(basis, history, loads, nodes), case.spectra)
    truth = node_spectra(run.response, case.spectra)
    known = same.frequency <= transient.maximum_frequency
    moved = truth.zpa > 1e-3 * truth.zpa.max()
    ratio = same.psa[:, moved][..., known] / truth.psa[:, moved][..., known]
    return float(np.abs(ratio - 1.0).max())
