"""An ensemble: many motions through the same sticks."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

from pydantic import Field

from impactfem.case.base import Section, rule
from impactfem.case.leaf import File, Whole


class Ensemble(Section):
    """Many motions through the sticks: other seeds of the synthetic motions, or other records."""

    motions: Annotated[int, Whole(2, 100_000)] | None = None
    """Number of members with synthetic motions; member i takes the seed first_seed + i, and a
    further component a seed of its own."""
    first_seed: Annotated[int, Whole(0)] = 0
    """Seed of the first member."""
    records: File | None = Field(default=None, validate_default=True)
    """In place of motions: a folder of records, each in place of the file of the case's one motion,
    with the same scale, component and treatment."""

    structure_motions: Annotated[int, Whole(0, 100_000)] = 0
    """Number of members, from the first, that are carried through the 3D model of [transient] and
    the devices, with their impact forces: statistics of design spectra and of forces on anchors. 0
    carries none; statistics need at least two."""

    @rule("structure_motions")
    @staticmethod
    def _some(count: int) -> Iterator[str]:
        if count == 1:
            yield "expected 0, or at least 2: statistics of one motion there are none"

    @rule("records", "motions")
    @staticmethod
    def _either(records: Path | None, motions: int | None) -> Iterator[str]:
        if (records is None) == (motions is None):
            yield "expected either motions or records"

    def files(self) -> tuple[Path, ...]:
        """The records of the folder in the order of their names; none for synthetic motions."""
        return tuple(path for path in self.entries() if path.is_file())

    def entries(self) -> tuple[Path, ...]:
        """What is in the folder, files and others, but hidden ones, in the order of the names."""
        if self.records is None:
            return ()
        return tuple(sorted(p for p in self.records.iterdir() if not p.name.startswith(".")))
