"""The stage `design`: design spectra of the 3D building, and an ensemble of motions through it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from impactfem.case import Case
from impactfem.design.bases import at_nodes, further_basis, lacking
from impactfem.design.carried import CarriedEnsemble
from impactfem.design.member import Carrier
from impactfem.design.member_loads import MemberLoads, Pairs, member_loads, pairs_of
from impactfem.design.members import carry_members, stacked, stored_members
from impactfem.equipment.analysis import Analyst
from impactfem.equipment.prepared import Prepared as DevicePrepared
from impactfem.equipment.scalars import PREFERRED
from impactfem.equipment.spectrum_choice import SpectrumChoice
from impactfem.equipment.stage import analyst_of, device_model
from impactfem.equipment.study_model import StudyModel
from impactfem.equipment.support import supports_of
from impactfem.errors import ImpactfemError
from impactfem.log import LOGGER
from impactfem.parallel import on_root, workers
from impactfem.sticks.ensemble import Member, member_key, members_of
from impactfem.sticks.from_case import calibration_of, system_of
from impactfem.transient.prepared import Prepared, transient_of
from impactfem.transient.reduced_basis import ReducedBasis
from impactfem.transient.stage import BASIS

Step = Callable[[str], AbstractContextManager[None]]
Progress = Callable[[str, float], None]

FURTHER_BASIS = "design_basis.npz"
MEMBERS = Path("design") / "members"


@dataclass(frozen=True)
class Keys:
    """Hashes of what is kept from run to run.

    Args:
        basis: Of the reduced basis of the stage `transient`.
        device: Of the reduced model of the stage `device`; empty without devices.
        members: Of what the members depend on beside their motions.
    """

    basis: str
    device: str
    members: str


def carried_members(case: Case) -> list[Member]:
    """The members that are carried through the 3D building: the first of the ensemble."""
    count = 0 if case.ensemble is None else case.ensemble.structure_motions
    return members_of(case)[:count] if count else []


def carry_ensemble(
    case: Case,
    prepared: Prepared,
    equipment: DevicePrepared | None,
    folder: Path,
    comm: Any,
    step: Step,
    *,
    keys: Keys,
    within: Progress = lambda name, part: None,
) -> CarriedEnsemble | None:
    """Carry members of the ensemble through the 3D building and the devices. Collective.

    Args:
        case: The case, with the targets of its sticks and the numbers of its contact laws.
        prepared: Of the stage `transient`.
        equipment: Of the stage `device`; None without devices.
        folder: The run's folder.
        comm: Communicator of the matrices.
        step: Called with the name of each step ("sticks", "matrices", "basis", "members"), which
            runs inside its context.
        keys: Hashes of what is kept.
        within: Called with the name of a step and the part of it that is done.

    Returns:
        The ensemble on rank 0, None on the others.

    Raises:
        SolutionError: Fewer than two members gave a result, or a basis is not accurate enough.
        ImpactfemError: A file cannot be written.
    """
    members = carried_members(case)
    files, member_keys = on_root(lambda: _places(members, folder / MEMBERS, keys.members))
    found = stored_members(files, member_keys) if comm.rank == 0 else {}
    waiting = comm.bcast([member.name for member in members if member.name not in found])
    failed: dict[str, str] = {}
    loads: dict[str, MemberLoads] = {}
    nodes = np.array([probe.node for probe in prepared.probes])
    pairs = on_root(lambda: _pairs(case, prepared, folder))
    if waiting:

        def run_sticks() -> None:
            asked = [member for member in members if member.name in waiting]
            more, others = _loads(case, asked, pairs, lambda part: within("sticks", part))
            loads.update(more)
            failed.update(others)

        with step("sticks"):
            on_root(run_sticks)
        bases = _bases(case, prepared, loads, folder, comm, step, keys.basis, within)
        analyst = None
        if equipment is not None:
            model = device_model(
                case, equipment, folder, comm, step, model_key=keys.device, within=within
            )
            if model is not None:
                analyst = _analyst(case, equipment, model)
        with workers() as executor:
            if executor is None:
                return None  # this rank has worked for rank 0 until now
            carrier = Carrier(
                bases=tuple(at_nodes(basis, nodes) for basis in bases),
                nodes=nodes,
                damping=prepared.damping,
                spectra=case.spectra,
                analyst=analyst,
                choice=None if equipment is None else _choice(equipment),
            )
            with step("members"):
                count = len(loads)
                more, others = carry_members(
                    carrier,
                    loads,
                    files,
                    member_keys,
                    executor,
                    lambda done: within("members", done / count),
                )
        found |= more
        failed |= others
    if comm.rank != 0:
        return None
    names = [member.name for member in members if member.name in found]
    return CarriedEnsemble(
        members=tuple(names),
        failed=failed,
        floors=pairs.floors,
        devices=()
        if equipment is None
        else tuple(one.name for one in supports_of(equipment.devices)),
        analysis="" if equipment is None else _choice(equipment).label,
        **stacked(names, found, failed),
    )


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
    case: Case, members: list[Member], pairs: Pairs, progress: Callable[[float], None]
) -> tuple[dict[str, MemberLoads], dict[str, str]]:
    """The loads of members by name, and the reason of those whose sticks failed."""
    system = system_of(case, calibration_of(case))
    found: dict[str, MemberLoads] = {}
    failed: dict[str, str] = {}
    for number, member in enumerate(members, 1):
        try:
            found[member.name] = member_loads(member.case, system, pairs)
        except ImpactfemError as error:
            failed[member.name] = str(error)
            LOGGER.warning("warning: ensemble member %s failed: %s", member.name, error)
        progress(number / len(members))
    return found, failed


def _bases(
    case: Case,
    prepared: Prepared,
    loads: dict[str, MemberLoads],
    folder: Path,
    comm: Any,
    step: Step,
    key: str,
    within: Progress,
) -> list[ReducedBasis]:
    """That of the stage `transient`, and a further one for the loads that it lacks. Collective."""
    transient = transient_of(case)
    nodes = np.array([probe.node for probe in prepared.probes])
    own = _own_basis(prepared, folder, key) if comm.rank == 0 else None
    directions, edges = comm.bcast(lacking(own, [one.loads for one in loads.values()]))
    bases = [] if own is None else [own]
    if not directions and not edges:
        return bases
    names = [f"ground {'xyz'[c]}" for c in directions] + [edge.name for edge in edges]
    further_key = hashlib.sha256(f"{key}{nodes.tolist()}{prepared.damping}".encode()).hexdigest()
    path = folder / FURTHER_BASIS
    stored = ReducedBasis.read(path, further_key) if comm.rank == 0 else None
    if stored is not None and not set(names) <= set(stored.loads):
        stored = None
    if comm.bcast(stored is None):
        LOGGER.info("design: a further reduced basis for %s", ", ".join(names))
        made = further_basis(transient, prepared, comm, directions, edges, step, within)
        on_root(lambda: made.write(path, further_key))
        return [*bases, made]
    return bases if stored is None else [*bases, stored]


def _own_basis(prepared: Prepared, folder: Path, key: str) -> ReducedBasis | None:
    """The basis of the stage `transient`, if it has the probes and the ground motion."""
    found = ReducedBasis.read(folder / BASIS, key)
    nodes = np.array([probe.node for probe in prepared.probes])
    if found is None or not np.isin(nodes, found.nodes).all():
        return None
    ground = {f"ground {'xyz'[c]}" for c in prepared.loads.directions}
    return found if ground <= set(found.loads) else None


def _choice(equipment: DevicePrepared) -> SpectrumChoice:
    """The response spectrum analysis that counts: translations, spectra as computed."""
    asked = list(equipment.plans[0].rules)
    combination = next((one for one in PREFERRED if one in asked), asked[0])
    return SpectrumChoice(combination, rotations=False, broadened=False)


def _analyst(case: Case, equipment: DevicePrepared, model: StudyModel) -> Analyst:
    """What does that analysis alone of each device, beside the detailed one."""
    chosen = _choice(equipment).combination
    # The contacts of the wall experiment are most of the model, and of no use here.
    every = analyst_of(case, equipment, replace(model, wall=None))
    plans = [
        replace(
            plan,
            rules={one: rules for one, rules in plan.rules.items() if one == chosen},
            rotations=False,
            broadening=0.0,
            given=(),
        )
        for plan in every.plans
    ]
    return replace(every, plans=plans, covered=[()] * len(every.covered))
