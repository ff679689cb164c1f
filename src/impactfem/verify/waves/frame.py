"""The shipped frame: superposition, reciprocity, and the error band of its reduced model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg

from impactfem.building.shell_model import UY, ShellModel, csr
from impactfem.case import load_case
from impactfem.dynamics.damping import Rayleigh
from impactfem.spectra import response_spectra
from impactfem.system.arrays import Array
from impactfem.system.files import in_source_tree
from impactfem.verify.row import Rows, benchmark
from impactfem.verify.waves import KRYLOV, Motion, MovingModel, apart

if TYPE_CHECKING:
    from impactfem.reduction.error_band import Effectivity

NAME = "frame under forces on two edges"
STEP, END, PULSE = 1e-3, 0.3, 0.02
ALLOWED = {
    "full": {"displacement": 1e-9, "acceleration": 1e-9},
    "reduced": {"displacement": 1e-9, "acceleration": 2e-6},
}
"""Of reciprocity: the basis leaves out what is nearly dependent, of the two loads not the same.
What is left out are short waves, which count in the acceleration by their frequency squared."""
OF_BASIS = {"displacement": 1e-8, "acceleration": 2e-5}
"""Of the reduced model beside the full one, for the same reason."""

BAND_STEP, BAND_END, BAND_PULSE, BAND_SHIFT = 0.5e-3, 0.4, 0.006, 60.0
BASES = (54, 66, 78, 90)  # vectors of the bases: from poor ones to good ones
FREQUENCY: Array = np.asarray(np.geomspace(2.0, 250.0, 100), dtype=np.float64)
ENOUGH = 0.95  # least share of the thirds of octaves at which band over error is between 1 and 10


@dataclass(frozen=True, eq=False)
class Frame:
    """The frame under a pulse on the edge of floor 1, on that of floor 2, and under the ground."""

    moving: MovingModel
    damping: Rayleigh
    #: Each probe's share in the mean motion of the two edges, as the loads' shares of the nodes,
    #: shape (2, n_probes).
    weights: Array


@benchmark(NAME, "the equations are linear")
def superposition(rows: Rows) -> None:
    """The response to all loads at once against the sum of those to each, at every probe."""
    frame = shipped_frame()
    each = _amplitudes(STEP, END, PULSE, (0.01, 0.1))
    for solver, motion in _solvers(frame).items():
        together, one_by_one = motion(each), [motion(each * only) for only in np.eye(3)]
        for name in ("displacement", "acceleration"):
            away = apart(together[name], np.sum([one[name] for one in one_by_one], axis=0))
            quantity = f"{name} under all loads from the sum over each, {solver}"
            rows.add(quantity, 0.0, away, "-", 1e-9)


@benchmark(NAME)
def reciprocity(rows: Rows) -> None:
    """A pulse on the edge of floor 1, seen on floor 2, against the same pulse the other way round.

    Of each edge the mean is seen that the line load does its work on: then both are equal, as K, M
    and C are symmetric (Rayleigh 1873).
    """
    frame = shipped_frame()
    loads = _amplitudes(STEP, END, PULSE, (0.01, 0.1))
    solvers = _solvers(frame)
    for solver, motion in solvers.items():
        lower, upper = (motion(np.outer(loads[:, 0], only)) for only in np.eye(3)[:2])
        rows.where = solver
        for name in ("displacement", "acceleration"):
            up, down = lower[name] @ frame.weights[1], upper[name] @ frame.weights[0]
            quantity = f"{name} of edge 2 by a pulse on edge 1 from the reverse"
            source = "Maxwell, Betti and Rayleigh: symmetric matrices"
            rows.add(quantity, 0.0, apart(up, down), "-", ALLOWED[solver][name], source)
        # Without this the rows above could compare what has nothing to do with the loads.
        own, seen = (np.abs(m["acceleration"] @ frame.weights[1]).max() for m in (upper, lower))
        quantity = "acceleration of edge 2 by its own pulse is another one (yes = 1)"
        rows.add(quantity, 1.0, own > 1.1 * seen > 0.0, "-", 0.0, "no symmetry")
    full, reduced = (motion(loads) for motion in solvers.values())
    rows.where = "reduced model from the full one, both by Newmark"
    for name, allowed in OF_BASIS.items():
        rows.add(name, 0.0, apart(reduced[name], full[name]), "-", allowed, KRYLOV)


@benchmark(
    "frame under short pulses, error band of the reduced model",
    "the full model with the same step; maxima within thirds of octaves",
)
def error_band(rows: Rows) -> None:
    """Spectra of the edges by three bases and two dampings: band over true error.

    Counted are thirds of octaves with an error above a ten-thousandth of the spectrum.
    """
    from impactfem.reduction.error_band import LEAST, MOST, effectivity, together
    from impactfem.reduction.response import LARGER, SAFETY, WIDTH, spectrum_difference

    frame = shipped_frame()
    amplitudes = _amplitudes(BAND_STEP, BAND_END, BAND_PULSE, (0.1, 0.2))
    amplitudes[:, 2] *= np.sin(np.pi * np.linspace(0.0, 1.0, len(amplitudes))) ** 2
    own = frame.damping
    found: list[Effectivity] = []
    for damping in (own, Rayleigh(own.alpha, 0.2 * own.beta)):
        full = frame.moving.full(amplitudes, BAND_STEP, damping)
        truth = _spectra(full.motion["acceleration"])
        for vectors in BASES:
            psa, *others = (
                _spectra(one.motion(amplitudes, BAND_STEP, damping, "newmark")["acceleration"])
                for one in frame.moving.nested(BAND_SHIFT, vectors, larger=True)
            )
            band = SAFETY[LARGER] * spectrum_difference(psa, others, FREQUENCY, WIDTH[LARGER])
            found.append(effectivity(band, psa, truth, FREQUENCY))
    every = together(found)
    quantity = (
        f"share of {len(every.ratio)} errors of which the band is {LEAST:g} to {MOST:g} times,"
        f" {len(every.misses)} of them not held"
    )
    rows.add(quantity, 1.0, every.good, "-", 1.0 - ENOUGH, absolute=True)
    much = len(every.ratio) >= 1000
    rows.add("errors in the comparison, at least 1000 (yes = 1)", 1.0, much, "-", 0.0)


def _spectra(acceleration: Array) -> Array:
    """Pseudo-acceleration at 5 % of each probe, shape (n_probes, n_frequencies)."""
    found = response_spectra(acceleration.T, BAND_STEP, FREQUENCY, [0.05], absolute=False)
    return np.asarray(found.psa[0], dtype=np.float64)


def shipped_frame() -> Frame:
    """Assemble the frame; ImpactfemError where the program runs without its source tree."""
    # Only here: the manual is read, and its other benchmarks run, without dolfinx.
    from mpi4py import MPI

    from impactfem.building.floor import edge_load
    from impactfem.building.from_case import read_parts
    from impactfem.building.model import assemble_building

    frame = load_case(in_source_tree("geometry/frame.toml")).modelled["F"]
    parts = read_parts(frame, in_source_tree("geometry/frame.msh"))[0]
    building = assemble_building(MPI.COMM_SELF, parts)
    stiffness = building.stiffness(0.5)
    held = np.zeros((len(building.coordinates), 6), dtype=bool)
    model = ShellModel(building.coordinates, csr(stiffness), csr(building.mass), held)
    edges = [edge_load(parts.mesh, floor) for floor in (1, 2)]
    loads = [edge.vector(building, (0.0, -1.0, 0.0)) for edge in edges]  # inwards
    probes = [building.rows(edge.nodes) + UY for edge in edges]
    weights = scipy.linalg.block_diag(*(edge.forces for edge in edges))
    for matrix in (stiffness, building.fixed, building.storeys, building.mass):
        matrix.destroy()
    patterns = np.column_stack([*loads, -building.ground[:, UY]])
    moving = MovingModel(model, patterns, np.concatenate(probes))
    return Frame(moving, frame.entry.damping.rayleigh, weights)


def _solvers(frame: Frame) -> dict[str, Callable[[Array], Motion]]:
    basis = frame.moving.reduced(shift=30.0, vectors=90)
    return {
        "full": lambda loads: frame.moving.full(loads, STEP, frame.damping).motion,
        "reduced": lambda loads: basis.motion(loads, STEP, frame.damping, "newmark"),
    }


def _amplitudes(step: float, end: float, pulse: float, starts: tuple[float, float]) -> Array:
    """A pulse on each edge, 1 MN and half of it later, and a ground that shakes, (n_t, 3)."""
    time = step * np.arange(round(end / step) + 1)
    pulses = [
        size * np.sin(np.pi * np.clip((time - start) / pulse, 0.0, 1.0)) ** 2
        for size, start in zip((1e6, 0.5e6), starts, strict=True)
    ]
    return np.column_stack([*pulses, 2.0 * np.sin(2.0 * np.pi * 5.0 * time)])
