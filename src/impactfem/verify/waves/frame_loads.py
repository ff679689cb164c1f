"""Superposition and reciprocity of the responses of a building: the shipped frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.building.shell_model import UY, ShellModel, csr
from impactfem.case import load_case
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.files import in_source_tree
from impactfem.verify.row import Row
from impactfem.verify.waves.shell_motion import Motion, MovingModel, apart

Array = NDArray[np.float64]
Solver = Callable[[Array], Motion]

NAME = "frame under forces on two edges"
CASE, MESH = "geometry/frame.toml", "geometry/frame.msh"
STOREY_FACTOR = 0.5
STEP, END = 1e-3, 0.3
SHIFT, VECTORS = 30.0, 90
PULSE = 0.02
INWARDS = (0.0, -1.0, 0.0)
ALLOWED = {
    "full": {"displacement": 1e-9, "acceleration": 1e-9},
    "reduced": {"displacement": 1e-9, "acceleration": 2e-6},
}
"""Of reciprocity: the basis leaves out what is nearly dependent, of the two loads not the same.
What is left out are short waves, which count in the acceleration by their frequency squared."""
OF_BASIS = {"displacement": 1e-8, "acceleration": 2e-5}
"""Of the reduced model beside the full one, for the same reason."""


@dataclass(frozen=True, eq=False)
class Frame:
    """The frame under a pulse on the edge of floor 1, on that of floor 2, and under the ground.

    Args:
        moving: Its matrices and the three loads.
        damping: Rayleigh of the case.
        weights: Share of each probe in the mean motion of the edges of floor 1 and of floor 2, as
            the loads' shares of the nodes, shape (2, n_probes).
    """

    moving: MovingModel
    damping: Rayleigh
    weights: Array


def superposition() -> list[Row]:
    """The response to all loads at once against the sum of those to each, at every probe."""
    frame = shipped_frame()
    each = _amplitudes()
    rows = []
    for solver, motion in _solvers(frame).items():
        together, one_by_one = motion(each), [motion(each * only) for only in np.eye(3)]
        for name in ("displacement", "acceleration"):
            total = np.sum([one[name] for one in one_by_one], axis=0)
            rows.append(
                Row(
                    NAME,
                    f"{name} under all loads from the sum over each, {solver}",
                    0.0,
                    apart(together[name], total),
                    "-",
                    1e-9,
                    "the equations are linear",
                    absolute=True,
                )
            )
    return rows


def reciprocity() -> list[Row]:
    """A pulse on the edge of floor 1, seen on floor 2, against the same pulse the other way round.

    Of each edge the mean is seen that the line load does its work on: then both are equal, as K, M
    and C are symmetric (Rayleigh 1873).
    """
    frame = shipped_frame()
    pulse = _amplitudes()[:, 0]
    rows = []
    for solver, motion in _solvers(frame).items():
        lower, upper = (motion(np.outer(pulse, only)) for only in np.eye(3)[:2])
        for name in ("displacement", "acceleration"):
            up, down = lower[name] @ frame.weights[1], upper[name] @ frame.weights[0]
            what = f"{name} of edge 2 by a pulse on edge 1 from the reverse, {solver}"
            source = "Maxwell, Betti and Rayleigh: symmetric matrices"
            allowed = ALLOWED[solver][name]
            rows.append(Row(NAME, what, 0.0, apart(up, down), "-", allowed, source, absolute=True))
        # Without this the rows above could compare what has nothing to do with the loads.
        own = float(np.abs(upper["acceleration"] @ frame.weights[1]).max())
        seen = float(np.abs(lower["acceleration"] @ frame.weights[1]).max())
        what = f"acceleration of edge 2 by its own pulse is another one (yes = 1), {solver}"
        rows.append(Row(NAME, what, 1.0, float(own > 1.1 * seen > 0.0), "-", 0.0, "no symmetry"))
    full, reduced = (motion(_amplitudes()) for motion in _solvers(frame).values())
    for name in ("displacement", "acceleration"):
        what = f"{name}, reduced model from the full one, both by Newmark"
        source = "the same equations in a Krylov space"
        difference = apart(reduced[name], full[name])
        rows.append(Row(NAME, what, 0.0, difference, "-", OF_BASIS[name], source, absolute=True))
    return rows


def shipped_frame() -> Frame:
    """Assemble the frame.

    Raises:
        ImpactfemError: The program runs without its source tree.
    """
    # Only here: the manual is read, and its other benchmarks run, without dolfinx.
    from mpi4py import MPI

    from impactfem.building.loads import edge_load
    from impactfem.building.model import assemble_building
    from impactfem.building.read_parts import read_parts

    case = load_case(in_source_tree(CASE))
    parts = read_parts(case, in_source_tree(MESH))[0]
    building = assemble_building(MPI.COMM_SELF, parts)
    stiffness = building.stiffness(STOREY_FACTOR)
    held = np.zeros((len(building.coordinates), 6), dtype=bool)
    model = ShellModel(building.coordinates, csr(stiffness), csr(building.mass), held)
    edges = [edge_load(parts.mesh, floor) for floor in (1, 2)]
    loads = [edge.vector(building, INWARDS) for edge in edges]
    probes = [building.rows(edge.nodes) + UY for edge in edges]
    weights = np.zeros((2, sum(map(len, probes))))
    weights[0, : len(probes[0])] = edges[0].forces
    weights[1, len(probes[0]) :] = edges[1].forces
    for matrix in (stiffness, building.fixed, building.storeys, building.mass):
        matrix.destroy()
    patterns = np.column_stack([*loads, -building.ground[:, UY]])
    return Frame(
        MovingModel(model, patterns, np.concatenate(probes)),
        case.buildings[0].damping.rayleigh,
        weights,
    )


def _solvers(frame: Frame) -> dict[str, Solver]:
    basis = frame.moving.reduced(SHIFT, VECTORS)
    return {
        "full": lambda loads: frame.moving.full(loads, STEP, frame.damping).motion,
        "reduced": lambda loads: basis.motion(loads, STEP, frame.damping, "newmark"),
    }


def _amplitudes() -> Array:
    """A pulse on each edge, 1 MN and half of it later, and a ground that shakes, (n_t, 3)."""
    time = STEP * np.arange(round(END / STEP) + 1)
    pulses = [
        size * np.sin(np.pi * np.clip((time - start) / PULSE, 0.0, 1.0)) ** 2
        for size, start in ((1e6, 0.01), (0.5e6, 0.1))
    ]
    return np.column_stack([*pulses, 2.0 * np.sin(2.0 * np.pi * 5.0 * time)])
