"""Transfer functions from the impact force of each floor to accelerations, without FFT noise."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.reduced_basis import ReducedBasis

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.int64]

LOWEST = 0.5
COUNT = 600


@dataclass(frozen=True, eq=False)
class Transfer:
    """Transfer functions of the reduced model."""

    frequency: Array  #: Shape (n_f,) [Hz].
    loads: tuple[str, ...]  #: Names of the loads; the floors' edges only.
    value: Complex  #: Acceleration over force, shape (n_f, n_loads, n_nodes, 3) [1/kg].
    #: Rigorous bound on the modulus of its error, same shape; infinite where it is not known.
    bound: Array


def transfer_functions(
    basis: ReducedBasis,
    nodes: Index,
    damping: Rayleigh,
    highest: float,
    loads: Collection[str] | None = None,
) -> Transfer:
    """−ω² x / F at nodes, straight from the modal equations.

    Args:
        basis: The reduced basis.
        nodes: Nodes that it was made for, shape (n,).
        damping: The damping.
        highest: Highest frequency [Hz].
        loads: Names of the loads; those of all floors that the basis has when None.
    """
    frequency = np.asarray(np.geomspace(LOWEST, highest, COUNT), dtype=np.float64)
    omega = 2.0 * math.pi * frequency
    floors = [name for name in basis.loads if name.startswith("floor ")]
    wanted = floors if loads is None else [name for name in floors if name in loads]
    chosen = [basis.loads.index(name) for name in wanted]
    shapes = basis.of(basis.model, nodes).reshape(3 * len(nodes), -1)
    value = np.empty((COUNT, len(chosen), len(nodes), 3), dtype=np.complex128)
    for k, w in enumerate(omega):
        z = basis.model.amplitude(np.array([w]), damping)[0][:, chosen]
        value[k] = (-(w**2) * (shapes @ z)).T.reshape(len(chosen), len(nodes), 3)
    bound = basis.bound(nodes, omega, damping)[..., chosen] * (omega**2)[:, None, None, None]
    names = tuple(basis.loads[k] for k in chosen)
    return Transfer(frequency, names, value, np.moveaxis(bound, -1, 1))
