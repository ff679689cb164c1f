"""The report of a run, made from what the stages wrote, and its comparison with another run."""

import math
from collections.abc import Iterable
from pathlib import Path

from impactfem.plot.table import Table
from impactfem.report.comparison import comparison_table
from impactfem.report.comparison import spectra_figure as spectra_of_both
from impactfem.report.governing import governing
from impactfem.report.governing_figure import spectra_figure
from impactfem.report.page import REPORT as PAGE
from impactfem.report.page import write_report
from impactfem.report.run_files import COMPARISON, SCENE, SPECTRA, RunFiles
from impactfem.report.scene_page import write_scene
from impactfem.run.folder import locked
from impactfem.run.stages import REPORT, STAGES
from impactfem.stages.manifest import mark_finished
from impactfem.stages.stores import stores_kept_open
from impactfem.system.errors import Fault, InputError, file_errors
from impactfem.system.files import StrPath
from impactfem.system.log import LOGGER, Steps

STEPS = {"overview": 2.0, "page": 8.0}


def make_report(folder: StrPath) -> Path:
    """Make the page of a finished run again, and its overview, from the files of its folder.

    Raises:
        InputError: The folder holds no run, or a run is at work in it.
        ImpactfemError: A file cannot be read or written.
    """
    folder = Path(folder)
    RunFiles(folder)  # before anything is written into a folder that holds no run
    with locked(folder), file_errors():
        return write_page(folder)


def write_page(folder: Path, *, bar: bool = True) -> Path:
    """Make the page and the overview in a folder that this process has locked."""
    LOGGER.info("stage %s: starts", REPORT)
    with Steps(STEPS, f"stage {REPORT}", bar=bar) as steps, stores_kept_open():
        with steps.step("overview"):
            run = RunFiles(folder)
            remove_page(folder, run.further)
            spectra_figure(run, governing(run))
            write_scene(run)
        with steps.step("page"):
            page = write_report(folder, STAGES)
    seconds, size = sum(steps.times.values()), page.stat().st_size / 1e6
    LOGGER.info("stage %s: done in %.1f s, %s, %.1f MB", REPORT, seconds, page.name, size)
    return page


def remove_page(folder: Path, further: Iterable[str]) -> None:
    """Remove the page of a run and the overview, in folders of further buildings as well."""
    (folder / PAGE).unlink(missing_ok=True)
    for one in (folder, *(folder / name for name in further)):
        for name in (f"{SPECTRA}.*", SCENE):
            for path in (one / "figures").glob(name):
                path.unlink()


def compare_runs(folder: StrPath, other: StrPath, highest: float) -> tuple[Table, Path]:
    """Compare two runs: all scalar results in one table, and floor spectra in one figure.

    Args:
        folder: The folder of a run; it gets the table, the figure and a new report.
        other: The folder of the other run; nothing is written there.
        highest: Highest frequency of the figure [Hz].

    Returns:
        The table (name, unit, both values in SI, ratio), and the report.

    Raises:
        InputError: A folder holds no finished run, or both are the same. Nothing is written.
        ImpactfemError: A file cannot be read or written.
    """
    folder, other = Path(folder), Path(other)
    if not (math.isfinite(highest) and highest > 0.0):
        expected = "expected a positive frequency [Hz]"
        raise InputError([Fault("command line", "--to", highest, expected)])
    if folder.resolve() == other.resolve():
        raise InputError([Fault(other, "", None, "expected the folder of another run")])
    run, another = RunFiles(folder), RunFiles(other)
    with locked(folder), file_errors():
        table = comparison_table(run, another)
        for part in ("tables", "figures"):  # a run may have neither yet
            (folder / part).mkdir(exist_ok=True)
        written = [table.write_csv(folder / "tables")]
        written += spectra_of_both(folder / "figures", run, another, highest)
        mark_finished(folder, COMPARISON, run.inputs_key, written, {})
        return table, write_page(folder)
