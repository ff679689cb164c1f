"""The stage `transient`: ground motion and impacts on the 3D building."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.building.bending_wave import mesh_limit
from impactfem.coupling.force_history import around_peak
from impactfem.reduction.loads import Loads
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.spectra.resolved import ResolvedBand, agreement, sampling_limit, step_limit
from impactfem.stages.transient.full_run import FullRun, run_prepared
from impactfem.stages.transient.maps import floor_maps
from impactfem.stages.transient.node_results import NodeResults, WithoutImpact
from impactfem.stages.transient.prepared import Prepared
from impactfem.stages.transient.reduced_run import ReducedRun
from impactfem.system.arrays import Index
from impactfem.system.log import LOGGER, Steps
from impactfem.system.parallel import communicator

TURNING = ("centre", "point")
"""Kinds of probes whose rotations are recorded, too."""


@dataclass(frozen=True, eq=False)
class TransientStudy:
    """The results of the stage; on rank 0."""

    prepared: Prepared  #: building, probes, loads and damping
    probes: NodeResults  #: response at the probes by the requested solver
    basis: ReducedBasis | None = None  #: None, as the next three, for the full model alone
    turning: Index | None = None  #: probes with recorded rotations, indices
    rotations: NodeResults | None = None  #: their rotations
    maps: xr.Dataset | None = None  #: fields over the floors, for `transient_maps.nc`; or None
    full: FullRun | None = None  #: the run in full order; None for the reduced model alone
    #: With both solvers the largest relative difference of a spectrum by the reduced model from the
    #: full one, both at the same step.
    full_error: float | None = None
    #: Limit of the resolved band by forces with another time step [Hz]; infinite where not known.
    refinement: float = math.inf
    free: WithoutImpact | None = None  #: without impact; None for the full model alone

    def band(self, contact: float) -> ResolvedBand:
        """Return the resolved band at the probes; the limit of the contact law is given [Hz]."""
        spectra = self.probes.spectra
        highest = self.prepared.building.transient.maximum_frequency
        basis = agreement(
            spectra.frequency, self.probes.psa, self.probes.psa + self.probes.psa_band
        )
        return ResolvedBand(
            time_step=step_limit(self.probes.time_step),
            oscillators=sampling_limit(spectra),
            mesh=mesh_limit(self.prepared.parts),
            basis=min(highest, basis),
            contact=contact,
            refinement=self.refinement,
        )


def main_impact(loads: Loads, *, external: bool = False) -> tuple[float, float] | None:
    """Return start and end of the impact with the largest force on a side [s]; None without one.

    With `external`, of the largest of all forces on a side, those of the case included.
    """
    forces = loads.resultants[0] if external else loads.impact_force
    if not forces.any():
        return None
    first, behind = around_peak(forces[:, int(np.argmax(np.abs(forces).max(axis=0)))])
    return first * loads.time_step, (behind - 1) * loads.time_step


def run_transient(
    prepared: Prepared,
    folder: Path,
    steps: Steps,
    *,
    basis: ReducedBasis | None,
    key: str,
) -> TransientStudy | None:
    """Run the stage; the results on rank 0, None on the others. Collective.

    `prepared` is the same on all ranks; the basis is on rank 0, None for the full model alone;
    `folder` is that of the run, `key` the hash of the inputs of the stage.

    Raises:
        SolutionError: The response is not finite.
        InputError: A load acts on a floor without a pattern in the basis.
    """
    building = prepared.building
    case, transient = building.case, building.transient
    full = None
    if transient.solver != "reduced":
        full = run_prepared(transient, prepared, folder, steps, key)
    if communicator().rank != 0:
        return None
    fields = bool(transient.fields) or transient.snapshots
    highest = transient.maximum_frequency
    if basis is None:
        if full is None:
            raise ValueError("neither a basis nor a full run")
        if fields:
            LOGGER.info("transient: the full model records its probes only; no maps and no waves")
        with steps.step("spectra"):
            probes = full.results(case.spectra, highest)
        return TransientStudy(prepared, probes, full=full)
    run = ReducedRun(basis, prepared.loads, prepared.damping, case.spectra, highest, transient.band)
    nodes = prepared.probe_nodes
    with steps.step("spectra"):
        turning = _turning(prepared, basis)
        probes, rotations = run.at(nodes), run.at(nodes[turning], rotations=True)
        error = None if full is None else run.largest_error(full.response, nodes)
        refinement, other = math.inf, prepared.other_loads
        if other is not None:
            refinement = run.refinement_limit(other, nodes, probes.spectra.psa)
        quiet = run.without_impact()
        free = WithoutImpact.of(*quiet.spectra_at(nodes))
    maps = None
    if fields:
        with steps.step("maps"):
            maps = floor_maps(
                prepared.parts,
                run,
                main_impact=main_impact(prepared.loads) if transient.snapshots else None,
                direction="xyz".index(case.shown_direction),
                floor=building.wave_floor,
                progress=lambda part: steps.within("maps", part),
            )
    return TransientStudy(
        prepared, probes, basis, turning, rotations, maps, full, error, refinement, free
    )


def _turning(prepared: Prepared, basis: ReducedBasis) -> Index:
    """Return the indices of the probes with rotations; warn of those that the basis lacks."""
    requested = np.array([probe.kind in TURNING for probe in prepared.probes])
    certified = np.isin(prepared.probe_nodes, basis.certified)
    if lacking := [prepared.probes[k].name for k in np.flatnonzero(requested & ~certified)]:
        LOGGER.warning(
            "warning: transient: no rotations of %s: the reduced model of an earlier run is used, "
            "which has no rotations at these probes; run with --fresh to compute them",
            ", ".join(lacking),
        )
    return np.flatnonzero(requested & certified)
