"""The declaration of a stage: all that the program knows of it stands in one place."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeAlias, TypeVar

from impactfem.case import Building3D, Case
from impactfem.stages.check import Check
from impactfem.stages.drawing import Figures
from impactfem.stages.inputs import inputs_key
from impactfem.stages.verdict import Verdict
from impactfem.system.log import Steps

DRAWING = "tables and figures"
"""The last step of every stage."""


Subject: TypeAlias = Case | Building3D
"""What a stage is done for: the case, or one of its buildings with a 3D model."""
S = TypeVar("S", bound=Subject)


def part_of(subject: Subject) -> str:
    """Return the folder of a subject within that of the run; "" where it is that of the run."""
    return subject.part if isinstance(subject, Building3D) else ""


@dataclass(frozen=True, eq=False)
class StageOf(Generic[S]):
    """One stage of the study.

    A finished stage is computed again when its `key` changes: when a section of the case, a file,
    the program or a stage that it needs does. Tables and figures are drawn again from its stores
    when a published value or a section in `drawn_from` changes.
    """

    name: str  #: its name on the command line, and of its folder in `impactfem.stages`
    title: str  #: its heading in the report
    about: str  #: what it does, in a sentence of the report
    #: Lines of the log, ``{name}`` for a result; one that is not there leaves its line out.
    headlines: tuple[str, ...]
    steps: Mapping[str, float]  #: its steps and their share of its time; `DRAWING` is the last one
    #: Sections of the case file that it depends on, in addition to those of its needs.
    sections: tuple[str, ...]
    #: Its files by the name under which `open_run` has them; the scalars are in the first.
    stores: Mapping[str, str]
    #: Computes and writes stores; gives the files that it wrote, on rank 0.
    compute: Callable[[S, Path, str, Steps], list[Path]]
    #: Writes tables and products from the stores of the run; gives their files. On rank 0.
    tabulate: Callable[[S, Path], list[Path]]
    checks: Callable[[S, Path], list[Check]]  #: the checks of its results in words
    #: What it is done for: the case in the folder of the run, or buildings in folders of their own.
    subjects: Callable[[Case], tuple[S, ...]]
    figures: Figures = field(default_factory=Figures)  #: drawn from the stores of the run
    #: Sections of the case file that its tables and figures depend on, in addition to `sections`.
    drawn_from: tuple[str, ...] = ()
    section: str = ""  #: the section of the case file without which there is none of them
    #: The stages whose files it reads; those that these need follow.
    needs: Callable[[S], tuple[StageOf[Any], ...]] = lambda subject: ()
    #: Files whose content counts, in addition to those of its sections.
    files: Callable[[S], tuple[Path, ...]] = lambda subject: ()
    further: Callable[[S], str] = lambda subject: ""  #: what else counts, as text
    #: Its demands with the capacities that they are compared with.
    verdicts: Callable[[S, Path], list[Verdict]] = lambda subject, folder: []
    #: Those of its checks that are known before anything is computed.
    announces: Callable[[Case], list[Check]] = lambda case: []
    collective: bool = False  #: whether all ranks compute it together; else rank 0 does

    def of(self, subject: Subject) -> tuple[S, ...]:
        """Return what it is done for in a case; of a building that it is done for, this alone."""
        if isinstance(subject, Case):
            return self.subjects(subject)
        every = self.subjects(subject.case)
        own = [one for one in every if isinstance(one, Building3D) and one.name == subject.name]
        return tuple(own) or every

    def lacks(self, case: Case) -> str | None:
        """Return the section of the case file that it lacks; None where nothing is missing."""
        return None if self.subjects(case) else self.section

    def label(self, subject: Subject) -> str:
        """Its name in a run, with the building where this has a folder: `B2/reduce`."""
        part = part_of(subject)
        return f"{part}/{self.name}" if part else self.name

    def labels(self, subject: Subject) -> tuple[str, ...]:
        """Return the labels of all that it is done for."""
        return tuple(self.label(one) for one in self.of(subject))

    @property
    def store(self) -> str:
        """Its main file, with the scalars."""
        return next(iter(self.stores.values()))

    def key(self, subject: Subject) -> str:
        """Compute the hash of the inputs of its stores, of all that it is done for."""
        digest = hashlib.sha256()
        for one in self.of(subject):
            needed = "".join(stage.key(one) for stage in self.needs(one))
            own = inputs_key(one, self.sections, self.files(one))
            digest.update(f"{own}{needed}{self.further(one)}".encode())
        return digest.hexdigest()

    def draw(self, subject: S, folder: Path) -> list[Path]:
        """Write tables, products and figures from the stores of the run; gives their files."""
        return [*self.tabulate(subject, folder), *self.figures.draw(subject, folder)]

    def drawing_key(self, subject: Subject) -> str:
        """Compute the hash of the inputs of its tables and figures."""
        drawn = inputs_key(subject, ("published", *self.drawn_from))
        report = (subject if isinstance(subject, Case) else subject.case).report
        requested = [report.figures, *report.shown_files]
        return hashlib.sha256(f"{self.key(subject)}{drawn}{requested}".encode()).hexdigest()


Stage: TypeAlias = StageOf[Any]
"""A stage of any subject."""
