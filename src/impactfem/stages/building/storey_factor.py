"""The storey stiffness factor that gives the first bending mode a frequency."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
import scipy.optimize
from numpy.typing import NDArray

from impactfem.building.bending import bending_modes
from impactfem.building.model import BuildingModel
from impactfem.dynamics.columns import inner, product
from impactfem.dynamics.modes import Modes, modes
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.reduced import reduced_model
from impactfem.system.errors import SolutionError
from impactfem.system.log import LOGGER

Array = NDArray[np.float64]
Index = NDArray[np.int64]

MOST_ROUNDS = 8
TOLERANCE = 1e-6
"""Relative error of the frequency that is reached."""
KRYLOV_STEPS, CHANGE_STEPS = 12, 4
"""Vectors of the ground motion, and of the change of the bending mode, in the first space."""
FARTHEST = 100.0
"""Largest change of the factor in a round, to either side."""


@dataclass(frozen=True, eq=False)
class FittedBuilding:
    """A fitted factor, with the modes of the building that has it.

    Args:
        factor: The factor on the stiffness of walls and columns.
        modes: Modes with it.
        rounds: Number of modal analyses it took.
    """

    factor: float
    modes: Modes
    rounds: int


def fit_storey_factor(
    model: BuildingModel, frequency: float, direction: int, start: float, count: int
) -> FittedBuilding:
    """Find the factor f with which the first bending mode has a frequency. Collective.

    A factor is found in a small space V, (Vᵀ K_fixed V + f Vᵀ K_storeys V) a = λ a: first in one
    that costs little, of Krylov vectors of the ground motion and of how the bending mode φ changes
    with f, the response to K_storeys φ; then, should the frequency of the modes that follow not be
    near enough, in the space of these modes. Its error is of the second order in that of V.

    Args:
        model: The building.
        frequency: Frequency to reach [Hz].
        direction: 0 or 1, along x or y: the direction in which the mode moves.
        start: First value of f.
        count: Number of modes.

    Raises:
        SolutionError: There is no such mode among them, or no factor gives the frequency, as when
            the slabs alone are too soft.
    """
    factor = _reduced_fit(
        model, _ground_space(model, direction, start), frequency, direction, start
    )
    for rounds in range(1, MOST_ROUNDS + 1):
        K = model.stiffness(factor)
        found = modes(K, model.mass, count)
        K.destroy()
        reached = float(found.frequency[_first_bending(model, found, direction, factor)])
        LOGGER.debug("storey factor %.6g: first bending mode at %.8g Hz", factor, reached)
        if abs(reached / frequency - 1.0) < TOLERANCE:
            return FittedBuilding(factor, found, rounds)
        factor = _reduced_fit(model, found.shapes, frequency, direction, factor)
    raise SolutionError(
        f"no storey factor gives the first bending mode {frequency:g} Hz: after {MOST_ROUNDS} "
        f"modal analyses it is {reached:.6g} Hz"
    )


def _first_bending(model: BuildingModel, found: Modes, direction: int, factor: float) -> int:
    bending = _bending(model, found.shapes, direction)
    if bending.size == 0:
        raise SolutionError(
            f"none of the {found.frequency.size} lowest modes bends along {'xy'[direction]}: they "
            f"reach {found.frequency[-1]:.4g} Hz at the storey factor {factor:.4g}"
        )
    return int(bending[0])


def _bending(model: BuildingModel, shapes: Array, direction: int) -> Index:
    """Numbers of the shapes Φ, Φᵀ M Φ = I, that bend along a direction, from the lowest."""
    gamma = model.comm.allreduce(shapes.T @ model.ground[:, direction])
    return bending_modes(gamma**2, float(model.total[direction, direction]))


def _ground_space(model: BuildingModel, direction: int, factor: float) -> Array:
    """Columns V, Vᵀ M V = I, with the bending mode at a factor and its change with the factor."""
    K = model.stiffness(factor)
    with KrylovBasis(K, model.mass, 0.0) as basis:
        basis.add(model.ground[:, [direction]])
        basis.grow(KRYLOV_STEPS)
        shapes = basis.V @ reduced_model(basis).coordinates
        bending = _bending(model, shapes, direction)
        if bending.size:
            basis.add(product(model.storeys, shapes[:, bending[:1]]))
            basis.grow(CHANGE_STEPS)
        V = np.array(basis.V)
    K.destroy()
    return V


def _reduced_fit(
    model: BuildingModel, V: Array, frequency: float, direction: int, factor: float
) -> float:
    """The factor that gives the frequency in the space of V, shape (n_local, k), Vᵀ M V = I."""
    fixed, storeys = _projected(model.fixed, V), _projected(model.storeys, V)
    gamma = model.comm.allreduce(V.T @ model.ground[:, direction])
    total = float(model.total[direction, direction])
    asked = (2.0 * math.pi * frequency) ** 2

    def excess(logarithm: float) -> float:
        values, vectors = scipy.linalg.eigh(fixed + math.exp(logarithm) * storeys)
        bending = bending_modes((vectors.T @ gamma) ** 2, total)
        return float(np.log(values[bending[0] if bending.size else 0] / asked))

    here = math.log(factor)
    low, high = here - math.log(FARTHEST), here + math.log(FARTHEST)
    if not excess(low) < 0.0 < excess(high):
        raise SolutionError(
            f"no storey factor from {math.exp(low):.3g} to {math.exp(high):.3g} gives the first "
            f"bending mode {frequency:g} Hz: the slabs and beams are too soft or too stiff for it"
        )
    return math.exp(float(scipy.optimize.brentq(excess, low, high, xtol=1e-12)))


def _projected(matrix: Any, V: Array) -> Array:
    reduced = inner(matrix, V, product(matrix, V))
    return 0.5 * (reduced + reduced.T)
