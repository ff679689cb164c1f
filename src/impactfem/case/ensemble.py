"""An ensemble: many motions through the same sticks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, present, refuse
from impactfem.case.leaf import FileName, Whole
from impactfem.case.motions import Motion, RecordMotion, RestMotion
from impactfem.case.source import Source
from impactfem.case.transient import Transient
from impactfem.system.errors import Fault

Folder = Annotated[Path, FileName()]


class Ensemble(Section):
    """Many motions through the sticks: other seeds of the synthetic motions, or other records."""

    motions: Annotated[int, Whole(2, 100_000)] | None = None
    """Number of members with synthetic motions; member i takes the seed first_seed + i, and a
    further component a seed of its own."""
    first_seed: Annotated[int, Whole(0)] = 0
    """Seed of the first member."""
    records: Folder | None = Field(default=None, validate_default=True)
    """In place of motions: a folder of records, each in place of the file of the case's one motion,
    with the same scale, component and treatment."""

    structure_motions: Annotated[int, Whole(0, 100_000)] = 0
    """Number of members, from the first, that are carried through the 3D model of [transient] and
    the devices, with their impact forces: statistics of design spectra and of forces on anchors. 0
    carries none; statistics need at least two."""

    @field_validator("structure_motions")
    @classmethod
    def _some(cls, value: int) -> int:
        if value == 1:
            raise refuse("expected 0, or at least 2: statistics of one motion there are none")
        return value

    @field_validator("records")
    @classmethod
    def _either(cls, value: Path | None, info: ValidationInfo) -> Path | None:
        if not present(info, ["motions"]):
            return value
        if (value is None) == (info.data["motions"] is None):
            raise refuse("expected either motions or records")
        return value

    def files(self) -> tuple[Path, ...]:
        """The records of the folder in the order of their names; none for synthetic motions."""
        return tuple(path for path in self.entries() if path.is_file())

    def entries(self) -> tuple[Path, ...]:
        """What is in the folder, files and others, but hidden ones, in the order of the names."""
        if self.records is None:
            return ()
        return tuple(sorted(p for p in self.records.iterdir() if not p.name.startswith(".")))


def ensemble_faults(
    source: Source,
    ensemble: Ensemble,
    motions: Sequence[Motion],
    transient: Transient | None,
) -> Iterator[Fault]:
    """What does not go together between an ensemble and the rest of its case.

    Args:
        source: The case file.
        ensemble: The ensemble, its folder relative to the working folder.
        motions: The motions of the case.
        transient: The response of the 3D model in time, or None.
    """
    yield from _carried_faults(source, ensemble, transient)
    if any(isinstance(motion, RestMotion) for motion in motions):
        expected = "expected [[motions]] as well: ground at rest has no other motions"
        yield source.fault(("ensemble",), None, expected)
        return
    recorded = [motion for motion in motions if isinstance(motion, RecordMotion)]
    if ensemble.motions is not None and recorded:
        expected = "synthetic motions only: other seeds of a record there are none; use records"
        yield source.fault(("ensemble", "motions"), ensemble.motions, expected)
    if ensemble.records is not None:
        place, records = ("ensemble", "records"), str(ensemble.records)
        if len(motions) != 1 or len(recorded) != 1:
            expected = (
                "expected a case with one motion of type 'record', whose file the records take"
            )
            yield source.fault(place, records, expected)
        if not ensemble.records.is_dir():
            expected = "expected a folder of records; there is none of this name"
            yield source.fault(place, records, expected)
        elif len(ensemble.files()) < 2:
            expected = f"at least two records in it, found {len(ensemble.files())}"
            yield source.fault(place, records, expected)
        else:
            strange = sorted(set(ensemble.entries()) - set(ensemble.files()))
            if strange:
                expected = f"expected ordinary files only; {strange[0].name} in it is none"
                yield source.fault(place, records, expected)


def _carried_faults(
    source: Source, ensemble: Ensemble, transient: Transient | None
) -> Iterator[Fault]:
    """Why members cannot be carried through the 3D model."""
    place, carried = ("ensemble", "structure_motions"), ensemble.structure_motions
    if carried == 0:
        return
    there = ensemble.motions
    if there is None and ensemble.records is not None and ensemble.records.is_dir():
        there = len(ensemble.files())
    if there is not None and carried > there:
        yield source.fault(place, carried, f"expected at most all members, {there}")
    if transient is None:
        yield source.fault(place, carried, "expected 0, or a section [transient], the 3D model")
    elif transient.solver == "full":
        expected = "expected 0, or a [transient] with another solver than 'full'"
        yield source.fault(place, carried, f"{expected}: members take the reduced model")
    elif transient.forces is not None:
        expected = "expected 0: each member has its own impact forces, not transient.forces"
        yield source.fault(place, carried, expected)
