"""The declaration of a stage: all that the program knows of it stands in one place."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from impactfem.case import Case
from impactfem.stages.check import Check
from impactfem.stages.inputs import inputs_key
from impactfem.system.log import Steps

DRAWING = "tables and figures"
"""The last step of every stage."""


@dataclass(frozen=True, eq=False)
class Stage:
    """One stage of the study.

    A finished stage is computed again when its `key` changes: when a section of the case, a file,
    the program or a stage that it needs does. Tables and figures are drawn again from its stores
    when a published value changes.
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
    compute: Callable[[Case, Path, str, Steps], list[Path]]
    #: Writes tables and figures from the stores of the run; gives their files. On rank 0.
    draw: Callable[[Case, Path], list[Path]]
    checks: Callable[[Case, Path], list[Check]]  #: the checks of its results in words
    #: The stages whose files it reads; those that these need follow.
    needs: Callable[[Case], tuple[Stage, ...]] = lambda case: ()
    #: Files whose content counts, in addition to those of its sections.
    files: Callable[[Case], tuple[Path, ...]] = lambda case: ()
    further: Callable[[Case], str] = lambda case: ""  #: what else counts, as text
    #: Those of its checks that are known before anything is computed.
    announces: Callable[[Case], list[Check]] = lambda case: []
    #: The section of the case file without which the stage has nothing to do; None when nothing is
    #: missing.
    lacks: Callable[[Case], str | None] = lambda case: None
    collective: bool = False  #: whether all ranks compute it together; else rank 0 does
    #: Whether it is done for each building with a 3D model, on a view of the case for it and in the
    #: folder of the view; else once for the whole case, in that of the run.
    each: bool = False

    def cases(self, case: Case) -> tuple[Case, ...]:
        """Return the whole case, or the views of the buildings that the stage is done for.

        Of a view that has what the stage needs, this alone.
        """
        if not self.each:
            return (case.whole,)
        views = (case,) if case.complete and self.lacks(case) is None else case.whole.views
        return tuple(view for view in views if self.lacks(view) is None)

    def label(self, case: Case) -> str:
        """Its name in a run with the building of a view, if that has a folder: `B2/reduce`."""
        return f"{case.part}/{self.name}" if case.part and self.each else self.name

    def labels(self, case: Case) -> tuple[str, ...]:
        """Return the labels of all `cases`."""
        return tuple(self.label(one) for one in self.cases(case))

    @property
    def store(self) -> str:
        """Its main file, with the scalars."""
        return next(iter(self.stores.values()))

    def key(self, case: Case) -> str:
        """Compute the hash of the inputs of its stores, of all views of a case."""
        digest = hashlib.sha256()
        for one in self.cases(case) or (case,):
            needed = "".join(stage.key(one) for stage in self.needs(one))
            own = inputs_key(one, self.sections, self.files(one))
            digest.update(f"{own}{needed}{self.further(one)}".encode())
        return digest.hexdigest()

    def drawing_key(self, case: Case) -> str:
        """Compute the hash of the inputs of its tables and figures."""
        drawn = inputs_key(case, ("published",))
        return hashlib.sha256(f"{self.key(case)}{drawn}".encode()).hexdigest()
