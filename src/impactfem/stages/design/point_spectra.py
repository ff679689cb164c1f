"""Floor response spectra under one motion at probes and at the vertices that govern."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Spectra
from impactfem.reduction.response import record_spectra
from impactfem.spectra import response_spectra
from impactfem.stages.design.bases import ModalShare, records_of
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


def governing_of(shares: Sequence[ModalShare], search: Search) -> Records:
    """The fewest candidates whose envelope is near that of all candidates, as of `fewest`.

    The spectra that tell are of the records as they are, without samples between.

    Args:
        shares: The motion in modal coordinates, as of `modal_shares`.
        search: Among which vertices.
    """
    every = search.candidates
    curves = np.empty((len(every), len(search.frequency) + 1))
    for first in range(0, len(every), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        found = response_spectra(
            records_of(shares, every.node[part], every.component[part], roughly=True),
            shares[0].loads.time_step,
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
    shares: Sequence[ModalShare], nodes: Index, components: Index, spectra: Spectra
) -> RecordSpectra:
    """Spectra of some nodes, each along one direction.

    Args:
        shares: The motion in modal coordinates.
        nodes: Nodes that all bases were made for, shape (n_r,).
        components: 0, 1 or 2 for x, y, z, shape (n_r,).
        spectra: The case's floor spectra.

    Raises:
        KeyError: A basis was not made for a node.
    """
    records = records_of(shares, nodes, components)
    found = record_spectra(records, shares[0].loads.time_step, spectra)
    return RecordSpectra(found.psa, found.zpa)
