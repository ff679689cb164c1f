"""The devices with the building's own damping, then again with every damping case."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

from impactfem.case import Case, DampingCase, KelvinVoigtLaw
from impactfem.case.damping import OWN
from impactfem.case.quantity import CALIBRATED
from impactfem.coupling.force_history import ForceHistory
from impactfem.coupling.from_case import calibration_of
from impactfem.dynamics.damping import Rayleigh
from impactfem.motion.from_case import GroundMotion
from impactfem.reduction.loads import Loads
from impactfem.reduction.reduced_building import CompleteModel
from impactfem.stages.device.analysis import Analyst, DeviceResult, with_detailed
from impactfem.stages.device.full_run import FullHistories
from impactfem.stages.device.prepared import Prepared, analysis_of
from impactfem.stages.device.support import Support, supports_of
from impactfem.stages.pounding.compute import pounded
from impactfem.stages.transient.prepared import case_loads, transient_of
from impactfem.sticks.calibration import Calibration
from impactfem.system.log import LOGGER


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


@dataclass(frozen=True, eq=False)
class DampedStudy:
    """The devices with one damping of the buildings.

    Args:
        name: Name of the damping case.
        damping: The damping.
        epsilon: Restitution of the pounding; None where the laws kept theirs.
        calibrated: Whether it comes from the impact on the wall with this damping.
        loads: Ground motion and impacts.
        no_impact: The devices without the impacts.
        impact: The devices with them.
    """

    name: str
    damping: Rayleigh
    epsilon: float | None
    calibrated: bool
    loads: Loads
    no_impact: tuple[DeviceResult, ...]
    impact: tuple[DeviceResult, ...]


@dataclass(frozen=True, eq=False)
class DeviceStudy:
    """What the stage computed.

    Args:
        case: The case.
        prepared: What it was given.
        model: The reduced model.
        cases: The devices by damping; that of the building's own first.
        full_error: With the detailed analysis in full order the largest relative difference of a
            peak force by the reduced model from it, both at the same step; None otherwise.
    """

    case: Case
    prepared: Prepared
    model: CompleteModel
    cases: tuple[DampedStudy, ...]
    full_error: float | None = None

    @property
    def supports(self) -> tuple[Support, ...]:
        """The anchors of all devices, which results are told of."""
        return supports_of(self.prepared.devices)

    @property
    def direction(self) -> int:
        """Component of the first ground motion."""
        return "xyz".index(self.case.shown_direction)


def device_study(
    case: Case,
    prepared: Prepared,
    analyst: Analyst,
    full: FullHistories | None = None,
    progress: Callable[[float], None] = lambda part: None,
) -> DeviceStudy:
    """Analyse the devices with every damping. Not collective.

    Args:
        case: The case, with the targets of its sticks and the numbers of its contact laws.
        prepared: What `prepare` gave.
        analyst: Of the devices by the reduced model.
        full: The devices in full order with the building's own damping; None without.
        progress: Called with the part of the work that is done.

    Raises:
        ImpactfemError: A spectrum does not reach a mode of a device.
        SolutionError: A response is not finite.
    """
    calibration = calibration_of(case) if case.damping_cases else None
    count = 1 + len(case.damping_cases)
    cases = [_damped(analyst, OWN, prepared.own, None, calibrated=False, loads=prepared.loads)]
    full_error = None
    if full is not None:
        own = cases[0]
        cases[0] = replace(
            own,
            no_impact=with_detailed(own.no_impact, full[0]),
            impact=with_detailed(own.impact, full[1]),
        )
        full_error = _largest_error(own, cases[0])
    progress(1.0 / count)
    for number, one in enumerate(case.damping_cases, 2):
        cases.append(_damping_case(case, prepared, analyst, one, calibration))
        progress(number / count)
    if analysis_of(case).envelope_dampings and case.damping_cases:
        quiet = analyst.over_dampings([one.no_impact for one in cases])
        pounded = analyst.over_dampings([one.impact for one in cases])
        cases = [
            replace(one, no_impact=without, impact=with_them)
            for one, without, with_them in zip(cases, quiet, pounded, strict=True)
        ]
    return DeviceStudy(case, prepared, analyst.model, tuple(cases), full_error)


def _largest_error(reduced: DampedStudy, full: DampedStudy) -> float:
    """Largest relative difference of a peak force, each along the axis of the largest one."""
    worst = 0.0
    for found, known in (
        *zip(reduced.no_impact, full.no_impact, strict=True),
        *zip(reduced.impact, full.impact, strict=True),
    ):
        peak = known.detailed.largest[:3]
        axis = int(peak.argmax())
        if peak[axis] > 0.0:
            worst = max(worst, abs(float(found.detailed.largest[axis] / peak[axis]) - 1.0))
    return worst


def _damping_case(
    case: Case,
    prepared: Prepared,
    analyst: Analyst,
    one: DampingCase,
    calibration: Calibration | None,
) -> DampedStudy:
    """Restitution, sticks, 3D model and devices again with another damping."""
    transient = transient_of(case)
    if transient.forces is not None:
        # Nothing is known of what another damping would do to forces from elsewhere.
        LOGGER.info("device: damping case %s with the forces of %s", one.name, transient.forces)
        return _damped(
            analyst, one.name, one.rayleigh, None, calibrated=False, loads=prepared.loads
        )
    calibrated = one.name in prepared.restitution
    epsilon = prepared.restitution.get(one.name)
    if one.restitution != CALIBRATED:
        epsilon = float(one.restitution)
    laws = prepared.calibrated_laws if calibrated else ()
    damped = damped_case(case, one, epsilon, laws)
    duration = prepared.loads.time_step * (len(prepared.loads.ground) - 1)
    forces = impact_forces(damped, calibration, prepared.motions, duration)
    mesh = prepared.parts.mesh
    loads = case_loads(damped, mesh, prepared.motions, forces, case.path, duration)
    LOGGER.debug("device: damping case %s with the restitution %s", one.name, epsilon)
    return _damped(analyst, one.name, one.rayleigh, epsilon, calibrated=calibrated, loads=loads)


def _damped(
    analyst: Analyst,
    name: str,
    damping: Rayleigh,
    epsilon: float | None,
    *,
    calibrated: bool,
    loads: Loads,
) -> DampedStudy:
    quiet = loads.without_impacts()
    return DampedStudy(
        name=name,
        damping=damping,
        epsilon=epsilon,
        calibrated=calibrated,
        loads=loads,
        no_impact=tuple(analyst.analyse(quiet, damping)),
        impact=tuple(analyst.analyse(loads, damping)),
    )
