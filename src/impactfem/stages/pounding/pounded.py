"""The pounding of the sticks of a case under given ground motions, over a given time."""

from __future__ import annotations

from collections.abc import Sequence

from impactfem.case import Case
from impactfem.coupling.from_case import loads_of, system_of
from impactfem.coupling.pounding import Response, interpolate_ground, simulate
from impactfem.motion.from_case import GroundMotion
from impactfem.sticks.calibration import Calibration


def pounded(
    case: Case,
    calibration: Calibration | None,
    motions: Sequence[GroundMotion],
    duration: float,
) -> Response:
    """Run the pounding of the sticks.

    Args:
        case: The case, with the damping and the laws that are meant.
        calibration: Of the sticks, which does not depend on damping.
        motions: The ground motions.
        duration: Time that is computed, to the end of a step at least [s].

    Raises:
        SolutionError: The contact forces do not converge, or lagged ones create energy.
    """
    dt = case.pounding.time_step
    ground = interpolate_ground([m.history for m in motions], dt, int(duration / dt) + 2)
    system = system_of(case, calibration)
    loads = loads_of(case, system, dt, len(ground))
    return simulate(system, ground, dt, update=case.pounding.update, loads=loads)
