"""The study: the stages in order, what each reads and writes, and what may be reused."""

from impactfem.study.compare import compare_runs
from impactfem.study.loop import Run, check, run
from impactfem.study.report import make_report
from impactfem.study.stage import Stage
from impactfem.study.stages import STAGES, stage_names
from impactfem.study.sweep import Sweep, sweep

__all__ = [
    "STAGES",
    "Run",
    "Stage",
    "Sweep",
    "check",
    "compare_runs",
    "make_report",
    "run",
    "stage_names",
    "sweep",
]
