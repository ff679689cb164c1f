"""Impact forces of one member of an ensemble, and its loads on the 3D building."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh
from impactfem.case import Case
from impactfem.coupling.force_history import ForceHistory, read_forces
from impactfem.coupling.from_case import loads_of
from impactfem.coupling.pounding import System, interpolate_ground, simulate
from impactfem.motion.from_case import ground_motions
from impactfem.reduction.forces import checked_forces, with_floor_forces
from impactfem.reduction.loads import EdgeForce, Loads, make_loads
from impactfem.stages.transient.prepared import transient_of
from impactfem.system.errors import SolutionError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pairs:
    """The contact pairs that touch the building of the 3D model.

    Args:
        names: Their names.
        edges: What a positive force of each does to the building.
    """

    names: tuple[str, ...]
    edges: tuple[EdgeForce, ...]

    @property
    def floors(self) -> tuple[int, ...]:
        """Numbers of the floors that they touch, ascending."""
        return tuple(sorted({edge.floor for edge in self.edges}))


@dataclass(frozen=True, eq=False)
class MemberLoads:
    """What a member does to the 3D building.

    Args:
        loads: At the step of the 3D model.
        peak_force: Largest force of the sticks on each of the floors of the pairs, shape
            (n_floors,) [N]; 0 on one that is not hit.
    """

    loads: Loads
    peak_force: Array


def pairs_of(case: Case, mesh: BuildingMesh, forces: Path, duration: float) -> Pairs:
    """The pairs of a case, which are the same for all motions.

    Args:
        case: The case, with a structure.
        mesh: The mesh of its building.
        forces: `forces.nc` of the case's own motion.
        duration: Time that is to be computed [s].

    Raises:
        InputError: A pair cannot act on the edge of a floor.
    """
    history, edges = checked_forces(read_forces(forces), forces, case, mesh, duration)
    return Pairs(history.pairs, tuple(edges))


def member_loads(case: Case, system: System, pairs: Pairs, mesh: BuildingMesh) -> MemberLoads:
    """Run the sticks under the motions of a member as the stage `pounding` does.

    Args:
        case: The case with the motions of the member.
        system: The sticks.
        pairs: Those that touch the building.
        mesh: The mesh of the building.

    Raises:
        InputError: A record is not usable.
        SolutionError: The sticks found no usable result, or their motion is too short.
    """
    transient, dt = transient_of(case), case.pounding.time_step
    motions = ground_motions(case.motions, accept=False)
    along = [motion.history for motion in motions]
    longest = max(motion.accelerogram.duration for motion in motions)
    n_t = round((case.pounding.duration or longest) / dt) + 1
    ground, forces = interpolate_ground(along, dt, n_t), loads_of(case, system, dt, n_t)
    response = simulate(system, ground, dt, update=case.pounding.update, loads=forces)
    duration = transient.duration or float(response.time[-1])
    if response.time[-1] < duration - dt:
        raise SolutionError(
            f"the sticks end at {response.time[-1]:g} s, the 3D model is asked up to {duration:g} s"
        )
    names = [pair.name for pair in system.pairs]
    columns = [names.index(name) for name in pairs.names]
    own = ForceHistory(response.time, pairs.names, response.force[:, columns])
    n_steps = math.floor(duration / transient.time_step * (1.0 + 1e-9))
    every, edges = with_floor_forces(case, mesh, own, list(pairs.edges))
    external = len(edges) - len(pairs.edges)
    loads = make_loads(along, every, edges, transient.time_step, n_steps, external)
    floor = np.array([edge.floor for edge in pairs.edges])
    peaks = [own.force[:, floor == k].max() for k in pairs.floors]
    return MemberLoads(loads, np.maximum(np.array(peaks, dtype=np.float64), 0.0))
