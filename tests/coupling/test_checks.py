from dataclasses import dataclass, replace

import numpy as np
import pytest

from impactfem.case import ContactPoint
from impactfem.case.plan import Opposite
from impactfem.coupling.base import BaseHistory
from impactfem.coupling.impacts import approaches, impact_checks, impacts, separations
from impactfem.coupling.laws import KelvinVoigt
from impactfem.coupling.pounding import End, Pair, Response, System, simulate
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.energy import Energy
from impactfem.sticks.element import Section
from impactfem.sticks.stick import Floor, build_stick

from ..sticks.conftest import damped_stick

UY = 1
STRENGTH = {"a": 30e6, "b": 25e6}
P, PEAK = 2e6, 7e6
N_T, HIT = 20, slice(8, 12)
ENERGY = Energy(*np.zeros((4, 1)))
"""Nothing here reads the energies of responses made by hand."""


def loaded(system, component=UY, *, peak_of="a", when=10):
    """A response by hand: a blow in steps 8 to 11, and P on the top of one building at one time."""
    stick = system.stick(peak_of)
    load = np.zeros(stick.n)
    load[6 * len(stick.floors) - 6 + component] = P
    u, force = np.zeros((N_T, system.M.shape[0])), np.zeros((N_T, len(system.pairs)))
    start = system.offsets[peak_of]
    u[when, start : start + stick.n] = np.linalg.solve(stick.K, load)
    force[HIT, 1] = [3e6, PEAK, 5e6, 1e6]
    return Response(system, 1e-3, u, np.zeros_like(u), force, np.zeros((N_T, 3)), ENERGY)


def check(response, strength=STRENGTH):
    (found,) = impact_checks(response, impacts(response), strength)
    return found


def test_bearing_by_hand(row):
    found = check(loaded(row()))
    assert found.bearing_pressure == pytest.approx(PEAK / 5.0)
    assert found.bearing_ratio == pytest.approx(PEAK / 5.0 / 25e6)  # of the weaker building
    assert found.impact.peak_force == PEAK
    one = check(loaded(row()), {"a": 30e6, "b": None})
    assert one.bearing_ratio == pytest.approx(PEAK / 5.0 / 30e6)


@pytest.mark.parametrize("building", ["a", "b"])
def test_shear_by_hand(row, building):
    found = check(loaded(row(), peak_of=building))
    assert found.storey_shear == pytest.approx(P, rel=1e-8)
    assert found.shear_stress == pytest.approx(P / 0.9, rel=1e-8)
    # f_ctm of EN 1992-1-1, table 3.1: 2.9 MPa for C30, 2.6 MPa for C25.
    tensile = {"a": 2.9e6, "b": 2.6e6}[building]
    assert found.cracking_ratio == pytest.approx(P / 0.9 / tensile, rel=0.02)


def test_the_storey_with_the_largest_stress_counts(row):
    # The same shear in both storeys, but half the area in the lower one.
    system = row()
    a = system.sticks[0]
    half = replace(a.floors[0], section=replace(a.floors[0].section, Avy=0.45))
    system = System((replace(a, floors=(half, a.floors[1])), system.sticks[1]), system.pairs)
    assert check(loaded(system)).shear_stress == pytest.approx(P / 0.45, rel=1e-8)


def turned_to(system, normal):
    normal = np.array(normal) / np.linalg.norm(normal)
    return System(system.sticks, tuple(replace(p, normal=normal) for p in system.pairs))


def test_oblique_normal(row):
    # P along y on a normal (3, 4) / 5: 0.8 P, over 0.36 A_vx + 0.64 A_vy.
    found = check(loaded(turned_to(row(), (3.0, 4.0, 0.0))))
    assert found.storey_shear == pytest.approx(0.8 * P, rel=1e-8)
    assert found.shear_stress == pytest.approx(0.8 * P / (0.36 * 1.1 + 0.64 * 0.9), rel=1e-8)
    assert check(loaded(turned_to(row(), (1.0, 0.0, 0.0)))).storey_shear < 1e-6 * P
    # The vertical part of a normal shears nothing: its horizontal part counts.
    for vertical in (1.0, -20.0):
        inclined = check(loaded(turned_to(row(), (3.0, 4.0, vertical))))
        assert inclined.storey_shear == pytest.approx(found.storey_shear, rel=1e-8)
        assert inclined.shear_stress == pytest.approx(found.shear_stress, rel=1e-8)


def test_a_vertical_normal_shears_no_storey(row):
    found = check(loaded(turned_to(row(), (0.0, 0.0, -1.0))))
    assert np.isnan([found.storey_shear, found.shear_stress, found.cracking_ratio]).all()
    assert found.bearing_pressure > 0.0


def test_a_blow_inside_a_storey(floors):
    """It shears the lower part of the storey, which a look at the upper parts alone misses."""
    stick = damped_stick("a", floors(2), storey_points=[(1, 0.5)])
    master = stick.storey_points[1, 0.5]
    end = End("a", master, (0.0, 6.0, 0.0), 1, 0.5)
    law = KelvinVoigt(1e10, 0.1, mass=1e5)
    system = System((stick,), (Pair("wall", end, None, np.eye(3)[UY], 0.01, law),))
    load = np.zeros(stick.n)
    load[6 * master + UY] = P
    u, force = np.zeros((N_T, stick.n)), np.zeros((N_T, 1))
    u[10] = np.linalg.solve(stick.K, load)
    force[HIT, 0] = PEAK
    found = check(Response(system, 1e-3, u, 0 * u, force, np.zeros((N_T, 3)), ENERGY))
    assert found.storey_shear == pytest.approx(P, rel=1e-8)
    upper = np.abs(stick.element_forces(u)[:, 1:, UY]).max()
    assert upper < 1e-6 * P


def test_cracking_ratio_is_the_largest_known(row):
    # Building b is sheared; of a alone the strength is known, which is not.
    response = loaded(row(), peak_of="b")
    assert check(response, {"a": 30e6, "b": None}).cracking_ratio == 0.0
    assert check(response, {"a": None, "b": 25e6}).cracking_ratio > 0.5


def test_cracking_need_not_be_where_the_stress_is_largest(row):
    # Both sheared: a less, but of weaker concrete.
    system = row()
    response = loaded(system, peak_of="b")
    u = response.u.copy()
    u[10, :12] = 0.6 * loaded(system).u[10, :12]
    found = check(replace(response, u=u), {"a": 12e6, "b": 60e6})
    assert found.shear_stress == pytest.approx(P / 0.9, rel=1e-8)
    tensile = 0.30e6 * 12.0 ** (2.0 / 3.0)
    assert found.cracking_ratio == pytest.approx(0.6 * P / 0.9 / tensile, rel=1e-8)


@pytest.mark.parametrize(("strength", "tensile"), [(12, 1.6), (50, 4.1), (55, 4.2), (90, 5.0)])
def test_tensile_strength(row, strength, tensile):
    """EN 1992-1-1, table 3.1, to its digits."""
    found = check(loaded(row()), {"a": 1e6 * strength, "b": None})
    assert 1e-6 * found.shear_stress / found.cracking_ratio == pytest.approx(tensile, abs=0.05)


@pytest.mark.parametrize(("when", "counts"), [(6, False), (7, True), (12, True), (13, False)])
def test_only_the_time_of_the_impact_counts(row, when, counts):
    assert (check(loaded(row(), when=when)).storey_shear > 0.0) == counts


def test_what_is_not_known_is_nan(row):
    system = row()
    no_area = System(system.sticks, tuple(replace(p, area=None) for p in system.pairs))
    found = check(loaded(no_area))
    assert np.isnan(found.bearing_pressure) and np.isnan(found.bearing_ratio)
    assert found.cracking_ratio > 0.0
    found = check(loaded(system), {"a": None, "b": None})
    assert np.isnan(found.bearing_ratio) and np.isnan(found.cracking_ratio)
    assert found.bearing_pressure > 0.0 and found.shear_stress > 0.0
    # A wall has no storeys and no strength.
    wall = System(system.sticks, tuple(replace(p, b=None) for p in system.pairs))
    found = check(loaded(wall, peak_of="b"), {"a": 30e6})
    assert found.storey_shear == 0.0
    assert found.bearing_ratio == pytest.approx(PEAK / 5.0 / 30e6)


def test_separation_by_hand(row):
    system = row(0.01)
    u = np.zeros((5, 24))
    u[2, [UY, 12 + UY]] = [0.007, -0.005]  # floors 1 come 12 mm closer
    u[1:, 18 + UY] = 0.001  # floors 2 only part
    free = Response(
        system.without_contact(), 1e-3, u, 0 * u, np.zeros((5, 0)), np.zeros((5, 3)), ENERGY
    )
    force = np.zeros((5, 2))
    force[4, 0] = -1.0
    lower, upper = separations(free, replace(free, system=system, u=0 * u, force=force))
    assert lower.required == pytest.approx(0.012) and lower.margin == pytest.approx(-0.002)
    assert lower.touched and lower.pair.name == "a1-b1"
    assert upper.required == 0.0 and upper.margin == 0.01 and not upper.touched
    assert f"{upper.required:g}" == "0"  # its approach is at most -0


def test_the_required_separation_is_just_enough(row, shake):
    ground, dt = shake(), 2.5e-4
    free = simulate(row(None), ground, dt)

    def at(gap):
        response = simulate(row(gap), ground, dt)
        return max(separations(free, response), key=lambda found: found.required)

    required = at(0.003).required
    assert at(0.003).touched and at(0.003).margin < 0.0
    assert not at(required + 1e-9).touched and at(required - 1e-6).touched


def tower(name, points=()):
    """Two storeys of 4 m and 3 m, flexible over 3.4 m and 2.2 m."""
    section = Section(E=30e9, G=12e9, A=2.0, Avx=0.7, Avy=1.0, Ix=0.5, Iy=0.8, Iz=0.6)
    floors = [
        Floor(k, 3e5, (1e6, 2e6, 3e6), h, section, below=0.6, above=0.2)
        for k, h in ((1, 4.0), (2, 3.0))
    ]
    return build_stick(name, floors, damping=Rayleigh(1.0, 1e-3), storey_points=points)


@pytest.mark.parametrize(("storey", "s"), [(1, 0.3), (2, 0.7), (2, 0.5), (1, 0.8)])
@pytest.mark.parametrize("known", [(), ((2, 0.5),), ((1, 0.2), (1, 0.6), (2, 0.5))])
def test_motion_inside_a_storey(storey, s, known):
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


def test_rigid_motion_inside_a_storey():
    """A floor that leans takes the storey above along, up to the next floor that leans as it."""
    stick = tower("a")
    body = stick.rigid_body()
    z = 4.0 + 0.25 * 3.0
    expected = np.eye(6)
    expected[:3, 3:] = [[0.0, z, 0.0], [-z, 0.0, 0.0], [0.0, 0.0, 0.0]]
    assert stick.storey_motion(2, 0.25) @ body == pytest.approx(expected, abs=1e-12)


def point(building, floor, offset):
    inside = {"storey": None, "relative_height": None}
    if floor is None:
        inside = {"storey": 2, "relative_height": 0.5}
    return ContactPoint(building=building, floor=floor, offset=offset, **inside)


@dataclass(frozen=True)
class Places:
    """What `approaches` reads of two places that face each other."""

    a: ContactPoint
    b: ContactPoint
    normal: tuple[float, float, float]
    opposite: Opposite
    level: float = 7.0

    @property
    def half(self):
        return 0.5 * self.opposite.length


def facing(a, b, half=0.0, axis=1, gap_slope=0.0):
    normal = tuple(float(c == axis) for c in range(3))
    return Places(a, b, normal, Opposite(normal, (0, 0), (0, 0), 2.0 * half, 0.03, gap_slope))


def response(u):
    """Motions of two towers by time, master and component; the masters of b come last."""
    system = System((tower("a"), tower("b")), ())
    values = np.zeros((4, 24))
    for (step, master, component), value in u.items():
        values[step, 6 * master + component] = value
    nothing = np.zeros((4, 0))
    return Response(system, 0.5, values, np.zeros_like(values), nothing, np.zeros((4, 3)), ENERGY)


def test_translation():
    """Towards each other they lose distance, away from each other they win it."""
    run = response({(1, 1, 1): 0.04, (1, 3, 1): 0.02, (2, 1, 1): 0.02, (2, 3, 1): -0.03})
    pair = facing(point("a", 2, (0, 4, 0)), point("b", 2, (0, -4, 0)))
    (found,) = approaches(run, [pair])
    assert found.facing is pair
    assert (found.distance, found.time) == pytest.approx((-0.02, 1.0))
    back = approaches(run, [facing(point("b", 2, (0, 4, 0)), point("a", 2, (0, -4, 0)))])[0]
    assert (back.distance, back.time) == pytest.approx((0.03, 0.0))
    assert approaches(run, []) == []


def test_torsion_brings_an_end_near():
    """Both turn about z: edges that face each other over 2 h lose h (rz_a + rz_b') at one end."""
    run = response({(3, 1, 5): 2e-3, (3, 3, 5): -1e-3})
    ends = point("a", 2, (1, 4, 0)), point("b", 2, (-1, -4, 0))
    # u_y = rz x: at x = 1 + s of a and -1 + s of b; the distance is 0.03 - 1e-3 (1 + 3 s).
    (found,) = approaches(run, [facing(*ends, half=5.0)])
    assert (found.distance, found.time) == pytest.approx((0.03 - 1e-3 * 16.0, 1.5))
    (middle,) = approaches(run, [facing(*ends)])
    assert middle.distance == pytest.approx(0.03 - 1e-3)
    along_x = point("a", 2, (4, 0, 0)), point("b", 2, (-4, 0, 0))
    (found,) = approaches(response({(3, 1, 5): 2e-3}), [facing(*along_x, half=5.0, axis=0)])
    assert found.distance == pytest.approx(0.03 - 2e-3 * 5.0)
    # A gap that grows by 2 mm for each metre along the edges is the least at one end.
    (found,) = approaches(response({}), [facing(*ends, half=5.0, gap_slope=2e-3)])
    assert found.distance == pytest.approx(0.03 - 2e-3 * 5.0)


@pytest.mark.parametrize(("storey", "level"), [(1, 2.0), (2, 7.0)])
def test_a_base_that_moves_takes_storeys_along(storey, level):
    """Ground that sways and a base that rocks: the lower end of the first storey is no floor."""
    run = response({})
    stick, sway, base = run.system.sticks[0], np.zeros((3, 4, 3)), np.zeros((4, 6))
    sway[0, 2, 1], base[2, 3] = 0.01, 1e-3
    run.u[:, : stick.n] = base @ stick.rigid_body().T + sway[0] @ stick.rigid_body()[:, :3].T
    rocks = BaseHistory(base, *np.zeros((3, 4, 6)), radiated=np.zeros(4))
    inside = point("a", None, (0, 4, 0)).model_copy(update={"storey": storey})
    pair = replace(facing(inside, point("b", 2, (0, -4, 0))), level=level)
    (found,) = approaches(replace(run, relative={"a": sway}, bases={"a": rocks}), [pair])
    assert found.distance == pytest.approx(0.03 - 0.01 + 1e-3 * level)


def test_a_storey_and_a_floor_that_leans():
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
