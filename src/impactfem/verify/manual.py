"""All benchmarks of the manual, run and shown."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import ModuleType

from rich.table import Table

from impactfem.case.base import nearest
from impactfem.system.errors import Fault, InputError
from impactfem.system.files import write_json
from impactfem.system.log import Steps
from impactfem.system.parallel import one_blas_thread, rank
from impactfem.verify import (
    contact,
    devices,
    massless,
    model_updating,
    motion,
    soil,
    spectra,
    sticks,
    unilateral,
    validation,
)
from impactfem.verify.devices import spectra as device_spectra
from impactfem.verify.row import HEAVY, REGISTERED, Row, Rows
from impactfem.verify.shells import beams, curved, plates, steel_frames
from impactfem.verify.waves import forced, frame, in_time, paper, pounding, slab

GROUPS: Mapping[str, Sequence[ModuleType]] = {
    "Contact between sticks": (contact,),
    "Sticks and their time integration": (sticks,),
    "Soil under rafts, waves that pass": (soil,),
    "Ground motion": (motion,),
    "Oscillators and spectra": (spectra,),
    "Shells": (plates, curved),
    "Beams and frames": (beams, steel_frames),
    "Waves and the 3D building in time": (slab, in_time, forced, frame, pounding, paper),
    "Unilateral contact": (unilateral, massless),
    "Devices and response spectrum analysis": (devices, device_spectra),
    "Model updating": (model_updating,),
}
"""Modules of the benchmarks, by subject."""


def _in_order(benchmarks: list[Callable[..., Rows]]) -> dict[str, Callable[..., Rows]]:
    """By name, in the order of the groups."""
    names = [module.__name__ for group in GROUPS.values() for module in group]
    return {
        run.__name__: run for run in sorted(benchmarks, key=lambda r: names.index(r.__module__))
    }


BENCHMARKS = _in_order(REGISTERED)
FULL = _in_order(HEAVY)
"""The last one takes about half an hour, the others some minutes."""


def verify(
    only: str | None = None,
    json_file: Path | None = None,
    full: bool = False,
    validation_cases: bool = False,
) -> list[Row]:
    """Run the benchmarks, those with `only` in their name where it is given.

    `full` adds the heavy ones, `validation_cases` runs the cases against other programs and
    experiments in their place, and `json_file` gets the rows as JSON. InputError where no benchmark
    has `only` in its name, or a case is not usable; ImpactfemError where the file cannot be
    written, or the cases are not there.
    """
    known = {**BENCHMARKS, **FULL} if full else BENCHMARKS
    if validation_cases:
        known = validation.cases()
    chosen = {name: run for name, run in known.items() if only is None or only in name}
    if not chosen:
        expected = f"no benchmark has this in its name; {nearest(only or '', list(known))}"
        if not full and not validation_cases:
            expected += f"; or with --full of {', '.join(FULL)}"
        raise InputError([Fault("command line", "--only", only, expected)])
    found: list[tuple[str, Row]] = []
    steps = Steps(dict.fromkeys(chosen, 1.0), "verify", quiet=rank() != 0)
    with one_blas_thread(), steps:
        for name, run in chosen.items():
            with steps.step(name):
                found += [(name, row) for row in run()]
    if json_file is not None:
        write_json(json_file, [{"benchmark": name, **row.as_dict()} for name, row in found])
    return [row for _, row in found]


def as_table(rows: list[Row], sources: bool = False) -> Table:
    """Return the rows for a terminal, on request with the sources of the references."""
    heads = "benchmark", "quantity", "reference", "computed", "unit", "error", "allowed", ""
    table = Table(*heads, *(["source"] if sources else []))
    for row in rows:
        values = f"{row.reference:.6g}", f"{row.computed:.6g}", row.unit
        errors = f"{row.error:.1e}", f"{row.tolerance:.2g}", "pass" if row.passed else "FAIL"
        table.add_row(row.name, row.quantity, *values, *errors, *([row.source] if sources else []))
    return table
