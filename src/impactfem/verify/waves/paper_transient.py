"""The reduced model of the paper's building against the full one, for three dampings."""

from __future__ import annotations

import re
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Case, load_case
from impactfem.coupling.force_history import write_forces
from impactfem.coupling.from_case import calibration_of
from impactfem.dynamics.damping import Rayleigh
from impactfem.motion.from_case import ground_motions
from impactfem.stages.pounding.pounded import pounded
from impactfem.system.files import in_source_tree
from impactfem.system.log import LOGGER
from impactfem.verify.row import Row

if TYPE_CHECKING:
    from impactfem.building.model import BuildingModel
    from impactfem.reduction.effectivity import Effectivity
    from impactfem.reduction.reduced_basis import ReducedBasis
    from impactfem.reduction.response import NodeResponse
    from impactfem.stages.transient.full_run import FullRun
    from impactfem.stages.transient.prepared import Prepared

Array = NDArray[np.float64]

NAME = "paper's building, reduced model against the full one"
CASE = "geometry/npp_pair.toml"
TABLE_8 = {
    "under-damped": Rayleigh(0.838, 2.12e-4),
    "damped": Rayleigh(0.838, 1.06e-3),
    "over-damped": Rayleigh(0.559, 3.18e-3),
}
"""α [1/s] and β [s] of Table 8 of the paper; the first one, the lightest, makes the basis."""
WINDOW = 6.5
"""Time that is computed: the strong motion, 2 to 5 s, and the main impact at 5.1 s [s]."""
HIGHEST, SPECTRUM_DAMPING = 450.0, 0.05
WITHIN = 0.005
"""Largest relative error of a spectrum."""
QUIET = 0.01
"""Peak acceleration, over the largest along the same axis, up to which a point is at rest along it:
on the plane of symmetry nothing moves across it but for the mesh."""
PLACES = {
    "floor centres": "centre_.*",
    "impact edges": "edge_.*",
    "line across floor 8": "line_.*",
    "corners of floor 8": "corner_.*",
}
"""Names of the probes, by place."""
TOLD = 0.95
"""Least share of the errors that the band tells to within a factor of ten."""
LEAST = 100_000
"""Free degrees of freedom that the mesh has at least."""
SIZE = 2.0
"""Size of the elements of the paper's building here [m]: it has 110,652 degrees of freedom."""


def reduced_against_full(
    case_file: Path | None = None, window: float = WINDOW, least: int = LEAST
) -> list[Row]:
    """Floor spectra by both solvers, with Newmark at the same step; one basis serves all dampings.

    The forces are those of the sticks of the case, the same for all dampings: what is compared is
    how the 3D model answers to them. A full run of the paper's building and window takes some 8
    minutes on a core; how long is said after the first steps.

    Args:
        case_file: The case; the shipped one of the paper, with elements of 2 m, when None.
        window: Time that is computed [s].
        least: Fewest free degrees of freedom of the mesh.

    Raises:
        ImpactfemError: The source tree with the shipped case is missing.
        SolutionError: The basis does not reach its tolerance.
    """
    # Only here: the manual is read, and its other benchmarks run, without dolfinx.
    from impactfem.reduction.effectivity import together
    from impactfem.reduction.response import modal_histories, node_response

    case = _case(case_file, window)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        both = _both_models(case, _prepared(case, folder, window))
        loads = both.prepared.loads
        rows = [
            _at_least("free degrees of freedom", least, both.model.n_free),
            _at_least("floors that are hit in the window", 1, len(loads.edges)),
        ]
        told: list[Effectivity] = []
        for label, damping in TABLE_8.items():
            run = _full_run(both, label, damping, folder)
            history = modal_histories(both.basis, loads, damping, scheme="newmark")
            reduced = node_response(both.basis, history, loads, both.nodes)
            rows += _spectrum_rows(both, label, reduced, run.response)
            told.append(_told(both, label, damping, reduced, run.response))
            rows.append(_energy_row(label, run))
        rows.append(_band_row(together(told)))
    return rows


@dataclass(frozen=True, eq=False)
class _BothModels:
    """The full model of the building and the reduced one.

    Args:
        case: The case.
        prepared: The building, its loads and its probes.
        model: Its matrices.
        K: Its stiffness matrix.
        patterns: Of the loads.
        basis: The reduced model; one serves all dampings.
    """

    case: Case
    prepared: Prepared
    model: BuildingModel
    K: Any
    patterns: Array
    basis: ReducedBasis

    @property
    def nodes(self) -> NDArray[np.int64]:
        """Nodes of the probes, shape (n_probes,)."""
        return np.array([probe.node for probe in self.prepared.probes])


def _case(case_file: Path | None, window: float) -> Case:
    """The case, with the window that is computed for its duration."""
    case = load_case(in_source_tree(CASE) if case_file is None else case_file)
    if case_file is None:
        case = _with_size(case, SIZE)
    if case.transient is None:
        raise ValueError(f"{case.path} has no transient part")
    transient = case.transient.model_copy(update={"duration": window})
    return case.model_copy(update={"transient": transient})


def _both_models(case: Case, prepared: Prepared) -> _BothModels:
    from mpi4py import MPI

    from impactfem.building.model import assemble_building
    from impactfem.reduction.reduced_basis import build_basis
    from impactfem.stages.transient.prepared import transient_of

    transient, loads = transient_of(case), prepared.loads
    nodes = np.array([probe.node for probe in prepared.probes])
    model = assemble_building(MPI.COMM_SELF, prepared.parts)
    K = model.take_stiffness(prepared.storey_factor)
    patterns = loads.patterns(model, prepared.parts.mesh, transient.eccentricity)
    start = time.perf_counter()
    basis = build_basis(
        model,
        K,
        patterns,
        loads.names,
        probes=nodes,
        nodes=np.unique(nodes),
        damping=next(iter(TABLE_8.values())),
        maximum_frequency=max(transient.maximum_frequency, HIGHEST),
        shift=transient.shift,
        tolerance=transient.tolerance,
        largest=transient.largest_basis,
        larger=True,
    )
    LOGGER.info(
        "paper's building: %d degrees of freedom, basis of %d vectors in %.0f s",
        model.n_free,
        len(basis.model.eigenvalue),
        time.perf_counter() - start,
    )
    return _BothModels(case, prepared, model, K, patterns, basis)


def _full_run(both: _BothModels, label: str, damping: Rayleigh, folder: Path) -> FullRun:
    from impactfem.stages.transient.full_run import run_full

    loads = both.prepared.loads
    return run_full(
        both.model,
        both.K,
        loads,
        both.patterns,
        damping,
        both.nodes,
        checkpoints=folder / label,
        key=label,
        every=len(loads.ground),
        progress=_Clock(label),
    )


def spectrum_errors(spectra: Array, truth: Array, moved: NDArray[np.bool_]) -> Array:
    """Largest relative error of each spectrum, of those that count, and 0 of the others.

    Args:
        spectra: Shape (n_points, 3, n_frequencies).
        truth: Same shape.
        moved: Whether a direction at a point counts, shape (n_points, 3).

    Returns:
        Shape (n_points, 3).
    """
    apart = np.abs(spectra[moved] / truth[moved] - 1.0).max(axis=-1)
    errors = np.zeros(moved.shape)
    errors[moved] = apart
    return errors


class _Clock:
    """Says once how long a run will take; called with the part that is done."""

    def __init__(self, label: str) -> None:
        self.label, self.start, self.said = label, time.perf_counter(), False

    def __call__(self, part: float) -> None:
        passed = time.perf_counter() - self.start
        if not self.said:
            text = "paper's building, %s: about %.1f minutes for the full run"
            LOGGER.info(text, self.label, passed / part / 60.0)
        self.said = True


def _with_size(case: Case, size: float) -> Case:
    """The case with elements of another size [m]; its mesh is generated."""
    if case.structure is None:
        raise ValueError(f"{case.path} has no structure")
    mesh = case.structure.mesh.model_copy(update={"size": size})
    return case.model_copy(update={"structure": case.structure.model_copy(update={"mesh": mesh})})


def _prepared(case: Case, folder: Path, window: float) -> Prepared:
    """Mesh, and the forces of the sticks, as the stages would make them."""
    from impactfem.building.from_case import geometry_of
    from impactfem.building.generate import generate
    from impactfem.stages.transient.prepared import prepare

    structure = case.structure
    if structure is None:
        raise ValueError(f"{case.path} has no structure")
    mesh, forces = folder / "building.msh", folder / "forces.nc"
    generate(geometry_of(case), mesh, source=str(case.path))
    response = pounded(case, calibration_of(case), ground_motions(case.motions), window)
    write_forces(forces, response, case.content_hash())
    return prepare(case, mesh, forces, structure.storey_stiffness_factor, "")


def _spectrum_rows(
    both: _BothModels, label: str, reduced: NodeResponse, full: NodeResponse
) -> Iterator[Row]:
    """The worst error by place, and how many spectra it is of."""
    from impactfem.reduction.response import node_spectra

    probes = both.prepared.probes
    n = len(probes)
    shown = both.case.spectra.model_copy(update={"damping": (SPECTRUM_DAMPING,)})
    found, truth = (node_spectra(response, shown) for response in (reduced, full))
    known = truth.frequency <= HIGHEST
    psa, exact = (s.psa[0].reshape(n, 3, -1)[..., known] for s in (found, truth))
    largest = np.abs(full.acceleration).max(axis=0)
    moved = largest > QUIET * largest.max(axis=0)
    errors = spectrum_errors(psa, exact, moved)
    for place, pattern in PLACES.items():
        here = [k for k, p in enumerate(probes) if re.fullmatch(pattern, p.name)]
        yield Row(
            NAME,
            f"largest error of a floor spectrum up to {HIGHEST:g} Hz, {place}, {label}",
            0.0,
            float(errors[here].max()) if here else np.inf,
            "-",
            WITHIN,
            f"the full model with the same step; {len(here)} points, {int(moved[here].sum())} of"
            f" {3 * len(here)} spectra, the others of directions at rest",
            absolute=True,
        )


def _told(
    both: _BothModels,
    label: str,
    damping: Rayleigh,
    reduced: NodeResponse,
    full: NodeResponse,
) -> Effectivity:
    """The error band over the true error of the spectra; what the band misses is logged."""
    from impactfem.reduction.band import response_band
    from impactfem.reduction.effectivity import effectivity
    from impactfem.reduction.response import node_spectra

    prepared = both.prepared
    shown = both.case.spectra.model_copy(update={"damping": (SPECTRUM_DAMPING,)})
    found, truth = (node_spectra(response, shown) for response in (reduced, full))
    band = response_band(
        both.basis, prepared.loads, damping, both.nodes, reduced, found.psa, shown, scheme="newmark"
    )
    known = truth.frequency <= HIGHEST
    widths, psa, exact = (values[0][:, known] for values in (band.psa, found.psa, truth.psa))
    told = effectivity(widths, psa, exact, truth.frequency[known])
    for spectrum, frequency, ratio in told.misses:
        probe = prepared.probes[spectrum // 3].name
        LOGGER.info(
            "paper's building, %s: the error band is %.2f times the error at %s along %s, %.0f Hz",
            label,
            ratio,
            probe,
            "xyz"[spectrum % 3],
            frequency,
        )
    return told


def _energy_row(label: str, run: FullRun) -> Row:
    return Row(
        NAME,
        f"residual of the energy identity over the largest energy, {label}, full",
        0.0,
        run.energy.residual,
        "-",
        1e-9,
        "average acceleration conserves the discrete balance (Hughes 1983)",
        absolute=True,
    )


def _band_row(told: Effectivity) -> Row:
    from impactfem.reduction.effectivity import LEAST, MOST

    return Row(
        NAME,
        f"share of errors of which the band is {LEAST:g} to {MOST:g} times, all dampings",
        1.0,
        told.good,
        "-",
        1.0 - TOLD,
        f"the full model; {len(told.ratio)} maxima within thirds of octaves, {len(told.misses)} of"
        " them larger than the band",
        absolute=True,
    )


def _at_least(quantity: str, least: int, found: int) -> Row:
    enough = float(found >= least)
    return Row(NAME, f"{quantity}, at least {least} (yes = 1)", 1.0, enough, "-", 0.0, f"{found}")
