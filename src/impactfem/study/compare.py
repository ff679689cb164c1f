"""Two finished runs of a 3D building beside each other: another mesh, solver, law or motion."""

from __future__ import annotations

import math
from pathlib import Path

from impactfem.errors import Fault, InputError
from impactfem.file_errors import file_errors
from impactfem.files import write_netcdf
from impactfem.report.run_files import COMPARISON, RunFiles
from impactfem.results.comparison import STORE, Comparison, compare
from impactfem.results.comparison_views import (
    FIGURE,
    comparison_figure,
    comparison_table,
    directions_table,
)
from impactfem.results.open_store import open_stores
from impactfem.results.table import Table
from impactfem.results.transient_view import TransientView
from impactfem.study.finished import mark_finished
from impactfem.study.folder import locked
from impactfem.study.report import write_page

TRANSIENT = "transient.nc"


def compare_runs(folder: Path, other: Path, highest: float) -> tuple[tuple[Table, ...], Path]:
    """Put the floor response spectra of two runs beside each other, and the result into a report.

    Args:
        folder: The folder of a run; it gets `comparison.nc`, tables, a figure and a new report.
        other: The folder of the run that it is compared with; nothing is written there.
        highest: Highest frequency that is compared [Hz].

    Returns:
        The tables, by point and by direction, and the report.

    Raises:
        InputError: A folder holds no finished run of a 3D building, or both have nothing in common.
        ImpactfemError: A file cannot be read or written.
    """
    if not (math.isfinite(highest) and highest > 0.0):
        raise InputError(
            [Fault("command line", "--to", highest, "expected a positive frequency [Hz]")]
        )
    faults = []
    for path in (folder, other):
        run = RunFiles(path)
        if "transient" not in run.stages:
            expected = "expected a run with the stage transient, whose spectra are compared"
            faults.append(Fault(path, "", None, expected))
    if folder.resolve() == other.resolve():
        faults.append(Fault(other, "", None, "expected the folder of another run"))
    if faults:
        raise InputError(faults)
    files = folder / TRANSIENT, other / TRANSIENT
    with locked(folder), file_errors():
        with open_stores(folder) as opened, open_stores(other) as opened_other:
            views = TransientView(opened(TRANSIENT)), TransientView(opened_other(TRANSIENT))
            store = compare(*views, files, highest)
        write_netcdf(folder / STORE, store)
        found = Comparison(store)
        tables = comparison_table(found), directions_table(found)
        figure = folder / "figures" / FIGURE
        comparison_figure(figure, found)
        listed = [table.write_csv(folder / "tables") for table in tables]
        written = [folder / STORE, *listed, figure]
        mark_finished(folder, COMPARISON, str(store.attrs["inputs"]), written, {})
        return tables, write_page(folder)
