"""The groups of `impactfem bench`, the table of their figures, and watches for what calls take."""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import wraps
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from rich.table import Table

from impactfem.system.errors import Fault, InputError
from impactfem.system.files import write_json
from impactfem.system.log import Steps
from impactfem.system.parallel import one_blas_thread

T = TypeVar("T")


@dataclass(frozen=True)
class Figure:
    """One performance figure."""

    name: str  #: what is measured
    value: float
    unit: str
    target: float | None = None  #: what it should reach; None where it is only reported
    at_most: bool = True  #: whether the target is an upper bound

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None without one."""
        if self.target is None:
            return None
        return self.value <= self.target if self.at_most else self.value >= self.target


def as_table(figures: list[Figure]) -> Table:
    """The figures for a terminal."""
    table = Table("figure", "value", "unit", "goal on an idle machine", "")
    for figure in figures:
        sign = "≤" if figure.at_most else "≥"
        target = "" if figure.target is None else f"{sign} {figure.target:.3g}"
        verdict = {True: "met", False: "not reached", None: ""}[figure.met]
        table.add_row(figure.name, f"{figure.value:.3g}", figure.unit, target, verdict)
    return table


def timed(run: Callable[[], T]) -> tuple[T, float]:
    """What a function gives, and its wall time [s]."""
    start = time.perf_counter()
    return run(), time.perf_counter() - start


def best_time(run: Callable[[], object], repeats: int) -> float:
    """Shortest of several wall times [s]; a first run, which may compile, does not count."""
    run()
    return min(timed(run)[1] for _ in range(repeats))


class Watch:
    """Wall time and operations by label; of nested functions each has its own part alone.

    What a second thread does meanwhile takes no time of its own: its operations count for what the
    main thread does.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self.operations: dict[str, float] = defaultdict(float)
        self._inside = [0.0]
        self._labels: list[str] = []

    @contextmanager
    def on(
        self, owner: Any, name: str, label: str, operations: Callable[..., float]
    ) -> Iterator[None]:
        """Watch a function or method while the block runs.

        Args:
            owner: Its module or class.
            name: Its name there.
            label: What it counts for.
            operations: Floating-point operations of a call, from its arguments; called after it.
        """
        right = getattr(owner, name)

        @wraps(right)
        def watched(*arguments: Any, **options: Any) -> Any:
            if threading.current_thread() is not threading.main_thread():
                found = right(*arguments, **options)
                doing = self._labels[-1] if self._labels else label
                self.operations[doing] += operations(*arguments, **options)
                return found
            self._inside.append(0.0)
            self._labels.append(label)
            try:
                found, passed = timed(lambda: right(*arguments, **options))
            finally:
                inside = self._inside.pop()
                self._labels.pop()
            self.seconds[label] += passed - inside
            self._inside[-1] += passed
            self.operations[label] += operations(*arguments, **options)
            return found

        setattr(owner, name, watched)
        try:
            yield
        finally:
            setattr(owner, name, right)


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
    "pounding": _later("pounding", "pounding_figures"),
    "fit": _later("fit", "fit_figures"),
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
