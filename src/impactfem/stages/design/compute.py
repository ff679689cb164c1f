"""The stage `design`: design spectra of the 3D building, and an ensemble of motions through it."""

import hashlib
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.case import Case
from impactfem.coupling.force_history import read_forces
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.reduction.edge_force import Shares
from impactfem.reduction.forces import checked_forces
from impactfem.reduction.loads import Loads
from impactfem.reduction.pounding_3d import Models3D
from impactfem.reduction.reduced_building import ReducedBuilding
from impactfem.reduction.response import modal_histories, record_spectra
from impactfem.stages.design.ensemble import (
    Arrays,
    Carrier,
    carry,
    motion_loads,
    point_records,
    stacked,
)
from impactfem.stages.design.floors import (
    NO_POINTS,
    WholeFloors,
    probe_points,
    read_probes,
    read_whole_floors,
)
from impactfem.stages.design.store import write_design
from impactfem.stages.device.analysis import supports_of
from impactfem.stages.device.compute import Prepared as DevicePrepared
from impactfem.stages.device.compute import analyst_of
from impactfem.stages.device.spectrum_plan import headline_of
from impactfem.stages.ensemble.compute import member_key, members_of, worked_off
from impactfem.stages.stores import of_run
from impactfem.stages.transient.prepared import Prepared, transient_of
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import read_archive
from impactfem.system.log import LOGGER, Steps
from impactfem.system.parallel import on_root, workers

FOLDER = Path("design") / "members"
EVERY = 2
"""At every so many-th frequency of the fields the vertices are sought that govern under other
motions: 33 in a decade."""


def run_design(
    case: Case,
    prepared: Prepared,
    equipment: DevicePrepared | None,
    reduced: ReducedBuilding | None,
    folder: Path,
    steps: Steps,
    *,
    key: str,
    members_key: str,
    models: Models3D | None = None,
) -> list[Path]:
    """Run the stage and write `design.nc`: the case's own motion, and an ensemble. Collective.

    Members of the ensemble are carried through the 3D building and the devices. The case has the
    targets of its sticks and the numbers of its contact laws; `equipment` is None without devices,
    or without an ensemble; `reduced` is None but on rank 0. `key` is the hash of the stage's
    inputs, `members_key` of what members depend on in addition to their motions; `models` are the
    3D models that pound, None where all buildings are sticks.

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
    # Members depend on where and how the vertices that govern are sought under other motions, too.
    search = "probes alone"
    if whole is not None:
        places = whole.candidates[["floor", "component", "node"]].to_numpy().tobytes()
        every = f"{whole.frequency[::EVERY].tolist()}{whole.damping}"
        search = f"{hashlib.sha256(places).hexdigest()}{every}"
    members_key = hashlib.sha256(f"{members_key}{search}".encode()).hexdigest()
    keys = {member.name: member_key(member, members_key) for member in members}
    files = {name: folder / FOLDER / f"{name}.npz" for name in keys}

    def stored() -> dict[str, Arrays]:
        known = {name: read_archive(files[name], own) for name, own in keys.items()}
        return {name: arrays for name, arrays in known.items() if arrays is not None}

    found = on_root(stored)
    waiting = [member for member in members if member.name not in found]
    names: tuple[str, ...] = ()
    edges: list[Shares] = []
    mesh, own = prepared.parts.mesh, prepared.loads
    loads: dict[str, tuple[Loads, Array]] = {}
    failed: dict[str, str] = {}
    if members:
        duration = own.time_step * (len(own.ground) - 1)
        path = of_run(folder, "forces.nc")
        history, edges = on_root(
            lambda: checked_forces(
                read_forces(path), path, case, mesh, duration, impulses=prepared.impulses
            )
        )
        names = history.pairs

    def run_sticks() -> None:
        (folder / FOLDER).mkdir(parents=True, exist_ok=True)
        system = system_of(case, calibration_of(case))
        for number, member in enumerate(waiting, 1):
            try:
                loads[member.name] = motion_loads(member.case, system, names, edges, mesh, models)
            except ImpactfemError as error:
                failed[member.name] = str(error)
                LOGGER.warning("warning: ensemble member %s failed: %s", member.name, error)
            steps.within("sticks", number / len(waiting))

    if waiting:
        # The loads stay on rank 0, which hands each to the worker that carries it.
        with steps.step("sticks"):
            on_root(run_sticks)
    spectra = None
    if whole is not None and reduced is not None:
        with steps.step("vertices"):
            modal = modal_histories(reduced.basis, own, prepared.damping).acceleration
            records = point_records(reduced.basis, own, modal, whole.governing)
            spectra = record_spectra(records, own.time_step, case.spectra)
        LOGGER.debug(
            "design: %d of %d floor vertices govern the envelopes, each along one direction",
            len(whole.governing),
            whole.vertices.sum(),
        )
    if waiting:
        carrier = None
        if reduced is not None:
            carrier = _carrier(case, prepared, equipment, reduced, probes, whole)
        with workers() as executor:
            if executor is not None and carrier is not None:
                with steps.step("members"):
                    more, others = worked_off(
                        partial(carry, carrier),
                        loads,
                        files,
                        keys,
                        executor,
                        lambda done: steps.within("members", done / len(loads)),
                        where=" in 3D",
                    )
                found |= more
                failed |= others

    def write() -> list[Path]:
        if reduced is None:
            raise ValueError("rank 0 has the reduced building")
        results: dict[str, Any] = {}
        analysis = ""
        if members:
            with_result = [member.name for member in members if member.name in found]
            results = stacked(with_result, found, failed) | {
                "motion": with_result,
                "edge": np.unique([shares[0][0].floor for shares in edges]).astype(np.int64),
                "failed": list(failed),
                "failed_reason": list(failed.values()),
            }
        if members and equipment is not None:
            results["device"] = [support.name for support in supports_of(equipment.plans)]
            results["component"] = ["x", "y", "z", "rx", "ry", "rz"]
            analysis = headline_of(equipment.plans[0].rules).label
        with steps.step("stores"):
            path = folder / "design.nc"
            write_design(path, case, key, probes, whole, spectra, results, analysis)
        return [folder / "design.nc"]

    return on_root(write)


def _carrier(
    case: Case,
    prepared: Prepared,
    equipment: DevicePrepared | None,
    reduced: ReducedBuilding,
    probes: xr.Dataset,
    whole: WholeFloors | None,
) -> Carrier:
    basis, highest = reduced.basis, transient_of(case).maximum_frequency
    governing = NO_POINTS if whole is None else whole.governing
    candidates = NO_POINTS if whole is None else whole.candidates
    points = np.union1d(probes["probe_node"].values, governing["node"])
    every = probe_points(probes)
    error = basis.error(points, prepared.damping, highest)
    analyst = choice = None
    if equipment is not None:
        # Of each device the analysis that counts alone, in addition to the detailed one:
        # translations, spectra as computed.
        choice = headline_of(equipment.plans[0].rules)
        rule = choice.combination, choice.rigid
        # The contacts of the wall experiment are most of the model, and of no use here.
        analyst = analyst_of(case, equipment, replace(reduced.complete, wall=None))
        plans = [
            replace(plan, rules={rule: plan.rules[rule]}, rotations=False, broadening=0.0, given=())
            for plan in analyst.plans
        ]
        analyst = replace(analyst, plans=plans, covered=[()] * len(analyst.covered))
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
        choice=choice,
    )
