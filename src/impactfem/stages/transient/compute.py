"""The stage `transient`: ground motion and impacts on the 3D building."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.building.links import Displacements, carried, linked
from impactfem.building.model import assemble_building, damping_matrix
from impactfem.case import Case
from impactfem.dynamics.newmark import in_full_order
from impactfem.reduction.loads import Loads
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.reduction.response import (
    NodeResponse,
    modal_histories,
    node_response,
    node_spectra,
    response_band,
)
from impactfem.spectra import ResponseSpectra
from impactfem.stages.transient.full_run import FullRun, run_full
from impactfem.stages.transient.maps import floor_maps
from impactfem.stages.transient.prepared import Prepared, transient_of
from impactfem.system.log import LOGGER

Array = NDArray[np.float64]
Step = Callable[[str], AbstractContextManager[None]]
Progress = Callable[[str, float], None]

CHECKPOINTS = "transient_checkpoints"
QUIET = 0.01
"""Part of the largest force below which an impact has not begun, or has ended."""


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
    maps: xr.Dataset | None  #: fields over the floors, for `transient_maps.nc`; None without
    full: FullRun | None  #: the run in full order; None for the reduced model alone
    #: With both solvers the largest relative difference of a spectrum by the reduced model from the
    #: full one's, both at the same step; None otherwise.
    full_error: float | None


def by_probe(values: Array, probes: int) -> Array:
    """Spectra of records as (n_dampings, n_probes, 3, n_frequencies)."""
    return values.reshape(values.shape[0], probes, 3, -1)


def main_impact(loads: Loads) -> tuple[float, float] | None:
    """Start and end of the impact with the largest force on a side [s]; None without one."""
    if not loads.edges:
        return None
    forces, _ = loads.resultants
    force = forces[:, int(np.argmax(np.abs(forces).max(axis=0)))]
    peak = int(np.argmax(np.abs(force)))
    apart = np.flatnonzero(force / force[peak] <= QUIET)
    start = int(apart[apart < peak].max(initial=-1)) + 1
    end = int(apart[apart > peak].min(initial=len(force))) - 1
    return start * loads.time_step, end * loads.time_step


def run_transient(
    case: Case,
    prepared: Prepared,
    folder: Path,
    comm: Any,
    step: Step,
    *,
    basis: ReducedBasis | None,
    key: str,
    within: Progress = lambda name, part: None,
) -> TransientStudy | None:
    """Run the stage; the results on rank 0, None on the others. Collective.

    Args:
        case: The case.
        prepared: What `prepare` gave, the same on all ranks.
        folder: Where checkpoints are kept.
        comm: Communicator of the matrices.
        step: Called with the name of each step, which runs inside its context.
        basis: The reduced basis on rank 0; None for the full model alone.
        key: Hash of what the stage depends on.
        within: Called with the name of a step and the part of it that is done.

    Raises:
        SolutionError: The response is not finite.
        InputError: A floor is hit that the building was not reduced for.
    """
    transient, loads, damping = transient_of(case), prepared.loads, prepared.damping
    run = None
    if transient.solver != "reduced":
        run = _full(case, prepared, folder, comm, step, key, within)
    if comm.rank != 0:
        return None
    nodes = np.array([probe.node for probe in prepared.probes])
    wanted = bool(transient.fields) or transient.snapshots
    maps = full_error = None
    with step("spectra"):
        if basis is not None:
            history = modal_histories(basis, loads, damping)
            response = node_response(basis, history, loads, nodes)
            spectra = node_spectra(response, case.spectra)
            error = response_band(
                basis,
                loads,
                damping,
                nodes,
                response,
                spectra.psa,
                case.spectra,
                kind=transient.band,
            )
            band, pfa_band = by_probe(error.psa, len(nodes)), error.acceleration
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
        with step("maps"):
            maps = floor_maps(
                prepared.parts,
                basis,
                history,
                loads,
                case.spectra,
                main_impact=main_impact(loads) if transient.snapshots else None,
                floor=prepared.wave_floor,
                progress=lambda part: within("maps", part),
            )
    return TransientStudy(
        case, prepared, response, spectra, band, pfa_band, basis, maps, run, full_error
    )


def _full(
    case: Case,
    prepared: Prepared,
    folder: Path,
    comm: Any,
    step: Step,
    key: str,
    within: Progress,
) -> FullRun:
    """The run in full order, with the base plates tied as in the reduced building. Collective."""
    transient, loads, mesh = transient_of(case), prepared.loads, prepared.parts.mesh
    links = [plate.link for plate in prepared.base_plates]
    nodes = np.array([probe.node for probe in prepared.probes])
    with step("matrices"):
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
    with step("time steps"):
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
            progress=lambda part: within("time steps", part),
        )
