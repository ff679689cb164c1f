"""The stage `design`: design spectra of the 3D building, and an ensemble of motions through it.

Each motion of the ensemble goes through the sticks first, whose impact forces then act on the 3D
building and the devices. Its results are stored as soon as they are there, so that an interrupted
run goes on.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh
from impactfem.case import Case, Spectra
from impactfem.coupling.force_history import ForceHistory, read_forces
from impactfem.coupling.from_case import calibration_of
from impactfem.dynamics.damping import DampingLaw
from impactfem.motion.from_case import ground_motions
from impactfem.reduction.edge_force import Shares
from impactfem.reduction.forces import checked_forces
from impactfem.reduction.loads import Loads
from impactfem.reduction.pounding_3d import Models3D
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.reduction.reduced_building import ReducedBuilding
from impactfem.reduction.response import modal_histories, record_spectra
from impactfem.spectra import response_spectra
from impactfem.stages.design.floors import (
    NO_POINTS,
    WholeFloors,
    counted,
    enveloped,
    fewest,
    probe_points,
    read_probes,
    read_whole_floors,
)
from impactfem.stages.design.store import write_design
from impactfem.stages.device.analysis import Analyst, SpectrumChoice, headline_of, supports_of
from impactfem.stages.device.compute import Prepared as DevicePrepared
from impactfem.stages.device.compute import analyst_of
from impactfem.stages.ensemble.compute import member_key, members_of, worked_off
from impactfem.stages.pounding.compute import pounded
from impactfem.stages.stores import of_run
from impactfem.stages.transient.maps import AS_THEY_ARE
from impactfem.stages.transient.prepared import Prepared, loads_on_edges, transient_of
from impactfem.sticks.calibration import Calibration
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError, SolutionError
from impactfem.system.files import read_archive
from impactfem.system.log import LOGGER, Steps
from impactfem.system.parallel import on_root, threads, workers

FOLDER = Path("design") / "members"
EVERY = 2
"""At every so many-th frequency of the fields the vertices are sought that govern under other
motions: 33 in a decade."""
AT_ONCE = 768
"""Records whose spectra are computed together."""
Arrays = dict[str, Any]


def motion_loads(
    case: Case,
    calibration: Calibration | None,
    names: Sequence[str],
    edges: Sequence[Shares],
    mesh: BuildingMesh,
    models: Models3D | None = None,
) -> tuple[Loads, Array]:
    """Compute the pounding under the motions of a case as the stage `pounding` does.

    Gives the loads at the step of the 3D model, by the patterns of each of the contact pairs that
    touch the building (`names`), and the largest force on each floor that a pair touches, ascending
    [N]; 0 on one that is not hit.

    Raises:
        InputError: A record is not usable.
        SolutionError: The sticks found no usable result, or their motion is too short.
    """
    motions = ground_motions(case.motions, accept=False)
    response = pounded(case, calibration, motions, models=models)
    duration = transient_of(case).duration or float(response.time[-1])
    if response.time[-1] < duration - case.pounding.time_step:
        raise SolutionError(
            f"the pounding ends at {response.time[-1]:g} s, the 3D model runs up to {duration:g} s"
        )
    exerted = ForceHistory.of_response(response)
    history = exerted.of([exerted.pairs.index(name) for name in names])
    loads = loads_on_edges(case, mesh, motions, history, list(edges), duration)
    # Pairs on one side push it together.
    largest: dict[int, float] = {}
    for side, columns in history.ends.sides(case.modelled.building).items():
        force = float(history.force[:, columns].sum(axis=1).max())
        largest[side.floor] = max(force, largest.get(side.floor, 0.0))
    peaks = [largest[one] for one in sorted(largest)]
    return loads, np.array(peaks, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Carrier:
    """What all motions share."""

    #: The reduced basis of the building, at all nodes of the points and candidates.
    basis: ReducedBasis
    points: pd.DataFrame  #: the probes of the floors, as of `probe_points`
    #: Which of them are at the mass centre of their floor, shape (n_points,).
    centres: NDArray[np.bool_]
    #: Among which the vertices that govern are sought; none without fields over the floors, where
    #: the probes stand alone for them.
    candidates: pd.DataFrame
    frequency: Array  #: at which frequencies they are sought [Hz]
    search_damping: float  #: with which damping of the oscillators [-]
    damping: DampingLaw  #: of the building
    spectra: Spectra  #: the case's floor spectra
    highest: float  #: frequency up to which the model is meant [Hz]
    analyst: Analyst | None  #: of the devices; None without devices
    choice: SpectrumChoice | None  #: which response spectrum analysis counts; None without devices


def point_records(
    basis: ReducedBasis, loads: Loads, modal: Array, points: pd.DataFrame, kind: Any = np.float64
) -> Array:
    """Absolute accelerations of points, each along its direction, shape (n, n_t) [m/s2].

    `modal` is q'' of the finest model of the basis under the loads, shape (r, n_t). In single
    precision, as `kind`, it takes half the time. KeyError: the basis was not made for a node.
    """
    component = points["component"].to_numpy()
    shapes = basis.of(basis.model, points["node"].to_numpy())[np.arange(len(points)), component]
    relative = shapes.astype(kind) @ modal.astype(kind)
    return np.asarray(relative + loads.ground.T[component], dtype=np.float64)


def carry(carrier: Carrier, loads: Loads, impact_force: Array) -> Arrays:
    """The results of one motion: the variables `member_...` of `design.nc` without the motions.

    From loads and largest forces as of `motion_loads`; these are among the results. Points are the
    probes and the vertices that govern under this motion; the error of the basis is that at the
    probes and at the vertices that govern under the case's own motion.

    Raises:
        ImpactfemError: A spectrum does not reach a mode of a device, or the result is not finite.
        KeyError: The basis has no pattern of one of the loads.
    """
    basis, floors = carrier.basis, int(carrier.centres.sum()) // 3
    modal = modal_histories(basis, loads, carrier.damping).acceleration
    # The fewest candidates whose envelope is near that of all candidates, as of `fewest`.
    every = carrier.candidates
    curves = np.empty((len(every), len(carrier.frequency) + 1))
    for first in range(0, len(every), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        # Records as they are, without samples between: enough to choose by.
        rough = response_spectra(
            point_records(basis, loads, modal, every.iloc[part], np.float32),
            loads.time_step,
            carrier.frequency,
            [carrier.search_damping],
            points_per_cycle=AS_THEY_ARE,
            threads=threads(),
            absolute=False,
        )
        curves[part, :-1], curves[part, -1] = rough.psa[0], rough.zpa
    groups = every.groupby(["floor", "component"]).indices.values()
    chosen = pd.concat([NO_POINTS, *(every.iloc[rows[fewest(curves[rows])]] for rows in groups)])
    points = pd.concat([carrier.points, chosen], join="inner")
    spectra = record_spectra(
        point_records(basis, loads, modal, points), loads.time_step, carrier.spectra
    )
    centres = np.flatnonzero(carrier.centres)
    meant = spectra.frequency <= carrier.highest * (1.0 + 1e-9)
    at_centres = spectra.psa[:, centres][..., meant]
    found = {
        "member_psa": enveloped(points, spectra.psa, floors, axis=1),
        "member_zpa": enveloped(points, spectra.zpa, floors),
        "member_centre_peak": at_centres.max(axis=2).reshape(-1, floors, 3),
        "member_vertices": counted(chosen, floors),
        "member_basis_error": np.array(basis.difference),
        "member_impact_force": impact_force,
    }
    if carrier.analyst is not None and carrier.choice is not None:
        results = carrier.analyst.analyse(loads, carrier.damping)
        by_spectrum = [one.values(carrier.choice) for one in results]
        found["member_device_force"] = np.array([one.detailed.largest for one in results])
        found["member_device_spectrum"] = np.array(by_spectrum)
    return found


def stacked(names: Sequence[str], found: Mapping[str, Arrays], failed: Mapping[str, str]) -> Arrays:
    """The results of all motions, each array with the motions first; at least two are needed."""
    if len(names) < 2:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in failed.items())
        raise SolutionError(
            f"fewer than two members of the ensemble went through the 3D model: {reasons}"
        )
    # Those that were stored before have their key among them.
    parts = [part for part in found[names[0]] if part != "key"]
    return {part: np.stack([found[name][part] for name in names]) for part in parts}


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
    members = dict(list(members_of(case).items())[:count]) if count else {}
    # Members depend on where and how the vertices that govern are sought under other motions, too.
    search = "probes alone"
    if whole is not None:
        places = whole.candidates[["floor", "component", "node"]].to_numpy().tobytes()
        every = f"{whole.frequency[::EVERY].tolist()}{whole.damping}"
        search = f"{hashlib.sha256(places).hexdigest()}{every}"
    members_key = hashlib.sha256(f"{members_key}{search}".encode()).hexdigest()
    keys = {name: member_key(member, members_key) for name, member in members.items()}
    files = {name: folder / FOLDER / f"{name}.npz" for name in keys}

    def stored() -> dict[str, Arrays]:
        known = {name: read_archive(files[name], own) for name, own in keys.items()}
        return {name: arrays for name, arrays in known.items() if arrays is not None}

    found = on_root(stored)
    waiting = {name: member for name, member in members.items() if name not in found}
    names: tuple[str, ...] = ()
    edges: list[Shares] = []
    mesh, own = prepared.parts.mesh, prepared.loads
    loads: dict[str, tuple[Loads, Array]] = {}
    failed: dict[str, str] = {}
    if members:
        duration = own.time_step * (len(own.ground) - 1)
        path = of_run(folder, "forces.nc")
        given = on_root(lambda: read_forces(path))  # what they were made from is known by now
        history, edges = on_root(
            lambda: checked_forces(
                given, path, case, mesh, duration, given.inputs, prepared.impulses
            )
        )
        names = history.pairs

    def run_sticks() -> None:
        (folder / FOLDER).mkdir(parents=True, exist_ok=True)
        calibration = calibration_of(case)
        for number, (name, member) in enumerate(waiting.items(), 1):
            try:
                loads[name] = motion_loads(member, calibration, names, edges, mesh, models)
            except ImpactfemError as error:
                failed[name] = str(error)
                LOGGER.warning("warning: ensemble member %s failed: %s", name, error)
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
        results: dict[str, Any] = {}
        analysis = ""
        if members:
            with_result = [name for name in members if name in found]
            forces = [shares[0][0] for shares in edges]
            floors = sorted({force.floor for force in forces})
            storeys = {force.floor for force in forces if force.height is not None}
            results = stacked(with_result, found, failed) | {
                "motion": with_result,
                "edge": np.array(floors, dtype=np.int64),
                "edge_storey": [int(floor in storeys) for floor in floors],
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
        highest=highest,
        analyst=analyst,
        choice=choice,
    )
