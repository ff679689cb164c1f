"""Checks before a run: the case, its files, its mesh, and all that a run would refuse later."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from impactfem.building.from_case import geometry_of, part_faults, read_parts
from impactfem.building.mesh import BuildingMesh
from impactfem.building.mesh_report import MeshReport
from impactfem.building.outline import mesh_plans
from impactfem.building.read_mesh import read_mesh
from impactfem.case import Building3D, Case
from impactfem.case.base import nearest
from impactfem.case.buildings import GeneratedMesh
from impactfem.case.contact_checks import pair_distance
from impactfem.case.contact_search import facing_floors
from impactfem.case.devices import NODES
from impactfem.case.load import read_case
from impactfem.case.model import CaseFile
from impactfem.case.motions import RecordMotion, read_force_table
from impactfem.case.plausibility import implausible
from impactfem.case.report import ALL_FIGURES
from impactfem.case.source import read_source
from impactfem.case.transient import transient_files
from impactfem.coupling.conditions import conditions as required_conditions
from impactfem.coupling.force_history import FORCES, ForceHistory
from impactfem.coupling.given_forces import doubts, given_forces
from impactfem.device.from_case import checked_devices
from impactfem.motion.from_case import checked_durations, plausibility_warnings
from impactfem.run.estimate import (
    DAY,
    NODE,
    Estimate,
    duration,
    elements_of,
    estimate,
    too_much,
)
from impactfem.run.stages import STAGES, asked_stages, needed_stages
from impactfem.stages.check import Check, log_checks
from impactfem.stages.device.stage import ANCHOR_NODES
from impactfem.stages.inputs import program_key
from impactfem.stages.patches import contact_patches
from impactfem.stages.pounding.checks import distance_check
from impactfem.system.errors import Fault, InputError, file_errors
from impactfem.system.files import LARGEST_FORCES, unreadable
from impactfem.system.log import LOGGER
from impactfem.system.packages import require_packages

if TYPE_CHECKING:
    from impactfem.building.links import BasePlate

T = TypeVar("T")

MOST_ELEMENTS = 300_000
"""Elements of the largest mesh that a check makes; that takes some ten seconds."""


def check(path: Path, *, mesh: bool = False, conditions: bool = True) -> Case:
    """Read a case file and everything it names; nothing is computed.

    Args:
        path: The case file.
        mesh: Whether the mesh is read, or made, too, which takes some seconds, and the warnings of
            a run are given: gaps that are not those of axes and offsets, floors that face each
            other and are in no pair, and implausible values.
        conditions: Whether the conditions that a case must allow are checked.

    Raises:
        InputError: With every fault; also where the run would not fit this machine.
        ImpactfemError: A file cannot be read.
    """
    return checked(path, mesh=mesh, conditions=conditions)[0]


def checked(
    path: Path, *, mesh: bool = False, stage: str | None = None, conditions: bool = True
) -> tuple[Case, Estimate]:
    """As `check`, for a run up to a stage, or of all; with the estimate of what it takes."""
    with file_errors():
        source = read_source(path, CaseFile)
        case, faults, left_out = read_case(source)
        found, readable = None, not faults
        if case is not None:
            require_packages(three_d=bool(case.structures))
            stages = {one.name for one in asked_stages(case, stage)} if not faults else set()
            # Forces of another program may be missing for stages that do not read them.
            given = transient_files(case.transient) if case.transient is not None else ()
            read = {
                file
                for needed in needed_stages(case, stage)
                for subject in needed.of(case)
                for file in needed.files(subject)
            }
            forces = stage is None or not read.isdisjoint(given)
            found, further = further_checks(case, left_out, stages, mesh=mesh, forces=forces)
            # Of what the file has wrong, as a pair or where it acts, the mesh says no more.
            wrong = {fault.key for fault in faults}
            if any(key.startswith(("contacts", "transient.eccentricity")) for key in wrong):
                further = [fault for fault in further if not fault.key.startswith("pair ")]
            further = [fault for fault in further if not fault.key or fault.key not in wrong]
            faults += map(source.as_written, further)
        if conditions and case is not None and not faults:
            # Only of a case without other faults, of which these may be a consequence.
            for fault in required_conditions(case):
                if fault.kind in case.allow:
                    LOGGER.warning("warning: %s", fault)
                else:
                    faults.append(fault)
        if mesh and case is not None and readable:
            warn_of_implausible(case, found.longest if found else 0.0)  # may be what is at fault
        if faults or case is None or found is None:
            raise InputError(faults)
        if mesh:
            # Contacts whose gap is not the distance of axes and offsets.
            pairs = [contact for contact in case.contacts if contact.name == contact.pair]
            distances = [pair_distance(pair, case) for pair in pairs]
            gaps = distance_check([pair.name for pair in pairs], [p.gap for p in pairs], distances)
            log_checks("contacts", (check for check in gaps if check.passed is False))
            facing = facing_floors(case)
            for line in facing.lines():
                LOGGER.warning("warning: %s: %s", case.path, line)
            for line in (*facing.unknown_lines, *contact_patches(case.model_dump())):
                LOGGER.info("%s: %s", case.path, line)
            for one in asked_stages(case, stage):
                log_checks(one.name, one.announces(case))
        if found.seconds > DAY:
            LOGGER.warning(
                "warning: a run of this case takes about %s: check time steps, element sizes and "
                "the number of motions",
                duration(found.seconds),
            )
        program_key()  # a run goes by the sources at its start
    return case, found


def warn_of_implausible(case: Case, longest: float) -> None:
    """Warn of values that are probably mistakes; the longest motion has this duration [s]."""
    found = [*implausible(case, longest), *plausibility_warnings(case)]
    transient = case.transient
    if transient is not None and transient.forces is not None:
        # Where they cannot be read, that is a fault.
        history = _attempt([], partial(given_forces, transient, check=True))
        found += () if history is None else doubts(history, transient.forces, case)
    for one in found:
        LOGGER.warning("warning: %s", one)


def _attempt(faults: list[Fault], action: Callable[[], T]) -> T | None:
    """The result of a check; None where it has faults, which are added, each once."""
    try:
        return action()
    except InputError as error:
        faults += [fault for fault in error.faults if fault not in faults]
        return None


def further_checks(
    case: Case, left_out: set[str], stages: set[str], *, mesh: bool, forces: bool = True
) -> tuple[Estimate | None, list[Fault]]:
    """Check devices, motions, times and forces of a case, and the mesh if it is read or made.

    Sections that could not be read (`left_out`) are not checked, nor are, without `forces`, the
    impact forces of another program. Gives what a run of the stages
    will take, None where faults hide it, and the faults.
    """
    faults = unknown_figures(case)
    attempt = partial(_attempt, faults)
    if not left_out & {"devices", "device_analysis", "damping_cases"}:
        for building in case.modelled.values():
            attempt(partial(checked_devices, building))
    durations = None
    ensemble = case.ensemble
    if ensemble is not None and not left_out & {"motions", "ensemble"}:
        attempt(lambda: checked_durations(ensemble.of_records(case.motions)))
    if "motions" not in left_out:
        durations = _attempt(faults, lambda: checked_durations(case.motions, case.path))
    longest = max(durations or (), default=0.0)  # without a motion, the case says how long
    computed = case.computed_time(longest)
    transient = case.transient
    # Where nothing moves, that is a fault of its own.
    if "pounding" not in left_out and durations is not None and computed > 0.0:
        # Steps and durations that do not go with the motions, whose records say how long they
        # last; durations that the case itself states were checked when it was read.
        half = computed / 2.0, "half of what is computed"
        times = [("pounding.time_step", case.pounding.time_step, *half)]
        recorded = any(isinstance(motion, RecordMotion) for motion in case.motions)
        if transient and transient.forces is None and recorded and case.pounding.duration is None:
            if transient.duration is None:
                times.append(("transient.time_step", transient.time_step, *half))
            else:
                whole = computed * (1.0 + 1e-9), "what is computed of the pounding"
                times.append(("transient.duration", transient.duration, *whole))
        for key, value, most, words in times:
            if value > most:
                expected = f"expected at most {words}, {computed:g} s"
                faults.append(Fault(case.path, key, value, expected))
        for loads in case.loads:
            table = read_force_table(loads.file, faults)
            if table is not None:
                faults += table.early_ends(loads.file, computed)
    if transient is not None and transient.forces is not None and forces:
        missing = unreadable(transient.forces, FORCES, LARGEST_FORCES)
        if missing is not None:
            given = str(transient.forces)
            faults.append(Fault(case.path, "transient.forces", given, missing.expected))
            transient = transient.model_copy(update={"forces": None})
    if transient is not None and transient.forces is not None and forces:
        history = attempt(partial(given_forces, transient, check=True))
        if history is not None and "contacts" not in left_out and case.structures:
            from impactfem.reduction.forces import pair_ends

            computed = float(history.time[-1])
            lasting = transient.duration or computed
            for building in case.modelled.values():
                every = pair_ends(history, transient.forces, building, lasting)[1]
                faults += [fault for fault in every if fault not in faults]
    if transient is not None and transient.export and transient.duration is None:
        start = transient.export_start or 0.0
        expected = f"expected less than what is computed, {computed:g} s"
        if durations is not None and start >= computed:
            faults.append(Fault(case.path, "transient.export_start", f"{start:g} s", expected))
    found = None if durations is None else estimate(case, longest).of(stages)
    counted = "pounding" not in left_out  # else the sticks have steps that nobody wrote
    refused = list(too_much(case, found)) if found and counted else []
    faults += refused
    meshes = {}
    for name, building in case.modelled.items():
        if isinstance(building.structure.mesh, GeneratedMesh):
            parts = sorted(geometry_of(building).part_sections())
            faults += part_faults(building.structure, parts, case.path)
        read = mesh_of(building, faults, bool(refused)) if mesh else None
        if read is not None:
            meshes[name] = read
    faults += plans_of_meshes(case, meshes)
    in_3d = {*case.pounding_in_3d}
    if in_3d and in_3d <= {*meshes} and "contacts" not in left_out:
        from impactfem.reduction.contact_line import contact_lines, warn_of_narrow

        warn_of_narrow(attempt(lambda: contact_lines(case, meshes)) or (), case)
    if meshes and found:
        found = estimate(case, longest, meshes).of(stages)
        faults += too_much(case, found) if counted and not refused else ()
    return found, faults


def plans_of_meshes(case: Case, meshes: Mapping[str, BuildingMesh]) -> list[Fault]:
    """Return the plans that [contact_search] lacks and that meshes have, as a fault to type them.

    Args:
        case: The case.
        meshes: Meshes by the names of the buildings.
    """
    search = case.contact_search
    if search is None:
        return []
    lacking = {
        name for *_, names in facing_floors(case, search.buildings).unknown for name in names
    }
    found = []
    for k, building in enumerate(case.buildings):
        if building.name not in lacking or building.name not in meshes:
            continue
        plans = [
            (floors, ", ".join(f'["{x:g} m", "{y:g} m"]' for x, y in plan))
            for plan, floors in mesh_plans(meshes[building.name], building).items()
        ]
        if not plans:
            continue
        text = f"plan = [{plans[0][1]}]"
        if len(plans) > 1:
            parts = (f"{{ floors = {floors}, plan = [{corners}] }}" for floors, corners in plans)
            text = f"plans = [{', '.join(parts)}]"
        expected = f"missing; type {text}, the outline of the slabs of its mesh"
        found.append(Fault(case.path, f"buildings[{k}].plan", None, expected, "plan_of_mesh"))
    return found


def unknown_figures(case: Case) -> list[Fault]:
    """Return a fault for each requested figure that no stage declares."""
    known = [one.name for stage in STAGES for one in stage.figures.declared] + [ALL_FIGURES]
    return [
        Fault(case.path, f"report.figures[{k}]", name, f"no such figure; {nearest(name, known)}")
        for k, name in enumerate(case.report.figures)
        if name not in known
    ]


def mesh_of(
    building: Building3D, faults: list[Fault], refused: bool = False
) -> BuildingMesh | None:
    """The mesh of a building, read or made and read; None where it cannot be.

    One of a file that is large is not read for a run that is refused as too large already.
    """
    of = building.structure.mesh
    if not isinstance(of, GeneratedMesh):
        large = refused and of.file.stat().st_size / NODE > 2 * MOST_ELEMENTS
        return None if large else check_mesh(building, of.file, faults)
    geometry = geometry_of(building)
    if elements_of(geometry) > MOST_ELEMENTS:
        LOGGER.info("check: the mesh is large and is not made; the stage building checks it")
        return None
    # gmsh is loaded in a process of its own, PETSc where it is needed.
    from impactfem.building.generate import generate

    with TemporaryDirectory() as folder:
        path, before = Path(folder) / "building.msh", len(faults)
        _attempt(faults, partial(generate, geometry, path, source=str(building.case.path)))
        return check_mesh(building, path, faults) if len(faults) == before else None


def check_mesh(building: Building3D, path: Path, faults: list[Fault]) -> BuildingMesh | None:
    """The mesh, where it can be read; its faults and contradictions to the case are added."""
    attempt = partial(_attempt, faults)
    generated, case_file = isinstance(building.structure.mesh, GeneratedMesh), building.case.path
    read = _attempt(faults, lambda: read_parts(building, path))
    mesh = None
    if read is not None:
        parts, _ = read
        mesh = parts.mesh
        for text in MeshReport.of(mesh, parts.sections).warnings:
            LOGGER.warning("warning: %s: %s", case_file if generated else path, text)
    if read is None and not generated:  # sections or heights hide no other fault
        mesh = _attempt(faults, lambda: read_mesh(path))
    # A mesh of another building contradicts all that the case says of its own.
    if mesh is None or list(mesh.floors) != [one.floor for one in building.entry.floors]:
        return None
    if building.wall_impact is not None:
        from impactfem.reduction.wall import wall_side

        floors, file = building.wall_impact.floors, case_file if generated else path
        attempt(lambda: wall_side(mesh, floors, file))
    if building.transient is not None:
        from impactfem.reduction.forces import check_contacts
        from impactfem.reduction.probes import checked_probes

        attempt(lambda: checked_probes(building, mesh))
        attempt(lambda: check_contacts(building, mesh))
    if building.transient is not None or building.case.pounding_in_3d:
        from impactfem.reduction.forces import with_floor_forces

        at_rest = ForceHistory(np.array([0.0, 1.0]), (), np.zeros((2, 0)))
        attempt(lambda: with_floor_forces(building, mesh, at_rest, []))
    if building.devices:
        from impactfem.building.links import find_base_plates
        from impactfem.reduction.probes import covered_points

        plates = attempt(lambda: find_base_plates(building, mesh))
        log_checks("device", node_checks(plates or ()))
        attempt(lambda: covered_points(building, mesh))
    return mesh


def node_checks(plates: Iterable[BasePlate]) -> Iterator[Check]:
    """Yield the check of a run for the nodes of each base plate, with a radius that is enough."""
    for plate in plates:
        detail = f"a radius of {math.ceil(100.0 * plate.least_radius)} cm has {NODES}"
        place = f"{plate.name} on floor {plate.floor}"
        yield ANCHOR_NODES.check(plate.nodes.size, place, detail)
