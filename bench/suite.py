"""The groups of performance figures of `impactfem bench`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from importlib import import_module
from pathlib import Path

from bench.figures import Figure
from impactfem.system.errors import Fault, InputError
from impactfem.system.files import write_json
from impactfem.system.log import Steps
from impactfem.system.parallel import one_blas_thread


def _later(module: str, function: str, **options: bool) -> Callable[[], list[Figure]]:
    """A group whose module, and dolfinx with it, is loaded when it is measured."""

    def measured() -> list[Figure]:
        figures: list[Figure] = getattr(import_module(f"bench.{module}"), function)(**options)
        return figures

    return measured


GROUPS: dict[str, Callable[[], list[Figure]]] = {
    "sticks": _later("kernels", "stick_figures"),
    "spectra": _later("kernels", "spectrum_figures"),
    "building": _later("building", "building_figures"),
    "transient": _later("transient", "transient_figures"),
    "dampings": _later("transient", "transient_figures", every_damping=True),
    "basis": _later("transient", "basis_figures"),
    "wall": _later("building", "wall_figures"),
}
QUICK = ("sticks", "spectra")
"""Groups that run when none is named: those that take seconds."""


def measure(groups: Sequence[str] = (), json_file: Path | None = None) -> list[Figure]:
    """Measure figures.

    Args:
        groups: Names of groups; those that take seconds when empty.
        json_file: Where to write them as JSON; nowhere when None.

    Raises:
        InputError: There is no such group.
        ImpactfemError: The file cannot be written, or the source tree is missing.
    """
    expected = f"expected one of the groups {', '.join(GROUPS)}"
    faults = [Fault("command line", "GROUP", g, expected) for g in groups if g not in GROUPS]
    if faults:
        raise InputError(faults)
    figures = []
    # No bar: it would be drawn ten times a second while something is measured.
    steps = Steps(dict.fromkeys(groups or QUICK, 1.0), "bench", bar=False)
    with one_blas_thread(), steps:
        for group in groups or QUICK:
            with steps.step(group):
                figures += GROUPS[group]()
    if json_file is not None:
        write_json(json_file, [{**asdict(figure), "met": figure.met} for figure in figures])
    return figures
