"""The one reduced model of the 3D building: what it is made for, and how accurate it has to be."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from impactfem.building.facade import facades
from impactfem.building.from_case import read_parts
from impactfem.building.links import find_base_plates
from impactfem.building.mesh import BuildingMesh, place
from impactfem.building.model import assemble_building
from impactfem.building.parts import BuildingParts
from impactfem.building.read_mesh import read_mesh
from impactfem.case import Building3D
from impactfem.case.transient import LARGEST_BASIS, MAXIMUM_FREQUENCY, TOLERANCE, Transient
from impactfem.dynamics.damping import DampingLaw
from impactfem.reduction.contact_line import contact_lines
from impactfem.reduction.edge_force import floor_shares
from impactfem.reduction.forces import check_contacts, loaded_edges
from impactfem.reduction.probes import checked_probes, covered_points, motion_grid, recorded_nodes
from impactfem.reduction.reduced_basis import Accuracy
from impactfem.reduction.reduced_building import ReducedBuilding, ReductionPlan, reduce_building
from impactfem.reduction.response import LARGER
from impactfem.reduction.wall import Wall, wall_side
from impactfem.stages.reduce.store import MODEL
from impactfem.system.errors import Fault, ImpactfemError, InputError
from impactfem.system.log import LOGGER, Steps
from impactfem.system.parallel import communicator, on_root

LIGHT_FREQUENCY = 100.0
"""Up to which the whole space is accurate with the lightest damping case [Hz]. Measured on the
paper's building with 63,000 degrees of freedom: a basis for the own damping alone (352 vectors)
gives the largest force of the paper's device with a fifth of β within 0.15 % of a basis for that
damping up to 450 Hz (892)."""
COMPLETE = 0.005
"""Tolerance of the whole space: with the lightest damping case, and at the wall. On the paper's
building, with a fifth of β and three times of it, 290 vectors more change no restitution by more
than 0.2 %."""
WALL_FREQUENCY = 200.0
"""Up to which the whole space is accurate at the wall, where an impact of 10 ms has its power below
200 Hz [Hz]."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """What a run needs in addition to the matrices."""

    parts: BuildingParts  #: The building.
    storey_factor: float  #: Factor on walls and columns.
    plan: ReductionPlan  #: What it is reduced for.


def prepare(
    building: Building3D,
    mesh_file: Path,
    storey_factor: float,
    others: Mapping[str, Path] | None = None,
) -> Prepared:
    """Read the mesh, and see what the case needs of a building. Not collective.

    In `others` are the meshes of all buildings with a 3D model by name; needed where this one
    pounds in 3D. InputError where the mesh is not usable; a probe, a contact, a device or the wall
    does not go with it.
    """
    parts, _ = read_parts(building, mesh_file)
    mesh, transient, asked = parts.mesh, building.transient, building.wall_impact
    plates, covered = find_base_plates(building, mesh), covered_points(building, mesh)
    wall = None
    if asked is not None:
        wall_side(mesh, asked.floors, mesh_file)
        # The displaced floor must be free to be held at a displacement as a whole.
        slab = np.unique(mesh.triangles[mesh.slab(asked.displaced_floor)])
        clamped = np.isin(slab, mesh.base)
        if asked.pull == "whole_floor" and clamped.any():
            at = place(mesh.nodes[slab[clamped][0]])
            expected = (
                f"{clamped.sum()} of the {len(slab)} nodes of the slab of floor "
                f"{asked.displaced_floor} are clamped, at {at} for example; expected a floor that "
                "is free to move, or 'even_load' or 'mass_centre'"
            )
            raise InputError([Fault(building.case.path, "wall_impact.pull", asked.pull, expected)])
        wall = Wall(asked.floors, asked.displaced_floor, asked.pull, asked.contact_spacing)
    probes = [plate.master for plate in plates] + list(covered.nodes)
    if wall is not None:
        probes += wall_probes(mesh, wall.floors)
    if transient is not None:
        probes += [probe.node for probe in checked_probes(building, mesh)]
    if building.pounds:
        probes += list(mesh.centres.values())
    certified = np.unique(np.array(probes, dtype=np.int64))
    directions: tuple[int, ...] = ()
    if transient is not None or building.pounds:
        directions = tuple(
            sorted({"xyz".index(motion.direction) for motion in building.case.motions})
        )
        if building.entry.soil is not None:
            # Whatever the soil, its base moves in all components.
            directions = tuple(range(6))
    plan = ReductionPlan(
        probes=certified,
        nodes=certified,
        accuracies=accuracies(building),
        directions=directions,
        base_plates=plates,
        points=covered.nodes,
        wall=wall,
    )
    if transient is not None:
        nodes = recorded_nodes(mesh, certified, building.wave_floor)
        if transient.export:
            nodes = np.union1d(nodes, motion_grid(mesh, transient.export_nodes).nodes)
        plan = replace(
            plan,
            nodes=nodes,
            edges=check_contacts(building, mesh),
            shift=transient.shift,
            largest=transient.largest_basis,
            larger=transient.band == LARGER,
        )
    if building.pounds:
        plan = _with_contacts(plan, building, mesh, others or {})
    return Prepared(parts, storey_factor, plan)


def _with_contacts(
    plan: ReductionPlan, building: Building3D, mesh: BuildingMesh, others: Mapping[str, Path]
) -> ReductionPlan:
    """A plan with the lines along which the building touches others, and all of its floors."""
    name = building.name
    meshes = {other: mesh if other == name else read_mesh(path) for other, path in others.items()}
    contacts = [
        force for line in contact_lines(building.case, meshes) for force in line.forces_on(name)
    ]
    patterns = list(plan.edges)
    patterns += [one for shares in loaded_edges(building, mesh).values() for one, _ in shares]
    for force in contacts:
        if force.height is None:
            # All of a side, and its turning: what its points do together.
            facade, _ = facades(mesh, force.floor, force.side or None)[force.side]
            place = (force.floor, facade, force.direction, facade.length)
            patterns += [one for one, _ in floor_shares(*place, Transient(time_step=1.0))]
    return replace(
        plan,
        edges=tuple(dict.fromkeys(patterns)),
        contacts=tuple(contacts),
        points=(*plan.points, *(mesh.centres[floor] for floor in mesh.floors)),
    )


def accuracies(building: Building3D) -> tuple[Accuracy, ...]:
    """How accurate the reduced building has to be: its own model first, then the whole space."""
    own, transient = building.entry.damping.law, building.transient
    if transient is None:
        remedy = f"more than {LARGEST_BASIS} need a section [transient] with a larger largest_basis"
        return (Accuracy(own, MAXIMUM_FREQUENCY, TOLERANCE, remedy),)
    top, cases = transient.maximum_frequency, [one.law for one in building.case.damping_cases]
    served = [own, *(cases if transient.serve_damping_cases else ())]
    requested = [Accuracy(_lightest(served, top), top, transient.tolerance)]
    # The frequencies of the wall and of the devices are not those of the case.
    remedy = "allow more with transient.largest_basis"
    if building.wall_impact is not None:
        requested.append(Accuracy(own, WALL_FREQUENCY, COMPLETE, remedy))
    if building.devices and cases:
        low = min(LIGHT_FREQUENCY, top)
        requested.append(Accuracy(_lightest(cases, low), low, COMPLETE, remedy))
    return tuple(requested)


def _lightest(dampings: list[DampingLaw], frequency: float) -> DampingLaw:
    return min(dampings, key=lambda damping: float(damping.ratio(frequency)))


def wall_probes(mesh: BuildingMesh, floors: tuple[int, ...]) -> list[int]:
    """Mass centres, and ends and middles of the edges, of the floors that may hit a wall."""
    nodes = [mesh.centres[floor] for floor in floors]
    for floor in floors:
        edge = np.unique(mesh.edges[floor])
        along = mesh.nodes[edge] @ np.ptp(mesh.nodes[edge], axis=0)
        nodes += [int(edge[k]) for k in np.argsort(along)[[0, len(edge) // 2, -1]]]
    return nodes


def run_reduce(
    prepared: Prepared, folder: Path, steps: Steps, *, model_key: str
) -> ReducedBuilding | None:
    """Run the stage: the reduced building of an earlier run where it serves, or a new one.

    Collective; None on ranks other than 0. `model_key` is the hash of what the reduced building
    depends on; loads, nodes and accuracy are checked when it is used again. SolutionError where
    the basis does not reach its tolerance.
    """
    plan, comm = prepared.plan, communicator()
    # On rank 0 alone: it is large, and the others have no use for it.
    stored = ReducedBuilding.read(folder / MODEL, model_key) if comm.rank == 0 else None
    if stored is not None:
        stored, lack = stored.serving(plan)
        if stored is None:
            LOGGER.info("reduce: the reduced building of %s is %s, and made again", MODEL, lack)
    if comm.bcast(stored is not None):
        LOGGER.info("reduce: the reduced building of %s is used again", MODEL)
        return stored
    with steps.step("matrices"):
        building = assemble_building(comm, prepared.parts)
    reduced = reduce_building(building, prepared.parts.mesh, prepared.storey_factor, plan, steps)
    with steps.step("stores"):
        on_root(lambda: reduced.write(folder / MODEL, model_key))
    return reduced if comm.rank == 0 else None


def reduced_of_run(folder: Path, model_key: str) -> ReducedBuilding:
    """The reduced building of a run. Not collective.

    ImpactfemError where the folder has none that was made from this case.
    """
    found = ReducedBuilding.read(folder / MODEL, model_key)
    if found is None:
        raise ImpactfemError(
            f"{folder / MODEL} is missing, or made from another case or by another state of the "
            "program: run stage reduce"
        )
    return found


def reduced_on_soil(folder: Path, model_key: str, building: Building3D) -> ReducedBuilding:
    """Return the reduced building of a run on its soil; as `reduced_of_run`."""
    found, soil = reduced_of_run(folder, model_key), building.entry.soil
    return found if soil is None else found.on(soil.law)


def reduced_on_root(folder: Path, model_key: str, building: Building3D) -> ReducedBuilding | None:
    """The reduced building of a run on its soil on rank 0, None on the others: it is large.

    Collective; arguments as of `reduced_of_run`.
    """
    kept: list[ReducedBuilding] = []
    on_root(lambda: kept.append(reduced_on_soil(folder, model_key, building)))
    return kept[0] if kept else None
