"""The reduced model of a building and what of it is looked at: for any motion and damping."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from impactfem.building.mesh import DOFS
from impactfem.building.model import BuildingModel
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.error_band import (
    by_third_octave,
    nested_models,
    transfer_band,
    transfer_bound,
)
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.larger_models import larger_models
from impactfem.reduction.reduced import ReducedModel, Residual, residual_norms
from impactfem.system.errors import SolutionError
from impactfem.system.files import read_archive, write_archive
from impactfem.system.log import LOGGER
from impactfem.system.memory import give_back

Array = NDArray[np.float64]
Index = NDArray[np.int64]

AT_ONCE = 4
"""Block steps between two looks at the accuracy."""
LOWEST = 0.5
PER_OCTAVE = 12
"""Frequencies at which accuracy is looked at: from LOWEST [Hz] up, so many an octave."""


@dataclass(frozen=True, eq=False)
class ReducedBasis:
    """A reduced model, those nested in it and around it, and their shapes where one looks.

    Args:
        loads: Names of the load patterns, in the order of the models' loads.
        models: The reduced model, then those nested in it that tell how good it is.
        larger: Models that it is nested in, which tell the band of its error; none where none were
            asked for.
        nodes: Nodes that are looked at, ascending, shape (n,).
        vectors: V at their displacements, shape (n, 3, size of the largest model); zero at clamped
            nodes.
        difference: Estimated error of the transfer functions at the probes that it was made for,
            as of `error`.
        certified: Nodes for which the rigorous bound is known, ascending, shape (m,).
        norm: ‖l‖ of their displacements (see `error_band`), shape (m, 3).
        gram: Qᵀ (K + σ0 M) Q of the basis, shape (n_tail, n_tail).
    """

    loads: tuple[str, ...]
    models: tuple[ReducedModel, ...]
    larger: tuple[ReducedModel, ...]
    nodes: Index
    vectors: Array
    difference: float
    certified: Index
    norm: Array
    gram: Array

    @property
    def model(self) -> ReducedModel:
        """The reduced model itself."""
        return self.models[0]

    def of(self, model: ReducedModel, nodes: Index) -> Array:
        """Φ of one of the models at some of the nodes.

        Args:
            model: One of `models` or `larger`.
            nodes: Nodes among those that are looked at, shape (m,).

        Returns:
            Shape (m, 3, r).

        Raises:
            KeyError: The basis was not made for one of the nodes.
        """
        rows = self.rows(nodes)
        flat = rows.reshape(-1, rows.shape[2])
        return model.shapes(flat).reshape(len(rows), 3, len(model.eigenvalue))

    def rows(self, nodes: Index) -> Array:
        """V at some of the nodes, shape (m, 3, size of the largest model).

        Raises:
            KeyError: The basis was not made for one of the nodes.
        """
        at = np.searchsorted(self.nodes, nodes)
        if at.max(initial=-1) >= len(self.nodes) or np.any(self.nodes[at] != nodes):
            raise KeyError("a node that the basis was not made for")
        return self.vectors[at]

    def bound(self, nodes: Index, omega: Array, damping: Rayleigh) -> Array:
        """Rigorous bound on the error of displacements under exp(iωt) of each load.

        Args:
            nodes: Nodes, shape (n,).
            omega: ω, shape (n_freq,) [rad/s].
            damping: The damping.

        Returns:
            Shape (n_freq, n, 3, n_loads); infinite where nothing is known.
        """
        at = np.searchsorted(self.certified, nodes)
        known = np.isin(nodes, self.certified)
        norm = np.full((len(nodes), 3), math.inf)
        norm[known] = self.norm[at[known]]
        residual = residual_norms(self.gram, self.model, omega, damping)
        found = transfer_bound(self.model, norm.ravel(), residual, omega, damping)
        return found.reshape(len(omega), len(nodes), 3, -1)

    def error(self, probes: Index, damping: Rayleigh, maximum_frequency: float) -> float:
        """Largest estimated error of the accelerations at probes under any one of the loads.

        The error band of the transfer functions by nested models, over the largest acceleration of
        any probe under the same load within the same third of an octave.

        Args:
            probes: Nodes among those that are looked at.
            damping: The damping.
            maximum_frequency: Up to which they count [Hz].
        """
        rows = self.vectors[np.searchsorted(self.nodes, np.unique(probes))]
        return _difference(self.models, rows, _omega(maximum_frequency), damping)

    def write(self, path: Path, key: str) -> None:
        """Write it as NumPy's archive, in one piece.

        Raises:
            ImpactfemError: The file cannot be written.
        """
        content: dict[str, Any] = {
            "loads": np.array(self.loads),
            "nodes": self.nodes,
            "vectors": self.vectors,
            "difference": self.difference,
            "models": len(self.models),
            "larger": len(self.larger),
            "certified": self.certified,
            "norm": self.norm,
            "gram": self.gram,
        }
        for number, model in enumerate((*self.models, *self.larger)):
            for field in fields(ReducedModel):
                content[f"{field.name}_{number}"] = getattr(model, field.name)
        write_archive(path, key, content)

    @classmethod
    def read(cls, path: Path, key: str) -> ReducedBasis | None:
        """The basis of a file; None where there is none with this key, or it is damaged."""
        content = read_archive(path, key)
        if content is None:
            return None

        def model(number: int) -> ReducedModel:
            values = {f.name: content[f"{f.name}_{number}"] for f in fields(ReducedModel)}
            return ReducedModel(**values | {"shift": float(values["shift"])})

        count = int(content["models"])
        return cls(
            loads=tuple(str(name) for name in content["loads"]),
            models=tuple(model(number) for number in range(count)),
            larger=tuple(model(count + number) for number in range(int(content["larger"]))),
            nodes=content["nodes"],
            vectors=content["vectors"],
            difference=float(content["difference"]),
            certified=content["certified"],
            norm=content["norm"],
            gram=content["gram"],
        )


def build_basis(
    model: BuildingModel,
    K: Any,
    patterns: Array,
    loads: tuple[str, ...],
    *,
    probes: Index,
    nodes: Index,
    damping: Rayleigh,
    maximum_frequency: float,
    shift: float,
    tolerance: float,
    largest: int,
    larger: bool = False,
    spend: bool = False,
    progress: Callable[[float], None] = lambda part: None,
) -> ReducedBasis:
    """Grow a Krylov basis until nested models agree on the probes' accelerations. Collective.

    Args:
        model: The building.
        K: Its stiffness.
        patterns: Load patterns at this rank's rows, shape (n_local, n_patterns).
        loads: Their names.
        probes: Nodes whose transfer functions must be accurate.
        nodes: All nodes that are looked at, probes included.
        damping: The lightest damping that the basis must serve.
        maximum_frequency: Up to which the transfer functions must be accurate [Hz].
        shift: Frequency of the shift [Hz].
        tolerance: Largest error of the accelerations at the probes, as of `ReducedBasis.error`.
        largest: Most vectors of the reduced model.
        larger: Whether the basis grows further, for models that tell the band of the error.
        spend: Whether K may be destroyed when it is of no more use here.
        progress: Called with the part of the work that is done: 1 when the tolerance is met, before
            what tells error and bound is made.

    Raises:
        SolutionError: The tolerance is not met with the most vectors.
    """
    basis = KrylovBasis(K, model.mass, (2.0 * math.pi * shift) ** 2)
    basis.add(patterns)
    models, difference = grow_until_accurate(
        basis,
        model,
        probes,
        damping=damping,
        maximum_frequency=maximum_frequency,
        tolerance=tolerance,
        largest=largest,
        progress=progress,
    )
    gram = Residual(basis).gram
    if spend:
        K.destroy()
        give_back()
    certified = np.unique(probes)
    norm = basis.dual_norm(_Rows(model, certified).columns(model)).reshape(-1, DOFS // 2)
    around = tuple(larger_models(basis)) if larger else ()
    # The rows are gathered without the factor: there may not be room for both.
    basis.destroy()
    vectors = _Rows(model, nodes).gathered(basis)
    return ReducedBasis(
        loads, tuple(models), around, nodes, vectors, difference, certified, norm, gram
    )


def grow_until_accurate(
    basis: KrylovBasis,
    model: BuildingModel,
    probes: Index,
    *,
    damping: Rayleigh,
    maximum_frequency: float,
    tolerance: float,
    largest: int,
    progress: Callable[[float], None] = lambda part: None,
) -> tuple[list[ReducedModel], float]:
    """Grow a basis until nested models agree on the probes' accelerations. Collective.

    Args:
        basis: The basis, with its loads.
        model: The building that it is of.
        probes: Nodes whose transfer functions must be accurate.
        damping: The lightest damping.
        maximum_frequency: Up to which they must be accurate [Hz].
        tolerance: Largest error, as of `ReducedBasis.error`.
        largest: Most vectors.
        progress: Called with the part of the work that is done.

    Returns:
        The reduced model with those nested in it, and their error as of `ReducedBasis.error`.

    Raises:
        SolutionError: The tolerance is not met with the most vectors.
    """
    omega = _omega(maximum_frequency)
    at_probes = _Rows(model, np.unique(probes))
    rows = np.zeros((at_probes.count, DOFS // 2, 0))
    first = math.inf
    while True:
        grown = basis.grow(AT_ONCE)
        models = nested_models(basis)
        rows = np.concatenate([rows, at_probes.gathered(basis, rows.shape[2])], axis=2)
        difference = _difference(models, rows, omega, damping)
        LOGGER.debug("reduced basis: %d vectors, difference %.2e", basis.size, difference)
        first = min(first, difference) if math.isinf(first) else first
        if difference <= tolerance or grown == 0:
            progress(1.0)
            return models, difference
        if basis.size >= largest:
            raise SolutionError(
                f"{basis.size} vectors of the reduced basis leave an error of {difference:.2%} "
                f"at the probes, {tolerance:.2%} is asked: allow more with transient.largest_basis,"
                " or lower transient.maximum_frequency"
            )
        progress(min(1.0, math.log(first / difference) / math.log(max(first / tolerance, 1.01))))


class _Rows:
    """Displacements of nodes that may lie on any rank."""

    def __init__(self, model: BuildingModel, nodes: Index) -> None:
        self.comm = model.comm
        rows = model.rows(nodes)
        self.here = np.flatnonzero(rows >= 0)
        self.rows = rows[self.here, None] + np.arange(DOFS // 2)
        self.count = len(nodes)

    def columns(self, model: BuildingModel) -> scipy.sparse.csc_matrix:
        """The displacements as columns at this rank's rows, shape (n_local, 3 n), sparse."""
        each = DOFS // 2
        column = each * self.here[:, None] + np.arange(each)
        shape = (DOFS * len(model.nodes), each * self.count)
        entries = (np.ones(self.rows.size), (self.rows.ravel(), column.ravel()))
        return scipy.sparse.csc_matrix(entries, shape=shape)

    def gathered(self, basis: KrylovBasis, first: int = 0) -> Array:
        """V from a vector on at the nodes of all ranks; zero at clamped ones. Collective.

        Returns:
            Shape (n, 3, size - first).
        """
        found = np.zeros((self.count, DOFS // 2, basis.size - first))
        found[self.here] = basis.rows(self.rows, first)
        if self.comm.size > 1:
            from mpi4py import MPI

            self.comm.Allreduce(MPI.IN_PLACE, found)
        return found


def _omega(maximum_frequency: float) -> Array:
    """Angular frequencies at which accuracy is looked at [rad/s]."""
    octaves = math.log2(maximum_frequency / LOWEST)
    count = max(2, int(PER_OCTAVE * octaves) + 1)
    return np.asarray(2.0 * math.pi * np.geomspace(LOWEST, maximum_frequency, count))


def _difference(
    models: Sequence[ReducedModel], rows: Array, omega: Array, damping: Rayleigh
) -> float:
    """Largest error, as estimated, of the transfer functions over the largest of any probe."""
    flat = rows.reshape(-1, rows.shape[2])
    band = transfer_band(models, flat, omega, damping).max(axis=1)
    size = np.abs(models[0].transfer(flat, omega, damping)).max(axis=1)
    return float((band / by_third_octave(omega, size)).max())
