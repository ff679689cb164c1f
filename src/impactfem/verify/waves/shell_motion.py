"""The motion of a small model of shells and beams: in full order, and by a reduced model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from impactfem.building.shell_model import ShellModel, petsc_matrix
from impactfem.dynamics.damping import Rayleigh

if TYPE_CHECKING:
    from impactfem.dynamics.history import History
    from impactfem.reduction.reduced import ReducedModel

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Motion = dict[str, Array]
"""By quantity ("displacement", "velocity", "acceleration") of probes, shape (n_t, n_probes)."""


class MovingModel:
    """A model with loads and probes.

    Args:
        model: The model.
        loads: Patterns of the loads, shape (6 n, m) [N, N m].
        probes: Rows that are looked at, free ones, shape (n_probes,).
    """

    def __init__(self, model: ShellModel, loads: Array, probes: Ints) -> None:
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

    def full(
        self, amplitudes: Array, time_step: float, damping: Rayleigh, start: Array | None = None
    ) -> History:
        """Newmark's average acceleration in full order (`ShellModel.transient`).

        Args:
            amplitudes: Of the loads at each time, shape (n_t, m).
            time_step: Δt [s].
            damping: The damping.
            start: Velocity of all rows at the first time; from rest when None [m/s, rad/s].
        """
        return self.model.transient(
            list(self.patterns.T),
            amplitudes,
            time_step,
            damping=damping,
            probes=self.rows,
            velocity=start,
        )

    def reduced(self, shift: float, vectors: int) -> ReducedMotion:
        """The reduced model of a Krylov basis, which serves all dampings.

        Args:
            shift: Frequency of the shift [Hz].
            vectors: Fewest vectors of the basis, as far as the loads reach so many.
        """
        from impactfem.reduction.krylov import KrylovBasis
        from impactfem.reduction.reduced import reduced_model

        K, M = petsc_matrix(self.K), petsc_matrix(self.M)
        with KrylovBasis(K, M, (2.0 * np.pi * shift) ** 2) as basis:
            basis.add(self.loads)
            while basis.size < vectors and basis.grow(1) > 0:
                pass
            model = reduced_model(basis)
            shapes = model.shapes(basis.rows(self.probes))
        K.destroy()
        M.destroy()
        return ReducedMotion(model, shapes)


@dataclass(frozen=True, eq=False)
class ReducedMotion:
    """A reduced model and its shapes at the probes.

    Args:
        model: The model.
        shapes: Φ at the probes, shape (n_probes, r).
    """

    model: ReducedModel
    shapes: Array

    def motion(
        self, amplitudes: Array, time_step: float, damping: Rayleigh, scheme: str = "exact"
    ) -> Motion:
        """The probes' motion from rest.

        Args:
            amplitudes: Of the loads at each time, shape (n_t, m).
            time_step: Δt [s].
            damping: The damping.
            scheme: "exact" for loads that are straight between the times, or "newmark".
        """
        from impactfem.reduction.modal_response import modal_response

        z = modal_response(self.model, amplitudes, time_step, damping, scheme=scheme)
        histories = {
            "displacement": z.displacement,
            "velocity": z.velocity,
            "acceleration": z.acceleration,
        }
        return {name: (self.shapes @ values).T for name, values in histories.items()}


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
