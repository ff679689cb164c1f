"""Speed of the 3D stage in time on the paper-size mesh: full Newmark against the reduced model."""

from __future__ import annotations

import resource
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.bench.building import CASE, load_forms
from impactfem.bench.figure import Figure
from impactfem.building.from_case import geometry_of
from impactfem.building.generate import generate
from impactfem.building.model import assemble_building
from impactfem.building.parts import BuildingParts
from impactfem.building.read_parts import read_parts
from impactfem.case import Case, load_case
from impactfem.dynamics.newmark import Newmark
from impactfem.motion.from_case import ground_motions
from impactfem.parallel import communicator, threads
from impactfem.spectra import response_spectra
from impactfem.sticks.force_history import ForceHistory
from impactfem.sticks.from_case import calibration_of
from impactfem.sticks.pounded import pounded
from impactfem.transient.loads import Loads
from impactfem.transient.maps import floor_maps, looked_at
from impactfem.transient.prepared import case_loads, transient_of
from impactfem.transient.probes import case_probes
from impactfem.transient.reduced_basis import build_basis
from impactfem.transient.response import modal_histories, node_response, node_spectra
from impactfem.verify.shipped import shipped_case

Array = NDArray[np.float64]

STEPS = 12
"""Steps of the full model that are timed, interleaved with bare solves."""
SAMPLE = 256
"""Vertices whose spectra are made with 20 points a cycle."""
FULL_STEPS = 10_001
"""Computed times of the paper's 3D run (section 4.1)."""


def transient_figures() -> list[Figure]:
    """Measure; the forces are those of the sticks of the paper's case.

    Raises:
        ImpactfemError: The source tree with the shipped cases is missing.
    """
    case = load_case(shipped_case(CASE))
    transient, structure = case.transient, case.structure
    if transient is None or structure is None:
        raise ValueError(f"{CASE} has no transient part")
    parts = _parts(case)
    loads = _loads(case, parts)
    damping = case.building(structure.building).damping.coefficients
    load_forms()
    comm = communicator()
    model = assemble_building(comm, parts)
    K = model.take_stiffness(structure.storey_stiffness_factor)
    patterns = loads.patterns(model, parts.mesh, transient.eccentricity)

    factored, step, solve = _full_steps(model.mass, K, loads, patterns, damping)
    nodes = np.array([probe.node for probe in case_probes(parts.mesh, transient.probes)])
    start = time.perf_counter()
    basis = build_basis(
        model,
        K,
        patterns,
        loads.names,
        probes=nodes,
        nodes=looked_at(parts.mesh, nodes),
        damping=damping,
        maximum_frequency=transient.maximum_frequency,
        shift=transient.shift,
        tolerance=transient.tolerance,
        largest=transient.largest_basis,
        larger=True,
        spend=True,
    )
    built = time.perf_counter() - start
    start = time.perf_counter()
    history = modal_histories(basis, loads, damping)
    node_spectra(node_response(basis, history, loads, nodes), case.spectra)
    again = time.perf_counter() - start
    start = time.perf_counter()
    maps = floor_maps(parts, basis, history, loads, case.spectra, main_impact=None)
    mapped = time.perf_counter() - start
    sample = maps.nodes[:SAMPLE]
    records = node_response(basis, history, loads, sample).acceleration
    start = time.perf_counter()
    response_spectra(
        records.reshape(len(records), -1).T,
        loads.time_step,
        maps.frequency,
        [maps.damping],
        points_per_cycle=20.0,
        threads=threads(),
        absolute=False,
    )
    fine = (time.perf_counter() - start) * len(maps.nodes) / len(sample)
    peak = comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) / 1024.0**2
    full = factored + step * FULL_STEPS
    return [
        Figure("3D in time, free degrees of freedom", float(model.n_free), "-"),
        Figure("full Newmark, factorisation", factored, "s"),
        Figure("full Newmark, one step", step, "s"),
        Figure("one bare solve", solve, "s"),
        Figure("step over bare solve", step / solve, "-", 1.3),
        Figure("full Newmark, time a degree of freedom and step", 1e6 * step / model.n_free, "µs"),
        Figure(f"full Newmark, {FULL_STEPS} steps", full, "s"),
        Figure("reduced model, vectors", float(len(basis.model.eigenvalue)), "-"),
        Figure("reduced model, basis", built, "s"),
        Figure("reduced model, basis to spectra at all points", built + again, "s"),
        Figure("full loop over reduced model", full / (built + again), "-", 40.0, at_most=False),
        Figure("a further motion, gap or damping", again, "s", 5.0),
        Figure("spectra of every floor vertex, vertices", float(len(maps.nodes)), "-"),
        Figure("spectra of every floor vertex, frequencies", float(len(maps.frequency)), "-"),
        Figure("spectra of every floor vertex", mapped, "s", 180.0),
        Figure("the same with 20 points a cycle, from a sample", fine, "s"),
        Figure("peak memory", peak, "GB", 16.0),
    ]


def _parts(case: Case) -> BuildingParts:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "building.msh"
        generate(geometry_of(case), path, source=str(case.path))
        return read_parts(case, path)[0]


def _loads(case: Case, parts: BuildingParts) -> Loads:
    """The loads of the case, from a run of its sticks."""
    motions = ground_motions(case.motions)
    longest = max(motion.accelerogram.duration for motion in motions)
    duration = transient_of(case).duration or case.pounding.duration or longest
    response = pounded(case, calibration_of(case), motions, duration)
    history = ForceHistory.of_response(response)
    return case_loads(case, parts.mesh, motions, history, case.path, duration)


def _full_steps(
    M: Any, K: Any, loads: Loads, patterns: Array, damping: tuple[float, float]
) -> tuple[float, float, float]:
    """Times of the factorisation, of a step, and of a bare solve [s]."""
    amplitudes = loads.amplitudes
    alpha, beta = damping
    with Newmark(K, M, loads.time_step, patterns, alpha=alpha, beta=beta) as system:
        start = time.perf_counter()
        factor = system.factorise()
        factored = time.perf_counter() - start
        state = system.start(0.0 * amplitudes[0])
        begin = int(np.argmax(np.abs(loads.force).max(axis=1))) if loads.edges else 0
        state.step = begin
        right = M.createVecRight()
        left = M.createVecRight()
        right.set(1.0)
        steps, solves = [], []
        for _ in range(STEPS):
            start = time.perf_counter()
            system.march(state, amplitudes, last=state.step + 1)
            steps.append(time.perf_counter() - start)
            start = time.perf_counter()
            factor.solve(right, left)
            solves.append(time.perf_counter() - start)
    return factored, float(np.median(steps)), float(np.median(solves))
