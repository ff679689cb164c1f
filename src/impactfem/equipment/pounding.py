"""Impact forces of the sticks for another damping and another restitution."""

from __future__ import annotations

from impactfem.case import Case, DampingCase, KelvinVoigtLaw
from impactfem.motion.from_case import GroundMotion
from impactfem.sticks.calibration import Calibration
from impactfem.sticks.force_history import ForceHistory
from impactfem.sticks.from_case import system_of
from impactfem.sticks.pounding import interpolate_ground, simulate


def damped_case(case: Case, damping: DampingCase, epsilon: float | None) -> Case:
    """The case with another damping of all buildings, and another restitution.

    The contact stiffness stays (paper, section 5.3).

    Args:
        case: The case.
        damping: The damping case.
        epsilon: Restitution of its Kelvin-Voigt laws; they keep theirs when None.
    """
    buildings = tuple(b.model_copy(update={"damping": damping}) for b in case.buildings)
    update: dict[str, object] = {"buildings": buildings}
    if epsilon is not None:
        given = {"restitution": epsilon, "damping_ratio": None}
        update["contact_laws"] = {
            name: law.model_copy(update=given) if isinstance(law, KelvinVoigtLaw) else law
            for name, law in case.contact_laws.items()
        }
    return case.model_copy(update=update)


def impact_forces(
    case: Case,
    calibration: Calibration | None,
    motions: tuple[GroundMotion, ...],
    duration: float,
) -> ForceHistory:
    """Run the pounding of the sticks.

    Args:
        case: The case, with the damping and the laws that are meant.
        calibration: Of the sticks, which does not depend on damping.
        motions: The ground motions.
        duration: Time that is computed [s].

    Raises:
        SolutionError: The contact forces do not converge, or lagged ones create energy.
    """
    system = system_of(case, calibration)
    dt = case.pounding.time_step
    along = [
        ("xyz".index(m.direction), m.accelerogram.time_step, m.accelerogram.acceleration)
        for m in motions
    ]
    ground = interpolate_ground(along, dt, int(duration / dt) + 2)
    response = simulate(system, ground, dt, update=case.pounding.update)
    names = tuple(pair.name for pair in system.pairs)
    return ForceHistory(response.time, names, response.force)
