"""Penalty parameters from one impact on the wall: equations 4, 5 and 6 of the paper."""

from __future__ import annotations

from dataclasses import dataclass

from impactfem.coupling.restitution import kelvin_voigt_phase, kelvin_voigt_xi
from impactfem.stages.calibrate.impact import WallImpact
from impactfem.system.errors import SolutionError


@dataclass(frozen=True)
class PenaltyParameters:
    """What makes a mass on Kelvin-Voigt contact behave like the floor at the wall.

    Args:
        epsilon: Restitution ε [-].
        xi_c: Damping ratio at contact ξ_c [-].
        K_Ceq: Penalty stiffness [N/m].
        tension: Whether the contact may pull at its end.
    """

    epsilon: float
    xi_c: float
    K_Ceq: float
    tension: bool


def penalty_parameters(
    impact: WallImpact, *, tension: bool = True, at_end: bool = False
) -> PenaltyParameters:
    """Parameters of the penalty law from the impulse, approach velocity and duration of an impact.

        ε = P / (M u̇⁻) - 1                     (5)
        ξ_c = -ln ε / √(π² + ln² ε)             (4)
        K_Ceq = M / (1 - ξ_c²) (π / Δt_c)²      (6)

    P is the largest impulse, as in the paper. Where the wall only pushes, that is the one at the
    end of the impact; where the force pulls at its end, as that of the law itself, only the impulse
    at the end gives the ε and ξ_c back with which a free mass was computed, and Δt_c the K_Ceq.

    A law that may not pull has other relations of ε, ξ_c and the duration; theirs are used with
    `tension` false: K_Ceq = M (φ / Δt_c)² with the law's phase φ, in equation 6 π / √(1 - ξ_c²).

    All three take the floor for a free mass, but the forces of its building act during the impact.
    In the paper's experiment they push it towards the wall, because the floors below move on
    while it is stopped: they add to the impulse and lengthen the impact, so that ε comes out
    larger and K_Ceq smaller than those of a law with which the stick runs. A mass on one spring
    behind a gap is pulled back instead: ε comes out smaller.

    Args:
        impact: A complete impact.
        tension: Whether the contact of the law may pull at its end.
        at_end: Take the impulse at the end of the impact for P, not the largest.

    Raises:
        SolutionError: The floor did not approach the wall, or ε is not above 0 and at most 1.
    """
    momentum = impact.mass * impact.approach
    if not impact.approach > 0.0:
        raise SolutionError(
            f"the approach velocity of floor {impact.floor} before its impact at "
            f"{impact.start:.4g} s is {impact.approach:.4g} m/s, not positive: its mass centre "
            "does not move towards the wall, and equation 5 gives no restitution"
        )
    epsilon = impact.epsilon_at_end if at_end else impact.epsilon
    impulse = impact.impulse if at_end else impact.largest_impulse
    if not 0.0 < epsilon <= 1.0:
        raise SolutionError(
            f"equation 5 gives the restitution {epsilon:.4g} for floor {impact.floor}, expected "
            f"above 0 and at most 1: impulse {1e-3 * impulse:.4g} kN s, momentum "
            f"before the impact {1e-3 * momentum:.4g} kN s; the longer the impact, the more of the "
            "impulse is that of the building's own forces"
        )
    xi_c = kelvin_voigt_xi(epsilon, tension=tension)
    phase = kelvin_voigt_phase(xi_c, tension=tension)
    K_Ceq = impact.mass * (phase / impact.duration) ** 2
    return PenaltyParameters(epsilon, xi_c, K_Ceq, tension)
