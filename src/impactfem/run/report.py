"""The report: the last stage, made from what the others wrote."""

from __future__ import annotations

from pathlib import Path

from impactfem.case import Case
from impactfem.report.page import write_report
from impactfem.report.run_figures import overview_pictures
from impactfem.report.run_files import CASE, CHECKS, RunFiles
from impactfem.run.folder import locked
from impactfem.run.stages import REPORT, STAGES
from impactfem.stages.check import Check
from impactfem.system.errors import file_errors
from impactfem.system.files import write_json
from impactfem.system.log import LOGGER, Steps

STEPS = {"overview": 2.0, "page": 8.0}


def write_findings(folder: Path, case: Case, checks: dict[str, list[Check]]) -> None:
    """Write the case as it was read, and the checks of all stages.

    `good` is true or false of a check that is met or not, and null of what is told.

    Args:
        folder: The run's folder.
        case: The case.
        checks: Those of each stage by its name.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    write_json(folder / CASE, case.model_dump(mode="json", exclude={"path"}))
    write_json(
        folder / CHECKS,
        [
            {"stage": stage, "good": good, "text": text}
            for stage, found in checks.items()
            for good, text in found
        ],
    )


def make_report(folder: Path) -> Path:
    """Make the page of a finished run again, and its overview, from the files of its folder.

    Args:
        folder: The run's folder.

    Returns:
        The page.

    Raises:
        InputError: The folder holds no run, or a run is at work in it.
        ImpactfemError: A file cannot be read or written.
    """
    RunFiles(folder)  # before anything is written into a folder that is none of a run
    with locked(folder), file_errors():
        return write_page(folder)


def write_page(folder: Path, *, bar: bool = True) -> Path:
    """Make the page and the overview in a folder that this process has opened.

    Args:
        folder: The run's folder.
        bar: Whether a bar shows on a terminal how far it is.

    Returns:
        The page.

    Raises:
        ImpactfemError: A file cannot be read or written.
    """
    LOGGER.info("stage %s: starts", REPORT)
    with Steps(STEPS, f"stage {REPORT}", bar=bar) as steps:
        with steps.step("overview"):
            overview_pictures(folder)
        with steps.step("page"):
            page = write_report(folder, {s.name: (s.title, s.about) for s in STAGES})
    LOGGER.info("stage %s: %s, %.1f MB", REPORT, page, page.stat().st_size / 1e6)
    LOGGER.info("stage %s: done in %.1f s", REPORT, sum(steps.times.values()))
    return page
