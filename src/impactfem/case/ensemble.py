"""An ensemble: many motions through the same sticks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, present
from impactfem.case.leaf import FileName, Whole, refuse
from impactfem.case.motions import Motion, RecordMotion
from impactfem.case.source import Source
from impactfem.errors import Fault

Folder = Annotated[Path, FileName()]


class Ensemble(Section):
    """Many motions through the sticks: other seeds of the synthetic motions, or other records."""

    motions: Annotated[int, Whole(2)] | None = Field(
        default=None,
        description="Number of members with synthetic motions; member i takes the seed "
        "first_seed + i, and a further component a seed of its own.",
    )
    first_seed: Annotated[int, Whole(0)] = Field(default=0, description="Seed of the first member.")
    records: Folder | None = Field(
        default=None,
        validate_default=True,
        description="In place of motions: a folder of records, each in place of the file of the "
        "case's one motion, with the same scale, component and treatment.",
    )

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
        if self.records is None:
            return ()
        visible = (path for path in self.records.iterdir() if not path.name.startswith("."))
        return tuple(sorted(path for path in visible if path.is_file()))


def ensemble_faults(
    source: Source, ensemble: Ensemble, motions: Sequence[Motion]
) -> Iterator[Fault]:
    """What does not go together between an ensemble and the motions of its case.

    Args:
        source: The case file.
        ensemble: The ensemble, its folder relative to the working folder.
        motions: The motions of the case.
    """
    recorded = [motion for motion in motions if isinstance(motion, RecordMotion)]
    if ensemble.motions is not None and recorded:
        expected = "synthetic motions only: other seeds of a record there are none; use records"
        yield source.fault(("ensemble", "motions"), ensemble.motions, expected)
    if ensemble.records is not None:
        place, records = ("ensemble", "records"), str(ensemble.records)
        if len(motions) != 1 or len(recorded) != 1:
            expected = "a case with one motion of type 'record', whose file the records take"
            yield source.fault(place, records, expected)
        if not ensemble.records.is_dir():
            expected = "a folder of records; there is none of this name"
            yield source.fault(place, records, expected)
        elif len(ensemble.files()) < 2:
            expected = f"at least two records in it, found {len(ensemble.files())}"
            yield source.fault(place, records, expected)
