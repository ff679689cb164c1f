"""The groups of performance figures of `impactfem bench`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

from bench.figure import Figure
from bench.spectra import spectrum_figures
from bench.sticks import stick_figures
from impactfem.system.errors import Fault, InputError
from impactfem.system.files import write_json
from impactfem.system.log import Steps
from impactfem.system.parallel import one_blas_thread


def _building() -> list[Figure]:
    # dolfinx is loaded only when it is needed.
    from bench.building import building_figures

    return building_figures()


def _transient() -> list[Figure]:
    from bench.transient import transient_figures

    return transient_figures()


def _dampings() -> list[Figure]:
    from bench.transient import transient_figures

    return transient_figures(every_damping=True)


def _wall() -> list[Figure]:
    from bench.wall import wall_figures

    return wall_figures()


GROUPS: dict[str, Callable[[], list[Figure]]] = {
    "sticks": stick_figures,
    "spectra": spectrum_figures,
    "building": _building,
    "transient": _transient,
    "dampings": _dampings,
    "wall": _wall,
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
