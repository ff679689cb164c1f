"""The response at nodes from a reduced model: histories and floor response spectra, with a band."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Spectra
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.loads import Loads
from impactfem.reduction.modal_response import ModalHistory, modal_response
from impactfem.reduction.reduced import ReducedModel
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.spectra import ResponseSpectra, response_spectra
from impactfem.system.parallel import threads

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class NodeResponse:
    """Histories at nodes."""

    time_step: float  #: Δt [s].
    displacement: Array  #: Relative to the ground, shape (n_t, n_nodes, 3) [m].
    acceleration: Array  #: Absolute, same shape [m/s2].


def modal_histories(
    basis: ReducedBasis,
    loads: Loads,
    damping: Rayleigh,
    *,
    scheme: str = "exact",
    model: ReducedModel | None = None,
) -> ModalHistory:
    """Modal coordinates under the loads.

    Args:
        basis: The basis; it has the patterns of the loads.
        loads: The loads.
        damping: The damping.
        scheme: "exact" or "newmark".
        model: One of the models of the basis; the finest when None.

    Raises:
        KeyError: The basis has no pattern of one of the loads.
    """
    amplitudes = np.zeros((len(loads.ground), len(basis.loads)))
    for name, history in zip(loads.names, loads.amplitudes.T, strict=True):
        if name not in basis.loads:
            raise KeyError(f"the reduced basis has no load {name}")
        amplitudes[:, basis.loads.index(name)] = history
    return modal_response(model or basis.model, amplitudes, loads.time_step, damping, scheme=scheme)


def node_response(
    basis: ReducedBasis,
    history: ModalHistory,
    loads: Loads,
    nodes: Index,
    *,
    model: ReducedModel | None = None,
) -> NodeResponse:
    """Histories at nodes.

    Args:
        basis: The basis.
        history: Modal coordinates of its model, or of a nested one.
        loads: The loads, for the ground's motion.
        nodes: Nodes that the basis was made for, shape (n,).
        model: The model that the history is of; the finest when None.
    """
    shapes = basis.of(model or basis.model, nodes)
    flat = shapes.reshape(-1, shapes.shape[2])
    shape = (-1, len(nodes), 3)
    return NodeResponse(
        time_step=loads.time_step,
        displacement=(flat @ history.displacement).T.reshape(shape),
        acceleration=(flat @ history.acceleration).T.reshape(shape) + loads.ground[:, None, :],
    )


def node_spectra(response: NodeResponse, spectra: Spectra) -> ResponseSpectra:
    """Spectra of all nodes and directions; records are ordered node by node, x y z each."""
    n_t = len(response.acceleration)
    return record_spectra(response.acceleration.reshape(n_t, -1).T, response.time_step, spectra)


def record_spectra(records: Array, time_step: float, spectra: Spectra) -> ResponseSpectra:
    """Spectra of records, sampled as a case asks.

    Args:
        records: Absolute accelerations in rows, shape (n_records, n_t) [m/s2].
        time_step: Of the records [s].
        spectra: The case's floor spectra.
    """
    return response_spectra(
        records,
        time_step,
        spectra.frequency_values,
        spectra.damping,
        points_per_cycle=spectra.points_per_cycle,
        method=spectra.method,
        threads=threads(),
        absolute=False,
    )
