"""An ensemble of motions through the sticks, the 3D building and the devices.

Each result is stored when it is computed. An interrupted run resumes with the stored results.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from impactfem.case import Case
from impactfem.coupling.force_history import ForceHistory, read_forces
from impactfem.coupling.from_case import calibration_of
from impactfem.motion.from_case import ground_motions
from impactfem.reduction.edge_force import Shares
from impactfem.reduction.forces import checked_forces
from impactfem.reduction.loads import Loads
from impactfem.stages.design.carrier import EVERY, Arrays, Carrier, DesignInputs, carry
from impactfem.stages.design.floors import WholeFloors
from impactfem.stages.device.analysis import supports_of
from impactfem.stages.device.choice import headline_of
from impactfem.stages.ensemble.compute import member_key, members_of, worked_off
from impactfem.stages.pounding.compute import pounded
from impactfem.stages.stores import of_run
from impactfem.stages.transient.prepared import loads_on_edges
from impactfem.sticks.calibration import Calibration
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError, SolutionError
from impactfem.system.files import read_archive
from impactfem.system.log import LOGGER
from impactfem.system.parallel import on_root

FOLDER = Path("design") / "members"


@dataclass(eq=False)
class Members:
    """The motions of an ensemble, and the results so far."""

    inputs: DesignInputs
    cases: dict[str, Case]  #: the case with the motions of each member, by its name
    keys: dict[str, str]  #: hash of the inputs of each member
    files: dict[str, Path]  #: file of each result
    results: dict[str, Arrays]  #: results of `carry`
    pairs: tuple[str, ...]  #: the contact pairs that touch the building
    edges: list[Shares]  #: the patterns of each of them on the building
    loads: dict[str, tuple[Loads, Array]] = field(default_factory=dict)  #: of `motion_loads`
    failed: dict[str, str] = field(default_factory=dict)  #: reasons of members without a result

    @classmethod
    def of(cls, inputs: DesignInputs, folder: Path, whole: WholeFloors | None) -> Members | None:
        """Read the stored results of the ensemble; None without an ensemble. Collective.

        InputError: `forces.nc`, in the folder of the run, is not usable.
        """
        prepared, building = inputs.prepared, inputs.prepared.building
        case = building.case
        count = 0 if case.ensemble is None else case.ensemble.structure_motions
        if not count:
            return None
        cases = dict(list(members_of(case).items())[:count])
        # Members depend on the search for the governing vertices, too.
        search = "probes alone"
        if whole is not None:
            places = whole.candidates[["floor", "component", "node"]].to_numpy().tobytes()
            every = f"{whole.frequency[::EVERY].tolist()}{whole.damping}"
            search = f"{hashlib.sha256(places).hexdigest()}{every}"
        shared = hashlib.sha256(f"{inputs.members_key}{search}".encode()).hexdigest()
        keys = {name: member_key(member, shared) for name, member in cases.items()}
        files = {name: folder / FOLDER / f"{name}.npz" for name in keys}
        results = on_root(lambda: {name: read_archive(files[name], keys[name]) for name in keys})
        path, loads, mesh = of_run(folder, "forces.nc"), prepared.loads, prepared.parts.mesh
        duration = loads.time_step * (len(loads.ground) - 1)
        given = on_root(lambda: read_forces(path))  # the stage before checked its inputs
        history, edges = on_root(
            lambda: checked_forces(
                given, path, building, mesh, duration, given.inputs, prepared.impulses
            )
        )
        known = {name: arrays for name, arrays in results.items() if arrays is not None}
        return cls(inputs, cases, keys, files, known, history.pairs, edges)

    @property
    def waiting(self) -> list[str]:
        """Names of the members without a result."""
        return [name for name in self.cases if name not in self.results]

    def pound(self, progress: Callable[[float], None]) -> None:
        """Compute the pounding of the waiting members. On rank 0, which keeps the loads."""
        waiting, calibration = self.waiting, calibration_of(self.inputs.prepared.building.case)
        next(iter(self.files.values())).parent.mkdir(parents=True, exist_ok=True)
        for number, name in enumerate(waiting, 1):
            try:
                self.loads[name] = motion_loads(
                    self.cases[name], calibration, self.pairs, self.edges, self.inputs
                )
            except ImpactfemError as error:
                self.failed[name] = str(error)
                LOGGER.warning("warning: ensemble member %s failed: %s", name, error)
            progress(number / len(waiting))

    def carry(
        self, carrier: Carrier, executor: Executor, progress: Callable[[float], None]
    ) -> None:
        """Compute the 3D building and the devices under the loads of `pound`. On rank 0."""
        count = len(self.loads)
        found, failed = worked_off(
            partial(carry, carrier),
            self.loads,
            self.files,
            self.keys,
            executor,
            lambda done: progress(done / count),
            where=" in 3D",
        )
        self.results |= found
        self.failed |= failed

    def values(self) -> dict[str, Any]:
        """Return the values of the store: all results, each array with the motions first.

        Raises:
            SolutionError: Fewer than two members have a result.
        """
        names = [name for name in self.cases if name in self.results]
        forces = [shares[0][0] for shares in self.edges]
        floors = sorted({force.floor for force in forces})
        storeys = {force.floor for force in forces if force.height is not None}
        found = stacked(names, self.results, self.failed) | {
            "motion": names,
            "edge": np.array(floors, dtype=np.int64),
            "edge_storey": [int(floor in storeys) for floor in floors],
            "failed": list(self.failed),
            "failed_reason": list(self.failed.values()),
        }
        if (equipment := self.inputs.equipment) is not None:
            found["device"] = [support.name for support in supports_of(equipment.plans)]
            found["component"] = ["x", "y", "z", "rx", "ry", "rz"]
        return found

    @property
    def analysis(self) -> str:
        """Name of the response spectrum analysis of the devices; "" without devices."""
        equipment = self.inputs.equipment
        return "" if equipment is None else headline_of(equipment.plans[0].rules).label


def motion_loads(
    case: Case,
    calibration: Calibration | None,
    pairs: Sequence[str],
    edges: Sequence[Shares],
    inputs: DesignInputs,
) -> tuple[Loads, Array]:
    """Compute the pounding under the motions of a case as the stage `pounding` does.

    Gives the loads at the step of the 3D model, by the patterns (`edges`) of the contact pairs that
    touch the building, and the largest force on each floor that a pair touches, ascending [N]; 0 on
    a floor without an impact.

    Raises:
        InputError: A record is not usable.
        SolutionError: The sticks found no usable result, or their motion is too short.
    """
    building = replace(inputs.prepared.building, case=case)
    motions = ground_motions(case.motions, accept=False)
    response = pounded(case, calibration, motions, models=inputs.models)
    duration = building.transient.duration or float(response.time[-1])
    if response.time[-1] < duration - case.pounding.time_step:
        raise SolutionError(
            f"the pounding ends at {response.time[-1]:g} s, the 3D model runs up to {duration:g} s"
        )
    every = ForceHistory.of_response(response)
    history = every.of([every.pairs.index(name) for name in pairs])
    mesh = inputs.prepared.parts.mesh
    loads = loads_on_edges(building, mesh, motions, history, list(edges), duration)
    # Pairs on one side push it together.
    largest: dict[int, float] = {}
    for side, columns in history.ends.sides(building.name).items():
        force = float(history.force[:, columns].sum(axis=1).max())
        largest[side.floor] = max(force, largest.get(side.floor, 0.0))
    return loads, np.array([largest[floor] for floor in sorted(largest)], dtype=np.float64)


def stacked(names: Sequence[str], found: Mapping[str, Arrays], failed: Mapping[str, str]) -> Arrays:
    """Stack the results of at least two members, each array with the motions first."""
    if len(names) < 2:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in failed.items())
        raise SolutionError(
            f"fewer than two members of the ensemble have a result in the 3D model: {reasons}"
        )
    # Stored results have their key among them.
    parts = [part for part in found[names[0]] if part != "key"]
    return {part: np.stack([found[name][part] for name in names]) for part in parts}
