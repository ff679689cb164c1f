"""The performance figures of `impactfem bench`."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from rich.table import Table

from impactfem.case import load_case
from impactfem.files import write_json
from impactfem.motion.from_case import ground_motions
from impactfem.spectra.throughput import measure_throughput
from impactfem.sticks.from_case import calibration_of, system_of
from impactfem.sticks.pounding import interpolate_ground, simulate
from impactfem.verify.sticks import shipped_case

STEPS = 50_000


@dataclass(frozen=True)
class Figure:
    """One performance figure.

    Args:
        name: What is measured.
        value: The figure.
        unit: Its unit.
        target: What it should reach; None where it is only told.
        at_most: Whether the target is an upper bound.
    """

    name: str
    value: float
    unit: str
    target: float | None = None
    at_most: bool = True

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None without one."""
        if self.target is None:
            return None
        return self.value <= self.target if self.at_most else self.value >= self.target


def measure(json_file: Path | None = None) -> list[Figure]:
    """Measure all figures.

    Args:
        json_file: Where to write them as JSON; nowhere when None.

    Raises:
        ImpactfemError: The file cannot be written, or the source tree is missing.
    """
    figures = [*_pounding(), *_oscillators()]
    if json_file is not None:
        write_json(json_file, [{**asdict(figure), "met": figure.met} for figure in figures])
    return figures


def as_table(figures: list[Figure]) -> Table:
    """The figures for a terminal."""
    table = Table("figure", "value", "unit", "target", "")
    for figure in figures:
        sign = "≤" if figure.at_most else "≥"
        target = "" if figure.target is None else f"{sign} {figure.target:.3g}"
        verdict = {True: "met", False: "MISSED", None: ""}[figure.met]
        table.add_row(figure.name, f"{figure.value:.3g}", figure.unit, target, verdict)
    return table


def _pounding() -> list[Figure]:
    """The two 8-floor buildings of the paper, all 96 degrees of freedom, 50,000 steps."""
    case = load_case(shipped_case("npp_pair.toml"))
    start = time.perf_counter()
    calibration = calibration_of(case)
    calibrated = time.perf_counter() - start
    system = system_of(case, calibration)
    motions = ground_motions(case.motions)
    dt = case.pounding.time_step
    histories = [
        ("xyz".index(m.direction), m.accelerogram.time_step, m.accelerogram.acceleration)
        for m in motions
    ]
    ground = interpolate_ground(histories, dt, STEPS + 1)
    simulate(system, ground[:10], dt)
    whole = _best(lambda: simulate(system, ground, dt), 5)
    return [
        Figure("pounding, 50,000 steps of two 8-floor buildings", whole, "s", 0.3),
        Figure("pounding, degrees of freedom", float(system.M.shape[0]), "-"),
        Figure("pounding, time a step", 1e6 * whole / STEPS, "µs"),
        Figure("calibration of the sticks", calibrated, "s"),
    ]


def _oscillators() -> list[Figure]:
    rates = measure_throughput()
    unit = "record·frequency·sample/s"
    return [
        Figure("oscillator kernel, one core", rates.kernel, unit, 1.5e9, at_most=False),
        Figure("plain compiled scalar loop, one core", rates.plain_loop, unit),
        Figure("scipy lfilter, one core", rates.lfilter, unit),
        Figure("kernel over plain loop", rates.kernel / rates.plain_loop, "-"),
        Figure("kernel over lfilter", rates.kernel / rates.lfilter, "-"),
    ]


def _best(run: Callable[[], object], repeats: int) -> float:
    """Shortest of several wall times [s]."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)
