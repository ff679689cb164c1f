"""Floor response spectra under one motion at probes and at the vertices that govern."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Spectra
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.loads import Loads
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.reduction.response import modal_histories, record_spectra
from impactfem.spectra import response_spectra
from impactfem.stages.design.fewest import fewest
from impactfem.stages.design.records import Records, RecordSpectra
from impactfem.stages.transient.maps import AS_THEY_ARE
from impactfem.system.parallel import threads

Array = NDArray[np.float64]
Index = NDArray[np.int64]

AT_ONCE = 768
"""Records whose spectra are computed together."""


@dataclass(frozen=True, eq=False)
class Search:
    """Where and how the governing vertices of a motion are sought.

    Args:
        candidates: Among which.
        frequency: At which frequencies, shape (n_f,) [Hz].
        damping: Of the oscillators [-].
    """

    candidates: Records
    frequency: Array
    damping: float

    @property
    def key(self) -> str:
        """Hash of what it depends on."""
        return f"{self.candidates.key}{self.frequency.tolist()}{self.damping}"


@dataclass(frozen=True, eq=False)
class BuildingMotion:
    """A motion of the building in modal coordinates.

    Args:
        basis: The reduced basis.
        loads: The loads.
        acceleration: q'' of its finest model under them, shape (r, n_t).
    """

    basis: ReducedBasis
    loads: Loads
    acceleration: Array

    @classmethod
    def under(cls, basis: ReducedBasis, loads: Loads, damping: Rayleigh) -> BuildingMotion:
        """The motion under some loads.

        Args:
            basis: The reduced basis.
            loads: The loads.
            damping: The damping.

        Raises:
            KeyError: The basis has no pattern of one of the loads.
        """
        return cls(basis, loads, modal_histories(basis, loads, damping).acceleration)

    def records(self, nodes: Index, components: Index, *, roughly: bool = False) -> Array:
        """Absolute accelerations of nodes, each along one direction, shape (n, n_t) [m/s2].

        Args:
            nodes: Nodes that the basis was made for, shape (n,).
            components: 0, 1 or 2 for x, y, z, shape (n,).
            roughly: Whether single precision is enough, which takes half the time.

        Raises:
            KeyError: The basis was not made for a node.
        """
        kind = np.float32 if roughly else np.float64
        shapes = self.basis.of(self.basis.model, nodes)[np.arange(len(nodes)), components]
        relative = shapes.astype(kind) @ self.acceleration.astype(kind)
        return np.asarray(relative + self.loads.ground.T[components], dtype=np.float64)


def governing_of(motion: BuildingMotion, search: Search) -> Records:
    """The fewest candidates whose envelope is near that of all candidates, as of `fewest`.

    The spectra that tell are of the records as they are, without samples between.

    Args:
        motion: The motion.
        search: Among which vertices.
    """
    every = search.candidates
    curves = np.empty((len(every), len(search.frequency) + 1))
    for first in range(0, len(every), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        found = response_spectra(
            motion.records(every.node[part], every.component[part], roughly=True),
            motion.loads.time_step,
            search.frequency,
            [search.damping],
            points_per_cycle=AS_THEY_ARE,
            threads=threads(),
            absolute=False,
        )
        curves[part, :-1], curves[part, -1] = found.psa[0], found.zpa
    groups = np.unique(np.stack([every.floor, every.component], axis=1), axis=0)
    chosen = []
    for floor, component in groups:
        there = every.at(floor, component)
        chosen.append(every.taken(there[fewest(curves[there])]))
    return Records.joined(chosen)


def point_spectra(
    motion: BuildingMotion, nodes: Index, components: Index, spectra: Spectra
) -> RecordSpectra:
    """Spectra of some nodes, each along one direction.

    Args:
        motion: The motion.
        nodes: Nodes that the basis was made for, shape (n_r,).
        components: 0, 1 or 2 for x, y, z, shape (n_r,).
        spectra: The case's floor spectra.

    Raises:
        KeyError: The basis was not made for a node.
    """
    records = motion.records(nodes, components)
    found = record_spectra(records, motion.loads.time_step, spectra)
    return RecordSpectra(found.psa, found.zpa)
