"""The report of a run, made from what the stages wrote, and its comparison with another run."""

import math
from collections.abc import Iterable
from pathlib import Path

from impactfem.plot.table import Table
from impactfem.report.compared_impacts import (
    floors_table,
    impacts_figure,
    impacts_table,
    what_pounds,
)
from impactfem.report.comparison import (
    FIGURE,
    STORE,
    Comparison,
    Side,
    cases_table,
    compare,
    comparison_figure,
    comparison_table,
    directions_table,
)
from impactfem.report.decision import governing, spectra_figure
from impactfem.report.flowchart import flowchart_figure
from impactfem.report.page import REPORT as PAGE
from impactfem.report.page import write_report
from impactfem.report.run_files import COMPARISON, FLOWCHART, SCENE, SPECTRA, RunFiles
from impactfem.report.scene_page import write_scene
from impactfem.run.folder import locked
from impactfem.run.stages import REPORT, STAGES
from impactfem.stages.manifest import mark_finished
from impactfem.stages.stores import open_stores, stores_kept_open
from impactfem.system.errors import Fault, InputError, file_errors
from impactfem.system.files import StrPath, write_netcdf
from impactfem.system.log import LOGGER, Steps

TRANSIENT = "transient.nc"
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
            flowchart_figure(folder, STAGES)
            spectra_figure(run, governing(run))
            for one in (folder, *(folder / name for name in run.further)):
                write_scene(one)
        with steps.step("page"):
            page = write_report(folder, STAGES)
    seconds, size = sum(steps.times.values()), page.stat().st_size / 1e6
    LOGGER.info("stage %s: done in %.1f s, %s, %.1f MB", REPORT, seconds, page.name, size)
    return page


def remove_page(folder: Path, further: Iterable[str]) -> None:
    """Remove the page of a run and the overview, in folders of further buildings as well."""
    (folder / PAGE).unlink(missing_ok=True)
    for one in (folder, *(folder / name for name in further)):
        for name in (f"{FLOWCHART}.*", f"{SPECTRA}.*", SCENE):
            for path in (one / "figures").glob(name):
                path.unlink()


def compare_runs(folder: StrPath, other: StrPath, highest: float) -> tuple[tuple[Table, ...], Path]:
    """Compare two runs of one building, and put it into a report.

    Floor response spectra, impacts, spectra over whole floors and forces of devices.

    Args:
        folder: The folder of a run; it gets `comparison.nc`, tables, figures and a new report.
        other: The folder of the run that it is compared with; nothing is written there.
        highest: Highest frequency that is compared [Hz].

    Returns:
        The tables, of the cases, of impacts, over whole floors where both runs have fields, by
        point and by direction, and the report.

    Raises:
        InputError: A folder holds no finished run of a 3D building, they are of different
            buildings, or points, dampings or frequencies do not go together. Nothing is written.
        ImpactfemError: A file cannot be read or written.
    """
    folder, other = Path(folder), Path(other)
    if not (math.isfinite(highest) and highest > 0.0):
        raise InputError(
            [Fault("command line", "--to", highest, "expected a positive frequency [Hz]")]
        )
    faults = []
    runs = [RunFiles(path) for path in (folder, other)]
    for path, run in zip((folder, other), runs, strict=True):
        if "transient" not in run.stages:
            expected = "expected a run with the stage transient, whose spectra are compared"
            faults.append(Fault(path, "", None, expected))
    if folder.resolve() == other.resolve():
        faults.append(Fault(other, "", None, "expected the folder of another run"))
    if faults:
        raise InputError(faults)
    with locked(folder), file_errors():
        with open_stores(folder) as opened, open_stores(other) as opened_other:
            one, another = (
                Side(
                    response=stores(TRANSIENT),
                    building=stores("building.nc"),
                    case_file=str(run.provenance["case"]),
                    folder=run.folder,
                    pounding=what_pounds(run.case),
                )
                for run, stores in zip(runs, (opened, opened_other), strict=True)
            )
            store = compare(one, another, highest)
        write_netcdf(folder / STORE, store)
        found = Comparison(store)
        whole = floors_table(runs, highest)
        tables = (
            cases_table(found),
            impacts_table(runs),
            *([whole] if whole else []),
            comparison_table(found),
            directions_table(found),
        )
        figure = folder / "figures" / FIGURE
        for part in ("tables", "figures"):  # a run may have neither yet
            (folder / part).mkdir(exist_ok=True)
        comparison_figure(figure, found)
        listed = [table.write_csv(folder / "tables") for table in tables]
        written = [folder / STORE, *listed, figure, *impacts_figure(figure.parent, runs)]
        mark_finished(folder, COMPARISON, str(store.attrs["inputs"]), written, {})
        return tables, write_page(folder)
