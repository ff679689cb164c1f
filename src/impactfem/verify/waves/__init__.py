"""Models of shells and beams in motion that benchmarks share: in full order, and reduced."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from impactfem.building.shell_model import UZ, ShellModel, petsc_matrix
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.arrays import Array, Index

if TYPE_CHECKING:
    from impactfem.dynamics.history import History
    from impactfem.reduction.reduced import ReducedModel

BALANCE = "average acceleration conserves the discrete balance (Hughes 1983)"
KRYLOV = "the same equations in a Krylov space"
Motion = dict[str, Array]
"""By quantity ("displacement", "velocity", "acceleration") of probes, shape (n_t, n_probes)."""


class MovingModel:
    """A model, patterns of its loads (6 n, m) [N, N m], and the free rows of its probes."""

    def __init__(self, model: ShellModel, loads: Array, probes: Index) -> None:
        free = model.free
        self.model = model
        self.patterns = loads
        self.rows = probes
        # Of the free rows alone, as the reduced model has them.
        self.K, self.M = (matrix[free][:, free] for matrix in (model.K, model.M))
        self.loads = loads[free]
        self.probes = np.searchsorted(free, probes)

    def static(self) -> Array:
        """Displacement of the probes under each load at rest, shape (n_probes, m) [m, rad]."""
        return np.column_stack([self.model.static(load)[self.rows] for load in self.patterns.T])

    def full(self, amplitudes: Array, time_step: float, damping: Rayleigh) -> History:
        """Average acceleration in full order from rest, by amplitudes of the loads (n_t, m)."""
        return self.model.transient(
            list(self.patterns.T), amplitudes, time_step, damping=damping, probes=self.rows
        )

    def reduced(self, shift: float, vectors: int) -> ReducedMotion:
        """Return the model of a Krylov basis with its shift [Hz] and at least so many vectors.

        Fewer, where the loads do not reach so many. It serves all dampings.
        """
        return self.nested(shift, vectors)[0]

    def nested(self, shift: float, vectors: int, larger: bool = False) -> list[ReducedMotion]:
        """Return the reduced model, and on request the larger models of its error band."""
        from impactfem.reduction.error_band import larger_models
        from impactfem.reduction.krylov import KrylovBasis
        from impactfem.reduction.reduced import reduced_model

        K, M = petsc_matrix(self.K), petsc_matrix(self.M)
        with KrylovBasis(K, M, (2.0 * np.pi * shift) ** 2) as basis:
            basis.add(self.loads)
            while basis.size < vectors and basis.grow(1) > 0:
                pass
            models = [reduced_model(basis), *(larger_models(basis, basis.size) if larger else ())]
            rows = basis.rows(self.probes)
        K.destroy()
        M.destroy()
        return [ReducedMotion(model, model.shapes(rows)) for model in models]


def pressures(model: ShellModel, values: Array, mass: float) -> Array:
    """Nodal loads (6 n, m) of pressures, or line loads, at the nodes (n, m) along z.

    The mass of the deflections is the mass per area, or length, times ∫N Nᵀ: over that mass it
    turns a distributed load into its forces.
    """
    loads = np.zeros((len(model.K.indptr) - 1, values.shape[1]))
    loads[UZ::6] = model.M[UZ::6, UZ::6] @ values / mass
    return loads


@dataclass(frozen=True, eq=False)
class ReducedMotion:
    """A reduced model and its shapes Φ at the probes, shape (n_probes, r)."""

    model: ReducedModel
    shapes: Array

    def motion(
        self, amplitudes: Array, time_step: float, damping: Rayleigh, scheme: str = "exact"
    ) -> Motion:
        """The probes' motion from rest by amplitudes of the loads, shape (n_t, m).

        The scheme is "exact" for loads that are straight between the times, or "newmark".
        """
        from impactfem.reduction.modal_response import modal_response

        z = modal_response(self.model, amplitudes, time_step, damping, scheme=scheme)
        quantities = ("displacement", "velocity", "acceleration")
        return {name: (self.shapes @ getattr(z, name)).T for name in quantities}


def apart(values: Array, reference: Array) -> float:
    """Largest difference over the largest value of the reference [-]."""
    return float(np.abs(values - reference).max() / np.abs(reference).max())


def peak(time: Array, values: Array) -> tuple[float, float]:
    """Time and value of the largest sample, where the parabola through its neighbours peaks."""
    k = int(np.clip(np.argmax(values), 1, len(values) - 2))
    before, at, after = values[k - 1 : k + 2]
    bend = before - 2.0 * at + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return float(time[k] + shift * (time[1] - time[0])), float(at - 0.25 * (before - after) * shift)
