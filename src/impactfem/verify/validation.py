"""Cases of `geometry/validation`, compared with what other programs or experiments print.

A case is a file NAME.toml, whose first comment says what it is and where from. Compared are the
values of its `[report] reference`, which are results, and displacements of floors at times in
NAME_histories.csv, where there is one.
"""

import math
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import numpy as np

from impactfem.case import load_case
from impactfem.case.base import Section
from impactfem.case.leaf import Text, Whole, Words
from impactfem.case.quantity import Length, PositiveLength, Time
from impactfem.case.table import read_table
from impactfem.stages.pounding.compute import StickStudy, run_sticks
from impactfem.stages.pounding.store import stick_scalars
from impactfem.sticks.element import COMPONENTS
from impactfem.system.errors import Fault, InputError
from impactfem.system.files import in_source_tree
from impactfem.verify.row import Rows

FOLDER = "geometry/validation"
REPORT = "_report"  # ends the names of files that are no cases


class Instant(Section):
    """A row of a table of published displacements."""

    building: Text
    """Name of the building."""
    floor: Annotated[int, Whole(1)]
    """Number of the floor."""
    component: Annotated[str, Words("x, y or z", "[xyz]")]
    """Direction."""
    time: Time
    """Time in the case."""
    displacement: Length
    """Published displacement relative to the ground."""
    tolerance: PositiveLength
    """Largest difference that counts as agreement."""
    source: Text
    """Where it is published."""


def cases() -> dict[str, Callable[[], Rows]]:
    """The benchmarks of the folder, by the names of the files; ImpactfemError without them."""
    files = sorted(in_source_tree(FOLDER).glob("*.toml"))
    return {path.stem: _benchmark(path) for path in files if not path.stem.endswith(REPORT)}


def _benchmark(path: Path) -> Callable[[], Rows]:
    def run() -> Rows:
        return compared(path)

    lines = path.read_text(encoding="utf-8").splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("# "))
    end = next(k for k in range(first, len(lines)) if not lines[k].startswith("#"))
    run.__name__ = path.stem
    run.__doc__ = "\n".join(line[2:] for line in lines[first:end])
    return run


def compared(path: Path) -> Rows:
    """Run the sticks of a case and compare their results with what its source prints.

    InputError where the case or its tables are not usable, or there is nothing to compare.
    """
    case = load_case(path)
    study = run_sticks(case, lambda _: nullcontext())
    found = {scalar.name: scalar.value for scalar in stick_scalars(study)}
    rows = Rows(path.stem)
    reference = case.report.reference
    for item in reference.items if reference is not None else ():
        for value in item.values:
            published = case.published[value.name]
            if published.relation != "=" or published.kind != "result":
                continue
            ours = found.get(value.name)
            numbers = published.value, math.nan if ours is None else ours, published.unit
            rows.add(value.name, *numbers, value.tolerance, published.source)
    histories = path.with_name(f"{path.stem}_histories.csv")
    if histories.exists():
        _instants(histories, study, rows)
    if not rows:
        expected = f"expected published results in it, or in {histories.name}"
        raise InputError([Fault(path, "report.reference", None, expected)])
    return rows


def _instants(path: Path, study: StickStudy, rows: Rows) -> None:
    """Displacements at times, straight between those that are computed."""
    faults: list[Fault] = []
    table = read_table(path, Instant, faults)
    if table is None:
        raise InputError(faults)
    time, stations = study.response.time, study.stations
    dofs = np.concatenate([study.system.floor_dofs(s.name) for s in study.system.sticks])
    for line, row in table:
        place = row.building, row.floor
        if place not in stations:
            faults.append(table.fault(line, "floor", row.floor, f"no such floor of {row.building}"))
        elif row.time > time[-1]:
            faults.append(table.fault(line, "time", row.time, f"expected at most {time[-1]:g} s"))
        else:
            u = study.response.u[:, dofs[stations.index(place), COMPONENTS.index(row.component)]]
            what = f"{row.building}, floor {row.floor}: {row.component} at {row.time:g} s"
            ours = np.interp(row.time, time, u)
            rows.add(what, row.displacement, ours, "m", row.tolerance, row.source, absolute=True)
    if faults:
        raise InputError(faults)
