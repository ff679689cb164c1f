"""The reduced model of the paper's building against the full one, for three dampings."""

from __future__ import annotations

import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from impactfem.case import BuildingInTime, Spectra, load_case
from impactfem.coupling.force_history import write_forces
from impactfem.coupling.from_case import calibration_of
from impactfem.dynamics.damping import Rayleigh
from impactfem.motion.from_case import ground_motions
from impactfem.stages.pounding.compute import pounded
from impactfem.system.files import in_source_tree
from impactfem.system.log import LOGGER
from impactfem.verify.row import Rows, benchmark
from impactfem.verify.waves import BALANCE

if TYPE_CHECKING:
    from impactfem.reduction.error_band import Effectivity
    from impactfem.reduction.reduced_basis import ReducedBasis
    from impactfem.reduction.response import NodeResponse
    from impactfem.stages.transient.prepared import Prepared


CASE = "geometry/npp_pair.toml"
TABLE_8 = {
    "under-damped": Rayleigh(0.838, 2.12e-4),
    "damped": Rayleigh(0.838, 1.06e-3),
    "over-damped": Rayleigh(0.559, 3.18e-3),
}
"""α [1/s] and β [s] of Table 8 of the paper; the first one, the lightest, makes the basis."""
WINDOW = 6.5  # time that is computed: the strong motion, 2 to 5 s, and the main impact at 5.1 s [s]
HIGHEST, SPECTRUM_DAMPING = 450.0, 0.05
WITHIN = 0.005  # largest relative error of a spectrum
QUIET = 0.01
"""Peak acceleration, over the largest along the same axis, up to which a point is at rest along it:
on the plane of symmetry nothing moves across it but for the mesh."""
PLACES = {
    "floor centres": "centre_",
    "impact edges": "edge_",
    "line across floor 8": "line_",
    "corners of floor 8": "corner_",
}
"""Prefix of the names of probes by place."""
ENOUGH = 0.95  # least share of the errors that the band tells to within a factor of ten
LEAST_FREE = 100_000  # free degrees of freedom that the mesh has at least
SIZE = 2.0
"""Size of the elements of the paper's building here [m]: it has 110,652 degrees of freedom."""


@benchmark("paper's building, reduced model against the full one", heavy=True)
def paper_reduced_against_full(
    rows: Rows, case_file: Path | None = None, window: float = WINDOW, least: int = LEAST_FREE
) -> None:
    """Floor spectra by both solvers, with Newmark at the same step; one basis serves all dampings.

    The forces are those of the sticks of the case, the same for all dampings: what is compared is
    how the 3D model answers to them. A full run of the paper's building and window takes some 8
    minutes on a core; how long is said after the first steps.
    """
    # Only here: the manual is read, and its other benchmarks run, without dolfinx.
    from mpi4py import MPI

    from impactfem.building.links import Displacements
    from impactfem.building.model import assemble_building
    from impactfem.reduction.error_band import LEAST, MOST, together
    from impactfem.reduction.reduced_basis import Accuracy, BasisPlan, build_basis
    from impactfem.stages.transient.full_run import FullModel, Resumption, run_full

    building = paper_building(case_file, window, SIZE if case_file is None else None)
    case, transient = building.case, building.transient
    shown = case.spectra.model_copy(update={"damping": (SPECTRUM_DAMPING,)})
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        prepared = prepared_building(building, folder, window)
        loads, probes = prepared.loads, prepared.probes
        nodes = np.array([probe.node for probe in probes])
        model = assemble_building(MPI.COMM_SELF, prepared.parts)
        for quantity, fewest, found in (
            ("free degrees of freedom", least, model.n_free),
            ("floors that are hit in the window", 1, len(loads.edges)),
        ):
            quantity = f"{quantity}, at least {fewest} (yes = 1)"
            rows.add(quantity, 1.0, found >= fewest, "-", 0.0, f"{found}")
        K = model.take_stiffness(prepared.storey_factor)
        patterns = loads.patterns(model, prepared.parts.mesh)
        start = time.perf_counter()
        lightest, highest = next(iter(TABLE_8.values())), max(transient.maximum_frequency, HIGHEST)
        basis = build_basis(
            model,
            K,
            patterns,
            BasisPlan(
                loads=loads.names,
                probes=nodes,
                nodes=np.unique(nodes),
                accuracies=(Accuracy(lightest, highest, transient.tolerance),),
                shift=transient.shift,
                largest=transient.largest_basis,
                larger=True,
            ),
        )
        sizes, passed = (model.n_free, len(basis.model.eigenvalue)), time.perf_counter() - start
        text = "paper's building: %d degrees of freedom, basis of %d vectors in %.0f s"
        LOGGER.info(text, *sizes, passed)
        of_band: list[Effectivity] = []
        for label, damping in TABLE_8.items():
            run = run_full(
                FullModel(model, K, damping),
                loads,
                patterns,
                Displacements(model, nodes),
                Resumption(folder / label, label, len(loads.ground)),
                _Clock(label),
            )
            of_band.append(
                _spectra_rows(rows, label, damping, prepared, basis, run.response, shown)
            )
            rows.where = f"{label}, full"
            quantity = "residual of the energy identity over the largest energy"
            rows.add(quantity, 0.0, run.energy.residual, "-", 1e-9, BALANCE)
    rows.where = ""
    every = together(of_band)
    quantity = f"share of errors of which the band is {LEAST:g} to {MOST:g} times, all dampings"
    source = (
        f"the full model; {len(every.ratio)} maxima within thirds of octaves,"
        f" {len(every.misses)} of them larger than the band"
    )
    rows.add(quantity, 1.0, every.good, "-", 1.0 - ENOUGH, source, absolute=True)


def _spectra_rows(
    rows: Rows,
    label: str,
    damping: Rayleigh,
    prepared: Prepared,
    basis: ReducedBasis,
    full: NodeResponse,
    shown: Spectra,
) -> Effectivity:
    """Write the errors of the spectra by place, and return how good the error band is."""
    from impactfem.reduction.error_band import effectivity
    from impactfem.reduction.response import (
        Analysis,
        modal_histories,
        node_response,
        node_spectra,
        response_band,
    )

    loads, probes = prepared.loads, prepared.probes
    nodes = np.array([probe.node for probe in probes])
    history = modal_histories(basis, loads, damping, scheme="newmark")
    reduced = node_response(basis, history, loads, nodes)
    spectra, truth = (node_spectra(response, shown) for response in (reduced, full))
    known = truth.frequency <= HIGHEST
    psa, exact = (s.psa[0].reshape(len(probes), 3, -1)[..., known] for s in (spectra, truth))
    largest = np.abs(full.acceleration).max(axis=0)
    moved = largest > QUIET * largest.max(axis=0)
    ratios = np.divide(psa, exact, out=np.ones_like(psa), where=moved[..., None])
    errors = np.abs(ratios - 1.0).max(axis=-1)
    for place, prefix in PLACES.items():
        here = [k for k, p in enumerate(probes) if p.name.startswith(prefix)]
        worst = errors[here].max() if here else np.inf
        rows.where = f"{place}, {label}"
        quantity = f"largest error of a floor spectrum up to {HIGHEST:g} Hz"
        source = (
            f"the full model with the same step; {len(here)} points, {int(moved[here].sum())} of "
            f"{3 * len(here)} spectra, the others of directions at rest"
        )
        rows.add(quantity, 0.0, worst, "-", WITHIN, source)
    analysis = Analysis(basis, loads, damping, scheme="newmark")
    band = response_band(analysis, nodes, reduced, spectra.psa, shown)
    widths, psa, exact = (v[0][:, known] for v in (band.psa, spectra.psa, truth.psa))
    found = effectivity(widths, psa, exact, truth.frequency[known])
    for spectrum, frequency, ratio in found.misses:
        place = f"{probes[spectrum // 3].name} along {'xyz'[spectrum % 3]}"
        text = "paper's building, %s: the error band is %.2f times the error at %s, %.0f Hz"
        LOGGER.info(text, label, ratio, place, frequency)
    return found


def paper_building(file: Path | None, window: float, size: float | None = None) -> BuildingInTime:
    """Return the building of the paper's or another case, with another element size [m].

    It is computed for a window [s].
    """
    case = load_case(in_source_tree(CASE) if file is None else file)
    if not case.in_time:
        raise ValueError(f"{case.path} has no transient part or no structure")
    building = case.in_time[0]
    transient, structure = building.transient, building.structure
    if size is not None:
        mesh = structure.mesh.model_copy(update={"size": size})
        structure = structure.model_copy(update={"mesh": mesh})
    transient = transient.model_copy(update={"duration": window})
    return replace(building, transient=transient, structure=structure)


def prepared_building(building: BuildingInTime, folder: Path, window: float) -> Prepared:
    """Return mesh and forces of the sticks as the stages compute them."""
    from impactfem.building.from_case import geometry_of
    from impactfem.building.generate import generate
    from impactfem.stages.transient.prepared import prepare

    mesh, forces = folder / "building.msh", folder / "forces.nc"
    case = building.case
    generate(geometry_of(building), mesh, source=str(case.path))
    response = pounded(case, calibration_of(case), ground_motions(case.motions), window)
    write_forces(forces, response, case.content_hash())
    return prepare(building, mesh, forces, building.structure.storey_stiffness_factor, "")


class _Clock:
    """Log the expected run time once; called with the completed part."""

    def __init__(self, label: str) -> None:
        self.label, self.start, self.said = label, time.perf_counter(), False

    def __call__(self, part: float) -> None:
        passed = time.perf_counter() - self.start
        if not self.said:
            text = "paper's building, %s: about %.1f minutes for the full run"
            LOGGER.info(text, self.label, passed / part / 60.0)
        self.said = True
