"""Speed of the sticks: calibration and pounding of the paper's two buildings."""

from __future__ import annotations

import time

from bench.figure import Figure
from bench.timing import best_time
from impactfem.case import load_case
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.coupling.pounding import interpolate_ground, simulate
from impactfem.motion.from_case import ground_motions
from impactfem.system.files import in_source_tree

STEPS = 50_000


def stick_figures() -> list[Figure]:
    """The two 8-floor buildings of the paper, all 96 degrees of freedom, 50,000 steps."""
    case = load_case(in_source_tree("geometry/npp_pair.toml"))
    start = time.perf_counter()
    calibration = calibration_of(case)
    calibrated = time.perf_counter() - start
    system = system_of(case, calibration)
    motions = ground_motions(case.motions)
    dt = case.pounding.time_step
    ground = interpolate_ground([m.history for m in motions], dt, STEPS + 1)
    whole = best_time(lambda: simulate(system, ground, dt), 5)
    return [
        Figure("pounding, 50,000 steps of two 8-floor buildings", whole, "s", 0.3),
        Figure("pounding, degrees of freedom", float(system.M.shape[0]), "-"),
        Figure("pounding, time a step", 1e6 * whole / STEPS, "µs"),
        Figure("calibration of the sticks", calibrated, "s"),
    ]
