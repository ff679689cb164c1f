"""Checks before a run: the case, its files, its mesh, and all that a run would refuse later."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

import numpy as np

from impactfem.building.from_case import geometry_of, part_faults, read_parts
from impactfem.building.mesh import BuildingMesh
from impactfem.building.read_mesh import read_mesh
from impactfem.case import Case
from impactfem.case.buildings import GeneratedMesh
from impactfem.case.contact_checks import pair_distance
from impactfem.case.facing import facing_floors
from impactfem.case.load import read_case
from impactfem.case.motions import RecordMotion, read_force_table
from impactfem.case.plausibility import implausible
from impactfem.coupling.force_history import ForceHistory, check_forces
from impactfem.device.from_case import checked_devices
from impactfem.motion.from_case import checked_durations
from impactfem.run.estimate import DAY, Estimate, duration, elements_of, estimate, too_much
from impactfem.run.stages import STAGES, asked_stages
from impactfem.stages.check import log_checks
from impactfem.stages.pounding.checks import distance_check
from impactfem.system.errors import Fault, InputError, file_errors
from impactfem.system.log import LOGGER

T = TypeVar("T")

MOST_ELEMENTS = 300_000
"""Elements of the largest mesh that a check makes; that takes some ten seconds."""


def check(path: Path, *, mesh: bool = False) -> Case:
    """Read a case file and everything it names; nothing is computed.

    Args:
        path: The case file.
        mesh: Whether the mesh is read, or made, too, which takes some seconds, and the warnings of
            a run are given: gaps that are not those of axes and offsets, floors that face each
            other and are in no pair, and implausible values.

    Raises:
        InputError: With every fault; also where the run would not fit this machine.
        ImpactfemError: A file cannot be read.
    """
    return checked(path, mesh=mesh)[0]


def checked(path: Path, *, mesh: bool = False, stage: str | None = None) -> tuple[Case, Estimate]:
    """As `check`, for a run up to a stage, or of all; with the estimate of what it takes."""
    with file_errors():
        case, faults, left_out = read_case(path)
        found = None
        if case is not None:
            stages = {one.name for one in asked_stages(case, stage)} if not faults else set()
            found = further_checks(case, left_out, stages, mesh=mesh)
            faults += found.faults
        if faults or case is None or found is None or found.estimate is None:
            raise InputError(faults)
        if mesh:
            warn_of_gaps(case)
            facing = facing_floors(case)
            for line in facing.lines():
                LOGGER.warning("warning: %s: %s", case.path, line)
            for line in facing.unknown_lines:
                LOGGER.info("%s: %s", case.path, line)
            warn_of_implausible(case, found.estimate)
        if found.estimate.seconds > DAY:
            LOGGER.warning(
                "warning: a run of this case takes about %s: see the numbers of time steps, vectors"
                " and members",
                duration(found.estimate.seconds),
            )
        for one in STAGES:
            one.freeze()
    return case, found.estimate


def warn_of_gaps(case: Case) -> None:
    """Warn of contacts whose gap is not the distance of axes and offsets."""
    pairs = case.contacts
    names, gaps = [pair.name for pair in pairs], [pair.gap for pair in pairs]
    found = distance_check(names, gaps, [pair_distance(pair, case) for pair in pairs])
    log_checks(one for one in found if one[0] is False)


def warn_of_implausible(case: Case, found: Estimate) -> None:
    """Warn of values that are probably mistakes."""
    for one in implausible(case, found.longest):
        LOGGER.warning("warning: %s", one)


@dataclass
class Further:
    """Faults, and what a run will take, which is None where faults hide it."""

    faults: list[Fault] = field(default_factory=list)
    estimate: Estimate | None = None

    def attempt(self, action: Callable[[], T]) -> T | None:
        """The result of a check; None where it has faults, which are added, each once."""
        try:
            return action()
        except InputError as error:
            self.faults += [fault for fault in error.faults if fault not in self.faults]
            return None


def further_checks(case: Case, left_out: set[str], stages: set[str], *, mesh: bool) -> Further:
    """Check devices, motions, times and forces of a case, and the mesh if it is read or made.

    Args:
        case: The case, as far as it could be read.
        left_out: Names of the sections that could not be read, which are not checked.
        stages: Names of the stages of the run.
        mesh: Whether the mesh is read, or made and read.
    """
    found = Further()
    if not left_out & {"devices", "device_analysis", "damping_cases"}:
        found.attempt(lambda: checked_devices(case))
    durations = None
    if "motions" not in left_out:
        durations = found.attempt(lambda: checked_durations(case.motions))
    if durations is None:
        return found
    longest = max(durations, default=0.0)  # without a motion, the case says how long
    computed = case.pounding.duration or longest
    if "pounding" not in left_out:
        found.faults += _time_faults(case, computed)
        for loads in case.loads:
            table = read_force_table(loads.file, found.faults)
            if table is not None:
                found.faults += table.early_ends(loads.file, computed)
    transient = case.transient
    if transient is not None and transient.forces is not None:
        history = found.attempt(partial(check_forces, transient.forces))
        if history is not None and "contacts" not in left_out and case.structure is not None:
            from impactfem.reduction.forces import history_faults

            computed = float(history.time[-1])
            lasting = transient.duration or computed
            for view in case.views:
                every = history_faults(history, transient.forces, view, lasting)
                found.faults += [fault for fault in every if fault not in found.faults]
    if transient is not None and transient.export and transient.duration is None:
        start, key = transient.export_start or 0.0, "transient.export_start"
        expected = f"less than what is computed, {computed:g} s"
        if start >= computed:
            found.faults.append(Fault(case.path, key, f"{start:g} s", expected))
    found.estimate = estimate(case, longest).of(stages)
    refused = list(too_much(case, found.estimate))
    found.faults += refused
    for view in case.views:
        if view.structure is not None and isinstance(view.structure.mesh, GeneratedMesh):
            parts = sorted(geometry_of(view).part_sections())
            found.faults += part_faults(view.structure, parts, case.path)
    if not mesh or refused:
        return found
    meshes = {}
    for view in case.views:
        read = _mesh_of(view, found)
        if read is not None and view.structure is not None:
            meshes[view.structure.building] = read
    if meshes:
        found.estimate = estimate(case, longest, meshes).of(stages)
        found.faults += too_much(case, found.estimate)
    return found


def _mesh_of(case: Case, found: Further) -> BuildingMesh | None:
    """The mesh of the building of a view, read or made and read; None where it cannot be."""
    made = None if case.structure is None else case.structure.mesh
    if made is None:
        return None
    if not isinstance(made, GeneratedMesh):
        return _read_mesh(case, made.file, found)
    if elements_of(geometry_of(case)) > MOST_ELEMENTS:
        LOGGER.info("check: the mesh is large and is not made; the stage building checks it")
        return None
    # gmsh is loaded in a process of its own, PETSc where it is needed.
    from impactfem.building.generate import generate

    with TemporaryDirectory() as folder:
        path = Path(folder) / "building.msh"
        before = len(found.faults)
        found.attempt(partial(generate, geometry_of(case), path, source=str(case.path)))
        return _read_mesh(case, path, found) if len(found.faults) == before else None


def mesh_faults(case: Case, path: Path) -> list[Fault]:
    """The contradictions between a mesh file and the rest of its case, which has a structure."""
    found = Further()
    _read_mesh(case, path, found)
    return found.faults


def _read_mesh(case: Case, path: Path, found: Further) -> BuildingMesh | None:
    """The mesh, where it can be read; its faults and contradictions to the case are added."""
    generated = case.structure is not None and isinstance(case.structure.mesh, GeneratedMesh)
    read = found.attempt(lambda: read_parts(case, path))
    mesh = None if read is None else read[0].mesh
    if read is None and not generated:  # sections or heights hide no other fault
        mesh = found.attempt(lambda: read_mesh(path))
    if mesh is None:
        return None
    if case.wall_impact is not None:
        from impactfem.reduction.wall import wall_side

        floors, file = case.wall_impact.floors, case.path if generated else path
        found.attempt(lambda: wall_side(mesh, floors, file))
    if case.transient is not None:
        from impactfem.reduction.forces import check_contacts, with_floor_forces
        from impactfem.reduction.probes import checked_probes

        found.attempt(lambda: checked_probes(case, mesh))
        found.attempt(lambda: check_contacts(case, mesh))
        at_rest = ForceHistory(np.array([0.0, 1.0]), (), np.zeros((2, 0)))
        found.attempt(lambda: with_floor_forces(case, mesh, at_rest, []))
    if case.devices:
        from impactfem.building.links import find_base_plates
        from impactfem.reduction.probes import covered_points

        found.attempt(lambda: find_base_plates(case, mesh))
        found.attempt(lambda: covered_points(case, mesh))
    return mesh


def _time_faults(case: Case, computed: float) -> list[Fault]:
    """Steps and durations that do not go with the motions, whose records say how long they last."""
    half = f"expected at most half of what is computed, {computed:g} s"
    step, transient = case.pounding.time_step, case.transient
    faults = []
    if step > computed / 2.0:
        faults.append(Fault(case.path, "pounding.time_step", step, half))
    recorded = any(isinstance(motion, RecordMotion) for motion in case.motions)
    # Durations that the case itself states were checked when it was read.
    if transient and transient.forces is None and recorded and case.pounding.duration is None:
        step, lasting = transient.time_step, transient.duration
        if lasting is not None and lasting > computed * (1.0 + 1e-9):
            expected = f"expected at most what is computed of the sticks, {computed:g} s"
            faults.append(Fault(case.path, "transient.duration", lasting, expected))
        if lasting is None and step > computed / 2.0:
            faults.append(Fault(case.path, "transient.time_step", step, half))
    return faults
