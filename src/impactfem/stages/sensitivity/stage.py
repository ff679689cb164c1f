"""The stage `sensitivity`: how the demands of the verdicts change with single parameters."""

from __future__ import annotations

from pathlib import Path

from impactfem.case import Case
from impactfem.stages.device.stage import DEVICE
from impactfem.stages.drawing import Figures
from impactfem.stages.ensemble.stage import ENSEMBLE
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.reduce.stage import REDUCE
from impactfem.stages.sensitivity import figures
from impactfem.stages.sensitivity.figures import (
    SensitivityData,
    sensitivity_checks,
    sensitivity_table,
)
from impactfem.stages.stage import DRAWING, Stage, StageOf
from impactfem.stages.stores import open_store
from impactfem.stages.transient.stage import TRANSIENT
from impactfem.system.log import Steps


def _compute(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    # dolfinx and PETSc are loaded when this stage runs, not before.
    from impactfem.stages.sensitivity.compute import run_sensitivity
    from impactfem.stages.sensitivity.store import write_sensitivity

    with steps.step("variations"):
        result = run_sensitivity(case, folder, lambda part: steps.within("variations", part))
    with steps.step("stores"):
        write_sensitivity(folder / "sensitivity.nc", case, result, key)
    return [folder / "sensitivity.nc"]


def _tabulate(case: Case, folder: Path) -> list[Path]:
    del case
    (folder / "tables").mkdir(exist_ok=True)
    with open_store(folder / "sensitivity.nc") as store:
        return [sensitivity_table(store).write_csv(folder / "tables")]


def _subjects(case: Case) -> tuple[Case, ...]:
    """The case, where a reduced 3D model carries its impacts."""
    in_time = case.in_time
    by_forces = any(one.transient.forces is not None for one in in_time)
    full = any(one.transient.solver == "full" for one in in_time)
    reduced = bool(in_time) and not by_forces and not full
    wanted = case.sensitivity.active and bool(case.sensitivity.parameters)
    return (case,) if wanted and case.contacts and (reduced or case.pounding_in_3d) else ()


def _needs(case: Case) -> tuple[Stage, ...]:
    return (
        REDUCE,
        POUNDING,
        *((ENSEMBLE,) if case.ensemble is not None else ()),
        *((TRANSIENT,) if case.in_time else ()),
        *((DEVICE,) if case.devices else ()),
    )


SENSITIVITY = StageOf[Case](
    name="sensitivity",
    title="Sensitivity",
    about="Demands of the verdicts with one changed parameter.",
    headlines=(),
    steps={"variations": 30.0, "stores": 0.2, DRAWING: 1.0},
    sections=("sensitivity",),
    # Capacities are no inputs of the stages before.
    further=lambda case: case.model_dump_json(include={"limits", "devices"}),
    stores={"sensitivity": "sensitivity.nc"},
    compute=_compute,
    tabulate=_tabulate,
    figures=Figures.of(SensitivityData, figures),
    checks=lambda case, folder: sensitivity_checks(folder),
    subjects=_subjects,
    section="sensitivity",
    needs=_needs,
)
