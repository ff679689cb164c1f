"""The reduced 3D model under the loads: its response at nodes, and its errors."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from impactfem.case import Spectra
from impactfem.dynamics.damping import DampingLaw
from impactfem.reduction.loads import Loads
from impactfem.reduction.modal_response import ModalHistory
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.reduction.response import (
    LARGER,
    Analysis,
    NodeResponse,
    modal_histories,
    node_response,
    node_spectra,
    response_band,
)
from impactfem.spectra import ResponseSpectra
from impactfem.spectra.resolved import refinement_limit
from impactfem.stages.transient.node_results import MOVED, NodeResults
from impactfem.system.arrays import Array, Index


@dataclass(frozen=True, eq=False)
class ReducedRun:
    """The response of the reduced model, integrated exactly."""

    basis: ReducedBasis
    loads: Loads
    damping: DampingLaw
    spectra: Spectra  #: which spectra the case requests
    highest: float  #: frequency up to which the model is valid [Hz]
    band: str = LARGER  #: method of the error estimate (`response_band`)

    @cached_property
    def history(self) -> ModalHistory:
        """Modal coordinates of the finest model."""
        return modal_histories(self.basis, self.loads, self.damping)

    def at(self, nodes: Index, *, rotations: bool = False) -> NodeResults:
        """Return the results at nodes of the basis, shape (n,), or those of their rotations."""
        response = node_response(self.basis, self.history, self.loads, nodes, rotations=rotations)
        spectra = node_spectra(response, self.spectra)
        band = response_band(
            Analysis(self.basis, self.loads, self.damping),
            nodes,
            response,
            spectra.psa,
            self.spectra,
            kind=self.band,
            rotations=rotations,
        )
        return NodeResults.of(response, spectra, self.highest, band)

    def without_impact(self) -> "ReducedRun":
        """Return the run under the same loads without contact forces."""
        return replace(self, loads=self.loads.without_impacts())

    def spectra_at(self, nodes: Index) -> tuple[NodeResponse, ResponseSpectra]:
        """Return histories and spectra at nodes, without error bands."""
        response = node_response(self.basis, self.history, self.loads, nodes)
        return response, node_spectra(response, self.spectra)

    def refinement_limit(self, other: Loads, nodes: Index, psa: Array) -> float:
        """Return the limit of the resolved band by loads at another step, from spectra at nodes.

        `psa` is that of the loads, shape (n_dampings, 3 n_nodes, n_frequencies) [m/s2].
        """
        _, found = replace(self, loads=other).spectra_at(nodes)
        return refinement_limit(
            found.frequency, psa, found.psa, other.time_step / self.loads.time_step
        )

    def largest_error(self, full: NodeResponse, nodes: Index) -> float:
        """Return the largest relative difference of a spectrum from the full model [-].

        The full model is integrated by Newmark; so is the reduced one here, with the same step.
        """
        newmark = modal_histories(self.basis, self.loads, self.damping, scheme="newmark")
        response = node_response(self.basis, newmark, self.loads, nodes)
        same, truth = (node_spectra(one, self.spectra) for one in (response, full))
        valid = same.frequency <= self.highest
        moved = truth.zpa > MOVED * truth.zpa.max()
        ratio = same.psa[:, moved][..., valid] / truth.psa[:, moved][..., valid]
        return float(np.abs(ratio - 1.0).max())
