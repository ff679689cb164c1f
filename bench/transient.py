"""Speed of the 3D stage in time on the paper-size mesh: full Newmark against the reduced model."""

from __future__ import annotations

import resource
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.building import CASE, load_forms
from bench.figure import Figure
from impactfem.building.from_case import geometry_of, read_parts
from impactfem.building.generate import generate
from impactfem.building.model import assemble_building
from impactfem.building.parts import BuildingParts
from impactfem.case import Case, load_case
from impactfem.coupling.force_history import ForceHistory
from impactfem.coupling.from_case import calibration_of
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.newmark import Newmark
from impactfem.motion.from_case import ground_motions
from impactfem.reduction.band import response_band
from impactfem.reduction.loads import Loads
from impactfem.reduction.probes import case_probes
from impactfem.reduction.reduced_basis import ReducedBasis, build_basis
from impactfem.reduction.response import modal_histories, node_response, node_spectra
from impactfem.spectra import response_spectra
from impactfem.stages.pounding.pounded import pounded
from impactfem.stages.transient.maps import floor_maps, looked_at
from impactfem.stages.transient.prepared import case_loads, lightest_damping, transient_of
from impactfem.system.files import in_source_tree
from impactfem.system.parallel import communicator, threads

Array = NDArray[np.float64]
Index = NDArray[np.int64]

STEPS = 12
"""Steps of the full model that are timed, interleaved with bare solves."""
AMONG = 100.0
"""Where the loss between the samples of the maps is told [Hz]."""
SAMPLE = 256
"""Vertices whose spectra are made with 20 points a cycle."""
FULL_STEPS = 10_001
"""Computed times of the paper's 3D run (section 4.1)."""


@dataclass(frozen=True)
class _Full:
    """Times of the full model [s]."""

    factorisation: float
    step: float
    solve: float

    @property
    def loop(self) -> float:
        return self.factorisation + self.step * FULL_STEPS


@dataclass(frozen=True)
class _Reduced:
    """Times of the reduced model [s].

    Args:
        vectors: Of the reduced model.
        basis: From the matrices until its tolerance is met.
        around: The norms of the rigorous bound, and the vectors of the larger models that tell the
            error band; the rows of the nodes that are looked at are gathered then, too.
        response: History of all modes and spectra at the points.
        band: The error band of these spectra.
    """

    vectors: int
    basis: float
    around: float
    response: float
    band: float


@dataclass(frozen=True)
class _Maps:
    """Times of the spectra of every floor vertex [s], and how many there are."""

    vertices: int
    frequencies: int
    time: float
    finer: float
    loss: float


def transient_figures(every_damping: bool = False) -> list[Figure]:
    """Measure; the forces are those of the sticks of the paper's case.

    Args:
        every_damping: Make the reduced basis for the lightest of the case's damping cases, so that
            it serves them all, not for the building's own damping.

    Raises:
        ImpactfemError: The source tree with the shipped cases is missing.
    """
    case = load_case(in_source_tree(CASE))
    transient, structure = case.transient, case.structure
    if transient is None or structure is None:
        raise ValueError(f"{CASE} has no transient part")
    parts = _parts(case)
    loads = _loads(case, parts)
    damping = case.building(structure.building).damping.rayleigh
    load_forms()
    comm = communicator()
    model = assemble_building(comm, parts)
    n_free = model.n_free
    K = model.take_stiffness(structure.storey_stiffness_factor)
    patterns = loads.patterns(model, parts.mesh, transient.eccentricity)
    full = _full_steps(model.mass, K, loads, patterns, damping)
    nodes = np.array([probe.node for probe in case_probes(parts.mesh, transient.probes)])
    clock = _Clock()
    basis = build_basis(
        model,
        K,
        patterns,
        loads.names,
        probes=nodes,
        nodes=looked_at(parts.mesh, nodes),
        damping=lightest_damping(case, every_damping),
        maximum_frequency=transient.maximum_frequency,
        shift=transient.shift,
        tolerance=transient.tolerance,
        largest=transient.largest_basis,
        larger=True,
        spend=True,
        progress=clock,
    )
    whole = clock.passed()
    response, band = _responses(case, basis, loads, damping, nodes)
    around = whole - clock.ended
    reduced = _Reduced(len(basis.model.eigenvalue), clock.ended, around, response, band)
    maps = _maps(case, parts, basis, loads, damping)
    peak = comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) / 1024.0**2
    return [
        *_full_figures(full, n_free),
        *_reduced_figures(reduced, full, every_damping),
        *_map_figures(maps),
        Figure("peak memory", peak, "GB", 16.0),
    ]


def _full_figures(full: _Full, n_free: int) -> list[Figure]:
    each = 1e6 * full.step / n_free
    return [
        Figure("3D in time, free degrees of freedom", float(n_free), "-"),
        Figure("full Newmark, factorisation", full.factorisation, "s"),
        Figure("full Newmark, one step", full.step, "s"),
        Figure("one bare solve", full.solve, "s"),
        Figure("step over bare solve", full.step / full.solve, "-", 1.3),
        Figure("full Newmark, time a degree of freedom and step", each, "µs"),
        Figure(f"full Newmark, {FULL_STEPS} steps", full.loop, "s"),
    ]


def _reduced_figures(reduced: _Reduced, full: _Full, every_damping: bool) -> list[Figure]:
    named, target = ("for every damping case, ", 25.0) if every_damping else ("", 40.0)
    spectra = reduced.basis + reduced.response
    whole = spectra + reduced.around + reduced.band
    again = reduced.response + reduced.band
    return [
        Figure(f"reduced model, {named}vectors", float(reduced.vectors), "-"),
        Figure(f"reduced model, {named}basis", reduced.basis, "s"),
        Figure(f"reduced model, {named}basis to spectra at all points", spectra, "s"),
        Figure(f"reduced model, {named}full loop over it", full.loop / spectra, "-", target, False),
        Figure(f"reduced model, {named}with error band and bound", whole, "s"),
        Figure(f"reduced model, {named}full loop over that", full.loop / whole, "-"),
        Figure("a further motion, gap or damping, error band included", again, "s", 5.0),
    ]


def _map_figures(maps: _Maps) -> list[Figure]:
    return [
        Figure("spectra of every floor vertex, vertices", float(maps.vertices), "-"),
        Figure("spectra of every floor vertex, frequencies", float(maps.frequencies), "-"),
        Figure("spectra of every floor vertex", maps.time, "s", 180.0),
        Figure(f"bound of what a peak at {AMONG:g} Hz lacks there", maps.loss, "-"),
        Figure("the same with 20 points a cycle, from a sample", maps.finer, "s"),
    ]


class _Clock:
    """Seconds since it was made; remembers when the basis was said to be done."""

    def __init__(self) -> None:
        self.start = time.perf_counter()
        self.ended = 0.0

    def __call__(self, part: float) -> None:
        if part >= 1.0:
            self.ended = self.passed()

    def passed(self) -> float:
        return time.perf_counter() - self.start


def _responses(
    case: Case, basis: ReducedBasis, loads: Loads, damping: Rayleigh, nodes: Index
) -> tuple[float, float]:
    """Times of the response with its spectra, and of their error band [s]."""
    clock = _Clock()
    history = modal_histories(basis, loads, damping)
    response = node_response(basis, history, loads, nodes)
    spectra = node_spectra(response, case.spectra)
    found = clock.passed()
    response_band(basis, loads, damping, nodes, response, spectra.psa, case.spectra)
    return found, clock.passed() - found


def _maps(
    case: Case,
    parts: BuildingParts,
    basis: ReducedBasis,
    loads: Loads,
    damping: Rayleigh,
) -> _Maps:
    history = modal_histories(basis, loads, damping)
    clock = _Clock()
    maps = floor_maps(parts, basis, history, loads, case.spectra, main_impact=None)
    mapped = clock.passed()
    sample = maps.nodes[:SAMPLE]
    records = node_response(basis, history, loads, sample).acceleration
    clock = _Clock()
    response_spectra(
        records.reshape(len(records), -1).T,
        loads.time_step,
        maps.frequency,
        [maps.damping],
        points_per_cycle=20.0,
        threads=threads(),
        absolute=False,
    )
    return _Maps(
        vertices=len(maps.nodes),
        frequencies=len(maps.frequency),
        time=mapped,
        finer=clock.passed() * len(maps.nodes) / len(sample),
        loss=float(np.interp(AMONG, maps.frequency, maps.sampling_loss)),
    )


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


def _full_steps(M: Any, K: Any, loads: Loads, patterns: Array, damping: Rayleigh) -> _Full:
    amplitudes = loads.amplitudes
    with Newmark(K, M, loads.time_step, patterns, damping=damping) as system:
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
    return _Full(factored, float(np.median(steps)), float(np.median(solves)))
