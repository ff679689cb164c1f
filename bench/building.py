"""Speed of the 3D building: mesh, matrices, factorisation and modes of the paper-size mesh."""

from __future__ import annotations

import resource
import tempfile
import time
from pathlib import Path

import numpy as np

from bench.figure import Figure
from impactfem.building.from_case import geometry_of, read_parts
from impactfem.building.generate import generate
from impactfem.building.model import assemble_building
from impactfem.case import load_case
from impactfem.dynamics.factorisation import Factorisation
from impactfem.dynamics.modes import modes
from impactfem.system.files import in_source_tree
from impactfem.system.parallel import communicator

CASE = "geometry/npp_pair_fine.toml"
MODES = 20


def building_figures() -> list[Figure]:
    """Measure the paper-size mesh; with OMP_NUM_THREADS=1 on one core.

    Raises:
        ImpactfemError: The source tree with the shipped cases is missing.
    """
    case = load_case(in_source_tree(CASE))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "building.msh"
        start = time.perf_counter()
        generate(geometry_of(case), path, source=str(case.path))
        generated = time.perf_counter() - start
        parts, _, report = read_parts(case, path)
        read = time.perf_counter() - start - generated
    load_forms()
    start = time.perf_counter()
    model = assemble_building(communicator(), parts)
    assembled = time.perf_counter() - start
    elements = report.shells + report.beams
    K = model.take_stiffness(case.structure.storey_stiffness_factor if case.structure else 1.0)
    start = time.perf_counter()
    factorisation = Factorisation(K)
    factored = time.perf_counter() - start
    b, x = K.createVecs()
    b.setArray(np.ones(b.getLocalSize()))
    start = time.perf_counter()
    factorisation.solve(b, x)
    solved = time.perf_counter() - start
    factorisation.destroy()
    start = time.perf_counter()
    modes(K, model.mass, MODES)
    modal = time.perf_counter() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0**2
    return [
        Figure("paper-size mesh, shell and beam elements", elements, "-", 113_000, at_most=False),
        Figure("paper-size mesh, degrees of freedom", 6.0 * report.nodes, "-"),
        Figure("mesh generated", generated, "s"),
        Figure("mesh read and checked", read, "s"),
        Figure("matrices assembled", assembled, "s", 60.0),
        Figure("matrices, time an element", 1e6 * assembled / elements, "µs"),
        Figure("stiffness factored", factored, "s"),
        Figure("one solve", solved, "s"),
        Figure(f"first {MODES} modes", modal, "s", 240.0),
        Figure(f"first {MODES} modes, time an element", 1e3 * modal / elements, "ms"),
        Figure("peak memory", peak, "GB", 12.0),
    ]


def load_forms() -> None:
    """Compile the forms, or load them: a small building has the same."""
    case = load_case(in_source_tree("geometry/frame.toml"))
    parts, _, _ = read_parts(case, in_source_tree("geometry/frame.msh"))
    assemble_building(communicator(), parts)
