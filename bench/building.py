"""Speed of the 3D building: the paper-size mesh, and the wall experiment."""

from __future__ import annotations

import resource
import tempfile
from pathlib import Path

import numpy as np

from bench.suite import Figure, timed
from impactfem.building.from_case import geometry_of, read_parts
from impactfem.building.generate import generate
from impactfem.building.model import assemble_building
from impactfem.building.shell_model import csr
from impactfem.case import load_case
from impactfem.case.transient import MAXIMUM_FREQUENCY
from impactfem.dynamics.factorisation import Factorisation
from impactfem.dynamics.modes import modes
from impactfem.reduction.reduced_basis import Accuracy
from impactfem.reduction.reduced_building import ReductionPlan, reduce_building
from impactfem.reduction.wall import Wall, WallPatterns
from impactfem.stages.calibrate.compute import prepare, run_reduced
from impactfem.stages.reduce.compute import COMPLETE, wall_probes
from impactfem.system.arrays import Array
from impactfem.system.files import in_source_tree
from impactfem.system.parallel import communicator
from impactfem.verify.full_order import FullMotion

MODES = 20
STEPS = 10
"""Steps of the wall experiment in full order that are timed, without and with impulses."""


def building_figures(case_file: str = "geometry/npp_pair_fine.toml") -> list[Figure]:
    """Measure the paper-size mesh; with OMP_NUM_THREADS=1 on one core.

    Raises:
        ImpactfemError: The source tree with the shipped cases is missing.
    """
    building = next(iter(load_case(in_source_tree(case_file)).modelled.values()))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "building.msh"
        _, generated = timed(lambda: generate(geometry_of(building), path, source=case_file))
        (parts, _), read = timed(lambda: read_parts(building, path))
    load_forms()
    model, assembled = timed(lambda: assemble_building(communicator(), parts))
    mesh = parts.mesh
    elements = len(mesh.triangles) + len(mesh.lines)
    K = model.take_stiffness(building.structure.storey_stiffness_factor)
    factorisation, factored = timed(lambda: Factorisation(K))
    b, x = K.createVecs()
    b.setArray(np.ones(b.getLocalSize()))
    _, solved = timed(lambda: factorisation.solve(b, x))
    factorisation.destroy()
    _, modal = timed(lambda: modes(K, model.mass, MODES))
    return [
        Figure("paper-size mesh, shell and beam elements", elements, "-", 113_000, at_most=False),
        Figure("paper-size mesh, degrees of freedom", 6.0 * len(mesh.nodes), "-"),
        Figure("mesh generated", generated, "s"),
        Figure("mesh read and checked", read, "s"),
        Figure("matrices assembled", assembled, "s", 60.0),
        Figure("matrices, time an element", 1e6 * assembled / elements, "µs"),
        Figure("stiffness factored", factored, "s"),
        Figure("one solve", solved, "s"),
        Figure(f"first {MODES} modes", modal, "s", 240.0),
        Figure(f"first {MODES} modes, time an element", 1e3 * modal / elements, "ms"),
        Figure("peak memory", peak_memory(), "GB", 12.0),
    ]


def load_forms() -> None:
    """Compile the forms, or load them: a small building has the same."""
    frame = load_case(in_source_tree("geometry/frame.toml")).modelled["F"]
    parts, _ = read_parts(frame, in_source_tree("geometry/frame.msh"))
    assemble_building(communicator(), parts)


def peak_memory() -> float:
    """Most memory of all ranks together so far [GB]."""
    here = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2
    return float(communicator().allreduce(here))


def wall_figures(case_file: str = "geometry/npp_pair.toml") -> list[Figure]:
    """The wall experiment on the default mesh of the paper's case, reduced and in full order.

    Raises:
        ImpactfemError: The source tree with the shipped cases is missing.
    """
    [building] = load_case(in_source_tree(case_file)).at_wall
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "building.msh"
        generate(geometry_of(building), path, source=case_file)
        prepared, factor = prepare(building, path), building.structure.storey_stiffness_factor
    load_forms()
    experiment, mesh = prepared.experiment, prepared.parts.mesh
    floors, damping = experiment.floors, next(iter(prepared.dampings.values()))
    model, assembled = timed(lambda: assemble_building(communicator(), prepared.parts))
    K = model.take_stiffness(factor)
    wall = Wall(floors, experiment.displaced_floor, experiment.pull)
    patterns = WallPatterns.of(model, mesh, wall)
    probes = np.unique(wall_probes(mesh, floors))
    accuracy = Accuracy(damping, MAXIMUM_FREQUENCY, COMPLETE)
    plan = ReductionPlan(probes=probes, nodes=probes, accuracies=(accuracy,), wall=wall)
    again = assemble_building(communicator(), prepared.parts)
    found, built = timed(lambda: reduce_building(again, mesh, factor, plan))
    reduced = found.complete.wall
    if reduced is None:
        raise ValueError("the building was reduced with a wall")
    run_reduced(reduced, experiment, prepared.mass, damping)  # compiles
    _, run = timed(lambda: run_reduced(reduced, experiment, prepared.mass, damping))

    def start() -> FullMotion:
        u = np.ascontiguousarray(patterns.held(K)[0])
        G, h = patterns.contact, experiment.time_step
        options = {"damping": damping.rayleigh, "probes": patterns.seen}
        motion = FullMotion(csr(K), csr(model.mass), G, h, **options)
        motion.delassus()
        motion.start(u, None)
        return motion

    motion, factored = timed(start)
    nothing, impulse = np.zeros(0), np.full(motion.constraints, 1.0)

    def step(impulse: Array | None = None) -> None:
        motion.free(nothing)
        if impulse is not None:
            motion.push(impulse)
        motion.advance()

    both = [(timed(step)[1], timed(lambda: step(impulse))[1]) for _ in range(STEPS)]
    motion.destroy()
    free, pushed = np.median(both, axis=0)
    steps = experiment.n_t - 1
    # Impacts last 3 % of the window.
    full = factored + steps * (0.97 * free + 0.03 * pushed)
    name = "wall, full order: static start, factorisation and Delassus operator"
    without, with_it = full / run, full / (built + run)
    return [
        Figure("wall, free degrees of freedom", float(model.n_free), "-"),
        Figure("wall, contact constraints", float(patterns.contact.shape[1]), "-"),
        Figure("wall, matrices", assembled, "s"),
        Figure("wall, vectors of the reduced model", float(len(reduced.eigenvalue)), "-"),
        Figure("wall, reduced model", built, "s"),
        Figure(f"wall, {steps} steps of the reduced model", run, "s"),
        Figure(name, factored, "s"),
        Figure("wall, full order: one step", free, "s"),
        Figure("wall, full order: one step with impulses", pushed, "s"),
        Figure(f"wall, full order: {steps} steps", full, "s"),
        Figure("wall, full over reduced, basis excluded", without, "-", 30.0, at_most=False),
        Figure("wall, full over reduced, basis included", with_it, "-", 10.0, at_most=False),
    ]
