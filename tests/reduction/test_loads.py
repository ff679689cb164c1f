"""Patterns and amplitudes of the ground motion and of the impact forces."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import trapezoid

from impactfem.coupling.force_history import ForceHistory
from impactfem.reduction.loads import EdgeForce, Loads, make_loads

if TYPE_CHECKING:
    from ..stages.transient.conftest import Frame

Array = NDArray[np.float64]

TIME = np.linspace(0.0, 1.0, 101)
HUMP = 1e5 * np.sin(np.pi * TIME) ** 2
MOTION = [(1, 0.1, np.array([0.0, 1.0, -1.0, 0.0]))]


def edge(floor: int, *direction: float) -> EdgeForce:
    x, y, z = direction
    return EdgeForce(f"floor {floor}", floor, (x, y, z))


def made(*pairs: tuple[EdgeForce, Array], steps: int = 50) -> Loads:
    names = tuple(f"pair {k}" for k in range(len(pairs)))
    force = np.array([force for _, force in pairs]).reshape(-1, len(TIME)).T
    history = ForceHistory(TIME, names, force)
    return make_loads(MOTION, history, [e for e, _ in pairs], 0.02, steps)


def test_each_edge_is_a_load() -> None:
    loads = made((edge(2, 0, -1, 0), HUMP), (edge(1, 0, -1, 0), 2 * HUMP))
    assert loads.names == ("ground y", "floor 2", "floor 1")
    assert loads.amplitudes.shape == (51, 3)
    assert loads.force[:, 1] == pytest.approx(2 * loads.force[:, 0])
    assert loads.amplitudes[:, 0].tolist() == loads.ground[:, 1].tolist()
    assert loads.impulse_error < 1e-13
    assert trapezoid(loads.force, dx=0.02, axis=0) == pytest.approx([5e4, 1e5], rel=1e-6)


def test_ground_motion_between_its_samples_and_after_its_end() -> None:
    motions = [(2, 0.1, np.array([0.0, 1.0, -1.0, 0.0])), (0, 0.5, np.array([1.0, 1.0, 1.0]))]
    loads = make_loads(motions, ForceHistory(TIME, (), np.zeros((101, 0))), [], 0.05, 8)
    assert loads.names == ("ground x", "ground z")
    assert loads.ground[:, 2] == pytest.approx([0, 0.5, 1, 0, -1, -0.5, 0, 0, 0], abs=1e-12)
    assert loads.ground[:, 0] == pytest.approx(np.ones(9)) and not loads.ground[:, 1].any()
    assert loads.amplitudes.tolist() == loads.ground[:, [0, 2]].tolist()


def test_pairs_on_one_edge_add() -> None:
    up = edge(2, 0, -1, 0)
    loads = made((up, HUMP), (edge(1, 0, -1, 0), HUMP), (up, 3 * HUMP))
    assert loads.names == ("ground y", "floor 2", "floor 1")
    assert loads.force[:, 0] == pytest.approx(4 * loads.force[:, 1])


def test_opposite_normals_are_the_same_load() -> None:
    loads = made((edge(2, 0, -1, 0), HUMP), (edge(2, 0, 1, 0), 3 * HUMP))
    assert loads.names == ("ground y", "floor 2")
    assert loads.edges[0].direction == (0, -1, 0)
    alone = made((edge(2, 0, -1, 0), HUMP))
    assert loads.force == pytest.approx(-2 * alone.force)


def test_oblique_forces_on_one_edge_are_refused() -> None:
    """Their amplitudes could not be told apart by name."""
    with pytest.raises(ValueError, match="loads of the same name: ground y, floor 2, floor 2"):
        made((edge(2, 0, -1, 0), HUMP), (edge(2, 1, 0, 0), HUMP))


def test_unused_pairs_have_no_pattern() -> None:
    late = np.where(TIME > 0.5, HUMP, 0.0)
    pairs = (edge(1, 0, -1, 0), 0 * HUMP), (edge(2, 0, -1, 0), HUMP), (edge(3, 0, -1, 0), late)
    assert made(*pairs).names == ("ground y", "floor 2", "floor 3")
    # What does not act within the time that is computed does not count.
    assert made(*pairs, steps=25).names == ("ground y", "floor 2")


@pytest.mark.parametrize("pairs", [(), ((edge(1, 0, -1, 0), 0 * HUMP),)])
def test_ground_motion_alone(pairs: tuple[tuple[EdgeForce, Array], ...]) -> None:
    loads = made(*pairs)
    assert (loads.names, loads.force.shape, loads.impulse_error) == (("ground y",), (51, 0), 0.0)


def test_a_lost_impulse_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a force that the 3D step cannot follow nothing is lost; the check sees what would be."""
    spike = np.where(np.arange(101) == 31, 1e6, 1e3)
    loads = made((edge(1, 0, -1, 0), spike))
    assert loads.impulse_error < 1e-12
    assert trapezoid(loads.force[:, 0], dx=0.02) == pytest.approx(1.099e4, rel=1e-12)

    def interpolated(time: Array, values: Array, step: float, n: int) -> Array:
        return np.interp(step * np.arange(n + 1), time, values[:, 0])[:, None]

    monkeypatch.setattr("impactfem.reduction.loads.project", interpolated)
    assert made((edge(1, 0, -1, 0), spike)).impulse_error == pytest.approx(0.999 / 1.099)


def test_patterns_push_and_turn_as_they_are_asked_to(frame: Frame, loads: Loads) -> None:
    """By virtual work on rigid-body motions about the middle of the edge of floor 2."""
    patterns = loads.patterns(frame.model, frame.parts.mesh, 0.3)
    assert patterns.shape == (frame.model.ground.shape[0], 3)
    work = frame.model.rigid_body((3.0, 4.0, 6.0)).T @ patterns
    assert work[:, 1] == pytest.approx([0, -1, 0, 0, 0, -0.3], abs=1e-12)
    # Floor 1 is 3 m below: its force turns about x, too.
    assert work[:, 2] == pytest.approx([0, -1, 0, -3, 0, -0.3], abs=1e-12)
    # The clamped base takes part of the mass.
    mass = frame.model.total[1, 1]
    assert 0.95 * mass < -work[1, 0] < mass
    assert np.array_equal(patterns[:, 0], -frame.model.ground[:, 1])
    middle = loads.patterns(frame.model, frame.parts.mesh, 0.0)
    assert (frame.model.rigid_body((3.0, 4.0, 6.0)).T @ middle)[5, 1] == pytest.approx(0, abs=1e-12)


def test_patterns_of_a_floor_without_an_edge(frame: Frame, loads: Loads) -> None:
    other = replace(loads, edges=(loads.edges[0], EdgeForce("floor 7", 7, (0.0, -1.0, 0.0))))
    with pytest.raises(KeyError):
        other.patterns(frame.model, frame.parts.mesh, 0.0)
