"""The reduced model of a building and what of it is looked at: for any motion and damping."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.local import DOFS
from impactfem.building.model import BuildingModel
from impactfem.dynamics.krylov import KrylovBasis
from impactfem.dynamics.reduced import ReducedModel, reduced_model
from impactfem.errors import SolutionError
from impactfem.files import atomic
from impactfem.log import LOGGER

Array = NDArray[np.float64]
Index = NDArray[np.int64]

AT_ONCE = 8
"""Block steps between two looks at the accuracy."""
NESTED = 0.8
"""Part of the vectors that the nested model has, whose difference is the estimate of the error."""
LOWEST = 0.5
PER_OCTAVE = 12
"""Frequencies at which accuracy is looked at: from LOWEST [Hz] up, so many an octave."""


@dataclass(frozen=True, eq=False)
class ReducedBasis:
    """A reduced model, the coarser one nested in it, and their shapes where they are looked at.

    Args:
        loads: Names of the load patterns, in the order of the models' loads.
        model: The reduced model.
        nested: The coarser one.
        nodes: Nodes that are looked at, ascending, shape (n,).
        shapes: Φ at their displacements, shape (n, 3, size of the basis), before `coordinates`.
        difference: Largest difference of the two models' transfer functions at the probes.
    """

    loads: tuple[str, ...]
    model: ReducedModel
    nested: ReducedModel
    nodes: Index
    shapes: Array
    difference: float

    def of(self, model: ReducedModel, nodes: Index) -> Array:
        """Φ of one of the two models at some of the nodes.

        Args:
            model: `model` or `nested`.
            nodes: Nodes among those that are looked at, shape (m,).

        Returns:
            Shape (m, 3, r).
        """
        at = np.searchsorted(self.nodes, nodes)
        if at.max(initial=-1) >= len(self.nodes) or np.any(self.nodes[at] != nodes):
            raise KeyError("a node that the basis was not made for")
        rows = self.shapes[at][:, :, : len(model.coordinates)]
        return np.asarray(rows @ model.coordinates)

    def write(self, path: Path, key: str) -> None:
        """Write it as NumPy's archive, in one piece.

        Raises:
            ImpactfemError: The file cannot be written.
        """
        content: dict[str, Any] = {"key": key, "loads": np.array(self.loads)}
        content |= {"nodes": self.nodes, "shapes": self.shapes, "difference": self.difference}
        for name, model in (("model", self.model), ("nested", self.nested)):
            for field in ("eigenvalue", "load", "coordinates", "shift", "tail"):
                content[f"{name}_{field}"] = getattr(model, field)
        with atomic(path) as temporary, temporary.open("wb") as stream:
            np.savez(stream, **content)

    @classmethod
    def read(cls, path: Path, key: str) -> ReducedBasis | None:
        """The basis of a file; None where there is none with this key, or it is damaged."""
        try:
            with np.load(path, allow_pickle=False) as content:
                if str(content["key"]) != key:
                    return None
                models = []
                for name in ("model", "nested"):
                    names = ("eigenvalue", "load", "coordinates", "shift", "tail")
                    values = {field: content[f"{name}_{field}"] for field in names}
                    models.append(ReducedModel(**values | {"shift": float(values["shift"])}))
                return cls(
                    loads=tuple(str(name) for name in content["loads"]),
                    model=models[0],
                    nested=models[1],
                    nodes=content["nodes"],
                    shapes=content["shapes"],
                    difference=float(content["difference"]),
                )
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, EOFError) as error:
            LOGGER.warning("%s cannot be read (%s); computed again", path, error)
            return None


def build_basis(
    model: BuildingModel,
    K: Any,
    patterns: Array,
    loads: tuple[str, ...],
    *,
    probes: Index,
    nodes: Index,
    damping: tuple[float, float],
    maximum_frequency: float,
    shift: float,
    tolerance: float,
    largest: int,
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
        damping: α [1/s] and β [s] of the lightest damping that the basis must serve.
        maximum_frequency: Up to which the transfer functions must be accurate [Hz].
        shift: Frequency of the shift [Hz].
        tolerance: Largest difference of the acceleration by the model and by the nested one over
            the largest acceleration of any probe under the same load at that frequency.
        largest: Most vectors.
        progress: Called with the part of the work that is done.

    Raises:
        SolutionError: The tolerance is not met with the most vectors.
    """
    octaves = math.log2(maximum_frequency / LOWEST)
    omega = 2.0 * math.pi * np.geomspace(LOWEST, maximum_frequency, int(PER_OCTAVE * octaves) + 1)
    basis = KrylovBasis(K, model.mass, (2.0 * math.pi * shift) ** 2)
    basis.add(patterns)
    at_probes = _Rows(model, np.unique(probes))
    first = math.inf
    while True:
        grown = basis.grow(AT_ONCE)
        fine, coarse = reduced_model(basis), reduced_model(basis, int(NESTED * basis.size))
        rows = at_probes.gathered(basis.V)
        difference = _difference(fine, coarse, rows, omega, damping)
        LOGGER.debug("reduced basis: %d vectors, difference %.2e", basis.size, difference)
        first = min(first, difference) if math.isinf(first) else first
        if difference <= tolerance or grown == 0:
            break
        if basis.size >= largest:
            raise SolutionError(
                f"{basis.size} vectors of the reduced basis leave a difference of {difference:.2%} "
                f"at the probes, {tolerance:.2%} is asked: allow more with transient.largest_basis,"
                " or lower transient.maximum_frequency"
            )
        progress(min(1.0, math.log(first / difference) / math.log(max(first / tolerance, 1.01))))
    shapes = _Rows(model, nodes).gathered(basis.V)
    basis.destroy()
    return ReducedBasis(loads, fine, coarse, nodes, shapes, difference)


class _Rows:
    """Displacements of nodes that may lie on any rank."""

    def __init__(self, model: BuildingModel, nodes: Index) -> None:
        self.comm = model.comm
        rows = model.rows(nodes)
        self.here = np.flatnonzero(rows >= 0)
        self.rows = rows[self.here, None] + np.arange(DOFS // 2)
        self.count = len(nodes)

    def gathered(self, columns: Array) -> Array:
        """Rows of the nodes on all ranks, shape (n, 3, k); zero at clamped ones. Collective."""
        found = np.zeros((self.count, DOFS // 2, columns.shape[1]))
        found[self.here] = columns[self.rows]
        if self.comm.size > 1:
            from mpi4py import MPI

            self.comm.Allreduce(MPI.IN_PLACE, found)
        return found


def _difference(
    fine: ReducedModel,
    coarse: ReducedModel,
    rows: Array,
    omega: Array,
    damping: tuple[float, float],
) -> float:
    """Largest difference of the transfer functions over the largest of any probe."""
    accelerations = []
    for model in (fine, coarse):
        shapes = rows[:, :, : len(model.coordinates)].reshape(-1, len(model.coordinates))
        z = model.amplitude(omega, *damping)
        accelerations.append(np.einsum("pr,nrm->npm", shapes @ model.coordinates, z))
    largest = np.abs(accelerations[0]).max(axis=1)
    apart = np.abs(accelerations[0] - accelerations[1]).max(axis=1)
    return float((apart / largest).max())
