"""The stage `design`: design spectra of the 3D building, and an ensemble of motions through it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh
from impactfem.case import Case
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.reduction.reduced_basis import ReducedBasis
from impactfem.reduction.reduced_building import CompleteModel, ReducedBuilding
from impactfem.stages.design.carried import CarriedEnsemble
from impactfem.stages.design.case_spectra import CaseSpectra, read_case_spectra
from impactfem.stages.design.member import Carrier
from impactfem.stages.design.member_loads import MemberLoads, Pairs, member_loads, pairs_of
from impactfem.stages.design.members import carry_members, stacked, stored_members
from impactfem.stages.design.point_spectra import BuildingMotion, Search, point_spectra
from impactfem.stages.design.whole_floors import WholeFloors, read_whole_floors
from impactfem.stages.device.analysis import Analyst
from impactfem.stages.device.compute import analyst_of
from impactfem.stages.device.prepared import Prepared as DevicePrepared
from impactfem.stages.device.spectrum_choice import SpectrumChoice, headline_of
from impactfem.stages.device.support import supports_of
from impactfem.stages.ensemble.compute import Member, member_key, members_of
from impactfem.stages.transient.prepared import Prepared, transient_of
from impactfem.system.errors import ImpactfemError
from impactfem.system.log import LOGGER
from impactfem.system.parallel import on_root, workers

Index = NDArray[np.int64]
Arrays = dict[str, Any]
Step = Callable[[str], AbstractContextManager[None]]
Progress = Callable[[str, float], None]
MEMBERS = Path("design") / "members"
EVERY = 2
"""At every so many-th frequency of the fields the vertices are sought that govern under other
motions: 33 in a decade."""


def choice_of(equipment: DevicePrepared) -> SpectrumChoice:
    """The response spectrum analysis that counts: translations, spectra as computed.

    Args:
        equipment: Of the stage `device`.
    """
    return headline_of(equipment.plans[0].rules)


def analyst_alone(case: Case, equipment: DevicePrepared, model: CompleteModel) -> Analyst:
    """What does the analysis that counts alone of each device, beside the detailed one.

    Args:
        case: The case.
        equipment: Of the stage `device`.
        model: Its reduced model.
    """
    chosen = choice_of(equipment)
    # The contacts of the wall experiment are most of the model, and of no use here.
    every = analyst_of(case, equipment, replace(model, wall=None))
    plans = [
        replace(
            plan,
            rules={
                (chosen.combination, chosen.rigid): plan.rules[chosen.combination, chosen.rigid]
            },
            rotations=False,
            broadening=0.0,
            given=(),
        )
        for plan in every.plans
    ]
    return replace(every, plans=plans, covered=[()] * len(every.covered))


def carried_members(case: Case) -> list[Member]:
    """The members that are carried through the 3D building: the first of the ensemble."""
    count = 0 if case.ensemble is None else case.ensemble.structure_motions
    return members_of(case)[:count] if count else []


@dataclass(frozen=True, eq=False)
class DesignStudy:
    """What the stage computed; on rank 0.

    Args:
        own: The spectra under the case's own motion.
        whole: Those over whole floors; None without fields over the floors.
        carried: The ensemble; None without one.
    """

    own: CaseSpectra
    whole: WholeFloors | None
    carried: CarriedEnsemble | None


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
    """Run the stage: the case's own motion, and an ensemble where one is asked for. Collective.

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
    own, whole = on_root(lambda: _seen(folder))
    run = _Run(case, prepared, equipment, folder, comm, step, reduced, key, within, own, whole)
    members = carried_members(case)
    files, member_keys = on_root(lambda: _places(members, folder / MEMBERS, run.members_key))
    found = stored_members(files, member_keys) if comm.rank == 0 else {}
    waiting = comm.bcast([member.name for member in members if member.name not in found])
    failed: dict[str, str] = {}
    loads: dict[str, MemberLoads] = {}
    pairs = on_root(lambda: _pairs(case, prepared, folder)) if members else None
    if waiting and pairs is not None:
        asked = [member for member in members if member.name in waiting]
        loads, failed = _loads_on_root(run, asked, pairs)
    if whole is not None or waiting:
        own = _with_vertices(run)
        if waiting:
            more, others = _carry(run, loads, files, member_keys)
            found |= more
            failed |= others
    if comm.rank != 0:
        return None
    names = [member.name for member in members if member.name in found]
    carried = None if pairs is None else _carried(run, pairs, names, found, failed)
    return DesignStudy(own, whole, carried)


@dataclass(frozen=True, eq=False)
class _Run:
    """What the parts of the stage share: the arguments of `run_design`, and what it read.

    Args:
        own: The spectra of the probes under the case's own motion.
        whole: Those over whole floors; None without.
    """

    case: Case
    prepared: Prepared
    equipment: DevicePrepared | None
    folder: Path
    comm: Any
    step: Step
    reduced: ReducedBuilding | None
    key: str
    within: Progress
    own: CaseSpectra
    whole: WholeFloors | None

    @property
    def basis(self) -> ReducedBasis:
        """The reduced basis; on rank 0."""
        if self.reduced is None:
            raise ValueError("rank 0 has the reduced building")
        return self.reduced.basis

    @property
    def probes(self) -> Index:
        """Nodes of the probes, shape (n_probes,)."""
        return np.array([probe.node for probe in self.prepared.probes])

    @property
    def points(self) -> Index:
        """Nodes of the probes and of the vertices that govern, ascending."""
        governing = [] if self.whole is None else [self.whole.governing.node]
        return _ascending([self.probes, *governing])

    @property
    def nodes(self) -> Index:
        """All nodes that are looked at under any motion, ascending."""
        candidates = [] if self.whole is None else [self.whole.candidates.node]
        return _ascending([self.points, *candidates])

    @property
    def search(self) -> Search | None:
        """Where the vertices are sought that govern under other motions."""
        if self.whole is None:
            return None
        return Search(self.whole.candidates, self.whole.frequency[::EVERY], self.whole.damping)

    @property
    def members_key(self) -> str:
        """Hash of what members depend on beside their motions, the search among vertices too."""
        search = "probes alone" if self.search is None else self.search.key
        return hashlib.sha256(f"{self.key}{search}".encode()).hexdigest()


def _ascending(nodes: list[Index]) -> Index:
    return np.asarray(np.unique(np.concatenate(nodes)), dtype=np.int64)


def _seen(folder: Path) -> tuple[CaseSpectra, WholeFloors | None]:
    """What the stage `transient` saw at probes and over the floors."""
    own = read_case_spectra(folder / "transient.nc")
    return own, read_whole_floors(folder / "transient_maps.nc", own.floors)


def _carried(
    run: _Run, pairs: Pairs, names: list[str], found: dict[str, Arrays], failed: dict[str, str]
) -> CarriedEnsemble:
    equipment = run.equipment
    return CarriedEnsemble(
        members=tuple(names),
        failed=failed,
        floors=pairs.floors,
        devices=()
        if equipment is None
        else tuple(one.name for one in supports_of(equipment.devices)),
        analysis="" if equipment is None else choice_of(equipment).label,
        **stacked(names, found, failed),
    )


def _with_vertices(run: _Run) -> CaseSpectra:
    """The case's own motion at the vertices that govern, too; on rank 0 alone."""
    if run.whole is None or run.comm.rank != 0:
        return run.own
    governing = run.whole.governing
    with run.step("vertices"):
        motion = BuildingMotion.under(run.basis, run.prepared.loads, run.prepared.damping)
        spectra = point_spectra(motion, governing.node, governing.component, run.case.spectra)
    LOGGER.info(
        "design: %d vertices govern the envelopes of the floors, each along one direction, of %d"
        " vertices",
        len(governing),
        run.whole.vertices.sum(),
    )
    return run.own.with_vertices(governing, spectra)


def _places(
    members: list[Member], folder: Path, key: str
) -> tuple[dict[str, Path], dict[str, str]]:
    """Where each member is kept, and the hash of what it depends on, by name."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {member.name: folder / f"{member.name}.npz" for member in members}
    return files, {member.name: member_key(member, key) for member in members}


def _pairs(case: Case, prepared: Prepared, folder: Path) -> Pairs:
    duration = prepared.loads.time_step * (len(prepared.loads.ground) - 1)
    return pairs_of(case, prepared.parts.mesh, folder / "forces.nc", duration)


def _loads(
    case: Case,
    mesh: BuildingMesh,
    members: list[Member],
    pairs: Pairs,
    progress: Callable[[float], None],
) -> tuple[dict[str, MemberLoads], dict[str, str]]:
    """The loads of members by name, and the reason of those whose sticks failed."""
    system = system_of(case, calibration_of(case))
    found: dict[str, MemberLoads] = {}
    failed: dict[str, str] = {}
    for number, member in enumerate(members, 1):
        try:
            found[member.name] = member_loads(member.case, system, pairs, mesh)
        except ImpactfemError as error:
            failed[member.name] = str(error)
            LOGGER.warning("warning: ensemble member %s failed: %s", member.name, error)
        progress(number / len(members))
    return found, failed


def _carry(
    run: _Run,
    loads: dict[str, MemberLoads],
    files: dict[str, Path],
    member_keys: dict[str, str],
) -> tuple[dict[str, Arrays], dict[str, str]]:
    """Carry members through building and devices. Collective.

    Returns:
        Results and reasons of failure, by name; empty on other ranks than 0.
    """
    analyst = _analyst(run)
    with workers() as executor:
        if executor is None:
            return {}, {}  # this rank has worked for rank 0 until now
        carrier = _carrier(run, analyst)
        with run.step("members"):
            count = len(loads)
            return carry_members(
                carrier,
                loads,
                files,
                member_keys,
                executor,
                lambda done: run.within("members", done / count),
            )


def _loads_on_root(
    run: _Run, members: list[Member], pairs: Pairs
) -> tuple[dict[str, MemberLoads], dict[str, str]]:
    """The step "sticks". Collective; on other ranks than 0 nothing is known of the loads."""
    loads: dict[str, MemberLoads] = {}
    failed: dict[str, str] = {}

    def run_sticks() -> None:
        mesh = run.prepared.parts.mesh
        more, others = _loads(
            run.case, mesh, members, pairs, lambda part: run.within("sticks", part)
        )
        loads.update(more)
        failed.update(others)

    with run.step("sticks"):
        on_root(run_sticks)
    return loads, failed


def _carrier(run: _Run, analyst: Analyst | None) -> Carrier:
    highest = transient_of(run.case).maximum_frequency
    nodes, points, damping, basis = run.nodes, run.points, run.prepared.damping, run.basis
    return Carrier(
        basis=replace(basis.at(nodes), difference=basis.error(points, damping, highest)),
        nodes=run.probes,
        floors=run.own.floors,
        search=run.search,
        damping=damping,
        spectra=run.case.spectra,
        analyst=analyst,
        choice=None if run.equipment is None else choice_of(run.equipment),
    )


def _analyst(run: _Run) -> Analyst | None:
    """What analyses the devices of the members; None without devices, and on other ranks than 0."""
    if run.equipment is None or run.reduced is None:
        return None
    return analyst_alone(run.case, run.equipment, run.reduced.complete)
