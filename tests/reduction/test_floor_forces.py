"""Loads of the case on the floors of the 3D building: a blast on one building alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid, trapezoid

from impactfem.case import Case
from impactfem.case.motions import FloorForces
from impactfem.coupling.force_history import ForceHistory
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.history import State
from impactfem.dynamics.newmark import Newmark
from impactfem.reduction.forces import with_floor_forces
from impactfem.reduction.loads import Loads, make_loads
from impactfem.system.errors import InputError

from ..stages.transient.conftest import INWARDS

if TYPE_CHECKING:
    from ..stages.transient.conftest import Frame

Array = NDArray[np.float64]
UY = 1
STEP = 1e-3


def blasted(frame: Frame, path: Path, direction: tuple[float, float, float], text: str) -> Case:
    path.write_text(text, encoding="utf-8")
    loads = FloorForces.model_validate({"file": str(path), "direction": list(direction)})
    return frame.case.model_copy(update={"loads": (loads,)})


def pulse(length: float = 0.02) -> str:
    """300 and 500 kN at their peak, on floors 1 and 2, as half a sine."""
    time = np.linspace(0.0, length, 41)
    shape = np.append(np.sin(np.pi * time[:-1] / length), 0.0)
    rows = [f"{t:.6g},{300 * f:.9g},{500 * f:.9g}" for t, f in zip(time, shape, strict=True)]
    return "\n".join(["time [s],F.floor_1 [kN],F.floor_2 [kN]", *rows]) + "\n"


def alone(frame: Frame, case: Case, steps: int) -> Loads:
    """The loads of the case, without a motion and without contacts."""
    time = 0.25e-3 * np.arange(4 * steps + 1)
    still = ForceHistory(time, (), np.zeros((len(time), 0)))
    forces, edges = with_floor_forces(case, frame.parts.mesh, still, [])
    return make_loads([(UY, STEP, np.zeros(2))], forces, edges, STEP, steps, len(edges))


def test_positive_forces_act_along_their_direction(frame: Frame, tmp_path: Path) -> None:
    for direction, sign in (((0.0, -1.0, 0.0), 1.0), ((0.0, 2.0, 0.0), -1.0)):
        case = blasted(frame, tmp_path / "blast.csv", direction, pulse())
        loads = alone(frame, case, 50)
        assert loads.edges == (INWARDS[1], INWARDS[2])
        impulse = trapezoid(loads.force, dx=STEP, axis=0)
        exact = sign * 2.0 / np.pi * 0.02 * np.array([3e5, 5e5])
        assert impulse == pytest.approx(exact, rel=1e-3)


def test_they_are_added_to_the_impacts_and_stay_without_them(frame: Frame, tmp_path: Path) -> None:
    case = blasted(frame, tmp_path / "blast.csv", (0.0, -1.0, 0.0), pulse())
    time = np.linspace(0.0, 0.05, 201)
    impact = ForceHistory(time, ("pair",), np.full((201, 1), 1e5))
    forces, edges = with_floor_forces(case, frame.parts.mesh, impact, [INWARDS[2]])
    assert forces.pairs == ("pair", "load 0, floor 1", "load 0, floor 2")
    both = make_loads([(UY, STEP, np.zeros(2))], forces, edges, STEP, 50, 2)
    quiet = both.without_impacts()
    own = alone(frame, case, 50)
    assert {e.floor for e in both.edges} == {e.floor for e in quiet.edges} == {1, 2}
    for edge in both.edges:
        j, k, m = (some.edges.index(edge) for some in (both, quiet, own))
        impulse = 1e5 if edge.floor == 2 else 0.0
        assert quiet.force[:, k] == pytest.approx(own.force[:, m], abs=1e-6)
        assert both.force[:, j] - quiet.force[:, k] == pytest.approx(np.full(51, impulse), abs=1e-4)
    # Without loads nothing is left, as before.
    bare = make_loads([(UY, STEP, np.zeros(2))], impact, [INWARDS[2]], STEP, 50)
    assert bare.without_impacts().edges == () and bare.without_impacts().force.shape == (51, 0)


def test_a_blast_gives_the_building_its_momentum(frame: Frame, tmp_path: Path) -> None:
    """rᵀ M v = ∫ (F − rᵀ (K u + C v)) dt: the force, less what the base takes."""
    case = blasted(frame, tmp_path / "blast.csv", (0.0, -1.0, 0.0), pulse())
    steps = 60
    loads = alone(frame, case, steps)
    alpha, beta = frame.damping.alpha, frame.damping.beta
    r = np.tile(np.eye(6)[UY], len(frame.model.nodes))
    momentum, base = [0.0], [0.0]

    def seen(state: State) -> None:
        damping = alpha * state.momentum
        Kv = np.zeros_like(state.velocity)
        x, y = frame.K.createVecs()
        x.setArray(state.velocity)
        frame.K.mult(x, y)
        Kv[:] = y.getArray()
        momentum.append(float(r @ state.momentum))
        base.append(float(r @ (state.restoring + damping + beta * Kv)))

    with Newmark(
        frame.K, frame.model.mass, STEP, frame.patterns(loads, 0.0), damping=frame.damping
    ) as newmark:
        newmark.march(newmark.start(loads.amplitudes[0]), loads.amplitudes, each_step=seen)
    given = cumulative_trapezoid(-loads.force.sum(axis=1), dx=STEP, initial=0.0)
    taken = cumulative_trapezoid(base, dx=STEP, initial=0.0)
    largest = np.abs(momentum).max()
    assert np.array(momentum) == pytest.approx(given - taken, abs=1e-9 * largest)
    # While the pulse lasts, most of it is in the building; towards −y, as the force.
    assert momentum[10] < -0.5 * 2.0 / np.pi * 0.02 * 8e5 * 0.5
    # With the base left out it does not balance.
    assert np.abs(np.array(momentum) - given).max() > 0.1 * largest


def test_a_lasting_force_ends_in_its_static_shape(frame: Frame, tmp_path: Path) -> None:
    text = "time [s],F.floor_2 [kN]\n0,100\n9,100\n"
    case = blasted(frame, tmp_path / "push.csv", (0.0, -1.0, 0.0), text)
    loads = alone(frame, case, 400)
    patterns = frame.patterns(loads, 0.0)
    # Damped so much that it is at rest after a fraction of a second.
    with Newmark(
        frame.K, frame.model.mass, 5e-3, patterns, damping=Rayleigh(40.0, 5e-3)
    ) as newmark:
        static = newmark.static(loads.amplitudes[0]).displacement
        state = newmark.start(loads.amplitudes[0])
        newmark.march(state, loads.amplitudes)
    assert loads.force[0, 0] == pytest.approx(1e5)
    assert np.abs(state.displacement - static).max() < 1e-3 * np.abs(static).max()


def test_a_direction_along_the_edge_is_refused(frame: Frame, tmp_path: Path) -> None:
    case = blasted(frame, tmp_path / "blast.csv", (1.0, 0.0, 0.0), pulse())
    history = ForceHistory(np.array([0.0, 1.0]), (), np.zeros((2, 0)))
    with pytest.raises(InputError) as caught:
        with_floor_forces(case, frame.parts.mesh, history, [])
    assert [fault.key for fault in caught.value.faults] == ["loads[0].direction"] * 2
    assert "at right angles to the edge of floor 1, (0, 1, 0)" in caught.value.faults[0].expected


def test_loads_of_another_building_are_not_those_of_the_3d_model(
    frame: Frame, tmp_path: Path
) -> None:
    text = pulse().replace("F.floor_1", "G.floor_1")
    case = blasted(frame, tmp_path / "blast.csv", (0.0, -1.0, 0.0), text)
    assert alone(frame, case, 50).edges == (INWARDS[2],)
