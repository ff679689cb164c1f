"""Estimate of a run from its case alone: memory, disk, and time within a factor of 2 to 3.

Constants are fitted to the runs of docs/speed.md. With N degrees of freedom, c bytes each for
matrices, factor and blocks, and v vectors of a reduced basis that are held k times,

    memory = m0 + N (c + 8 k v),   v = loads · 53 (f / 300 ξ)^0.69 (1 + ln(1e-3 / tolerance) / 7),

f is the highest frequency, ξ the damping ratio there.
"""

import math
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Self

from impactfem.building.from_case import geometry_of
from impactfem.building.geometry import Geometry
from impactfem.building.mesh import BuildingMesh
from impactfem.case import Building3D, Case
from impactfem.case.buildings import FileMesh
from impactfem.case.motions import SyntheticMotion
from impactfem.case.transient import MAXIMUM_FREQUENCY, TOLERANCE
from impactfem.stages.manifest import Label
from impactfem.system.errors import Fault
from impactfem.system.memory import available_memory, disk_folder
from impactfem.system.parallel import threads, world

BASE, PER_DOF, SCENES = 0.35e9, 6.9e3, 0.6e9
"""Memory of the program, of a degree of freedom, and of a stage that draws the 3D model [byte]."""
COPIES, APART, DAY = 1.1, 20.0, 86400.0
"""Copies of the vectors of a basis; least time of a building for a separate process [s]."""
NODE = 130.0  # of a mesh file [byte]
TRIANGLES = 2.95  # in a square of the element size


@dataclass(frozen=True)
class StageCost:
    """The cost of a stage."""

    name: str
    seconds: float  #: [s]
    memory: float  #: largest memory [byte]
    file: float = 0.0  #: part of the memory that goes to a file where memory is short [byte]


@dataclass(frozen=True)
class Estimate:
    """The cost of a run."""

    stages: tuple[StageCost, ...]  #: of each stage
    disk: float  #: size of the run folder [byte]
    dofs: float  #: degrees of freedom of the largest 3D model; 0 without one
    longest: float  #: duration of the longest ground motion [s]

    def of(self, names: set[str]) -> Self:
        """Return the estimate of some stages; of all where none of them is named."""
        stages = tuple(one for one in self.stages if Label.of(one.name).stage in names)
        return replace(self, stages=stages or self.stages)

    @property
    def seconds(self) -> float:
        """Time of all stages [s]."""
        return sum(one.seconds for one in self.stages)

    @property
    def largest(self) -> StageCost:
        """The stage with the largest memory."""
        return max(self.stages, key=lambda one: one.memory)

    @property
    def line(self) -> str:
        """The estimate in a line."""
        most = self.largest
        file = f" ({1e-9 * most.file:.2g} GB of it can go to a file)" if most.file else ""
        size = f"; 3D model: {self.dofs:,.0f} degrees of freedom" if self.dofs else ""
        return (
            f"estimate: {duration(self.seconds)} (within a factor of 3), {1e-9 * most.memory:.2g} "
            f"GB of memory{file}, {_rounded(1e-6 * self.disk)} MB of disk{size}"
        )


def side_by_side(costs: Sequence[StageCost]) -> bool:
    """Whether a stage is computed for several buildings at a time, one core for each."""
    several = len(costs) > 1 and world() is None and threads() > 1
    room = sum(one.memory for one in costs) <= available_memory()
    return several and room and min(one.seconds for one in costs) >= APART


def estimate(
    case: Case, longest: float, meshes: Mapping[str, BuildingMesh] = MappingProxyType({})
) -> Estimate:
    """Estimate all stages of a case with its longest ground motion [s] and the known meshes."""
    computed, transient, spectra = case.computed_time(longest), case.transient, case.spectra
    steps, floors = computed / case.pounding.time_step, sum(len(b.floors) for b in case.buildings)
    # Histories with and without contact, and those refined for spectra.
    rate = case.pounding.time_step * max(spectra.frequency_values)
    refined = 1.0 + max(1.0, spectra.points_per_cycle * rate)
    memory = BASE + 0.2e9 + 8.0 * steps * floors * (63.0 + len(case.motions) * refined)
    made = [motion for motion in case.motions if isinstance(motion, SyntheticMotion)]
    memory += max((400.0 * one.duration / one.time_step for one in made), default=0.0)
    each = steps * floors * (2.4e-7 + 2e-10 * len(spectra.frequency_values))
    in_3d = sum(_vectors(one)[1] for one in case.modelled.values() if _lines(one))
    seconds = 8.0 + each + 1.2e-7 * in_3d * steps
    sticks, disk = [StageCost("pounding", seconds, memory)], 80.0 * steps * floors
    if case.ensemble is not None:
        motions = case.ensemble.motions or len(case.ensemble.files())
        time = 4.0 + motions * (0.6 + each + 8e-8 * in_3d * steps) / threads()
        sticks.append(StageCost("ensemble", time, memory + 2e6 * motions))
    models, largest = [], 0.0
    for name, building in case.modelled.items():
        structure, mesh = building.structure, meshes.get(name)
        start = f"{building.part}/" if building.part else ""
        if mesh is not None:
            nodes = float(len(mesh.nodes))
        elif isinstance(structure.mesh, FileMesh):
            nodes = structure.mesh.file.stat().st_size / NODE
        else:
            nodes = 2.0 * elements_of(geometry_of(building))
        dofs, (reduced, every) = 6.0 * nodes, _vectors(building)
        largest = max(largest, dofs)
        time = 40.0 * (dofs / 342_594) ** 1.15 * (0.5 + structure.modes / 40.0)
        models.append(StageCost(f"{start}building", 6.0 + time, BASE + dofs * PER_DOF))
        disk += nodes * (12.0 * structure.modes + 400.0) + 6.6 * dofs * reduced * 0.17 + 2e7
        if not every:
            continue
        time, room = dofs / 342_594 * (10.0 + 0.06 * every + 8e-5 * every**2), 8.0 * COPIES * dofs
        held = BASE + dofs * PER_DOF + room * every
        models.append(StageCost(f"{start}reduce", time, held, room * every))
        small = BASE + 0.25 * dofs * PER_DOF + SCENES
        if case.wall_impact is not None:
            models.append(StageCost(f"{start}calibrate", 6.0, small))
        if transient is not None:
            times = (transient.duration or computed) / transient.time_step
            full = 0.57e-6 * dofs * times if transient.solver != "reduced" else 0.0
            rate = transient.time_step * max(spectra.frequency_values)
            refined = 1.0 + max(1.0, spectra.points_per_cycle * rate)
            held = small + 0.2e9 + times * (16.0 * every + 1e3 * refined)
            models.append(StageCost(f"{start}transient", 25.0 + 3e-4 * times + full, held))
            fine = 8.0 * times * (1 + len(case.devices)) * (1 + len(case.damping_cases))
            if case.devices:
                models.append(StageCost(f"{start}device", 10.0 + 5e-10 * every * fine, held))
            models.append(StageCost(f"{start}design", 15.0, held))
    return Estimate((*models, *sticks), disk, largest, longest)


def too_much(case: Case, found: Estimate) -> Iterator[Fault]:
    """Yield the fault of a run that does not fit this machine: its memory, or the disk instead."""
    machine, stage = available_memory(whole=True), found.largest
    held = max(found.stages, key=lambda one: one.memory - one.file)
    ways = "expected longer time steps, larger elements, fewer vectors or records"
    if held.memory - held.file > machine:
        expected = (
            f"stage {held.name} needs about {1e-9 * (held.memory - held.file):.3g} GB of memory, "
            f"this machine has {1e-9 * machine:.3g} GB for it; {ways}"
        )
        of_steps = held.name == "pounding"  # whose memory is that of its histories
        key, value = ("pounding.time_step", case.pounding.time_step) if of_steps else ("", None)
        yield Fault(case.path, key, value, expected)
    elif stage.memory > machine:
        folder = disk_folder()
        try:
            free = shutil.disk_usage(folder).free
        except OSError:
            free = 0
        if min(stage.file, stage.memory - machine) > free:
            expected = (
                f"stage {stage.name} needs about {1e-9 * stage.memory:.3g} GB, this machine has "
                f"{1e-9 * machine:.3g} GB of memory, and {folder} {1e-9 * free:.3g} GB for the "
                f"rest; {ways}, or a folder named by TMPDIR"
            )
            yield Fault(case.path, "", None, expected)


def duration(seconds: float) -> str:
    """Return a time with two digits in a unit that suits it."""
    for limit, unit, word in ((120.0, 1.0, "s"), (7200.0, 60.0, "min"), (2 * DAY, 3600.0, "h")):
        if seconds < limit:
            return f"{_rounded(max(seconds / unit, 1.0))} {word}"
    return f"{_rounded(seconds / DAY)} days"


def _rounded(count: float) -> str:
    return f"{int(float(f'{count:.1e}')):,}"


def elements_of(geometry: Geometry) -> float:
    """Return the number of triangles of the generated mesh; the nodes are twice as many."""
    heights = [b - a for a, b in zip(geometry.levels, geometry.levels[1:], strict=False)]
    squares = len(geometry.floors) * geometry.length * geometry.width / geometry.size.floor**2
    for wall in geometry.walls:
        tall = sum(heights[k - 1] for k in wall.storeys if k <= len(heights))
        squares += math.dist(wall.start, wall.end) * tall / geometry.size.storey**2
    return TRIANGLES * max(squares, 1.0)


def _lines(building: Building3D) -> int:
    """Lines along which the 3D model of a building touches others, about one for each pair."""
    return len(building.contacts) if building.pounds else 0


def _vectors(building: Building3D) -> tuple[float, float]:
    """Vectors of the reduced building: of the response in time, and all with those of contacts."""
    transient, wall, lines = building.transient, building.wall_impact, _lines(building)
    if transient is None and wall is None and not lines:
        return 0.0, 0.0
    loads = len(building.case.motions) + (1 + len(building.contacts) if transient else 0) + lines
    loads += 0 if wall is None else 1 + len(wall.floors) * (transient is None)
    top = MAXIMUM_FREQUENCY if transient is None else transient.maximum_frequency
    tolerance = TOLERANCE if transient is None else transient.tolerance
    ratio = max(float(building.entry.damping.law.ratio(top)), 1e-4)
    growth = 53.0 * (top / ratio / 300.0) ** 0.69 * (1.0 + math.log(1e-3 / tolerance) / 7.0)
    contacts = (0 if wall is None else 50 + 30 * len(wall.floors)) + 120 * lines
    anchors = sum(len(device.anchor_points) for device in building.devices)
    return loads * growth + 0.6 * contacts, 1.2 * loads * growth + contacts + 12.0 * anchors
