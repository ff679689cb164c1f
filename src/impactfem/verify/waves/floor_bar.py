"""A floor in 3D against the same floor as a bar: under a pulse on its edge, and at a rigid wall.

The fast rows take a floor of the program's own generator on soft columns; those of `--full` take
floor 8 of the paper, with the forces of its own run (docs/floor-as-a-bar.md has the closed form).
"""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import scipy.optimize

from impactfem.building.geometry import Beam, Column, Geometry, MeshSize
from impactfem.dynamics.damping import Rayleigh
from impactfem.spectra import response_spectra
from impactfem.stages.transient.physics import arrivals, crossing_time
from impactfem.system.arrays import Array
from impactfem.verify.row import Rows, benchmark
from impactfem.verify.waves.bar import Bar, EdgeWall
from impactfem.verify.waves.paper import paper_case, prepared_building

if TYPE_CHECKING:
    from impactfem.building.floor import FloorBar
    from impactfem.building.parts import BuildingParts
    from impactfem.reduction.loads import Loads


NAME = "floor as a bar"
LENGTH, WIDTH, SLAB, SIZE = 15.6, 4.8, 0.3, 1.2
"""The paper's slab is 15.6 m wide; a strip of it is free in plane."""
RHO, MASS = 2400.0, 250e3
"""With this mass on a strip of 54 t the wave is as slow as in the paper's floor 8."""
YOUNG = 33e9
RAYLEIGH = Rayleigh(0.8378, 1.061e-3)
FORCE, PULSE, STEP, WINDOW = 10e6, 10e-3, 0.5e-3, 0.04
LIGHT = Rayleigh(0.0, 2e-5)  # a damping that hides no wave: 0.4 % at 60 Hz
QUIET = 0.01  # time before the pulse [s]
DISPLACED, WALL_STEP, WALL_WINDOW = -0.02, 0.1e-3, 0.75
SOLVER = "the bar by an independent solver (verify/waves/bar.py)"

PAPER = "paper's floor 8 as a bar"
FLOOR, END = 8, 5.6  # the main impact is at 5.1 s
HIGHEST = 450.0
FAIR = {"facades lumped": (75.0, HIGHEST), "facades that bend": (40.0, 200.0)}
"""Frequencies between which a bar is a fair model [Hz]: below, the slab bows between the gables,
and lumped facades do not move as they do near their own frequency."""
POINTS = ("impact edge", "centre", "far edge")


@benchmark(NAME)
def floor_as_a_bar(rows: Rows) -> None:
    """A strip of a slab, 250 t in all, on six soft columns, under a pulse and before a wall.

    Before the wall, and in the closed form, two beams lie along it; under the pulse none, as the
    edge between beams is pushed further in than a bar's, by 6 % of its peak.

    With ν = 0 it is a bar but for its columns, whose half weighs 0.6 % and whose stiffness gives it
    0.4 Hz. A smooth pulse of 10 ms on its edge, and a release 2 cm before a wall that it touches at
    rest position: the columns push neither way then. 250 t displaced as a whole floor move as
    one, and the bar that meets the wall does so, too. With the paper's damping the restitution is
    that of the damping; hardly damped, it shows what the contact nodes of elements of 1.2 m lose.
    In closed form a wave takes L/c, c = √(EA'/m'), from edge to edge; the peak of a damped one is
    ahead of that, and near the far edge it is one with its reflection.
    """
    from impactfem.building.floor import floor_bar

    parts, bare = _strip(beams=True), _strip(beams=False)
    bar = floor_bar(parts, 1, 1)
    _bar_rows(rows, bar)
    _pulse_rows(rows, bare, floor_bar(bare, 1, 1))
    _wall_rows(rows, parts, bar)


def _strip(*, beams: bool) -> BuildingParts:
    from impactfem.building.generate import generate
    from impactfem.building.parts import BuildingParts, floor_masses
    from impactfem.building.read_mesh import read_mesh
    from impactfem.building.section import Material, Materials

    lines = {"west": 1.2, "east": 3.6}
    built = Geometry(
        length=WIDTH,
        width=LENGTH,
        levels=(0.0, 5.0),
        slab_thickness=SLAB,
        walls=(),
        beams=tuple(
            Beam(name, (1,), (x, 0.0), (x, LENGTH), 0.3, 0.5) for name, x in lines.items() if beams
        ),
        columns=tuple(
            Column(f"{name}{k}", (1,), (x, y), 0.2, 0.2)
            for name, x in lines.items()
            for k, y in enumerate((2.4, 7.8, 13.2))
        ),
        size=MeshSize.uniform(SIZE),
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "strip.msh"
        generate(built, path)
        mesh = read_mesh(path)
    sections = built.sections(mesh.shell_parts, mesh.beam_parts)
    concrete = Material(YOUNG, 0.0, RHO)
    materials = Materials((concrete,) * len(mesh.shell_parts), (concrete,) * len(mesh.beam_parts))
    masses = floor_masses(mesh, sections, materials, np.array([MASS]))
    return BuildingParts(mesh, sections, materials, masses.on_triangles)


def _bar_rows(rows: Rows, bar: FloorBar) -> None:
    """The bar in closed form; of its solver an end mass by an equation, the wall by d'Alembert."""
    columns = 6 * RHO * 0.04 * 2.5
    stiffness = YOUNG * (WIDTH * SLAB + 2 * 0.3 * 0.5)
    speed = math.sqrt(stiffness * LENGTH / (MASS - columns))
    rows.source = "closed form: slab and beams, 250 t less half of the columns"
    quantities = ["EA' of the mesh", "√(EA'/m') of the mesh"]
    rows.add(quantities, [stiffness, speed], [bar.stiffness, bar.speed], ["N", "m/s"], 1e-9)
    EA, m, end = 6e11, 2.6e6, 0.2e6
    c = math.sqrt(EA * LENGTH / m)
    # u = cos kx − (k L μ) sin kx, μ = end mass over m, with the same mass at x = L.
    mu = end / m

    def ends(kL: float) -> float:
        return (1.0 - (kL * mu) ** 2) * math.sin(kL) + 2.0 * kL * mu * math.cos(kL)

    kL = float(scipy.optimize.brentq(ends, 1.5, math.pi))
    exact = kL * c / (2.0 * math.pi * LENGTH)
    loaded = Bar(LENGTH, EA, m, (end, end)).frequencies(2)[1]
    impulse, lasts = Bar(LENGTH, EA, m, damping=LIGHT).against_wall(0.1, 2e-5)
    quantity = "the bar's solver: first frequency with masses at both ends"
    source = "closed form: (1 − (kLμ)²) sin kL + 2 kLμ cos kL = 0"
    rows.add(quantity, exact, loaded, "Hz", 1e-3, source)
    quantity = "the bar's solver: impulse on a wall over 2 m v, hardly damped"
    source = "d'Alembert: the wall turns the bar round"
    rows.add(quantity, 1.0, impulse / (2.0 * m * 0.1), "-", 0.03, source)
    quantity = "the bar's solver: time at the wall, hardly damped"
    rows.add(quantity, 2.0 * LENGTH / c, lasts, "s", 0.02, "d'Alembert: 2L/c")


def _pulse_rows(rows: Rows, parts: BuildingParts, bar: FloorBar) -> None:
    """Accelerations at both edges and the centre, spectra, and the crossing by the peak."""
    from impactfem.reduction.edge_force import EdgeForce
    from impactfem.reduction.loads import Loads

    time = STEP * np.arange(round((QUIET + WINDOW) / STEP) + 1)
    since = time - QUIET
    shape = 0.5 - 0.5 * np.cos(2.0 * math.pi * since / PULSE)
    force = np.where((since > 0.0) & (since < PULSE), FORCE * shape, 0.0)
    loads = Loads(
        time_step=STEP,
        ground=np.zeros((len(time), 3)),
        directions=(),
        edges=(EdgeForce("floor 1", 1, (0.0, -1.0, 0.0)),),
        force=force[:, None],
        impulse_error=0.0,
    )
    total = bar.slab_mass + bar.standing_mass

    def peaks(line: Array) -> Array:
        return arrivals(time, line, 1.0, (QUIET, QUIET + PULSE), bar.crossing).peak

    distance, floor = _line_in_3d(parts, 1, loads, RAYLEIGH, 1.0)
    made = Bar(LENGTH, bar.stiffness, total, bar.end_mass, RAYLEIGH)
    own = made.pushed(force, STEP, distance)
    rows.source = SOLVER
    away = np.abs(floor - own).max(axis=1)[[0, 4, 8]] / np.abs(own).max()
    quantity, places = "largest difference of the acceleration over its peak", POINTS[1:]
    quantities = [f"{quantity}, {place}" for place in ("edge that is hit", *places)]
    rows.add(quantities, 0.0, away, "-", 0.02)
    ours, theirs = (crossing_time(distance, peaks(one)) or math.nan for one in (own, floor))
    rows.add("crossing by the slope of the peak", ours, theirs, "s", 0.02)
    light = peaks(_line_in_3d(parts, 1, loads, LIGHT, 1.0)[1])
    quantity = "from the peak at the edge that is hit to that at the far edge, hardly damped"
    rows.add(quantity, bar.crossing, light[-1] - light[0], "s", 0.05, "closed form: L/√(EA'/m')")


def _line_in_3d(
    parts: BuildingParts, floor: int, loads: Loads, damping: Rayleigh, storey_factor: float
) -> tuple[Array, Array]:
    """Distance of the stage's line across a floor, and accelerations along the push, there."""
    from mpi4py import MPI

    from impactfem.building.model import assemble_building
    from impactfem.reduction.probes import standard_probes
    from impactfem.reduction.reduced_basis import Accuracy, build_basis
    from impactfem.reduction.response import modal_histories, node_response

    mesh = parts.mesh
    line = [p.node for p in standard_probes(mesh, floor) if p.name.startswith("line_")]
    nodes = np.array(line)
    model = assemble_building(MPI.COMM_SELF, parts)
    K = model.take_stiffness(storey_factor)
    basis = build_basis(
        *(model, K, loads.patterns(model, mesh), loads.names),
        probes=nodes,
        nodes=np.unique(nodes),
        accuracy=Accuracy(damping, HIGHEST, 1e-3),
        shift=30.0,
        largest=1200,
    )
    history = modal_histories(basis, loads, damping)
    found = node_response(basis, history, loads, nodes).acceleration
    where = mesh.nodes[nodes]
    inward = (where[-1] - where[0]) / np.linalg.norm(where[-1] - where[0])
    return np.linalg.norm(where - where[0], axis=1), (found @ inward).T


def _wall_rows(rows: Rows, parts: BuildingParts, bar: FloorBar) -> None:
    """The first impact by the stage's reduced model, made for each damping."""
    from mpi4py import MPI

    from impactfem.building.model import assemble_building
    from impactfem.case.transient import MAXIMUM_FREQUENCY
    from impactfem.reduction.reduced_basis import Accuracy
    from impactfem.reduction.reduced_building import ReductionPlan, reduce_building
    from impactfem.reduction.wall import Wall
    from impactfem.stages.calibrate.compute import run_reduced
    from impactfem.stages.calibrate.experiment import WallExperiment
    from impactfem.stages.calibrate.impact import floor_impacts
    from impactfem.stages.reduce.compute import COMPLETE, wall_probes

    experiment = WallExperiment((1,), 1, DISPLACED, 0.0, WALL_WINDOW, WALL_STEP)
    wall = Wall(experiment.floors, experiment.displaced_floor, experiment.pull)
    probes = np.unique(wall_probes(parts.mesh, experiment.floors))
    for label, damping, allowed in (("hardly damped", LIGHT, 0.07), ("damped", RAYLEIGH, 0.02)):
        accuracies = (Accuracy(damping, MAXIMUM_FREQUENCY, COMPLETE),)
        plan = ReductionPlan(probes=probes, nodes=probes, accuracies=accuracies, wall=wall)
        building = assemble_building(MPI.COMM_SELF, parts)
        reduced = reduce_building(building, parts.mesh, 1.0, plan).complete.wall
        if reduced is None:
            raise ValueError("the building was reduced with a wall")
        history = run_reduced(reduced, experiment, np.array([MASS]), damping).history
        impact = floor_impacts(history, 1).first_complete()
        total = bar.slab_mass + bar.standing_mass
        made = Bar(LENGTH, bar.stiffness, total, bar.end_mass, damping)
        if label == "damped":
            rows.source = SOLVER
            impulse, lasts = made.against_wall(impact.approach, WALL_STEP / 4.0)
            epsilon = impulse / (made.mass * impact.approach) - 1.0
        else:
            rows.source = "d'Alembert: the wall turns the bar round, in 2L/c"
            epsilon, lasts = 1.0, 2.0 * LENGTH * math.sqrt(made.mass / (bar.stiffness * LENGTH))
        rows.add(f"restitution at the wall, {label}", epsilon, impact.epsilon, "-", allowed)
        rows.add(f"time at the wall, {label}", lasts, impact.duration, "s", allowed)


@benchmark(PAPER, heavy=True)
def paper_floor_as_a_bar(rows: Rows, case_file: Path | None = None) -> None:
    """Floor 8 of the paper's case, of its default mesh, under the forces of its run.

    The bar has EA' and the masses of the mesh; only the force on floor 8 acts on it, while ground
    motion and the forces on all floors act on the building. With its facades lumped at its ends it
    holds from 75 Hz on. Between 40 and 75 Hz it does not, by up to 40 % at the impact edge: a
    facade of 0.6 m, clamped 4.8 m below and held by the slab, has its own frequency at 54 Hz if it
    turns freely there and at 79 Hz if it does not, and is no lump. As a beam that turns freely
    there it brings centre and far edge within 10 % from 40 to 200 Hz; the impact edge, where the
    slab restrains the turning, is up to 13 % too high and is compared by its peak alone.

    The slope of the arrivals is not compared: near the far edge the wave is one with its
    reflection, and the slopes of the bar and of 3D differ by 7 %.

    The wall is left out: the storeys below, which the bar has not, press floor 8 on. It stays there
    for 26 to 40 ms and the bar for 15 to 17 ms (docs/floor-as-a-bar.md).
    """
    from impactfem.building.floor import floor_bar
    from impactfem.building.mesh import areas
    from impactfem.stages.transient.compute import main_impact

    case = paper_case(case_file, END)
    with tempfile.TemporaryDirectory() as folder:
        prepared = prepared_building(case, Path(folder), END)
    parts, loads, damping = prepared.parts, prepared.loads, prepared.damping.rayleigh
    mesh, factor, step = parts.mesh, prepared.storey_factor, loads.time_step
    bar = floor_bar(parts, FLOOR, 1)
    distance, floor = _line_in_3d(parts, FLOOR, loads, damping, factor)
    force = loads.force[:, [edge.floor for edge in loads.edges].index(FLOOR)]
    # Both facades of the storey below as walls: volume over height and length of the slab.
    height = mesh.elevations[FLOOR] - mesh.elevations[FLOOR - 1]
    storey = mesh.triangles_of("storey", FLOOR)
    y = mesh.nodes[mesh.triangles[storey, :3], 1]
    in_edge = storey[np.ptp(y, axis=1) + np.abs(y[:, 0] - y.min()) < 1e-6]
    area = areas(mesh.nodes, mesh.triangles)[in_edge]
    thickness = float(np.average(parts.thickness()[in_edge], weights=area))
    concrete = parts.slab_material(FLOOR)  # of the walls, too
    bending = factor * concrete.E * area.sum() / height * thickness**3 / 12.0
    wall = EdgeWall(height, bending, mass=concrete.rho * float(area.sum()) * thickness)
    # Half of each is in the end masses; what is left there are the upstands.
    upstand = (bar.end_mass[0] - 0.5 * wall.mass, bar.end_mass[1] - 0.5 * wall.mass)
    spread = bar.length, bar.stiffness, bar.slab_mass + bar.standing_mass
    frequency = np.geomspace(10.0, HIGHEST, 200)

    def spectra(line: Array) -> Array:
        chosen = line[[0, len(line) // 2, -1]]
        found = response_spectra(
            chosen, step, frequency, [0.05], points_per_cycle=20.0, absolute=False
        )
        return np.asarray(found.psa[0])

    for kind, made in zip(
        FAIR,
        (Bar(*spread, bar.end_mass, damping), Bar(*spread, upstand, damping, wall)),
        strict=True,
    ):
        own = made.pushed(force, step, distance)
        lowest, highest = FAIR[kind]
        known = (frequency >= lowest) & (frequency <= highest)
        mine, theirs = spectra(own)[:, known], spectra(floor)[:, known]
        for k, point in enumerate(POINTS):
            rows.where = f"{point}, {kind}"
            ratio = mine[k] / theirs[k]
            worst = int(np.argmax(np.abs(ratio - 1.0)))
            # The slab restrains the facade at its edge, neither hinge nor clamp: no row there.
            if (kind, k) != ("facades that bend", 0):
                band = f"{lowest:g} to {highest:g} Hz"
                quantity = f"spectrum over that in 3D where it is farthest off, {band}"
                source = f"the building in 3D; at {frequency[known][worst]:.0f} Hz"
                rows.add(quantity, 1.0, ratio[worst], "-", 0.1, source)
            if kind == "facades that bend":
                peaks = theirs[k].max(), mine[k].max()
                rows.add("peak of the spectrum", *peaks, "m/s2", 0.1, "the building in 3D")
    rows.where = ""
    impact = main_impact(loads)
    if impact is None:
        rows.add("impacts in the window", 1.0, 0.0, "-", 0.0, "at least one")
        return
    time = step * np.arange(len(force))
    mine, theirs = (arrivals(time, line, 1.0, impact, bar.crossing).peak for line in (own, floor))
    quantity = "from the peak at the impact edge to that at the far edge"
    ways = theirs[-1] - theirs[0], mine[-1] - mine[0]
    rows.add(quantity, *ways, "s", 0.05, "the building in 3D")
