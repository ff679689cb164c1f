"""The Python interface: run a case, open a run, change a case, sweep, fit and compare.

    import impactfem

    run = impactfem.run("towers.toml")
    run.value("pounding.main_impact_force")
    run.plot.floor_spectrum("west", 3)

The functions of this module are those of the package: `impactfem.run` is `impactfem.study.run`.
"""

import os
from pathlib import Path

from impactfem.case import Case
from impactfem.fit.fit import fit
from impactfem.fit.results import Fit
from impactfem.run import check as _check
from impactfem.run import loop
from impactfem.run.editable_case import EditableCase
from impactfem.run.folder import Run, open_run
from impactfem.run.report import compare_runs, make_report
from impactfem.run.stages import STAGES, stage_names
from impactfem.run.sweep import Sweep, sweep
from impactfem.stages.stage import Stage
from impactfem.system.errors import Fault, ImpactfemError, InputError, SolutionError

__all__ = [
    "STAGES",
    "EditableCase",
    "Fault",
    "Fit",
    "ImpactfemError",
    "InputError",
    "Run",
    "SolutionError",
    "Stage",
    "Sweep",
    "check",
    "compare_runs",
    "fit",
    "load",
    "make_report",
    "open",
    "run",
    "stage_names",
    "sweep",
]

open = open_run  # as `impactfem.open`


def load(path: str | os.PathLike[str]) -> EditableCase:
    """Read a case file whose keys can be changed.

    Args:
        path: The case file.

    Raises:
        InputError: The file is no case file.
    """
    return EditableCase(path)


def check(case: str | os.PathLike[str] | EditableCase, *, mesh: bool = False) -> Case:
    """Validate a case and all files that it names; nothing is computed.

    Args:
        case: The case file, or a case from `load`.
        mesh: Whether the mesh is read, or made, as well, and warnings are logged.

    Returns:
        The values of the case in SI.

    Raises:
        InputError: With every fault.
    """
    return case.check() if isinstance(case, EditableCase) else _check.check(Path(case), mesh=mesh)


def run(
    case: str | os.PathLike[str] | EditableCase,
    *,
    out: str | os.PathLike[str] | None = None,
    stage: str | None = None,
    resume: bool = False,
    fresh: bool = False,
    draw: bool = True,
    bar: bool = True,
) -> Run:
    """Run a case and open its results. Collective under `mpirun`.

    A finished stage with the same inputs is reused. A case with changed keys is written next to the
    run folder as `<folder>.toml`.

    Args:
        case: The case file, or a case from `load`.
        out: The run folder; `runs/<name of the case file>` if None.
        stage: The last stage; all stages if None.
        resume: Whether the folder must hold a run of the same case, which is continued.
        fresh: Whether finished stages are computed again.
        draw: Whether tables, figures and the report are made.
        bar: Whether a progress bar is shown in a terminal.

    Raises:
        InputError: The case or the folder is invalid. Nothing is written.
        ImpactfemError: A computation or a file failed.
    """
    path = case.path if isinstance(case, EditableCase) else Path(case)
    folder = Path("runs") / path.stem if out is None else Path(out)
    if isinstance(case, EditableCase):
        path = case.written_for(folder)
    options = {"resume": resume, "fresh": fresh, "draw": draw, "bar": bar}
    return open_run(loop.run(path, out=folder, stage=stage, **options).folder)
