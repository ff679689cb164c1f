"""The stages in order."""

from difflib import get_close_matches

from impactfem.case import Case
from impactfem.stages.building.stage import BUILDING
from impactfem.stages.calibrate.stage import CALIBRATE
from impactfem.stages.design.stage import DESIGN
from impactfem.stages.device.stage import DEVICE
from impactfem.stages.ensemble.stage import ENSEMBLE
from impactfem.stages.equipment.stage import EQUIPMENT
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.reduce.stage import REDUCE
from impactfem.stages.sensitivity.stage import SENSITIVITY
from impactfem.stages.stage import Stage
from impactfem.stages.transient.stage import TRANSIENT
from impactfem.system.errors import Fault, InputError

REPORT = "report"
STAGES: tuple[Stage, ...] = (
    BUILDING,
    REDUCE,
    CALIBRATE,
    POUNDING,
    ENSEMBLE,
    TRANSIENT,
    DEVICE,
    DESIGN,
    EQUIPMENT,
    SENSITIVITY,
)

OF_CASE: tuple[Stage, ...] = (POUNDING, ENSEMBLE, EQUIPMENT, SENSITIVITY)
"""Those that are done for the case as a whole, not for each building with a 3D model."""


def stage_names() -> list[str]:
    """Names of the stages in order, the report last."""
    return [*(stage.name for stage in STAGES), REPORT]


def check_stage_name(name: str | None) -> None:
    """Raise an InputError where no stage has that name; None stands for the last one."""
    known = stage_names()
    if name is not None and name not in known:
        expected = f"expected one of the stages {', '.join(known)}"
        if near := get_close_matches(name.lower(), known, n=1):
            expected += f"; did you mean '{near[0]}'?"
        raise InputError([Fault("command line", "--stage", name, expected)])


def needed_stages(case: Case, last: str | None) -> list[Stage]:
    """The last stage with all that it needs, in order; None or "report" for all the case has."""
    if last in (None, REPORT):
        return [stage for stage in STAGES if stage.lacks(case) is None]
    by_name = {stage.name: stage for stage in STAGES}
    wanted, ahead = set(), [last]
    while ahead:
        name = ahead.pop()
        if name not in wanted:
            wanted.add(name)
            stage = by_name[name]
            ahead += [one.name for subject in stage.of(case) for one in stage.needs(subject)]
    return [stage for stage in STAGES if stage.name in wanted]


def asked_stages(case: Case, last: str | None) -> list[Stage]:
    """The stages to run, in order: up to the last with all that it needs; None or "report" for all.

    All are those that the case has the input for. InputError where it lacks what the last one
    needs.
    """
    stages = needed_stages(case, last)
    for stage in stages:
        missing = stage.lacks(case)
        if missing is not None:
            name = {"structure": "buildings.structure"}.get(missing, missing)
            expected = f"expected a section [{name}], which the stage {stage.name} needs"
            raise InputError([Fault(case.path, missing, None, expected)])
    return stages
