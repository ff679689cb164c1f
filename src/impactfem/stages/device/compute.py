"""The stage `device`: devices in the 3D model and by response spectra, for every damping case."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from impactfem.building.bending_wave import mesh_limit
from impactfem.case import BuildingInTime, Case, DampingCase, DeviceAnalysis, KelvinVoigtLaw
from impactfem.case.damping import OWN
from impactfem.case.quantity import CALIBRATED
from impactfem.coupling.force_history import ForceHistory
from impactfem.coupling.from_case import calibration_of
from impactfem.device.from_case import checked_devices, rules_of
from impactfem.device.spectrum import given_spectra
from impactfem.device.spectrum_analysis import SpectrumResponse
from impactfem.dynamics.damping import DampingLaw
from impactfem.reduction.loads import Loads
from impactfem.reduction.models_3d import Models3D
from impactfem.reduction.probes import CoveredPoints, covered_points
from impactfem.reduction.reduced_building import CompleteModel
from impactfem.spectra.resolved import POINTS, ResolvedBand, refinement_limit, step_limit
from impactfem.stages.device.analysis import (
    Analyst,
    DeviceResult,
    SpectrumPlan,
    Support,
    supports_of,
)
from impactfem.stages.device.choice import SpectrumChoice
from impactfem.stages.pounding.compute import pounded
from impactfem.stages.transient.prepared import Prepared as PreparedBuilding
from impactfem.stages.transient.prepared import case_loads
from impactfem.sticks.calibration import Calibration
from impactfem.system.log import LOGGER, Steps
from impactfem.system.parallel import on_root
from impactfem.system.quantity import results, si


@dataclass(frozen=True, eq=False)
class Prepared(PreparedBuilding):
    """What a run needs in addition to the matrices; the loads are those with the own damping."""

    points: CoveredPoints  #: further points, which envelopes of spectra cover
    plans: tuple[SpectrumPlan, ...]  #: response spectrum analyses of each device
    #: contact laws that left their restitution to the impact on the wall; empty where none did
    calibrated_laws: frozenset[str]
    restitution: Mapping[str, float]  #: what that gave by damping case; empty where there is none
    #: the 3D models that pound, for other dampings; None where all buildings are sticks
    models: Models3D | None = None


def prepare_devices(
    prepared: PreparedBuilding,
    calibrated_laws: frozenset[str] = frozenset(),
    restitution: Mapping[str, float] | None = None,
) -> Prepared:
    """Build the devices for what the stage `transient` has of a building. Not collective.

    What the impact on the wall gave: contact laws that left their restitution to it, and this by
    damping case.

    Raises:
        InputError: A device is not usable.
        SolutionError: An anchor stands on no node of a floor.
    """
    building = prepared.building
    analysis = _analysis_of(building)
    return Prepared(
        **vars(prepared),
        points=covered_points(building, prepared.parts.mesh),
        plans=tuple(
            SpectrumPlan(
                device,
                rules=rules_of(analysis, setup.maximum_frequency),
                rotations=analysis.rotations,
                broadening=analysis.broadening,
                supports=analysis.supports,
                given=given_spectra(setup.spectra or ()),
            )
            for device, setup in zip(checked_devices(building), building.devices, strict=True)
        ),
        calibrated_laws=calibrated_laws,
        restitution=restitution or {},
    )


def _analysis_of(building: BuildingInTime) -> DeviceAnalysis:
    if building.device_analysis is None:
        raise ValueError(f"{building.name} has no devices")
    return building.device_analysis


@results
class DampedStudy:
    """The devices with one damping of the buildings."""

    name: str  #: name of the damping case
    damping: DampingLaw
    epsilon: float | None = si("-", "restitution of the contact laws, nan if they keep theirs")
    calibrated: bool = si(
        "", "whether the impact on the wall gives the restitution", name="epsilon_calibrated"
    )
    impact_force: float = si("N", "largest impact force, at the time steps of the 3D model")
    #: the devices without the impacts, and with them
    results: tuple[list[DeviceResult], list[DeviceResult]]


@results
class DeviceStudy:
    """Results of the stage."""

    prepared: Prepared  #: its inputs
    basis_vectors: int = si("", "number of basis vectors of the reduced model")
    basis_error: float = si("-", "error estimate of the reduced model, transfer functions")
    cases: tuple[DampedStudy, ...]  #: the devices by damping; that of the building's own first
    #: Limit of the resolved band by forces with another time step [Hz]; infinite where not known.
    refinement: float

    def band(self, contact: float) -> ResolvedBand:
        """Return the resolved band at the anchors; the limit of the contact law is given [Hz]."""
        building, step = self.prepared.building, self.prepared.loads.time_step
        spectra = building.case.spectra
        last = float(spectra.frequency_values[-1])
        points = spectra.points_per_cycle if spectra.method == "upsampled" else 1.0 / (step * last)
        return ResolvedBand(
            time_step=step_limit(step),
            oscillators=last * min(1.0, points / POINTS),
            mesh=mesh_limit(self.prepared.parts),
            basis=building.transient.maximum_frequency,
            contact=contact,
            refinement=self.refinement,
        )

    @property
    def supports(self) -> tuple[Support, ...]:
        """The anchors of all devices, which results are reported for."""
        return supports_of(self.prepared.plans)

    @property
    def analyses(self) -> list[tuple[str, SpectrumChoice, SpectrumResponse]]:
        """Anchor, choice and response of all response spectrum analyses, with impacts first."""
        return [
            (result.support.name, choice, response)
            for one in self.cases
            for result in (*one.results[1], *one.results[0])
            for choice, response in result.by_spectrum.items()
        ]


def analyst_of(prepared: Prepared, model: CompleteModel) -> Analyst:
    """What analyses the devices under any load on a reduced model, as the case asks."""
    return Analyst(
        model=model,
        plans=prepared.plans,
        positions=np.array([one.point for one in prepared.base_plates]),
        covered=prepared.points.of_anchor,
        spectra=prepared.building.case.spectra,
        substeps=_substeps_of(prepared.building),
    )


def run_devices(
    prepared: Prepared, steps: Steps, *, model: CompleteModel | None
) -> DeviceStudy | None:
    """Run the stage; return its results on rank 0. Collective.

    The case of the building has the targets of its sticks and the numbers of its contact laws,
    `prepared` is the same on all ranks, and the model is on rank 0.

    Raises:
        ImpactfemError: A spectrum does not reach a mode of a device.
        SolutionError: A response is not finite.
    """
    found: list[DeviceStudy] = []  # not sent to the other ranks

    def evaluate() -> None:
        if model is None:
            raise ValueError("rank 0 has no reduced model")
        with steps.step("damping cases"):
            found.append(_study(prepared, model, steps))

    on_root(evaluate)
    return found[0] if found else None


def _study(prepared: Prepared, model: CompleteModel, steps: Steps) -> DeviceStudy:
    """Analyse the devices with the building's own damping, then with every damping case."""
    case = prepared.building.case
    analyst, count = analyst_of(prepared, model), 1 + len(case.damping_cases)
    cases = [_damped(analyst, OWN, prepared.damping, prepared.loads)]
    steps.within("damping cases", 1.0 / count)
    # The sticks are fitted once: their stiffness does not depend on the damping.
    calibration = calibration_of(case) if case.damping_cases else None
    for number, damping_case in enumerate(case.damping_cases, 2):
        cases.append(_damping_case(prepared, analyst, damping_case, calibration))
        steps.within("damping cases", number / count)
    if _analysis_of(prepared.building).envelope_dampings and case.damping_cases:
        both = zip(
            analyst.over_dampings([one.results[0] for one in cases]),
            analyst.over_dampings([one.results[1] for one in cases]),
            strict=True,
        )
        cases = [replace(one, results=results) for one, results in zip(cases, both, strict=True)]
    vectors, error = len(model.eigenvalue), model.difference
    refinement = _refinement(analyst, prepared, cases[0])
    return DeviceStudy(prepared, vectors, error, tuple(cases), refinement)


def _refinement(analyst: Analyst, prepared: Prepared, own: DampedStudy) -> float:
    """Return the limit of the resolved band by forces with another time step [Hz]."""
    other = prepared.other_loads
    if other is None:
        return math.inf
    psa = np.array([result.psa for result in own.results[1]])
    changed = analyst.anchor_spectra(other, prepared.damping)
    frequency = np.asarray(analyst.spectra.frequency_values)
    return refinement_limit(frequency, psa, changed, other.time_step / prepared.loads.time_step)


def _damping_case(
    prepared: Prepared,
    analyst: Analyst,
    one: DampingCase,
    calibration: Calibration | None,
) -> DampedStudy:
    """Restitution, sticks, 3D model and devices again with another damping."""
    building = prepared.building
    forces_file = building.transient.forces
    if forces_file is not None:
        # Nothing is known of what another damping would do to forces from elsewhere.
        LOGGER.debug("device: damping case %s with the forces of %s", one.name, forces_file)
        return _damped(analyst, one.name, one.law, prepared.loads)
    calibrated = one.name in prepared.restitution
    epsilon = prepared.restitution.get(one.name)
    if one.restitution != CALIBRATED:
        epsilon = float(one.restitution)
    laws = prepared.calibrated_laws if calibrated else ()
    damped = replace(building, case=damped_case(building.case, one, epsilon, laws))
    motions, path = prepared.motions, building.case.path
    duration = prepared.loads.time_step * (len(prepared.loads.ground) - 1)
    response = pounded(damped.case, calibration, motions, duration, prepared.models)
    forces, mesh = ForceHistory.of_response(response), prepared.parts.mesh
    loads = case_loads(damped, mesh, motions, forces, path, duration, impulses=prepared.impulses)
    LOGGER.debug("device: damping case %s with the restitution %s", one.name, epsilon)
    return _damped(analyst, one.name, one.law, loads, epsilon, calibrated=calibrated)


def _damped(
    analyst: Analyst,
    name: str,
    damping: DampingLaw,
    loads: Loads,
    epsilon: float | None = None,
    *,
    calibrated: bool = False,
) -> DampedStudy:
    both = analyst.analyse(loads.without_impacts(), damping), analyst.analyse(loads, damping)
    largest = float(loads.impact_force.max(initial=0.0))
    return DampedStudy(name, damping, epsilon, calibrated, largest, both)


def damped_case(
    case: Case, damping: DampingCase, epsilon: float | None, laws: Collection[str] = ()
) -> Case:
    """The case with another damping of all buildings, and another restitution.

    The contact stiffness stays (paper, section 5.3). The restitution is that of the Kelvin-Voigt
    laws with these names, or of all where none is named; they keep theirs when it is None.
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


def _substeps_of(building: BuildingInTime) -> int:
    """Steps of the detailed analysis in one of the loads."""
    whole = building.transient.time_step
    return max(1, math.ceil(whole / (_analysis_of(building).time_step or whole) * (1.0 - 1e-9)))
