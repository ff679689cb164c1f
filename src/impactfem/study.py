"""The study in Python: what the command line does, and a finished run open for reading."""

from impactfem.fit.fit import fit
from impactfem.fit.results import Fit
from impactfem.run.check import check
from impactfem.run.folder import RunFolder, open_run
from impactfem.run.loop import Run, run
from impactfem.run.report import compare_runs, make_report
from impactfem.run.stages import STAGES, stage_names
from impactfem.run.sweep import Sweep, sweep
from impactfem.stages.stage import Stage
from impactfem.system.errors import Fault, ImpactfemError, InputError, SolutionError

__all__ = [
    "STAGES",
    "Fault",
    "Fit",
    "ImpactfemError",
    "InputError",
    "Run",
    "RunFolder",
    "SolutionError",
    "Stage",
    "Sweep",
    "check",
    "compare_runs",
    "fit",
    "make_report",
    "open_run",
    "run",
    "stage_names",
    "sweep",
]
