"""The stage `design`: design spectra of the 3D building, and an ensemble of motions through it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.case import Case
from impactfem.coupling.force_history import read_forces
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.reduction.forces import checked_forces
from impactfem.reduction.loads import EdgeForce, Loads
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.reduction.reduced_building import CompleteModel, ReducedBuilding
from impactfem.reduction.response import modal_histories, record_spectra
from impactfem.spectra.response_spectrum import ResponseSpectra
from impactfem.stages.design.ensemble import (
    Array,
    Carrier,
    Ensemble,
    carry_motions,
    motion_loads,
    point_records,
    stacked,
    stored_motions,
)
from impactfem.stages.design.floors import (
    NO_POINTS,
    WholeFloors,
    probe_points,
    read_probes,
    read_whole_floors,
)
from impactfem.stages.device.analysis import Analyst, supports_of
from impactfem.stages.device.compute import Prepared as DevicePrepared
from impactfem.stages.device.compute import analyst_of
from impactfem.stages.device.spectrum_plan import SpectrumChoice, headline_of
from impactfem.stages.ensemble.compute import member_key, members_of
from impactfem.stages.stores import of_run
from impactfem.stages.transient.prepared import Prepared, transient_of
from impactfem.system.errors import ImpactfemError
from impactfem.system.log import LOGGER
from impactfem.system.parallel import on_root, workers

Step = Callable[[str], AbstractContextManager[None]]
Progress = Callable[[str, float], None]
FOLDER = Path("design") / "members"
EVERY = 2
"""At every so many-th frequency of the fields the vertices are sought that govern under other
motions: 33 in a decade."""


@dataclass(frozen=True, eq=False)
class DesignStudy:
    """What the stage computed; on rank 0."""

    #: The spectra of the probes under the case's own motion, as of `read_probes`.
    probes: xr.Dataset
    whole: WholeFloors | None  #: those over whole floors; None without fields over the floors
    #: Of the vertices that govern, in their order; None without fields.
    vertex_spectra: ResponseSpectra | None
    ensemble: Ensemble | None  #: the ensemble; None without one


def run_design(
    case: Case,
    prepared: Prepared,
    equipment: DevicePrepared | None,
    folder: Path,
    comm: Any,
    step: Step,
    *,
    reduced: ReducedBuilding | None,
    key: str,
    within: Progress = lambda name, part: None,
) -> DesignStudy | None:
    """Run the stage: the case's own motion, and an ensemble where one is requested. Collective.

    Members of the ensemble are carried through the 3D building and the devices.

    Args:
        case: The case, with the targets of its sticks and the numbers of its contact laws.
        prepared: Of the stage `transient`.
        equipment: Of the stage `device`; None without devices, or without an ensemble.
        folder: The run's folder.
        comm: Communicator of the matrices.
        step: Called with the name of each step ("sticks", "vertices", "members"), which runs
            inside its context.
        reduced: The reduced building on rank 0.
        key: Hash of what the members depend on in addition to their motions.
        within: Called with the name of a step and the part of it that is done.

    Returns:
        The results on rank 0, None on the others.

    Raises:
        SolutionError: Fewer than two members gave a result.
        ImpactfemError: A file cannot be read or written.
    """
    probes = on_root(lambda: read_probes(folder / "transient.nc"))
    whole = on_root(
        lambda: read_whole_floors(folder / "transient_maps.nc", probes["elevation"].values)
    )
    # The first of the ensemble.
    count = 0 if case.ensemble is None else case.ensemble.structure_motions
    members = members_of(case)[:count] if count else []
    key = hashlib.sha256(f"{key}{_search_key(whole)}".encode()).hexdigest()
    keys = {member.name: member_key(member, key) for member in members}
    files = {name: folder / FOLDER / f"{name}.npz" for name in keys}
    found = on_root(lambda: stored_motions(files, keys)) if members else {}
    waiting = [member for member in members if member.name not in found]
    names: tuple[str, ...] = ()
    edges: list[EdgeForce] = []
    mesh = prepared.parts.mesh
    loads: dict[str, tuple[Loads, Array]] = {}
    failed: dict[str, str] = {}
    if members:
        duration = prepared.loads.time_step * (len(prepared.loads.ground) - 1)
        path = of_run(folder, "forces.nc")
        history, edges = on_root(
            lambda: checked_forces(read_forces(path), path, case, mesh, duration)
        )
        names = history.pairs

    def run_sticks() -> None:
        (folder / FOLDER).mkdir(parents=True, exist_ok=True)
        system = system_of(case, calibration_of(case))
        for number, member in enumerate(waiting, 1):
            try:
                loads[member.name] = motion_loads(member.case, system, names, edges, mesh)
            except ImpactfemError as error:
                failed[member.name] = str(error)
                LOGGER.warning("warning: ensemble member %s failed: %s", member.name, error)
            within("sticks", number / len(waiting))

    if waiting:
        # The loads stay on rank 0, which hands each to the worker that carries it.
        with step("sticks"):
            on_root(run_sticks)
    spectra = None
    if whole is not None and comm.rank == 0:
        with step("vertices"):
            basis, own = _basis_of(reduced), prepared.loads
            modal = modal_histories(basis, own, prepared.damping).acceleration
            records = point_records(basis, own, modal, whole.governing)
            spectra = record_spectra(records, own.time_step, case.spectra)
        LOGGER.info(
            "design: %d vertices govern the envelopes of the floors, each along one direction, of"
            " %d vertices",
            len(whole.governing),
            whole.vertices.sum(),
        )
    if waiting:
        carrier = None
        if comm.rank == 0:
            carrier = _carrier(case, prepared, equipment, reduced, probes, whole)
        with workers() as executor:
            if executor is not None and carrier is not None:
                with step("members"):
                    more, others = carry_motions(
                        carrier,
                        loads,
                        files,
                        keys,
                        executor,
                        lambda done: within("members", done / len(loads)),
                    )
                found |= more
                failed |= others
    if comm.rank != 0:
        return None
    if not members:
        return DesignStudy(probes, whole, spectra, None)
    with_result = [member.name for member in members if member.name in found]
    ensemble = Ensemble(
        motions=tuple(with_result),
        failed=failed,
        edges=tuple(sorted({edge.floor for edge in edges})),
        devices=tuple(s.name for s in supports_of(equipment.plans)) if equipment else (),
        analysis=choice_of(equipment).label if equipment else "",
        results=stacked(with_result, found, failed),
    )
    return DesignStudy(probes, whole, spectra, ensemble)


def choice_of(equipment: DevicePrepared) -> SpectrumChoice:
    """The response spectrum analysis that counts: translations, spectra as computed."""
    return headline_of(equipment.plans[0].rules)


def _search_key(whole: WholeFloors | None) -> str:
    """Hash of where and how the vertices that govern are sought under other motions."""
    if whole is None:
        return "probes alone"
    every = whole.candidates[["floor", "component", "node"]].to_numpy()
    places = hashlib.sha256(every.tobytes()).hexdigest()
    return f"{places}{whole.frequency[::EVERY].tolist()}{whole.damping}"


def _basis_of(reduced: ReducedBuilding | None) -> ReducedBasis:
    if reduced is None:
        raise ValueError("rank 0 has the reduced building")
    return reduced.basis


def _carrier(
    case: Case,
    prepared: Prepared,
    equipment: DevicePrepared | None,
    reduced: ReducedBuilding | None,
    probes: xr.Dataset,
    whole: WholeFloors | None,
) -> Carrier:
    basis, highest = _basis_of(reduced), transient_of(case).maximum_frequency
    governing = NO_POINTS if whole is None else whole.governing
    candidates = NO_POINTS if whole is None else whole.candidates
    points = np.union1d(probes["probe_node"].values, governing["node"])
    every = probe_points(probes)
    error = basis.error(points, prepared.damping, highest)
    analyst = None
    if equipment is not None and reduced is not None:
        analyst = _analyst(case, equipment, reduced.complete)
    return Carrier(
        basis=replace(basis.at(np.union1d(points, candidates["node"])), difference=error),
        points=every,
        centres=np.isin(every["point"], probes["centre"].values),
        candidates=candidates,
        frequency=np.zeros(0) if whole is None else whole.frequency[::EVERY],
        search_damping=0.0 if whole is None else whole.damping,
        damping=prepared.damping,
        spectra=case.spectra,
        analyst=analyst,
        choice=None if equipment is None else choice_of(equipment),
    )


def _analyst(case: Case, equipment: DevicePrepared, model: CompleteModel) -> Analyst:
    """What does the analysis that counts alone of each device, in addition to the detailed one."""
    chosen = choice_of(equipment)
    rule = chosen.combination, chosen.rigid
    # The contacts of the wall experiment are most of the model, and of no use here.
    every = analyst_of(case, equipment, replace(model, wall=None))
    plans = [
        replace(plan, rules={rule: plan.rules[rule]}, rotations=False, broadening=0.0, given=())
        for plan in every.plans
    ]
    return replace(every, plans=plans, covered=[()] * len(every.covered))
