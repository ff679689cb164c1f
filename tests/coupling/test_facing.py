"""The closest approach of floors that are in no pair."""

from __future__ import annotations

import numpy as np
import pytest

from impactfem.case import ContactPoint
from impactfem.case.facing import Facing
from impactfem.coupling.facing import approaches
from impactfem.coupling.pounding import Response, System
from impactfem.dynamics.damping import Rayleigh
from impactfem.sticks.element import Section
from impactfem.sticks.stick import Floor, Stick, build_stick


def tower(name: str, points: tuple[tuple[int, float], ...] = ()) -> Stick:
    """Two storeys of 4 m and 3 m, flexible over 3.4 m and 2.2 m."""
    section = Section(E=30e9, G=12e9, A=2.0, Avx=0.7, Avy=1.0, Ix=0.5, Iy=0.8, Iz=0.6)
    floors = [
        Floor(k, 3e5, (1e6, 2e6, 3e6), h, section, Rayleigh(1.0, 1e-3), below=0.6, above=0.2)
        for k, h in ((1, 4.0), (2, 3.0))
    ]
    return build_stick(name, floors, storey_points=points)


@pytest.mark.parametrize(("storey", "s"), [(1, 0.3), (2, 0.7), (2, 0.5), (1, 0.9)])
@pytest.mark.parametrize("known", [(), ((2, 0.5),), ((1, 0.2), (1, 0.6), (2, 0.5))])
def test_motion_inside_a_storey(
    storey: int, s: float, known: tuple[tuple[int, float], ...]
) -> None:
    """As a node of the stick there moves under loads at the other nodes, in all six components."""
    full = tower("a", (*known, (storey, s)))
    plain = tower("a", known)
    node = full.storey_points[storey, s]
    # Loads on all nodes of the stick without it, which may have been one of its nodes before.
    load = np.random.default_rng(1).normal(size=plain.n)
    place = [full.storey_points[key] for key in plain.storey_points]
    masters = np.array([0, 1, *place])
    dofs = (6 * masters[:, None] + np.arange(6)).ravel()
    order = np.array([0, 1, *plain.storey_points.values()])
    same = (6 * order[:, None] + np.arange(6)).ravel()
    every = np.zeros(full.n)
    every[dofs] = load[same]
    exact = np.linalg.solve(full.K, every)[6 * node : 6 * node + 6]
    found = plain.storey_motion(storey, s) @ np.linalg.solve(plain.K, load)
    assert found == pytest.approx(exact, rel=1e-9, abs=1e-12 * np.abs(exact).max())


def test_rigid_motion_inside_a_storey() -> None:
    """A floor that leans takes the storey above along, up to the next floor that leans as it."""
    stick = tower("a")
    body = stick.rigid_body()
    z = 4.0 + 0.2 + 0.25 * 2.2
    expected = np.eye(6)
    expected[:3, 3:] = [[0.0, z, 0.0], [-z, 0.0, 0.0], [0.0, 0.0, 0.0]]
    assert stick.storey_motion(2, 0.25) @ body == pytest.approx(expected, abs=1e-12)


def point(building: str, floor: int | None, offset: tuple[float, float, float]) -> ContactPoint:
    inside = {"storey": None, "relative_height": None}
    if floor is None:
        inside = {"storey": 2, "relative_height": 0.5}
    return ContactPoint(building=building, floor=floor, offset=offset, **inside)


def facing(a: ContactPoint, b: ContactPoint, half: float = 0.0, axis: int = 1) -> Facing:
    normal = tuple(float(c == axis) for c in range(3))
    return Facing(a=a, b=b, normal=normal, gap=0.03, level=7.0, half=half, reach=0.3)


def response(u: dict[tuple[int, int, int], float]) -> Response:
    """Motions of two towers by time, master and component; the masters of b come last."""
    system = System((tower("a"), tower("b")), ())
    values = np.zeros((4, 24))
    for (step, master, component), value in u.items():
        values[step, 6 * master + component] = value
    nothing = np.zeros((4, 0))
    return Response(system, 0.5, values, np.zeros_like(values), nothing, np.zeros((4, 3)))


def test_translation() -> None:
    """Towards each other they lose distance, away from each other they win it."""
    run = response({(1, 1, 1): 0.04, (1, 3, 1): 0.02, (2, 1, 1): 0.02, (2, 3, 1): -0.03})
    pair = facing(point("a", 2, (0, 4, 0)), point("b", 2, (0, -4, 0)))
    (found,) = approaches(run, [pair])
    assert found.facing is pair
    assert (found.distance, found.time) == pytest.approx((-0.02, 1.0))
    back = approaches(run, [facing(point("b", 2, (0, 4, 0)), point("a", 2, (0, -4, 0)))])[0]
    assert (back.distance, back.time) == pytest.approx((0.03, 0.0))
    assert approaches(run, []) == []


def test_torsion_brings_an_end_near() -> None:
    """Both turn about z: edges that face each other over 2 h lose h (rz_a + rz_b') at one end."""
    run = response({(3, 1, 5): 2e-3, (3, 3, 5): -1e-3})
    ends = point("a", 2, (1, 4, 0)), point("b", 2, (-1, -4, 0))
    # u_y = rz x: at x = 1 + s of a and -1 + s of b; the distance is 0.03 - 1e-3 (1 + 3 s).
    (found,) = approaches(run, [facing(*ends, half=5.0)])
    assert (found.distance, found.time) == pytest.approx((0.03 - 1e-3 * 16.0, 1.5))
    (middle,) = approaches(run, [facing(*ends)])
    assert middle.distance == pytest.approx(0.03 - 1e-3)


def test_torsion_along_x() -> None:
    run = response({(3, 1, 5): 2e-3})
    ends = point("a", 2, (4, 0, 0)), point("b", 2, (-4, 0, 0))
    (found,) = approaches(run, [facing(*ends, half=5.0, axis=0)])
    assert found.distance == pytest.approx(0.03 - 2e-3 * 5.0)


def test_a_storey_and_a_floor_that_leans() -> None:
    """A floor at another height than the point: its rotation counts."""
    run = response({(1, 1, 3): 1e-3})
    (found,) = approaches(run, [facing(point("b", None, (0, 4, 0)), point("a", 2, (0, -4, 0.5)))])
    assert found.distance == pytest.approx(0.03 - 5e-4)
    (storey,) = approaches(run, [facing(point("b", 1, (0, -4, 0)), point("a", None, (0, 4, 0)))])
    middle = tower("a", ((2, 0.5),))
    node = middle.storey_points[2, 0.5]
    # The node follows the floors without load: K_mm u_m + K_mf u_f = 0.
    dofs = np.arange(6 * node, 6 * node + 6)
    u = np.zeros(middle.n)
    u[9] = 1e-3
    moved = -np.linalg.solve(middle.K[np.ix_(dofs, dofs)], middle.K[dofs] @ u)[1]
    assert storey.distance == pytest.approx(0.03 + min(moved, 0.0))
    assert abs(moved) > 1e-5
