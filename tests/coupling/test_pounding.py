from dataclasses import replace

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg

from impactfem.coupling.impacts import impacts
from impactfem.coupling.laws import HertzDamp, KelvinVoigt, Unilateral, effective_mass
from impactfem.coupling.pounding import End, Load, Pair, System, simulate
from impactfem.dynamics.damping import RatioTable, Rayleigh
from impactfem.sticks.stick import mass_on_spring
from impactfem.system.errors import ImpactfemError, SolutionError
from impactfem.verify.contact import Y, collision

from ..sticks.conftest import damped_stick

DT = 2.5e-4
UX, UY, UZ, RX, RY, RZ = range(6)


def point(name, offset=(0.0, 0.0, 0.0)):
    return End(name, 0, offset, 1)


def before_wall(mass, law, gap=0.0):
    return System((mass,), (Pair("wall", point(mass.name), None, Y, gap, law),))


def test_a_gap_that_never_closes_changes_nothing(row, shake):
    system, ground = row(100.0), shake()
    response = simulate(system, ground, DT)
    free = simulate(system.without_contact(), ground, DT)
    assert not response.force.any()
    assert np.array_equal(response.u, free.u) and np.array_equal(response.v, free.v)
    assert free.force.shape == (4000, 0) and free.gap.shape == (4000, 0)
    pounding = simulate(row(0.005), ground, DT)
    assert pounding.force.any() and not np.array_equal(pounding.u, free.u)


def test_each_contact_has_its_own_speed_of_approach():
    """Of three in one motion a law takes what it takes of each alone; the ends open slowly."""
    law = HertzDamp(5e9, 0.6, mass=1e5)
    speeds = (0.05, 0.4, 0.1)
    phase = np.linspace(-0.1 * np.pi, 1.1 * np.pi, 401)
    alone = [(-0.01 * v * np.sin(phase), -v * np.cos(phase)) for v in speeds]
    each = [law.dissipated(*motion) for motion in alone]
    gap, rate = (np.concatenate(some) for some in zip(*alone, strict=True))
    assert all(one > 0.0 for one in each)
    assert law.dissipated(gap, rate) == pytest.approx(sum(each), rel=1e-12)
    # With the first speed for all the second one would take several times as much.
    wrong = [law.at(max(-g, 1e-300), -r, (0.05,))[0]
             for g, r in zip(*alone[1], strict=True)]  # fmt: skip
    p = np.maximum(-alone[1][0], 0.0)
    assert scipy.integrate.trapezoid(wrong, p) > 4.0 * each[1]


@pytest.mark.parametrize("points", [[], [(2, 0.3), (1, 0.5)]])
def test_rayleigh_as_a_table_of_its_own_curve(floors, shake, points):
    """With points without mass, and with impacts, the numbers of Rayleigh damping."""
    own = Rayleigh(0.6, 8e-4)
    sticks = [damped_stick(name, floors(2), damping=own, storey_points=points) for name in "ab"]
    soft = replace(sticks[1], K=0.7 * sticks[1].K, C=own.matrix(0.7 * sticks[1].K, sticks[1].M))
    law = KelvinVoigt(1e9, 0.1, mass=effective_mass(*(2 * [floors(1)[0].mass])))
    ends = [End.of_floor(stick, 2, (0.0, 0.0, 0.0)) for stick in sticks]
    system = System((sticks[0], soft), (Pair("2", *ends, Y, 0.003, law),))
    ground, found = shake(), {}
    for factor in (None, 1.0, 1.01):
        as_table = []
        for (_, body), stick in zip(system.modes, system.sticks, strict=True):
            top = body.eigenvalue[body.mass > 0.0].max()
            frequency = (
                np.sqrt(np.unique([*body.eigenvalue[body.mass > 0.0], 4.0 * top])) / 2 / np.pi
            )
            ratios = tuple((factor or 1.0) * own.ratio(frequency))
            damping = RatioTable(tuple(frequency), ratios) if factor else own
            C = damping.matrix(stick.K, stick.M)
            as_table.append(replace(stick, damping=damping, C=C))
        found[factor] = simulate(replace(system, sticks=tuple(as_table)), ground, DT)
    one, same, other = found.values()
    assert one.force.any() and one.energy.residual < 1e-10 and same.energy.residual < 1e-10
    for name in ("u", "v", "force", "acceleration"):
        size = np.abs(getattr(one, name)).max()
        assert np.abs(getattr(same, name) - getattr(one, name)).max() < 1e-10 * size
        assert np.abs(getattr(other, name) - getattr(one, name)).max() > 1e-4 * size


def test_buildings_alike_never_touch(row, shake):
    alike = simulate(row(0.0, softer=1.0), shake(components=(0, 1, 2)), DT)
    assert not alike.force.any() and np.abs(alike.u).max() > 0.0
    assert simulate(row(0.0, softer=0.999), shake(), DT).force.any()


def test_a_point_without_mass_changes_nothing_when_nothing_touches(floors, shake):
    plain = System((damped_stick("a", floors(2)),), ())
    pointed = System((damped_stick("a", floors(2), storey_points=[(2, 0.3), (1, 0.5)]),), ())
    ground = shake(components=(0, 1, 2))
    one, other = simulate(plain, ground, DT), simulate(pointed, ground, DT)
    assert np.abs(one.u - other.u[:, :12]).max() < 1e-9 * np.abs(one.u).max()
    assert np.abs(one.acceleration - other.acceleration[:, :12]).max() < 1e-6
    # The points move, between base and floor 1 and between the floors; they have no acceleration.
    top, middle = np.abs(other.u[:, [UY, 6 + UY, 12 + UY, 18 + UY]]).max(axis=0).reshape(2, 2)
    assert 0.0 < middle[0] < top[0] < middle[1] < top[1]
    assert not other.acceleration[:, 12:].any()


@pytest.mark.parametrize("tension", [True, False])
def test_two_oscillators_that_pound_against_adaptive_integration(tension):
    dt, m1, m2 = 1e-5, 3e6, 1.5e6
    k1, k2, c1, c2 = m1 * 11.0**2, m2 * 8.0**2, 0.1 * m1, 0.2 * m2
    law = KelvinVoigt(1e10, 0.15, mass=effective_mass(m1, m2), tension=tension)
    sticks = (mass_on_spring("1", m1, k1, dashpot=c1), mass_on_spring("2", m2, k2, dashpot=c2))
    system = System(sticks, (Pair("1-2", point("1"), point("2"), Y, 0.004, law),))
    ground = np.zeros((round(0.6 / dt) + 1, 3))
    ground[:, 1] = 3.0 * np.sin(9.0 * dt * np.arange(len(ground)))
    v0 = 0.3 * np.eye(12)[UY]
    response = simulate(system, ground, dt, v0=v0)
    K, C = law.parameters[:2]
    touching = False

    def rhs(t, y):
        F = K * (y[0] - y[1] - 0.004) + C * (y[2] - y[3]) if touching else 0.0
        F = F if tension else max(F, 0.0)
        first, second = -k1 * y[0] - c1 * y[2] - F, -k2 * y[1] - c2 * y[3] + F
        a = 3.0 * np.sin(9.0 * t)
        return [y[2], y[3], first / m1 - a, second / m2 - a]

    def crossing(t, y):
        return y[0] - y[1] - 0.004

    crossing.terminal = True
    t, y, closings = 0.0, np.array([0.0, 0.0, 0.3, 0.0]), 0
    while t < 0.6:
        crossing.direction = -1 if touching else 1
        solution = scipy.integrate.solve_ivp(
            rhs, (t, 0.6), y, events=crossing, rtol=1e-9, atol=1e-12, max_step=2e-3
        )
        t, y = solution.t[-1], solution.y[:, -1]
        if solution.status == 1:
            touching = not touching
            closings += touching
    assert closings >= 2 == min(closings, len(impacts(response)))
    found = response.u[-1, [UY, 6 + UY]]
    assert found == pytest.approx(y[:2], abs=2e-3 * np.abs(response.u).max())
    # Without contact they would be elsewhere.
    free = simulate(system.without_contact(), ground, dt, v0=v0)
    assert np.abs(free.u[-1, [UY, 6 + UY]] - y[:2]).max() > 0.1 * np.abs(response.u).max()


def test_action_is_reaction():
    law = KelvinVoigt(1e9, 0.2, mass=effective_mass(2e3, 5e3))
    response = collision(law, 2e3, 5e3, 0.7, law.duration(0.7) / 50)
    momentum = response.v[:, [UY, 6 + UY]] @ [2e3, 5e3]
    assert momentum == pytest.approx(2e3 * 0.7, rel=1e-12)
    assert response.v[-1, 6 + UY] > 0.1
    force = response.force[:, 0]
    assert response.acceleration[:, UY] == pytest.approx(-force / 2e3)
    assert response.acceleration[:, 6 + UY] == pytest.approx(force / 5e3)


def test_three_buildings_in_a_row(row, shake):
    three = simulate(row(0.003, buildings=3), shake(), DT)
    assert [pair.name for pair in three.system.pairs] == ["a1-b1", "a2-b2", "b1-c1", "b2-c2"]
    assert three.force[:, :2].any() and three.force[:, 2:].any()
    two = simulate(row(0.003), shake(), DT)
    assert np.abs(three.u[:, :12] - two.u[:, :12]).max() > 1e-5


def test_roles_of_the_two_ends(row, shake):
    system, ground = row(0.003), shake()
    swapped = tuple(replace(p, a=p.b, b=p.a, normal=-p.normal) for p in system.pairs)
    one, other = simulate(system, ground, DT), simulate(System(system.sticks, swapped), ground, DT)
    assert one.force.any()
    assert np.abs(one.force - other.force).max() < 1e-9 * np.abs(one.force).max()
    assert np.abs(one.u - other.u).max() < 1e-12 * np.abs(one.u).max()
    # With the roles but not the normal the points move apart where they should touch.
    wrong = tuple(replace(pair, normal=-pair.normal) for pair in swapped)
    wrong_way = simulate(System(system.sticks, wrong), ground, DT)
    assert np.abs(one.u - wrong_way.u).max() > 1e-3 * np.abs(one.u).max()


def test_a_wall_moves_with_the_ground():
    # A mass on a spring, at rest against a wall: the ground pushes it there or away.
    system = before_wall(mass_on_spring("m", 1e3, 1e5), KelvinVoigt(1e9, 0.1, mass=1e3))
    for a, touches in ((-2.0, True), (2.0, False)):
        ground = np.zeros((100, 3))
        ground[:, 1] = a
        response = simulate(system, ground, 1e-4)
        assert response.force.any() == touches
        assert np.all(response.u[1:, UY] * a < 0.0)


def test_lagged_force_is_another_and_blows_up_for_a_long_step(row, shake):
    implicit = simulate(row(0.003), shake(), DT)
    lagged = simulate(row(0.003), shake(), DT, update="lagged")
    difference = np.abs(implicit.u - lagged.u).max() / np.abs(implicit.u).max()
    assert 1e-3 < difference < 1.0
    law = KelvinVoigt(1e11, 0.12, mass=1.5e6)
    system, v0 = before_wall(mass_on_spring("m", 1.5e6, 1e9), law), np.eye(6)[UY]
    ground, dt = np.zeros((20000, 3)), law.duration(1.0) / 2.0
    with pytest.raises(SolutionError, match="without bound; a lagged"):
        simulate(system, ground, dt, update="lagged", v0=v0)
    assert np.abs(simulate(system, ground, dt, v0=v0).u).max() < 0.1


@pytest.mark.parametrize("n_t", [50, 400])
def test_a_lagged_blow_up_that_is_still_finite_is_refused(n_t):
    """A floor at a wall, five steps an impact; with the paper's step it is 52 and goes well."""
    law = KelvinVoigt(1e11, 0.12, mass=3014e3)
    system, v0 = before_wall(mass_on_spring("m", 3014e3, 3e9), law), 0.163 * np.eye(6)[UY]
    ground, coarse, paper = np.zeros((n_t, 3)), law.duration(0.163) / 5.0, 16.79 / 50_000
    with pytest.raises(SolutionError, match="contact forces created"):
        simulate(system, ground, coarse, update="lagged", v0=v0)
    assert np.isfinite(simulate(system, ground, coarse, v0=v0).u).all()
    moderate = simulate(system, np.zeros((400, 3)), paper, update="lagged", v0=v0)
    (impact,) = impacts(moderate)[:1]
    assert impact.restitution == pytest.approx(law.epsilon, abs=0.1)


def test_lagged_force_is_the_law_one_step_before(row, shake):
    response = simulate(row(0.003), shake(), DT, update="lagged")
    law, p, v = response.system.pairs[1].law, -response.gap[:-1, 1], -response.gap_rate[:-1, 1]
    expected = np.where(p > 0.0, law.parameters[0] * p + law.parameters[1] * v, 0.0)
    assert expected.any()
    assert response.force[1:, 1] == pytest.approx(expected, rel=1e-9, abs=1e-3)


def test_a_start_in_contact_is_refused(row):
    system = row(0.01)
    u0 = np.zeros(24)
    u0[6 + UY] = 0.0101
    with pytest.raises(ImpactfemError, match="pair a2-b2 penetrates at"):
        simulate(system, np.zeros((10, 3)), DT, u0=u0)
    u0[6 + UY] = 0.0099
    assert simulate(system, np.zeros((10, 3)), DT, u0=u0).u[0, 6 + UY] == 0.0099


@pytest.mark.parametrize("mass", [1.7e3, 2.3e3, 2.9e3, 3.1e3, 7.7e3, 1.1e4])
def test_a_start_at_the_wall(mass):
    """The gap is just closed, whatever rounding the modal coordinates have: as with no gap."""
    stick = mass_on_spring("m", mass, 0.0)
    law = HertzDamp(5e9, 0.6, mass=mass)
    v0 = 0.4 * np.eye(6)[1]

    def against(gap):
        u0 = gap * np.eye(6)[1]
        return simulate(before_wall(stick, law, gap), np.zeros((400, 3)), 1e-5, u0=u0, v0=v0)

    found, wanted = against(0.013), against(0.0)
    assert wanted.force.max() > 0.0
    assert np.abs(found.force - wanted.force).max() < 1e-9 * wanted.force.max()


def test_shapes_that_do_not_fit(row):
    for shape in ((10,), (10, 2), (3, 10), (2, 10, 3)):
        with pytest.raises(ImpactfemError, match="ground must have shape"):
            simulate(row(), np.zeros(shape), DT)
    mass = mass_on_spring("m", 2.0, 0.0)
    load = Load(End.of_floor(mass, 1), Y, np.ones(10))
    with pytest.raises(ImpactfemError, match=r"shape \(11,\), got \(10,\)"):
        simulate(System((mass,), ()), np.zeros((11, 3)), 0.1, loads=[load])


def test_accelerations_are_those_of_the_scheme(row, shake):
    # The average acceleration rule: v₁ - v₀ = Δt/2 (a₀ + a₁), from equilibrium at both times.
    response = simulate(row(0.003), shake(components=(0, 1)), DT)
    a = response.acceleration
    step = DT / 2 * (a[:-1] + a[1:])
    assert np.abs(np.diff(response.v, axis=0) - step).max() < 1e-8 * np.abs(response.v).max()
    altered = replace(response, force=1.01 * response.force).acceleration
    assert np.abs(altered - a).max() > 1e-3 * np.abs(a).max()
    absolute = response.absolute_acceleration - a
    assert absolute[:, 6:9] == pytest.approx(response.ground)
    assert not absolute[:, 9:12].any()


def test_gap_and_its_rate(row, shake):
    response = simulate(row(0.003), shake(), DT)
    dofs = response.system.floor_dofs("b")
    assert dofs.shape == (2, 6) and dofs[0, 0] == 12
    expected = 0.003 + response.u[:, dofs[1, UY]] - response.u[:, 6 + UY]
    assert response.gap[:, 1] == pytest.approx(expected, abs=1e-15)
    assert response.gap_rate[:, 1] == pytest.approx(response.v[:, 18 + UY] - response.v[:, 6 + UY])
    assert response.time[-1] == pytest.approx(3999 * DT)


def test_oblique_normal_is_a_turned_building():
    # Free masses that collide along (1, 1)/√2: the same as along y.
    law = KelvinVoigt(1e9, 0.1, mass=500.0)
    n = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    straight = collision(law, 1e3, 1e3, 0.4, 1e-5)
    turned = System(straight.system.sticks, (replace(straight.system.pairs[0], normal=n),))
    v0 = np.zeros(12)
    v0[:3] = 0.4 * n
    response = simulate(turned, straight.ground, 1e-5, v0=v0)
    assert np.abs(response.force - straight.force).max() < 1e-9 * straight.force.max()
    assert response.v[:, 6:9] @ n == pytest.approx(straight.v[:, 6 + UY], abs=1e-12)
    assert response.v[-1, 6] == pytest.approx(straight.v[-1, 6 + UY] / np.sqrt(2), rel=1e-9)


def oscillator(xi, force, dt):
    """A mass of 2 t at 5 Hz under a force along y; its displacement along y."""
    mass = mass_on_spring("m", 2e3, frequency=5.0, damping_ratio=xi)
    load = Load(End.of_floor(mass, 1), Y, force)
    return simulate(System((mass,), ()), np.zeros((len(force), 3)), dt, loads=[load])


@pytest.mark.parametrize("xi", [0.0, 0.05])
def test_a_step_force_on_an_oscillator(xi):
    """u k/P = 1 − e^(−ξωt) (cos ω_d t + ξ/√(1 − ξ²) sin ω_d t); static at last."""
    w, P, dt = 2.0 * np.pi * 5.0, 1e4, 2e-5
    response = oscillator(xi, np.full(100001, P), dt)
    t, root = response.time, np.sqrt(1.0 - xi**2)
    decay = np.exp(-xi * w * t)
    exact = 1.0 - decay * (np.cos(w * root * t) + xi / root * np.sin(w * root * t))
    u = response.u[:, 1] * 2e3 * w**2 / P
    assert u == pytest.approx(exact, abs=3e-6 * (1.0 + 10.0 * (xi == 0.0)))
    assert response.energy.residual < 1e-9
    # The acceleration is in equilibrium with the force.
    assert response.acceleration[0, 1] == pytest.approx(P / 2e3)
    # The spring's force is the reaction: P − m a − c v.
    spring = -response.system.sticks[0].element_forces(response.u)[:, 0, 1]
    damper = response.system.sticks[0].C[1, 1] * response.v[:, 1]
    assert spring == pytest.approx(P - 2e3 * response.acceleration[:, 1] - damper, abs=1e-6 * P)


def test_a_force_and_its_inertia_are_one():
    """A force −m a(t) moves a mass as a ground acceleration a(t) does, in contact, too."""
    m, dt, n_t = 1e3, 1e-4, 20001
    a = 3.0 * np.sin(2.0 * np.pi * 1.5 * dt * np.arange(n_t))
    one, other = (mass_on_spring(name, m, frequency=f) for name, f in (("1", 2.0), ("2", 3.0)))
    pair = Pair("1-2", point("1"), point("2"), Y, 1e-3, KelvinVoigt(1e7, 0.2, mass=0.5 * m))
    system = System((one, other), (pair,))
    ground = np.zeros((n_t, 3))
    ground[:, 1] = a
    by_ground = simulate(system, ground, dt)
    loads = [Load(End.of_floor(stick, 1), Y, -m * a) for stick in (one, other)]
    by_force = simulate(system, np.zeros((n_t, 3)), dt, loads=loads)
    assert by_ground.force.max() > 1e3
    assert by_force.u == pytest.approx(by_ground.u, abs=1e-12)
    assert by_force.force == pytest.approx(by_ground.force, abs=1e-6 * by_ground.force.max())
    # On one mass alone it is another motion.
    alone = simulate(system, np.zeros((n_t, 3)), dt, loads=loads[:1])
    assert np.abs(alone.u - by_ground.u).max() > 1e-3


def test_an_eccentric_force_turns_a_floor():
    mass = mass_on_spring("m", 2.0, 0.0)
    load = Load(End.of_floor(mass, 1, (3.0, 0.0, 0.0)), Y, np.ones(11))
    v = simulate(System((mass,), ()), np.zeros((11, 3)), 0.1, loads=[load]).v[-1]
    # Momentum P t, moment of momentum x P t, with an inertia of m · 1 m².
    assert v == pytest.approx([0.0, 0.5, 0.0, 0.0, 0.0, 1.5])


def test_sticks_have_no_unilateral_contact():
    left, right = (mass_on_spring(name, 1e3, frequency=2.0) for name in ("a", "b"))
    ends = End.of_floor(left, 1), End.of_floor(right, 1)
    pair = Pair("a-b", *ends, np.array([0.0, 1.0, 0.0]), 0.01, Unilateral(mass=500.0))
    with pytest.raises(ImpactfemError, match="a-b"):
        simulate(System((left, right), (pair,)), np.zeros((5, 3)), 1e-3)
