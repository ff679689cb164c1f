"""What the stage `transient` needs in addition to matrices: mesh, probes, loads and dampings."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from impactfem.building.from_case import read_parts
from impactfem.building.links import BasePlate, find_base_plates
from impactfem.building.mesh import BuildingMesh
from impactfem.building.parts import BuildingParts
from impactfem.case import BuildingInTime
from impactfem.coupling.force_history import OTHER_FORCES, ForceHistory, read_forces
from impactfem.coupling.given_forces import given_forces
from impactfem.dynamics.damping import DampingLaw
from impactfem.motion.from_case import GroundMotion, ground_motions
from impactfem.reduction.edge_force import Shares
from impactfem.reduction.forces import checked_forces, with_floor_forces
from impactfem.reduction.loads import Loads, make_loads
from impactfem.reduction.probes import Probe, checked_probes
from impactfem.reduction.sides import Impulses
from impactfem.spectra.resolved import step_limit
from impactfem.stages.building.compute import mesh_of_run
from impactfem.stages.building.stage import storey_factor
from impactfem.stages.calibrate.selection import impulses_of_run
from impactfem.stages.stores import of_run, open_store
from impactfem.system.arrays import Index
from impactfem.system.errors import Fault, InputError


@dataclass(frozen=True, eq=False)
class Prepared:
    """What a run needs in addition to the matrices."""

    building: BuildingInTime
    parts: BuildingParts  #: its mesh, sections and masses
    probes: tuple[Probe, ...]  #: output points
    motions: tuple[GroundMotion, ...]
    loads: Loads  #: ground motion and impact forces, at the step of the 3D model
    storey_factor: float  #: factor on walls and columns
    base_plates: tuple[BasePlate, ...]  #: of the devices
    damping: DampingLaw
    #: Of the impact on the wall, for spread `calibrated`; None for another one.
    impulses: Impulses | None
    force_step: float  #: time step of the impact forces [s]
    #: Loads of impact forces with another time step, at a step with the same ratio to that of
    #: `loads`; None where there are none. Forces on further sides are left out.
    other_loads: Loads | None

    @property
    def probe_nodes(self) -> Index:
        """Nodes of the probes, shape (n,)."""
        return np.array([probe.node for probe in self.probes])


def prepare(
    building: BuildingInTime,
    mesh_file: Path,
    forces_file: Path,
    storey_factor: float,
    inputs: str,
    impulses: Impulses | None = None,
) -> Prepared:
    """Read mesh, motions and forces. Not collective.

    The forces are those of the case where it names some, else of the pounding; `inputs` is the
    hash of what these depend on, `impulses` of the impact on the wall, for spread `calibrated`.
    InputError where the mesh or the forces are not usable, or a probe is outside the building.
    """
    transient = building.transient
    parts, _ = read_parts(building, mesh_file)
    path = transient.forces or forces_file
    history = read_forces(path) if transient.forces is None else given_forces(transient)
    duration = transient.duration or float(history.time[-1])
    motions = tuple(ground_motions(building.case.motions))
    loads = case_loads(building, parts.mesh, motions, history, path, duration, inputs, impulses)
    probes = tuple(checked_probes(building, parts.mesh))
    step, other = float(history.time[1] - history.time[0]), None
    beside = forces_file.with_name(OTHER_FORCES)
    if transient.forces is None and beside.is_file() and loads.impact_force.any():
        compared = read_forces(beside)
        ratio = float(compared.time[1] - compared.time[0]) / step
        update = {"time_step": ratio * transient.time_step}
        view = replace(building, transient=transient.model_copy(update=update))
        forces, edges = checked_forces(
            compared, beside, view, parts.mesh, duration, inputs, impulses
        )
        other = loads_on_edges(view, parts.mesh, motions, forces, edges, duration).of(loads.names)
    return Prepared(
        building=building,
        parts=parts,
        probes=probes,
        motions=motions,
        loads=loads,
        storey_factor=storey_factor,
        base_plates=find_base_plates(building, parts.mesh),
        damping=building.entry.damping.law,
        impulses=impulses,
        force_step=step,
        other_loads=other,
    )


def prepared_of_run(building: BuildingInTime, run: Path, inputs: str) -> Prepared:
    """Prepare from the files of a run. Not collective.

    Args:
        building: The building.
        run: The folder of the run.
        inputs: As of `prepare`.

    Raises:
        InputError: As `prepare`.
        ImpactfemError: A file of the run is missing or cannot be read.
    """
    folder = building.folder(run)
    return prepare(
        building,
        mesh_of_run(building, folder),
        of_run(folder, "forces.nc"),
        storey_factor(folder),
        inputs,
        impulses_of_run(building, run),
    )


def case_loads(
    building: BuildingInTime,
    mesh: BuildingMesh,
    motions: Sequence[GroundMotion],
    history: ForceHistory,
    path: Path,
    duration: float,
    inputs: str = "",
    impulses: Impulses | None = None,
) -> Loads:
    """Ground motions and impact forces, for a duration [s], as loads at the 3D model's step.

    `path` is the forces' file, for messages; `inputs` the hash of what the sticks of this run
    depend on, empty when it is not known. InputError where the forces do not go with the case.
    """
    forces, edges = checked_forces(history, path, building, mesh, duration, inputs, impulses)
    loads = loads_on_edges(building, mesh, motions, forces, edges, duration)
    known = building.transient.floors
    lacking = sorted({edge.floor for edge in loads.edges} - set(known or ()))
    if known is not None and lacking:
        expected = f"floor {', '.join(map(str, lacking))}, too, whose edge is hit or loaded"
        raise InputError([Fault(building.case.path, "transient.floors", list(known), expected)])
    return loads


def loads_on_edges(
    building: BuildingInTime,
    mesh: BuildingMesh,
    motions: Sequence[GroundMotion],
    forces: ForceHistory,
    edges: list[Shares],
    duration: float,
) -> Loads:
    """As `case_loads`, of the forces of pairs that act on these edges; further loads are added."""
    time_step, contacts = building.transient.time_step, len(edges)
    forces, edges = with_floor_forces(building, mesh, forces, edges)
    # Of whole numbers, the quotient may be a rounding error below one.
    n_steps = math.floor(duration / time_step * (1.0 + 1e-9))
    ground = [motion.history for motion in motions]
    delay = building.case.delays.get(building.name, 0.0)
    return make_loads(ground, forces, edges, time_step, n_steps, len(edges) - contacts, delay)


def contact_limit(prepared: Prepared, pounding: Path) -> float:
    """Return the limit that impact forces set to the resolved band [Hz].

    That of the stage `pounding`, whose results file is given; of forces of another program that of
    their time step.
    """
    if prepared.building.transient.forces is not None:
        return step_limit(prepared.force_step)
    with open_store(pounding) as store:
        return float(store["limit_contact"])
