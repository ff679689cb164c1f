"""The reduced model of a building, and its shapes at nodes: for any motion and damping."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.linalg import svd

from impactfem.building.links import Displacements
from impactfem.building.mesh import DOFS
from impactfem.building.model import BuildingModel
from impactfem.dynamics.columns import inner
from impactfem.dynamics.damping import DampingLaw, Rayleigh
from impactfem.reduction.error_band import (
    NESTED_SHARES,
    by_third_octave,
    larger_models,
    nested_models,
    transfer_band,
    transfer_bound,
)
from impactfem.reduction.foundation import Foundation
from impactfem.reduction.galerkin import LOCAL, GalerkinModes
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.reduced import ReducedModel, residual_norms
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError
from impactfem.system.log import LOGGER
from impactfem.system.parallel import all_blas_threads
from impactfem.system.quantity import si

AT_ONCE = 4
"""Block steps between two estimates of the error."""
LOWEST = 0.5
PER_OCTAVE = 12
"""Frequencies at which the error is estimated: from LOWEST [Hz] up, so many an octave."""


@dataclass(frozen=True, eq=False)
class ReducedBasis:
    """A reduced model, those nested in it and around it, and their shapes at recorded nodes."""

    loads: tuple[str, ...]  #: names of the load patterns, in the order of the models' loads
    #: The reduced model, then those nested in it, which give an estimate of its error.
    models: tuple[ReducedModel, ...]
    #: Models that it is nested in, which give the band of its error; none where none were
    #: requested.
    larger: tuple[ReducedModel, ...]
    nodes: Index  #: recorded nodes, ascending, shape (n,)
    #: V at their displacements, shape (n, 3, size of the largest model); zero at clamped nodes.
    vectors: Array
    #: Estimated error of the transfer functions at the probes that it was made for, as of `error`.
    difference: float
    certified: Index  #: nodes for which the rigorous bound is known, ascending, shape (m,)
    norm: Array  #: ‖l‖ of their displacements (see `error_band`), shape (m, 3)
    gram: Array  #: Qᵀ (K + σ0 M) Q of the basis, shape (n_tail, n_tail)
    #: V at the rotations of the certified nodes, shape (m, 3, size of the largest model)
    rotations: Array
    #: R, displacements of the nodes by a motion of the base about the origin, shape (n, 3, 6).
    rigid: Array | None = None
    foundation: Foundation | None = None  #: raft and soil; None for a clamped building
    #: Number of the last loads that are of single points of contact, see `completed`.
    points: int = 0

    @property
    def model(self) -> ReducedModel:
        """The reduced model itself."""
        return self.models[0]

    def of(self, model: ReducedModel, nodes: Index, *, rotations: bool = False) -> Array:
        """Φ of one of `models` or `larger` at some of the nodes, shape (m, 3, r).

        Of their displacements, or of the rotations of certified ones; on soil with R of the six
        coordinates of the base after it, shape (m, 3, r + 6).

        Raises:
            KeyError: The basis was not made for one of the nodes.
        """
        rows = self.rows(nodes, rotations=rotations)
        flat = rows.reshape(-1, rows.shape[2])
        shapes = model.shapes(flat).reshape(len(rows), 3, len(model.eigenvalue))
        if self.foundation is None:
            return shapes
        return np.dstack([shapes, self.carried(nodes, rotations=rotations)])

    def carried(self, nodes: Index, *, rotations: bool = False) -> Array:
        """Rigid-body matrix at the nodes, or its rotational rows, shape (m, 3, 6)."""
        if rotations:
            return np.tile(np.eye(6)[3:], (len(nodes), 1, 1))
        if self.rigid is None:
            raise ValueError("a basis of a building that can only be clamped")
        return self.rigid[np.searchsorted(self.nodes, nodes)]

    def rows(self, nodes: Index, *, rotations: bool = False) -> Array:
        """V at some of the nodes, shape (m, 3, size of the largest model); refuses other nodes."""
        known = self.certified if rotations else self.nodes
        at = np.searchsorted(known, nodes)
        if at.max(initial=-1) >= len(known) or np.any(known[at] != nodes):
            raise KeyError("a node that the basis was not made for")
        return (self.rotations if rotations else self.vectors)[at]

    def at(self, nodes: Index) -> ReducedBasis:
        """The model with its shapes at some nodes alone, of any order, for other processes."""
        kept = np.unique(nodes)
        vectors = self.rows(kept)[..., : len(self.model.coordinates)]
        rigid = None if self.rigid is None else self.carried(kept)
        return replace(
            self, models=self.models[:1], larger=(), nodes=kept, vectors=vectors, rigid=rigid
        )

    def bound(self, nodes: Index, omega: Array, damping: DampingLaw) -> Array:
        """Rigorous bound on the error of displacements under exp(iωt) of each load.

        ω has the shape (n_freq,) [rad/s]. Shape (n_freq, n, 3, n_loads); infinite where nothing is
        known, as of damping that is not Rayleigh's, and of a `completed` basis.
        """
        if not isinstance(damping, Rayleigh) or not self.gram.size:
            return np.full((len(omega), len(nodes), 3, len(self.loads)), math.inf)
        at = np.searchsorted(self.certified, nodes)
        known = np.isin(nodes, self.certified)
        norm = np.full((len(nodes), 3), math.inf)
        norm[known] = self.norm[at[known]]
        residual = residual_norms(self.gram, self.model, omega, damping)
        found = transfer_bound(self.model, norm.ravel(), residual, omega, damping)
        return found.reshape(len(omega), len(nodes), 3, -1)

    def error(self, probes: Index, damping: DampingLaw, maximum_frequency: float) -> float:
        """Largest estimated error of the accelerations at probes, as of `NestedModels.error`.

        Under all loads but those of single points of contact, which `completed` added.
        """
        rows = self.vectors[np.searchsorted(self.nodes, np.unique(probes))]
        whole = len(self.loads) - self.points
        models = tuple(replace(one, load=one.load[:, :whole]) for one in self.models)
        return NestedModels(models, rows).error(damping, maximum_frequency)


@dataclass(frozen=True)
class Accuracy:
    """Required accuracy of a basis."""

    damping: DampingLaw
    maximum_frequency: float = si("Hz", "end of the band in which transfer functions are accurate")
    tolerance: float = si("-", "largest relative error at the probes that is allowed")
    #: Remedy if it is not reached, in the words of the case.
    remedy: str = "allow more with transient.largest_basis, or lower transient.maximum_frequency"


@dataclass(frozen=True, eq=False)
class BasisPlan:
    """Requirements of a reduced basis."""

    loads: tuple[str, ...]  #: names of the load patterns in their order
    probes: Index  #: nodes where the transfer functions must be accurate, ascending
    nodes: Index  #: nodes whose motion is wanted, probes included, ascending
    #: The first is that of the reduced model; the whole space meets all of them.
    accuracies: tuple[Accuracy, ...]
    shift: float  #: frequency that the basis is expanded about [Hz]
    largest: int  #: largest number of vectors of the Krylov space
    larger: bool = False  #: make larger models, for the error band


@dataclass(frozen=True, eq=False)
class NestedModels:
    """A reduced model with those nested in it, and the probes by which its error is estimated."""

    models: tuple[ReducedModel, ...]  #: the model, then those nested in it
    rows: Array  #: V at the probes, shape (n_probes, 3, size of the model)

    def error(self, damping: DampingLaw, maximum_frequency: float) -> float:
        """Largest estimated error of the accelerations at the probes under any one of the loads.

        The error band of the transfer functions by nested models up to a frequency [Hz], over the
        largest acceleration of any probe under the same load within the same third of an octave.
        """
        return _difference(self.models, self.rows, _omega(maximum_frequency), damping)


@dataclass(frozen=True, eq=False)
class Grown:
    """A basis that was grown until it is accurate."""

    coarse: NestedModels  #: as accurate as the first accuracy asks
    fine: NestedModels  #: as accurate as all of them: the same, or of more vectors
    #: Models that the coarse one is nested in; none where none were requested.
    larger: tuple[ReducedModel, ...]
    differences: tuple[float, ...]  #: error at each accuracy, of the model that met it
    gram: Array  #: Qᵀ (K + σ0 M) Q of the coarse model, shape (n_tail, n_tail)
    norm: Array  #: ‖l‖ of the probes' displacements (see `error_band`), shape (n_probes, 3)


def grow_basis(
    basis: KrylovBasis,
    probes: Displacements,
    plan: BasisPlan,
    *,
    bounded: bool = True,
    progress: Callable[[float], None] = lambda part: None,
) -> Grown:
    """Grow a basis with its loads until it is as accurate at probes as required. Collective.

    `bounded` adds the norms of the probes that a rigorous bound needs. `progress` is called with
    the part of the work that is done.

    Raises:
        SolutionError: An accuracy is not met with the largest number of vectors.
    """
    first, *others = plan.accuracies
    count, largest = len(plan.accuracies), plan.largest

    def within(k: int) -> Callable[[float], None]:
        return lambda part: progress((k + part) / count)

    coarse, difference = _grow_until_accurate(basis, probes, None, first, largest, within(0))
    n, gram = basis.size, inner(basis.M, basis.Q, basis.shifted_tail())
    norm = np.full((probes.count, DOFS // 2), math.inf)
    if bounded:
        norm = basis.dual_norm(probes.columns).reshape(norm.shape)
    fine, differences = coarse, [difference]
    for k, accuracy in enumerate(others, 1):
        rows, report = fine.rows, within(k)
        fine, difference = _grow_until_accurate(basis, probes, rows, accuracy, largest, report)
        differences.append(difference)
    around = tuple(larger_models(basis, n)) if plan.larger else ()
    return Grown(coarse, fine, around, tuple(differences), gram, norm)


def build_basis(
    model: BuildingModel,
    K: Any,
    patterns: Array,
    plan: BasisPlan,
    progress: Callable[[float], None] = lambda part: None,
) -> ReducedBasis:
    """Build a basis for given loads, without rigid links and contacts. Collective.

    Args:
        model: The building.
        K: Its stiffness.
        patterns: Load patterns at this rank's rows, shape (n_local, n_patterns).
        plan: Requirements; the accuracies with the lightest damping that they must serve.
        progress: Called with the part of the work that is done.

    Raises:
        SolutionError: The tolerance is not met with the largest number of vectors.
    """
    plan = replace(plan, probes=np.unique(plan.probes))
    with KrylovBasis(K, model.mass, (2.0 * math.pi * plan.shift) ** 2) as basis:
        basis.add(patterns)
        grown = grow_basis(basis, Displacements(model, plan.probes), plan, progress=progress)
    rotations = Displacements(model, plan.probes, rotations=True)
    return reduced_basis(basis, grown, plan, Displacements(model, plan.nodes), rotations)


def reduced_basis(
    basis: KrylovBasis,
    grown: Grown,
    plan: BasisPlan,
    displacements: Displacements,
    rotations: Displacements,
    rigid: Array | None = None,
    *,
    every: bool = False,
) -> ReducedBasis:
    """Return what is kept of a basis: its models, and its vectors at nodes. Collective.

    Its factorisation may be gone: there may not be room for both. `displacements` are those of the
    nodes of the plan, with their R in `rigid`; the rotations are those of the probes. The vectors
    are those of the models, or all (`every`), as `completed` needs them.
    """
    models, size = grown.coarse.models, basis.vectors.count
    if not every:
        size = max(len(model.coordinates) for model in (*models, *grown.larger))
    kept = partial(basis.vectors.rows, first=0, last=size)
    return ReducedBasis(
        loads=plan.loads,
        models=models,
        larger=grown.larger,
        nodes=plan.nodes,
        vectors=displacements.of(kept),
        difference=grown.differences[0],
        certified=plan.probes,
        norm=grown.norm,
        gram=grown.gram,
        rotations=rotations.of(kept),
        rigid=rigid,
    )


@dataclass(frozen=True, eq=False)
class LocalLoads:
    """Loads in Galerkin's modes that act locally, and the vectors that the basis has for them."""

    names: tuple[str, ...]  #: names of all load patterns, those of single points last
    b: Array  #: all patterns in the modes, shape (r, n_patterns)
    single: Array  #: those of single points, shape (r, n_points)
    shifts: tuple[float, ...]  #: σ at which it has the response to each, its own first [1/s2]
    smooth: Array  #: loads that many points share, shape (r, k)
    steps: int  #: of the chain that completed the basis for these (`append_chain`)


@all_blas_threads()
def completed(known: ReducedBasis, modes: GalerkinModes, local: LocalLoads) -> ReducedBasis:
    """Complete a reduced basis for loads that act locally. Collective.

    Its models are Galerkin's, on the vectors of each model and the responses to the local loads;
    so are those nested in it and around it. The rigorous bound is not known of them.

    Args:
        known: The reduced basis of the Krylov space, with all vectors at its nodes.
        modes: Galerkin's modes on all vectors.
        local: The loads.
    """
    points, V_F = len(local.names) - len(known.loads), modes.coordinates @ local.b
    Φ, count = modes.coordinates, len(modes.coordinates)
    λ_Φ = modes.eigenvalue[:, None]

    def outside(columns: Array, x: Array) -> Array:
        """Directions of Φ x outside orthonormal columns, but for those that hardly are."""
        W = Φ @ (x / np.linalg.norm(x, axis=0))
        for _ in range(2):
            W -= columns @ (columns.T @ W)
        U, size, _ = svd(W, full_matrices=False)
        return np.asarray(U[:, size > LOCAL])

    def model(size: int) -> ReducedModel:
        # What was appended is orthogonal to the whole Krylov space, and a model has a part of this:
        # it gets separate vectors, made in the same way.
        columns, x = np.eye(count, size), local.smooth
        for _ in range(local.steps):
            W = outside(columns, x / (λ_Φ + known.model.shift))
            columns, x = np.hstack([columns, W]), Φ.T @ W
        for shift in local.shifts:
            columns = np.hstack([columns, outside(columns, local.single / (λ_Φ + shift))])
        λ, Y = modes.within(columns)
        return ReducedModel(λ, Y.T @ V_F, Y, known.model.shift, np.zeros((0, len(λ))))

    models = tuple(model(len(one.coordinates)) for one in known.models)
    return replace(
        known,
        loads=local.names,
        models=models,
        larger=tuple(model(len(one.coordinates)) for one in known.larger),
        gram=np.zeros((0, 0)),
        points=points,
    )


def _grow_until_accurate(
    basis: KrylovBasis,
    probes: Displacements,
    known: Array | None,
    accuracy: Accuracy,
    largest: int,
    progress: Callable[[float], None],
) -> tuple[NestedModels, float]:
    """Grow a basis until nested models agree on the probes' accelerations. Collective."""
    # `known` is V at the probes for the vectors so far; None before the first growth.
    omega = _omega(accuracy.maximum_frequency)
    tolerance = accuracy.tolerance
    grown = basis.grow(AT_ONCE) if known is None else 1
    rows = np.zeros((probes.count, DOFS // 2, 0)) if known is None else known
    start = math.inf
    while True:
        seen = rows.shape[2]
        added = probes.of(partial(basis.rows, first=seen))
        rows = np.concatenate([rows, added], axis=2)
        # Most often the first nested model says that the basis has to grow.
        for shares in (NESTED_SHARES[:1], NESTED_SHARES):
            models = nested_models(basis, shares)
            difference = _difference(models, rows, omega, accuracy.damping)
            if tolerance < difference and grown > 0 and basis.size < largest:
                break
        LOGGER.debug("reduced basis: %d vectors, difference %.2e", basis.size, difference)
        start = min(start, difference) if math.isinf(start) else start
        if difference <= tolerance or grown == 0:
            progress(1.0)
            return NestedModels(tuple(models), rows), difference
        if basis.size >= largest:
            raise SolutionError(
                f"{basis.size} vectors of the reduced basis leave an error of {difference:.2%} "
                f"at the probes, {tolerance:.2%} is required: {accuracy.remedy}"
            )
        progress(min(1.0, math.log(start / difference) / math.log(max(start / tolerance, 1.01))))
        grown = basis.grow(AT_ONCE)


def _omega(maximum_frequency: float) -> Array:
    """Angular frequencies at which the error is estimated [rad/s]."""
    octaves = math.log2(maximum_frequency / LOWEST)
    count = max(2, int(PER_OCTAVE * octaves) + 1)
    return np.asarray(2.0 * math.pi * np.geomspace(LOWEST, maximum_frequency, count))


def _difference(
    models: Sequence[ReducedModel], rows: Array, omega: Array, damping: DampingLaw
) -> float:
    """Largest error, as estimated, of the transfer functions over the largest of any probe."""
    flat = rows.reshape(-1, rows.shape[2])
    band = transfer_band(models, flat, omega, damping).max(axis=1)
    size = np.abs(models[0].transfer(flat, omega, damping)).max(axis=1)
    return float((band / by_third_octave(omega, size)).max())
