"""Speed of the wall experiment with the 3D model: reduced against full order."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.building import load_forms
from bench.figure import Figure
from impactfem.building.from_case import geometry_of
from impactfem.building.generate import generate
from impactfem.building.model import BuildingModel, assemble_building
from impactfem.case import load_case
from impactfem.dynamics.damping import Rayleigh
from impactfem.stages.calibrate.building_model import (
    WallModel,
    WallPatterns,
    reduced_wall_model,
    wall_patterns,
)
from impactfem.stages.calibrate.building_run import run_reduced
from impactfem.stages.calibrate.compute import (
    LARGEST,
    MAXIMUM_FREQUENCY,
    TOLERANCE,
    Prepared,
    prepare,
    wall_probes,
)
from impactfem.stages.calibrate.experiment import WallExperiment
from impactfem.stages.calibrate.unilateral_full import FullMotion
from impactfem.system.files import in_source_tree
from impactfem.system.parallel import communicator

Array = NDArray[np.float64]

CASE = "geometry/npp_pair.toml"
STEPS = 10
"""Steps of the full model that are timed, without and with contact impulses."""


def wall_figures() -> list[Figure]:
    """Measure on the default mesh of the paper's case.

    Raises:
        ImpactfemError: The source tree with the shipped cases is missing.
    """
    prepared = _prepared()
    load_forms()
    experiment = prepared.experiment
    damping = next(iter(prepared.dampings.values()))
    start = time.perf_counter()
    model = assemble_building(communicator(), prepared.parts)
    K = model.take_stiffness(prepared.storey_factor)
    patterns = wall_patterns(
        model,
        prepared.parts.mesh,
        experiment.floors,
        experiment.displaced_floor,
        experiment.pull,
    )
    assembled = time.perf_counter() - start
    start = time.perf_counter()
    reduced = _reduced(model, K, patterns, prepared, damping)
    built = time.perf_counter() - start
    run_reduced(reduced, experiment, prepared.mass, damping)  # compiles
    start = time.perf_counter()
    run_reduced(reduced, experiment, prepared.mass, damping)
    run = time.perf_counter() - start
    factored, step, contact_step = _full(model.mass, K, patterns, experiment, damping)
    # Impacts last 3 % of the window.
    full = factored + (experiment.n_t - 1) * (0.97 * step + 0.03 * contact_step)
    return [
        Figure("wall, free degrees of freedom", float(model.n_free), "-"),
        Figure("wall, contact constraints", float(patterns.contact.shape[1]), "-"),
        Figure("wall, matrices", assembled, "s"),
        Figure("wall, vectors of the reduced model", float(len(reduced.eigenvalue)), "-"),
        Figure("wall, reduced model", built, "s"),
        Figure(f"wall, {experiment.n_t - 1} steps of the reduced model", run, "s"),
        Figure(
            "wall, full order: static start, factorisation and Delassus operator", factored, "s"
        ),
        Figure("wall, full order: one step", step, "s"),
        Figure("wall, full order: one step with impulses", contact_step, "s"),
        Figure(f"wall, full order: {experiment.n_t - 1} steps", full, "s"),
        Figure("wall, full over reduced, basis excluded", full / run, "-", 30.0, at_most=False),
        Figure(
            "wall, full over reduced, basis included",
            full / (built + run),
            "-",
            10.0,
            at_most=False,
        ),
    ]


def _prepared() -> Prepared:
    case = load_case(in_source_tree(CASE))
    structure = case.structure
    if structure is None:
        raise ValueError(f"{CASE} has no structure")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "building.msh"
        generate(geometry_of(case), path, source=str(case.path))
        return prepare(case, path, structure.storey_stiffness_factor)


def _reduced(
    model: BuildingModel,
    K: Any,
    patterns: WallPatterns,
    prepared: Prepared,
    damping: Rayleigh,
) -> WallModel:
    return reduced_wall_model(
        model,
        K,
        patterns,
        wall_probes(prepared.parts.mesh, prepared.experiment.floors),
        damping=damping,
        maximum_frequency=MAXIMUM_FREQUENCY,
        tolerance=TOLERANCE,
        largest=LARGEST,
    )


def _full(
    M: Any, K: Any, patterns: WallPatterns, experiment: WallExperiment, damping: Rayleigh
) -> tuple[float, float, float]:
    """Times of all before the first step, of a step, and of one with impulses [s]."""
    start = time.perf_counter()
    u = np.ascontiguousarray(patterns.held(K)[0])
    with FullMotion(
        K, M, patterns.contact, experiment.time_step, damping=damping, probes=patterns.seen
    ) as motion:
        motion.delassus()
        motion.start(u, None)
        factored = time.perf_counter() - start
        nothing, impulse = np.zeros(0), np.full(motion.constraints, 1.0)
        free, pushed = [], []
        for _ in range(STEPS):
            start = time.perf_counter()
            motion.free(nothing)
            motion.advance()
            free.append(time.perf_counter() - start)
            start = time.perf_counter()
            motion.free(nothing)
            motion.push(impulse)
            motion.advance()
            pushed.append(time.perf_counter() - start)
    return factored, float(np.median(free)), float(np.median(pushed))
