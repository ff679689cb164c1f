"""What a run will take, from its case alone: steps, unknowns, memory, time and disk by stage.

Constants are fitted to the runs of docs/speed.md (342,594 and 1,464,204 degrees of freedom, one
core) and of the small cases of geometry/: each within a factor of 2 on such a machine. Memory is

    m = m0 + N (c + 8 k v) + histories,

N degrees of freedom with c bytes each for matrices, factor and blocks, v vectors of a reduced basis
that are held k times. v is the number of loads times the block steps of the Krylov basis, which
grow with f / ζ(f), the highest frequency and the damping ratio there.
"""

import math
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Self

from impactfem.building.from_case import geometry_of
from impactfem.building.geometry import Geometry
from impactfem.building.mesh import BuildingMesh
from impactfem.case import Case, DampingEntry
from impactfem.case.buildings import FileMesh, Structure
from impactfem.case.motions import SyntheticMotion
from impactfem.case.transient import MAXIMUM_FREQUENCY, TOLERANCE, Transient
from impactfem.system.errors import Fault
from impactfem.system.memory import available_memory, disk_folder
from impactfem.system.parallel import threads, world

DOFS = 6  # of a node
TRIANGLES = 2.95
"""Triangles in a square of the target size: gmsh's are equilateral, of 0.88 of it."""
BASE = 0.35e9
"""Memory of the program without a model [byte]."""
PER_DOF = 6.9e3
"""Memory of matrices, factor and blocks for each degree of freedom [byte]."""
COPIES = 1.1
"""How often the vectors of a reduced basis are held, those that tell its error included."""
PICTURES = 0.2e9
"""Further memory of a stage that draws curves [byte]."""
SCENES = 0.6e9
"""Further memory of a stage that draws fields on the 3D model [byte]."""
GROUP = 40
"""Nodes of a probe that is a group of the mesh, such as an edge."""
APART = 20.0
"""Time that a stage takes for each building from which on they are computed side by side [s]: a
process of its own takes some seconds to start."""
DAY = 86400.0


@dataclass(frozen=True)
class StageCost:
    """What a stage takes."""

    name: str
    seconds: float  #: on one core, or on all of them where it uses them [s]
    memory: float  #: largest memory [byte]
    file: float = 0.0  #: part of the memory that goes to a file where memory is short [byte]
    disk: float = 0.0  #: what it leaves in the folder of the run [byte]


@dataclass(frozen=True)
class ModelSize:
    """How large a 3D model is."""

    name: str  #: how it is called in lines
    dofs: int  #: degrees of freedom
    meshed: bool  #: whether they are counted, not estimated from areas and element sizes
    vectors: dict[str, int]  #: number of vectors of the reduced basis of each stage that has one

    @property
    def line(self) -> str:
        """Its size in words."""
        counted = f"{self.dofs:,}" if self.meshed else f"about {_rounded(self.dofs):,}"
        vectors = ", ".join(f"{_rounded(n):,} {name}" for name, n in self.vectors.items())
        of_bases = f"; vectors of the reduced building: about {vectors}" if vectors else ""
        return f"{self.name}: {counted} degrees of freedom{of_bases}"


@dataclass(frozen=True)
class Estimate:
    """What a run will take."""

    steps: dict[str, int]  #: number of steps of each time loop, by what moves in it
    models: tuple[ModelSize, ...]  #: the 3D models, which run one after another
    stages: tuple[StageCost, ...]  #: what each stage takes
    longest: float  #: duration of the longest ground motion [s]

    def of(self, names: set[str]) -> Self:
        """The estimate of some stages; of all where none is named, as of a case at fault."""
        stages = tuple(one for one in self.stages if one.name.rpartition("/")[2] in names)
        return replace(self, stages=stages or self.stages)

    @property
    def dofs(self) -> int | None:
        """Degrees of freedom of the largest 3D model; None without one."""
        return max((model.dofs for model in self.models), default=None)

    @property
    def in_turn(self) -> Iterator[StageCost]:
        """What is computed one after the other, those of several buildings together as one."""
        named: dict[str, list[StageCost]] = {}
        for one in self.stages:
            named.setdefault(one.name.rpartition("/")[2], []).append(one)
        for name, some in named.items():
            if side_by_side(some):
                times = [one.seconds for one in some]
                parts = zip(*((one.memory, one.file, one.disk) for one in some), strict=True)
                yield StageCost(name, max(*times, sum(times) / threads()), *map(sum, parts))
            else:
                yield from some

    @property
    def largest(self) -> StageCost:
        """What takes the largest memory."""
        return max(self.in_turn, key=lambda stage: stage.memory)

    @property
    def seconds(self) -> float:
        """Time of all stages [s]."""
        return sum(stage.seconds for stage in self.in_turn)

    def lines(self) -> Iterator[str]:
        """The estimate in a few lines."""
        yield "steps: " + ", ".join(f"{count:,} {of}" for of, count in self.steps.items())
        yield from (model.line for model in self.models)
        each = ", ".join(
            f"{one.name} {duration(one.seconds)} {1e-9 * one.memory:.2g} GB" for one in self.stages
        )
        disk, most = sum(one.disk for one in self.stages), self.largest
        memory = f"{1e-9 * most.memory:.2g} GB of memory"
        if most.file > 0.0:
            memory += f" ({1e-9 * most.file:.2g} GB of it in a file where memory is short)"
        yield (
            f"about {duration(self.seconds)}, {memory} and {_rounded(1e-6 * disk):,} MB of disk, "
            f"within a factor of 2: {each}"
        )


def side_by_side(costs: Sequence[StageCost]) -> bool:
    """Whether a stage is computed for several buildings at a time, each on a core of its own.

    In one process with several cores, where there is memory for all and enough to do for each.
    """
    return (
        len(costs) > 1
        and world() is None
        and threads() > 1
        and min(one.seconds for one in costs) >= APART
        and sum(one.memory for one in costs) <= available_memory()
    )


def estimate(
    case: Case, longest: float, meshes: Mapping[str, BuildingMesh] = MappingProxyType({})
) -> Estimate:
    """What a run of all stages of a case will take, with its longest ground motion [s].

    The meshes of its buildings by their names are known as far as they are there already.
    """
    # Steps of each time loop.
    computed, transient = case.computed_time(longest), case.transient
    steps = {"of the pounding": _count(computed, case.pounding.time_step)}
    if case.wall_impact is not None:
        steps["at the wall"] = _count(case.wall_impact.duration, case.wall_impact.time_step)
    if transient is not None:
        lasting = transient.duration or computed
        steps["of the 3D model"] = _count(lasting, transient.time_step)
        if case.devices and case.device_analysis is not None:
            step = case.device_analysis.time_step or transient.time_step
            steps["with devices"] = _count(lasting, step)
    made = [motion for motion in case.motions if isinstance(motion, SyntheticMotion)]
    if made:
        steps["of the ground motion"] = max(_count(one.duration, one.time_step) for one in made)
    stages = list(_sticks(case, steps))
    models, meshed, reduced = [], [], []
    for view, structure in zip(case.views, case.structures, strict=True):
        mesh, vectors = meshes.get(structure.building), _vectors(view)
        if mesh is not None:
            nodes = len(mesh.nodes)
        elif isinstance(structure.mesh, FileMesh):
            nodes = nodes_of_file(structure.mesh.file)
        else:
            nodes = 2 * elements_of(geometry_of(view))
        dofs = DOFS * nodes
        words = f"3D model of {structure.building}" if case.further_structures else "3D model"
        models.append(ModelSize(words, dofs, mesh is not None, vectors))
        analyses = 0.5 if structure.calibration is None else 1.0
        seconds = 40.0 * (dofs / 342_594) ** 1.15 * analyses * (0.5 + structure.modes / 40.0)
        # Two further vectors of the eigensolver for each mode.
        memory = BASE + dofs * (PER_DOF + 24.0 * max(0, structure.modes - 20))
        start = f"{view.part}/" if view.part else ""
        disk = nodes * (12.0 * structure.modes + 60.0) + 2e6
        meshed.append(StageCost(f"{start}building", 6.0 + seconds, memory, disk=disk))
        for cost in _reduced_stages(view, dofs, steps, vectors):
            reduced.append(replace(cost, name=f"{start}{cost.name}"))
    return Estimate(steps, tuple(models), (*meshed, *stages, *reduced), longest)


def too_much(case: Case, found: Estimate) -> Iterator[Fault]:
    """Why a run does not fit this machine: its memory, or the disk where memory is short."""
    machine, stage = available_memory(whole=True), found.largest
    held = max(found.stages, key=lambda one: one.memory - one.file)
    most = max(found.steps, key=lambda of: found.steps[of])
    words = f"{found.steps[most]:.3g} steps {most}"
    if found.dofs is not None:
        words += f", {found.dofs:.3g} degrees of freedom"
    if held.memory - held.file > machine:
        file = " in addition to what can go to a file" if held.file else ""
        expected = (
            f"stage {held.name} needs about {1e-9 * (held.memory - held.file):.3g} GB of memory"
            f"{file}, this machine has {1e-9 * machine:.3g} GB for it; expected longer time steps, "
            f"larger elements, fewer vectors or records ({words})"
        )
        of_steps = held.name == "pounding"  # whose memory is that of its histories
        key, value = ("pounding.time_step", case.pounding.time_step) if of_steps else ("", None)
        yield Fault(case.path, key, value, expected)
    elif stage.memory > machine:
        folder = disk_folder()
        needed = min(stage.file, stage.memory - machine)
        try:
            free = shutil.disk_usage(folder).free
        except OSError:
            free = 0
        if needed > free:
            expected = (
                f"stage {stage.name} needs about {1e-9 * stage.memory:.3g} GB, this machine has "
                f"{1e-9 * machine:.3g} GB of memory, and {folder} {1e-9 * free:.3g} GB for the "
                "rest; expected larger elements, fewer vectors, or a folder named by TMPDIR"
            )
            yield Fault(case.path, "", None, expected)


def duration(seconds: float) -> str:
    """A time in a unit that suits it."""
    for limit, unit, word in ((120.0, 1.0, "s"), (7200.0, 60.0, "min"), (2 * DAY, 3600.0, "h")):
        if seconds < limit:
            return f"{_rounded(max(seconds / unit, 1.0)):,} {word}"
    return f"{_rounded(seconds / DAY):,} days"


def _rounded(count: float) -> int:
    """A number with two digits."""
    return int(float(f"{count:.1e}"))


def _count(time: float, step: float) -> int:
    return math.ceil(time / step * (1.0 - 1e-9))


def elements_of(geometry: Geometry) -> int:
    """Number of triangles that the generator makes, about; the nodes are twice as many."""
    heights = [b - a for a, b in zip(geometry.levels, geometry.levels[1:], strict=False)]
    floor, storey = geometry.size.floor**2, geometry.size.storey**2
    squares = len(geometry.floors) * geometry.length * geometry.width / floor
    for wall in geometry.walls:
        tall = sum(heights[k - 1] for k in wall.storeys if k <= len(heights))
        squares += math.dist(wall.start, wall.end) * tall / storey
    squares -= sum(bay.width * bay.height for bay in geometry.bays) / storey
    if geometry.parapet is not None:
        around = 2.0 * (geometry.length + geometry.width)
        squares += around * geometry.parapet.height / floor
    return math.ceil(TRIANGLES * max(squares, 1.0))


def nodes_of_file(path: Path) -> int:
    """Number of nodes that a mesh file says that it has; 0 where it says none."""
    content = path.read_bytes()
    header = content.partition(b"$MeshFormat")[2].partition(b"$")[0].split()
    place = content.find(b"$Nodes")
    if place < 0:
        return 0
    body = content[place + len(b"$Nodes") :].lstrip(b"\r\n")
    four = bool(header) and header[0].startswith(b"4")
    try:
        if four and header[1:2] == [b"1"]:
            return int.from_bytes(body[8:16], "little")
        return int(body.split(None, 2)[1 if four else 0])
    except (ValueError, IndexError):
        return 0


def _block_steps(damping: DampingEntry, frequency: float, tolerance: float) -> float:
    """Vectors for each load; the paper's building with three dampings to 100 and 450 Hz."""
    ratio = max(float(damping.law.ratio(frequency)), 1e-4)
    growth = (frequency / ratio / 300.0) ** 0.69
    return float(53.0 * growth * (1.0 + math.log(1e-3 / tolerance) / 7.0))


def _vectors(case: Case) -> dict[str, int]:
    """Vectors of the reduced building: of the response in time, and all with those of contacts."""
    structure, transient, wall = case.structure, case.transient, case.wall_impact
    lines = _lines(case)
    if structure is None or (transient is None and wall is None and not lines):
        return {}
    damping = case.building(structure.building).damping
    points, at_wall, loads = _points(structure, None), 0.0, 0
    if wall is not None:
        points = _points(structure, wall.contact_spacing)
        at_wall = 50.0 + 1.3 * points * len(wall.floors)
        loads += 1 + len(wall.floors)
    if lines:
        loads += len(case.motions) + 2 * lines
        # What the points of a line share, and each of them; those of the wall are among them.
        of_line = 40.0 + 4.0 * _points(structure, case.pounding.contact_spacing)
        at_wall = max(at_wall, of_line * lines)
    if transient is None:
        own = loads * _block_steps(damping, MAXIMUM_FREQUENCY, TOLERANCE)
        return {"reduce": math.ceil(own + at_wall)}
    patterns = _patterns(case, structure.building, transient, points)
    # A line along which it touches in 3D has a pattern more, that of its turning.
    loads = len(case.motions) + patterns + lines + (wall is not None)
    top = transient.maximum_frequency
    served = [damping, *(case.damping_cases if transient.serve_damping_cases else ())]
    own = loads * max(_block_steps(one, top, transient.tolerance) for one in served)
    every = own * (1.2 if transient.band == "larger" else 1.0)
    anchors = sum(len(one.anchors) for one in case.devices)
    if case.devices:
        low = min(top, 100.0)
        light = max((_block_steps(c, low, 5e-3) for c in case.damping_cases), default=0.0)
        every = max(every, loads * light)
    # Where it pounds in 3D, the response in time holds that to each point of contact, too.
    found = {"transient": own + 0.65 * at_wall * bool(lines)}
    found["reduce"] = every + 12 * anchors + at_wall
    return {name: math.ceil(number) for name, number in found.items()}


def _points(structure: Structure, spacing: float | None) -> float:
    """Points of contact along the edge of a floor, about."""
    mesh = structure.mesh
    if isinstance(mesh, FileMesh):
        return 20.0
    edge = mesh.length if mesh.impact_edge.startswith("y") else mesh.width
    return 1.0 + edge / max(mesh.floor_size or mesh.size, spacing or 0.0)


def _lines(case: Case) -> int:
    """Lines along which the 3D model of a view touches others, about one for each pair."""
    if case.structure is None or case.structure.building not in case.pounding_in_3d:
        return 0
    name = case.structure.building
    return sum(name in pair.buildings for pair in case.contacts)


def _patterns(case: Case, building: str, transient: Transient, points: float) -> int:
    """Patterns of the forces on the building, about: middles of sides are those of the axes."""
    struck: dict[tuple[object, ...], set[float]] = {}
    for pair in case.contacts:
        for end, _ in pair.ends:
            if end.building == building:
                (x, y, _), (nx, ny, _) = end.offset, pair.normal
                place = (end.floor, end.storey, end.relative_height, end is pair.a, pair.normal)
                along = x * ny - y * nx + transient.eccentricity
                struck.setdefault(place, set()).add(round(along, 6))
    named, count = set(transient.floors or ()), 0.0
    for (floor, storey, *_), offsets in struck.items():
        if transient.floors is not None and (floor or storey) not in transient.floors:
            continue
        named -= {floor or storey}
        if floor is None or transient.spread == "patch":
            count += len(offsets)
        else:
            count += points if transient.spread == "calibrated" else 1 + any(offsets)
    return math.ceil(count + len(named))


def _histories(case: Case, records: float, step: float, steps: int) -> float:
    """Memory of records [byte], refined for spectra up to the highest frequency."""
    highest = max(case.spectra.frequency_values)
    factor = 1.0
    if case.spectra.method == "upsampled":
        factor = max(1.0, math.ceil(case.spectra.points_per_cycle * highest * step))
    return 8.0 * records * steps * (1.0 + factor)


def _sticks(case: Case, steps: dict[str, int]) -> Iterator[StageCost]:
    """The stages pounding and ensemble."""
    count, ensemble = steps["of the pounding"], case.ensemble
    floors = sum(len(building.floors) for building in case.buildings)
    # Displacements, velocities and accelerations with contact and without, and their copies.
    memory = BASE + 8.0 * count * (10.5 * 6 * floors + 8.0 * len(case.contacts))
    memory += _histories(case, len(case.motions) * floors, case.pounding.time_step, count)
    memory += 400.0 * steps.get("of the ground motion", 0)
    # Of one motion: its synthesis, its pounding and its spectra.
    frequencies = len(case.spectra.frequency_values) * len(case.spectra.damping)
    motion_time = 2.4e-7 * count * floors + 2e-10 * count * floors * frequencies
    for motion in case.motions:
        if isinstance(motion, SyntheticMotion):
            samples = _count(motion.duration, motion.time_step)
            motion_time += 1.5e-6 * samples * (motion.iterations + 4)
    # A run of 3D models that pound, as measured in docs/coupled-study.md. Points of contact cost
    # little: they are closed for a small part of the time.
    vectors = points = 0.0
    for view in case.views:
        if (lines := _lines(view)) and view.structure is not None:
            vectors += _vectors(view)["reduce"]
            of_line = _points(view.structure, case.pounding.contact_spacing)
            points = max(points, lines * of_line)
    in_3d = (3.3e-8 + 1.2e-10 * points) * vectors * count
    # With contact and without it, and once with half of the points.
    seconds = 8.0 + motion_time + 3.0 * in_3d
    motion_time += 2.0 * in_3d
    if case.calibration is not None and case.calibration.mode == "fit":
        seconds += 0.5 * case.calibration.starts
    directions = len({motion.direction for motion in case.motions}) or 1
    disk = 6.8 * count * (12.0 * directions * floors + 2.5 * len(case.contacts)) + 2e6
    yield StageCost("pounding", seconds, memory + PICTURES, disk=disk)
    if ensemble is not None:  # one motion after the other, on all cores
        motions = ensemble.motions or len(ensemble.files())
        seconds = 4.0 + motions * (0.6 + motion_time) / threads()
        yield StageCost("ensemble", seconds, memory + 2e6 * motions, disk=1e5 * motions)


def _reduced_stages(
    case: Case, dofs: int, steps: dict[str, int], vectors: dict[str, int]
) -> Iterator[StageCost]:
    """The stage that makes the reduced building, and those that use it."""
    times = steps.get("of the 3D model", 0)
    if "reduce" not in vectors:
        return
    every, reduced = vectors["reduce"], vectors.get("transient", 0)
    # Factor, solutions, and products of all vectors with all before.
    seconds = dofs / 342_594 * (10.0 + 0.06 * every + 8e-5 * every**2)
    room = 8.0 * COPIES * dofs * every
    # Translations at a quarter of the nodes, and coordinates of the bases that tell the error.
    disk = 8.0 * COPIES * 0.125 * dofs * reduced + 64.0 * reduced**2
    yield StageCost("reduce", seconds, BASE + dofs * PER_DOF + room, room, disk)
    small = BASE + 0.25 * dofs * PER_DOF
    if case.wall_impact is not None:
        memory = small + PICTURES + 16.0 * every * steps["at the wall"]
        yield StageCost("calibrate", 6.0, memory, disk=1e6)
    transient = case.transient
    if transient is None:
        return
    probes = 20
    for one in transient.probes:
        probes += GROUP if one.group is not None else one.count or 1
    histories = 16.0 * reduced * times + _histories(case, 3 * probes, transient.time_step, times)
    seconds = 25.0 * (1.0 + 1e-5 * times)
    if transient.solver != "reduced":
        seconds += 0.57e-6 * dofs * times
    memory = small + SCENES + histories + 48.0 * probes * times
    # Histories and forces, maps of spectra, and what the report has of them.
    disk = 48.0 * probes * times + 67.0 * dofs + 1e7
    yield StageCost("transient", seconds, memory, disk=disk)
    if case.devices:
        fine, dampings = steps["with devices"], 1 + len(case.damping_cases)
        seconds = 10.0 + dampings * (3.0 + 4e-10 * every * fine * (1 + len(case.devices)))
        memory = small + SCENES + 16.0 * every * times + 400.0 * fine
        disk = 1.2e6 * dampings * len(case.devices)
        yield StageCost("device", seconds, memory, disk=disk)
    members = 0 if case.ensemble is None else case.ensemble.structure_motions
    memory = small + SCENES + histories
    seconds = 8.0 + 0.011 * reduced * members
    yield StageCost("design", seconds, memory, disk=7e6 + 5e5 * members)
