"""The stage `calibrate`: the 3D model against a rigid wall, and the stick that stands for it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from impactfem.building.floor import contact_edge
from impactfem.building.from_case import read_parts
from impactfem.building.parts import BuildingParts
from impactfem.case import BuildingAtWall
from impactfem.case.damping import OWN
from impactfem.case.quantity import CALIBRATED
from impactfem.coupling.contact_loop import ContactHistory, Motion
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.coupling.massless import MasslessPoints, massless_response, strip_stiffness
from impactfem.coupling.modal_motion import ModalMotion, body_before_walls
from impactfem.coupling.unilateral import unilateral_response
from impactfem.dynamics.damping import DampingLaw
from impactfem.reduction.pounding_3d import contact_frequency
from impactfem.reduction.wall import WallModel, wall_side
from impactfem.stages.calibrate.experiment import WallExperiment, WallHistory, run_stick
from impactfem.stages.calibrate.impact import (
    FloorImpacts,
    PenaltyParameters,
    WallComparison,
    compare,
    floor_impacts,
    penalty_parameters,
)
from impactfem.system.arrays import Array, Index
from impactfem.system.log import Step
from impactfem.system.quantity import quantity, results


@dataclass(frozen=True, eq=False)
class SoftPoints:
    """Contact points without mass, on edges with a compliance."""

    shift: float  #: σ of `MasslessPoints` [1/s2]
    compliance: Array  #: of the edge at each point, shape (m,) [m/N]


@dataclass(frozen=True, eq=False)
class Prepared:
    """What a run needs in addition to the matrices."""

    parts: BuildingParts  #: the building
    mass: Array  #: masses of the floors that may hit, shape (n_floors,) [kg]
    experiment: WallExperiment
    #: The building's own damping, then by name that of each damping case with a calibrated
    #: restitution.
    dampings: dict[str, DampingLaw]
    position: Array  #: place of each contact constraint along its edge, shape (m,) [m]
    length: Array  #: length of edge that it stands for, shape (m,) [m]
    soft: SoftPoints | None  #: contact points without mass; None with Moreau's scheme


@dataclass(frozen=True, eq=False)
class BuildingRun:
    """Histories of the floors of the 3D model; those of its constraints, with the energies."""

    history: WallHistory
    contact: ContactHistory


@dataclass(frozen=True, eq=False)
class DampedRun:
    """The experiment with one damping of the building."""

    name: str
    damping: DampingLaw
    run: BuildingRun  #: what the 3D model did
    impacts: tuple[FloorImpacts, ...]  #: impacts of its floors that may hit, bottom to top
    penalty: PenaltyParameters  #: ε, ξ_c and K_Ceq from the top one of them


@results
class CalibrationStudy:
    """What the stage computed."""

    building: BuildingAtWall
    prepared: Prepared  #: what it was given
    model: WallModel  #: the reduced 3D model
    cases: tuple[DampedRun, ...]  #: the experiment by damping; that of the building's own first
    stick: WallHistory  #: histories of the stick with the penalty parameters of the first one
    comparison: WallComparison  #: stick and 3D model at the top one of the floors that may hit

    def _dissipated(self, energy: Array) -> float:
        """Growth of an energy during the first impact with the building's own damping [J]."""
        impact = self.cases[0].impacts[-1].first_complete()
        return float(energy[impact.last] - energy[impact.first - 1])

    @property
    @quantity("J", "energy dissipated by the contact nodes in the first impact", shown="kJ")
    def contact_dissipation(self) -> float:
        """Energy that the contact nodes lose in the first impact; it falls with mesh and step."""
        return -self._dissipated(self.cases[0].run.contact.energy.contact)

    @property
    @quantity("J", "energy dissipated in the first impact, damping and contact", shown="kJ")
    def energy_dissipated(self) -> float:
        """Energy that damping, time stepping and contact take in the first impact."""
        energy = self.cases[0].run.contact.energy
        return self._dissipated(energy.damped + energy.numerical) + self.contact_dissipation

    @property
    @quantity("-", "residual of the energy balance")
    def energy_residual(self) -> float:
        """Residual of the energy balance of the first damping case."""
        return self.cases[0].run.contact.energy.residual

    @property
    @quantity("-", "energy gained by the contact")
    def energy_gained(self) -> float:
        """Largest work of the contact within a step over the largest energy."""
        return self.cases[0].run.contact.energy.gained

    @property
    @quantity("m", "largest penetration of a contact point", shown="mm")
    def penetration(self) -> float:
        """Largest penetration of a contact point."""
        return float(self.cases[0].run.contact.penetration.max())

    @property
    @quantity("-", "error estimate of the reduced model, transfer functions")
    def basis_error(self) -> float:
        """Error estimate of the reduced 3D model."""
        return self.model.difference

    @property
    @quantity("-", "largest departure of the displaced slab from its displacement")
    def start_unevenness(self) -> float:
        """Largest departure of the displaced slab from its displacement before the release."""
        return self.model.uneven


def prepare(building: BuildingAtWall, mesh_file: Path) -> Prepared:
    """Read the mesh, and make the experiment. Not collective.

    InputError where the mesh is not usable, ImpactfemError where edges and wall do not go together.
    """
    setup, case = building.wall_impact, building.case
    parts, masses = read_parts(building, mesh_file)
    side = wall_side(parts.mesh, setup.floors, mesh_file)
    edges = [contact_edge(parts.mesh, floor, setup.contact_spacing) for floor in setup.floors]
    length, soft = np.concatenate([edge.weight for edge in edges]), None
    if setup.unilateral_scheme == "massless":
        material = building.entry.material
        stiffness = strip_stiffness(material.young_modulus, material.poisson_ratio)
        shift = (2.0 * np.pi * contact_frequency(case)) ** 2
        soft = SoftPoints(shift, 1.0 / (stiffness * length))
    return Prepared(
        parts=parts,
        mass=masses.floors[[list(parts.mesh.floors).index(floor) for floor in setup.floors]],
        experiment=WallExperiment(
            **setup.model_dump(exclude={"building", "contact_spacing"}), side=side
        ),
        dampings={OWN: building.entry.damping.law}
        | {one.name: one.law for one in case.damping_cases if one.restitution == CALIBRATED},
        position=np.concatenate([edge.position for edge in edges]),
        length=length,
        soft=soft,
    )


def run_calibrate(
    building: BuildingAtWall, prepared: Prepared, model: WallModel, step: Step
) -> CalibrationStudy:
    """Run the stage; "impact" and "stick" run inside the context of `step`. Not collective.

    ImpactfemError where the wall starts inside the building, SolutionError where no impact ends in
    the window.
    """
    case = building.case
    experiment, separation = prepared.experiment, prepared.experiment.separation
    cases = []
    with step("impact"):
        for name, damping in prepared.dampings.items():
            run = run_reduced(model, experiment, prepared.mass, damping, prepared.soft)
            impacts = tuple(
                floor_impacts(run.history, floor, separation=separation)
                for floor in experiment.floors
            )
            penalty = penalty_parameters(impacts[-1].first_complete())
            cases.append(DampedRun(name, damping, run, impacts, penalty))
    with step("stick"):
        # Contacts of the pounding have no part in it, and their laws may be what is sought here.
        alone = case.model_copy(update={"contacts": ()})
        penalty = cases[0].penalty
        stick = run_stick(
            system_of(alone, calibration_of(case)).stick(building.name),
            experiment,
            K=penalty.K_Ceq,
            xi=penalty.xi_c,
            tension=penalty.tension,
            update=case.pounding.update,
        )
        history, top = cases[0].run.history, experiment.floors[-1]
        comparison = compare(stick, history, top, separation=separation)
    return CalibrationStudy(building, prepared, model, tuple(cases), stick, comparison)


def run_reduced(
    model: WallModel,
    experiment: WallExperiment,
    mass: Array,
    damping: DampingLaw,
    soft: SoftPoints | None = None,
) -> BuildingRun:
    """Run the experiment with the reduced model and the masses of the floors that may hit [kg].

    Contact points have mass when `soft` is None. Not collective; raises what `released` does.
    """
    z0, step = model.start(experiment.displacement), experiment.time_step
    body = body_before_walls(model.eigenvalue, model.contact, damping, experiment.gap)
    if soft is None:
        motion = ModalMotion(body, step, theta=experiment.theta, probes=model.seen)
        return released(motion, experiment, mass, model.floor_of, z0, z0 @ model.contact)
    _check_start(experiment, model.floor_of, z0 @ model.contact)
    points = MasslessPoints.of(body, dict.fromkeys(body.bodies, soft.shift))
    contact = massless_response(
        points,
        ModalMotion(points.assembly, step, probes=model.seen),
        experiment.n_t - 1,
        compliance=soft.compliance,
        displacement=z0,
    )
    return _building_run(contact, experiment, mass, model.floor_of)


def released(
    motion: Motion,
    experiment: WallExperiment,
    mass: Array,
    floor_of: Index,
    start: Array,
    at_contacts: Array,
) -> BuildingRun:
    """The run of a model from the displacement that the building is held in. Collective.

    The probes of `motion` are the mass centres of the floors that may hit, with their masses, shape
    (n_floors,) [kg], and others after them. `floor_of` has the index of the floor of each
    constraint, shape (m,), `start` the state that it is released from, as `motion` takes it, and
    `at_contacts` the displacement of each constraint towards the wall in it, shape (m,) [m].

    ImpactfemError where the wall starts inside the building, SolutionError where the response is
    not finite.
    """
    _check_start(experiment, floor_of, at_contacts)
    contact = unilateral_response(motion, experiment.gap, experiment.n_t - 1, displacement=start)
    return _building_run(contact, experiment, mass, floor_of)


def _check_start(experiment: WallExperiment, floor_of: Index, at_contacts: Array) -> None:
    floors = range(len(experiment.floors))
    experiment.check_start(np.array([at_contacts[floor_of == k].max() for k in floors]))


def _building_run(
    contact: ContactHistory, experiment: WallExperiment, mass: Array, floor_of: Index
) -> BuildingRun:
    """Histories of the floors by those of the constraints."""
    count = len(experiment.floors)
    of_floor = [floor_of == k for k in range(count)]
    history = WallHistory(
        floors=experiment.floors,
        mass=mass,
        gap=experiment.gap,
        time_step=experiment.time_step,
        displacement=contact.displacement[:, :count],
        velocity=contact.velocity[:, :count],
        force=np.column_stack([contact.force[:, mine].sum(axis=1) for mine in of_floor]),
        opening=np.column_stack([contact.gap[:, mine].min(axis=1) for mine in of_floor]),
    )
    return BuildingRun(history, contact)
