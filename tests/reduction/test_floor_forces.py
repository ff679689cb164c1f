"""Loads of the case on the floors of the 3D building: a blast on one building alone."""

import numpy as np
import pytest
from scipy.integrate import trapezoid

from impactfem.case.motions import FloorForces
from impactfem.coupling.force_history import ForceHistory
from impactfem.reduction.edge_force import EdgeForce
from impactfem.reduction.forces import with_floor_forces
from impactfem.reduction.loads import make_loads
from impactfem.stages.transient.compute import main_impact
from impactfem.system.errors import InputError
from one_building import building_of

UY = 1
STEP = 1e-3
EVEN = {k: EdgeForce(f"floor {k}", k, (0.0, -1.0, 0.0)) for k in (1, 2)}


def blasted(frame, path, direction, text):
    path.write_text(text, encoding="utf-8")
    loads = FloorForces.model_validate({"file": str(path), "direction": list(direction)})
    return frame.case.model_copy(update={"loads": (loads,)})


def pulse(length=0.02):
    """300 and 500 kN at their peak, on floors 1 and 2, as half a sine."""
    time = np.linspace(0.0, length, 41)
    shape = np.append(np.sin(np.pi * time[:-1] / length), 0.0)
    rows = [f"{t:.6g},{300 * f:.9g},{500 * f:.9g}" for t, f in zip(time, shape, strict=True)]
    return "\n".join(["time [s],F.floor_1 [kN],F.floor_2 [kN]", *rows]) + "\n"


def alone(frame, case, steps):
    """The loads of the case, without a motion and without contacts."""
    time = 0.25e-3 * np.arange(4 * steps + 1)
    still = ForceHistory(time, (), np.zeros((len(time), 0)))
    forces, edges = with_floor_forces(building_of(case), frame.parts.mesh, still, [])
    return make_loads([(UY, STEP, np.zeros(2))], forces, edges, STEP, steps, len(edges))


def test_positive_forces_act_along_their_direction(frame, tmp_path):
    for direction, sign in (((0.0, -1.0, 0.0), 1.0), ((0.0, 2.0, 0.0), -1.0)):
        loads = alone(frame, blasted(frame, tmp_path / "blast.csv", direction, pulse()), 50)
        assert loads.edges == (EVEN[1], EVEN[2])
        assert not loads.impact_force.any() and main_impact(loads) is None
        impulse = trapezoid(loads.force, dx=STEP, axis=0)
        exact = sign * 2.0 / np.pi * 0.02 * np.array([3e5, 5e5])
        assert impulse == pytest.approx(exact, rel=1e-3)


def test_they_are_added_to_the_impacts_and_stay_without_them(frame, tmp_path):
    case = blasted(frame, tmp_path / "blast.csv", (0.0, -1.0, 0.0), pulse())
    time = np.linspace(0.0, 0.05, 201)
    impact = ForceHistory(time, ("pair",), np.full((201, 1), 1e5))
    forces, edges = with_floor_forces(
        building_of(case), frame.parts.mesh, impact, [((EVEN[2], 1.0),)]
    )
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
    # The impact force is that of contact alone, the main impact, too.
    struck = [1e5 * (place == "floor 2") for place in both.places]
    assert both.impact_force == pytest.approx(np.tile(struck, (51, 1)), abs=1e-4)
    assert main_impact(both) is not None and both.resultants[0].max() > 4e5
    # Without loads nothing is left, as before.
    bare = make_loads([(UY, STEP, np.zeros(2))], impact, [((EVEN[2], 1.0),)], STEP, 50)
    assert bare.without_impacts().edges == () and bare.without_impacts().force.shape == (51, 0)


def test_a_direction_along_the_edge_is_refused(frame, tmp_path):
    case = blasted(frame, tmp_path / "blast.csv", (1.0, 0.0, 0.0), pulse())
    history = ForceHistory(np.array([0.0, 1.0]), (), np.zeros((2, 0)))
    with pytest.raises(InputError) as caught:
        with_floor_forces(building_of(case), frame.parts.mesh, history, [])
    assert [fault.key for fault in caught.value.faults] == ["loads[0].direction"] * 2
    assert "edge of floor 1, (0, 1, 0)" in caught.value.faults[0].expected


def test_loads_of_another_building_are_not_those_of_the_3d_model(frame, tmp_path):
    text = pulse().replace("F.floor_1", "G.floor_1")
    case = blasted(frame, tmp_path / "blast.csv", (0.0, -1.0, 0.0), text)
    assert alone(frame, case, 50).edges == (EVEN[2],)
