"""Impact forces of the sticks for another damping and another restitution."""

from __future__ import annotations

from collections.abc import Collection

from impactfem.case import Case, DampingCase, KelvinVoigtLaw
from impactfem.coupling.force_history import ForceHistory
from impactfem.motion.from_case import GroundMotion
from impactfem.stages.pounding.pounded import pounded
from impactfem.sticks.calibration import Calibration


def damped_case(
    case: Case,
    damping: DampingCase,
    epsilon: float | None,
    laws: Collection[str] = (),
) -> Case:
    """The case with another damping of all buildings, and another restitution.

    The contact stiffness stays (paper, section 5.3).

    Args:
        case: The case.
        damping: The damping case.
        epsilon: Restitution of its Kelvin-Voigt laws; they keep theirs when None.
        laws: Names of those that it is for; all of them when empty.
    """
    buildings = tuple(b.model_copy(update={"damping": damping}) for b in case.buildings)
    update: dict[str, object] = {"buildings": buildings}
    if epsilon is not None:
        given = {"restitution": epsilon, "damping_ratio": None}
        update["contact_laws"] = {
            name: law.model_copy(update=given)
            if isinstance(law, KelvinVoigtLaw) and (not laws or name in laws)
            else law
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
    return ForceHistory.of_response(pounded(case, calibration, motions, duration))
