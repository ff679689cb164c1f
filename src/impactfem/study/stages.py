"""The stages in order."""

from __future__ import annotations

from impactfem.case import Case
from impactfem.errors import Fault, InputError
from impactfem.study.ensemble import ENSEMBLE
from impactfem.study.stage import Stage
from impactfem.study.sticks import STICKS

STAGES: tuple[Stage, ...] = (STICKS, ENSEMBLE)


def stage_names() -> list[str]:
    """Names of the stages in order."""
    return [stage.name for stage in STAGES]


def check_stage_name(name: str | None) -> None:
    """See that a stage of that name exists; None stands for the last one.

    Raises:
        InputError: There is none.
    """
    known = stage_names()
    if name is not None and name not in known:
        expected = f"one of the stages {', '.join(known)}"
        raise InputError([Fault("command line", "--stage", name, expected)])


def asked_stages(case: Case, last: str | None) -> list[Stage]:
    """The stages up to the last one asked for that the case has the input for.

    Args:
        case: The case.
        last: Name of the last stage; None for all.

    Raises:
        InputError: The case lacks what the last stage needs.
    """
    stages = STAGES if last is None else STAGES[: stage_names().index(last) + 1]
    missing = stages[-1].lacks(case)
    if last is not None and missing is not None:
        expected = f"a section [{missing}], which the stage {last} needs"
        raise InputError([Fault(case.path, missing, None, expected)])
    return [one for one in stages if one.lacks(case) is None]
