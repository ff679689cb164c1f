"""What a stage of the study is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from impactfem.case import Case
from impactfem.stages.check import Check
from impactfem.system.log import Steps
from impactfem.system.scalar import Scalar


@dataclass(frozen=True)
class Stage:
    """One stage of the study.

    Args:
        name: Its name on the command line.
        steps: Its steps and their share of its time.
        rooms: Rooms of the program that its results depend on; their sources are hashed before
            anything runs.
        key: Hash of what it depends on.
        store: Its main file, with the scalars.
        run: Computes and writes; gives the files that it wrote, on rank 0.
        checks: The checks of its results in words.
        announces: Logs what is known of its results before anything is computed.
        lacks: The section of the case file without which the stage has nothing to do; None when
            nothing is missing.
        needs: Names of the stages whose files it reads.
        derived: Scalars that are read off the run's stores, beside those in its own store.
        collective: Whether all ranks run it together; else rank 0 does.
    """

    name: str
    steps: dict[str, float]
    rooms: tuple[str, ...]
    key: Callable[[Case], str]
    store: str
    run: Callable[[Case, Path, str, Steps], list[Path]]
    checks: Callable[[Case, Path], list[Check]]
    announces: Callable[[Case], None] = lambda case: None
    lacks: Callable[[Case], str | None] = lambda case: None
    needs: Callable[[Case], tuple[str, ...]] = lambda case: ()
    derived: Callable[[Path], list[Scalar]] = lambda folder: []
    collective: bool = False
