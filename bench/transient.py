"""Speed of the 3D stage in time: full Newmark, the reduced model, and what its basis takes."""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from bench.building import load_forms, peak_memory
from bench.suite import Figure, Watch, best_time, timed
from impactfem.building.from_case import geometry_of
from impactfem.building.generate import generate
from impactfem.building.model import BuildingModel, assemble_building
from impactfem.case import BuildingInTime, load_case
from impactfem.dynamics.factorisation import Factorisation
from impactfem.dynamics.newmark import Newmark
from impactfem.motion.from_case import ground_motions
from impactfem.reduction import galerkin, krylov, orthonormal
from impactfem.reduction.galerkin import GalerkinModes
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.orthonormal import Orthonormal
from impactfem.reduction.probes import recorded_nodes
from impactfem.reduction.reduced_basis import BasisPlan, ReducedBasis, build_basis
from impactfem.reduction.reduced_building import reduce_building
from impactfem.reduction.response import (
    Analysis,
    modal_histories,
    node_response,
    node_spectra,
    response_band,
)
from impactfem.spectra import response_spectra
from impactfem.stages.reduce.compute import accuracies, prepare
from impactfem.stages.transient.maps import floor_maps
from impactfem.stages.transient.prepared import Prepared
from impactfem.stages.transient.reduced_run import ReducedRun
from impactfem.system.arrays import Array
from impactfem.system.files import in_source_tree
from impactfem.system.parallel import all_blas_threads, communicator, threads
from impactfem.verify.waves.paper import prepared_building

PAPER_SIZE, DEFAULT = "geometry/npp_pair_fine.toml", "geometry/npp_pair.toml"
STEPS = 12
"""Steps of the full model that are timed, interleaved with bare solves."""
AMONG = 100.0
"""Where the loss between the samples of the maps is reported [Hz]."""
SAMPLE = 256
"""Vertices whose spectra are made with 20 points a cycle."""
FULL_STEPS = 10_001
"""Computed times of the paper's 3D run (section 4.1)."""
WITH_PRODUCTS = (krylov, orthonormal, galerkin)
"""Modules of the reduction that multiply with the mass or the stiffness."""
PEAK = 2000
"""Rows of the square matrices whose product shows the peak of BLAS."""


def transient_figures(every_damping: bool = False, case_file: str = PAPER_SIZE) -> list[Figure]:
    """Measure; the forces are those of the sticks of the case.

    Args:
        every_damping: Make the reduced basis for the lightest of the case's damping cases, so that
            it serves them all, not for the building's own damping.
        case_file: The case, from the root of the source tree.

    Raises:
        ImpactfemError: The source tree with the shipped cases is missing.
    """
    building = load_case(in_source_tree(case_file)).in_time[0]
    case, transient = building.case, building.transient
    longest = max((m.accelerogram.duration for m in ground_motions(case.motions)), default=0.0)
    with tempfile.TemporaryDirectory() as folder:
        duration = transient.duration or case.pounding.duration or longest
        prepared = prepared_building(building, Path(folder), duration)
    loads, damping, mesh = prepared.loads, prepared.damping, prepared.parts.mesh
    load_forms()
    model = assemble_building(communicator(), prepared.parts)
    K = model.take_stiffness(prepared.storey_factor)
    patterns = loads.patterns(model, mesh)
    full = _full_figures(model, K, prepared, patterns)
    loop = full[-1].value
    nodes = np.array([probe.node for probe in prepared.probes])
    asked = transient.model_copy(update={"serve_damping_cases": every_damping})
    ended: list[float] = []  # when the tolerance is met
    start = perf_counter()
    plan = BasisPlan(
        loads=loads.names,
        probes=nodes,
        nodes=recorded_nodes(mesh, nodes),
        accuracies=accuracies(replace(building, transient=asked))[:1],
        shift=transient.shift,
        largest=transient.largest_basis,
        larger=True,
    )

    def progress(part: float) -> None:
        if part >= 1.0:
            ended.append(perf_counter())

    basis = build_basis(model, K, patterns, plan, progress)
    whole, built = perf_counter() - start, ended[-1] - start

    def respond() -> Any:
        history = modal_histories(basis, loads, damping)
        response = node_response(basis, history, loads, nodes)
        return response, node_spectra(response, case.spectra)

    (response, spectra), responded = timed(respond)
    _, banded = timed(
        lambda: response_band(
            Analysis(basis, loads, damping), nodes, response, spectra.psa, case.spectra
        )
    )
    named, target = ("for every damping case, ", 25.0) if every_damping else ("", 40.0)
    reduced, first = f"reduced model, {named}", built + responded
    # The norms of the bound and the larger models of the band are made around the basis.
    certain = whole + responded + banded
    again = "a further motion, gap or damping, error band included"
    return [
        *full,
        Figure(f"{reduced}vectors", float(len(basis.model.eigenvalue)), "-"),
        Figure(f"{reduced}basis", built, "s"),
        Figure(f"{reduced}basis to spectra at all points", first, "s"),
        Figure(f"{reduced}full loop over it", loop / first, "-", target, at_most=False),
        Figure(f"{reduced}with error band and bound", certain, "s"),
        Figure(f"{reduced}full loop over that", loop / certain, "-"),
        Figure(again, responded + banded, "s", 5.0),
        *_map_figures(building, prepared, basis),
        Figure("peak memory", peak_memory(), "GB", 16.0),
    ]


def basis_figures(case_file: str = DEFAULT) -> list[Figure]:
    """Factor, solves, orthogonalisation and products of the one reduced building of a run.

    Operations are those that the algorithm needs, so that their rate over that of BLAS at its peak
    says what a better implementation could gain at most: MUMPS's count of its factorisation; four
    an entry of the factor and column for a solve; for the orthogonalisation of k columns against n
    others of N rows, in one pass or two and among themselves, 4 N k (n + k) a pass, 6 N k n for
    what rounding left, 2 N k n where they stay as they are; two an entry of the matrix and column
    for a product, also for what Galerkin's model is seen through. A block step that takes rounding
    off does so while the next one is solved for: both count as one.
    """
    modelled = next(iter(load_case(in_source_tree(case_file)).modelled.values()))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "building.msh"
        generate(geometry_of(modelled), path, source=case_file)
        prepared = prepare(modelled, path, modelled.structure.storey_stiffness_factor)
    load_forms()
    building = assemble_building(communicator(), prepared.parts)
    watch, degrees = Watch(), building.n_free

    def solving(factor: Factorisation, B: Any) -> float:
        return 4.0 * factor.entries * float(B.shape[1])

    def orthogonalising(
        basis: Orthonormal, X: Array, near: int = 0, dependent: float = 0.0, attempts: int = 3
    ) -> float:
        firsts = (near,) if attempts == 1 else (near, 0)
        return sum(4.0 * X.size * max(basis.count - first, X.shape[1]) for first in firsts)

    def knowing(basis: Orthonormal, X: Array, _: float) -> float:
        return 2.0 * X.size * basis.stored

    def settling(basis: KrylovBasis, last: slice) -> float:
        return 6.0 * basis.Q.size * basis.size if basis.clean else 0.0

    def multiplying(A: Any, X: Array, Y: Array | None = None) -> float:
        return 2.0 * float(A.getInfo()["nz_used"]) * X.shape[1]

    def projecting(basis: KrylovBasis) -> float:
        return float(basis.Q.shape[0]) * (basis.vectors.count - basis.size) ** 2

    watched: list[tuple[Any, str, str, Any]] = [
        (Factorisation, "__init__", "factor", lambda factor, *_, **__: factor.operations),
        (Factorisation, "solve_block", "solves", solving),
        (Orthonormal, "append", "orthogonalisation", orthogonalising),
        (Orthonormal, "append_kept", "orthogonalisation", knowing),
        (KrylovBasis, "_settle", "solves and orthogonalisation at once", settling),
        *((module, "product", "products with M and K", multiplying) for module in WITH_PRODUCTS),
        (GalerkinModes, "of", "Galerkin's products", projecting),
    ]
    with ExitStack() as stack:
        for owner, name, label, operations in watched:
            stack.enter_context(watch.on(owner, name, label, operations))
        reduced, whole = timed(
            lambda: reduce_building(
                building, prepared.parts.mesh, prepared.storey_factor, prepared.plan
            )
        )
    rng = np.random.default_rng(0)
    A, B = rng.standard_normal((2, PEAK, PEAK))
    with all_blas_threads():
        peak = 2.0 * PEAK**3 / best_time(lambda: A @ B, 3)
    figures = [
        Figure("BLAS at its peak (dgemm), all threads", peak / 1e9, "Gflop/s"),
        Figure("basis, free degrees of freedom", float(degrees), "-"),
        Figure("basis, vectors", float(len(reduced.fine.models[0].eigenvalue)), "-"),
        Figure("basis, with contacts and anchors", float(len(reduced.complete.eigenvalue)), "-"),
        Figure("basis", whole, "s"),
    ]
    for label, seconds in watch.seconds.items():
        operations = watch.operations[label]
        figures += [
            Figure(f"basis, {label}", seconds, "s"),
            Figure(f"basis, {label}, share of the time", seconds / whole, "-"),
            Figure(f"basis, {label}, operations", operations / 1e9, "Gflop"),
            Figure(f"basis, {label}, with BLAS at its peak", operations / peak, "s"),
            Figure(f"basis, {label}, rate over BLAS", operations / seconds / peak, "-"),
        ]
    rest = whole - sum(watch.seconds.values())
    return [*figures, Figure("basis, all else, share of the time", rest / whole, "-")]


def _full_figures(
    model: BuildingModel, K: Any, prepared: Prepared, patterns: Array
) -> list[Figure]:
    """Steps of Newmark in full order from the first impact on, each with a bare solve."""
    loads, damping = prepared.loads, prepared.damping.rayleigh
    amplitudes = loads.amplitudes
    with Newmark(K, model.mass, loads.time_step, patterns, damping=damping) as system:
        factor, factored = timed(system.factorise)
        state = system.start(0.0 * amplitudes[0])
        state.step = int(np.argmax(np.abs(loads.force).max(axis=1))) if loads.edges else 0
        right, left = model.mass.createVecRight(), model.mass.createVecRight()
        right.set(1.0)
        times = []
        for _ in range(STEPS):
            _, step = timed(lambda: system.march(state, amplitudes, last=state.step + 1))
            times.append((step, timed(lambda: factor.solve(right, left))[1]))
    step, solve = np.median(times, axis=0)
    each = 1e6 * step / model.n_free
    return [
        Figure("3D in time, free degrees of freedom", float(model.n_free), "-"),
        Figure("full Newmark, factorisation", factored, "s"),
        Figure("full Newmark, one step", step, "s"),
        Figure("one bare solve", solve, "s"),
        Figure("step over bare solve", step / solve, "-", 1.3),
        Figure("full Newmark, time a degree of freedom and step", each, "µs"),
        Figure(f"full Newmark, {FULL_STEPS} steps", factored + step * FULL_STEPS, "s"),
    ]


def _map_figures(building: BuildingInTime, prepared: Prepared, basis: ReducedBasis) -> list[Figure]:
    """Spectra of every floor vertex."""
    loads, highest = prepared.loads, building.transient.maximum_frequency
    run = ReducedRun(basis, loads, prepared.damping, building.case.spectra, highest)
    history = run.history
    maps, mapped = timed(lambda: floor_maps(prepared.parts, run, main_impact=None))
    nodes, frequency = maps["node_number"].values, maps["frequency"].values
    records = node_response(basis, history, loads, nodes[:SAMPLE]).acceleration
    _, finer = timed(
        lambda: response_spectra(
            records.reshape(len(records), -1).T,
            loads.time_step,
            frequency,
            [building.case.spectra.damping[0]],
            points_per_cycle=20.0,
            threads=threads(),
            absolute=False,
        )
    )
    count, name = len(nodes), "spectra of every floor vertex"
    loss = np.interp(AMONG, frequency, maps["sampling_loss"].values)
    return [
        Figure(f"{name}, vertices", float(count), "-"),
        Figure(f"{name}, frequencies", float(len(frequency)), "-"),
        Figure(name, mapped, "s", 180.0),
        Figure(f"bound of what a peak at {AMONG:g} Hz lacks there", float(loss), "-"),
        Figure("the same with 20 points a cycle, from a sample", finer * count / SAMPLE, "s"),
    ]
