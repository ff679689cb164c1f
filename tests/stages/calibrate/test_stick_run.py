from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize

from impactfem.case import load_case
from impactfem.coupling import restitution
from impactfem.coupling.from_case import stick_of
from impactfem.coupling.impacts import impacts
from impactfem.coupling.pounding import simulate
from impactfem.stages.calibrate.experiment import (
    WallExperiment,
    run_stick,
    static_state,
    wall_system,
)
from impactfem.stages.calibrate.impact import floor_impacts, penalty_parameters
from impactfem.sticks.stick import build_stick, mass_on_spring
from impactfem.system.errors import ImpactfemError

# The floor of the paper; domain anchor B8 has the figures of its impact.
M, K, XI, V = 3014e3, 1e11, 0.12, 0.163
UY = 1


def slowly(speed=V, amplitude=0.2, gap=0.0, dt=2e-5, k=None):
    """The floor on a spring, so soft that it is a free mass at the wall, let go to arrive there."""
    k = M * (speed / amplitude) ** 2 if k is None else k
    omega = np.sqrt(k / M)
    arrival = (np.pi / 2.0 + np.arcsin(gap / amplitude)) / omega
    experiment = WallExperiment((1,), 1, -amplitude, gap, arrival + 0.06, dt)
    return mass_on_spring("m", M, k), experiment, arrival


def test_the_floor_of_the_paper_as_a_free_mass():
    stick, experiment, arrival = slowly()
    history = run_stick(stick, experiment, K=K, xi=XI)
    impact = floor_impacts(history, 1).first_complete()
    assert impact.start == pytest.approx(arrival, rel=1e-6)
    assert impact.approach == pytest.approx(V, rel=1e-5)
    assert impact.duration == pytest.approx(17.373e-3, rel=1e-4)
    assert impact.peak_force == pytest.approx(77.31e6, rel=5e-4)
    assert history.force[impact.first, 0] == pytest.approx(21.5e6, rel=5e-3)
    assert impact.epsilon_at_end == pytest.approx(0.68404, rel=1e-3)
    # The largest impulse is that at F = 0: the law's at the phase where K p + C v changes its sign.
    root = np.sqrt(1.0 - XI**2)
    phase = np.arctan2(2.0 * XI * root, 2.0 * XI**2 - 1.0)
    assert impact.epsilon == pytest.approx(np.exp(-XI * phase / root), rel=1e-3)
    assert impact.epsilon > 1.02 * impact.epsilon_at_end
    # It leaves the wall where it met it, so the force took all that the mass lost.
    lost = 0.5 * M * V**2 * (1.0 - 0.68404**2)
    assert impact.work == pytest.approx(lost, rel=2e-3)


@pytest.mark.parametrize("tension", [True, False])
def test_the_parameters_of_the_law_come_back(tension):
    stick, experiment, _ = slowly()
    impact = floor_impacts(
        run_stick(stick, experiment, K=K, xi=XI, tension=tension), 1
    ).first_complete()
    found = penalty_parameters(impact, tension=tension, at_end=True)
    assert found.epsilon == pytest.approx(restitution.kelvin_voigt(XI, tension=tension), rel=1e-3)
    assert found.xi_c == pytest.approx(XI, rel=2e-3)
    assert found.K_Ceq == pytest.approx(K, rel=3e-3)
    # With the largest impulse ε and ξ do not, when the force pulls.
    largest = penalty_parameters(impact, tension=tension)
    assert (abs(largest.xi_c / XI - 1.0) > 0.05) == tension


def kelvin_voigt_behind_a_gap(k, gap, speed):
    """Duration, impulse at its end and peak force of the floor on a spring k that meets the wall.

    M x'' + C x' + (K + k) x = -k g from x = 0 at x' = v₀, until x = 0 again; P from the momentum:
    M (v₀ - v₁) = P + k ∫ (g + x) dt.
    """
    c = 2.0 * XI * np.sqrt(K * M)
    zeta, omega2 = c / (2.0 * M), (K + k) / M
    w = np.sqrt(omega2 - zeta**2)
    x_p = -k * gap / (K + k)
    a, b = -x_p, (speed - zeta * x_p) / w
    t = np.linspace(0.0, 0.03, 3_000_001)
    decay = np.exp(-zeta * t)
    x = x_p + decay * (a * np.cos(w * t) + b * np.sin(w * t))
    v = decay * ((b * w - zeta * a) * np.cos(w * t) - (a * w + zeta * b) * np.sin(w * t))
    n = int(np.flatnonzero(x[1:] < 0.0)[0]) + 1
    force = K * x[: n + 1] + c * v[: n + 1]
    impulse = M * (speed - v[n]) - k * float(
        scipy.integrate.trapezoid(gap + x[: n + 1], t[: n + 1])
    )
    return float(t[n]), impulse, float(force.max())


def test_a_stiff_spring_behind_a_gap_moves_what_equations_5_and_6_give():
    """They take the floor for free; at 1.75 Hz and 1 cm its own spring is 6 % of the impulse."""
    k, gap = M * (2.0 * np.pi * 1.75) ** 2, 0.01
    stick, experiment, arrival = slowly(k=k, amplitude=0.02, gap=gap, dt=1e-5)
    impact = floor_impacts(run_stick(stick, experiment, K=K, xi=XI), 1).first_complete()
    speed = np.sqrt(k / M * (0.02**2 - gap**2))
    duration, impulse, peak = kelvin_voigt_behind_a_gap(k, gap, speed)
    assert impact.start == pytest.approx(arrival, rel=1e-5)
    assert impact.approach == pytest.approx(speed, rel=1e-4)
    assert impact.duration == pytest.approx(duration, rel=1e-3)
    assert impact.impulse == pytest.approx(impulse, rel=1e-3)
    assert impact.peak_force == pytest.approx(peak, rel=1e-3)
    found = penalty_parameters(impact, at_end=True)
    assert found.epsilon < 0.95 * restitution.kelvin_voigt(XI)
    assert found.K_Ceq > 1.03 * K


def test_a_lagged_force_returns_more():
    """Equation 2 as printed: a force one step late takes K Δt / (2 √(K M)) from ξ_c."""
    stick, experiment, _ = slowly(dt=1e-4)
    found = {
        update: floor_impacts(
            run_stick(stick, experiment, K=K, xi=XI, update=update), 1
        ).first_complete()
        for update in ("implicit", "lagged")
    }
    late = XI - K * experiment.time_step / (2.0 * np.sqrt(K * M))
    expected = restitution.kelvin_voigt(late)
    assert found["lagged"].epsilon_at_end == pytest.approx(expected, rel=5e-3)
    assert found["implicit"].epsilon_at_end == pytest.approx(0.68404, rel=5e-3) != expected
    assert found["lagged"].start == pytest.approx(found["implicit"].start, abs=1e-7)


def test_static_state_is_that_of_one_force(stick, experiment):
    u = static_state(stick, experiment)
    top = 6 * stick.floor_master(3) + UY
    assert u[top] == pytest.approx(experiment.displacement, rel=1e-12)
    load = stick.K @ u
    assert load[top] < 0.0
    others = np.delete(load, top) * np.tile([1.0, 1.0, 1.0, 0.1, 0.1, 0.1], 3)[1:]
    assert np.abs(others).max() < 1e-9 * abs(load[top])
    # Below less, and the other way when the middle floor is pushed towards the wall.
    assert 0.0 > u[UY] > u[6 + UY] > u[top]
    middle = static_state(stick, replace(experiment, displaced_floor=2, displacement=0.005))
    assert middle[6 + UY] == pytest.approx(0.005) and middle[top] > 0.007


def test_static_state_of_a_cantilever(stick, experiment):
    """A Timoshenko cantilever with a force at its end, all storeys flexible: F (h³/3EI + h/GA)."""
    floors = [replace(floor, below=0.0, above=0.0) for floor in stick.floors]
    plain = build_stick("plain", floors)
    s, h = floors[0].section, sum(floor.height for floor in floors)
    force = (plain.K @ static_state(plain, experiment))[12 + UY]
    flexibility = h**3 / (3.0 * s.E * s.Ix) + h / (s.G * s.Avy)
    assert force * flexibility == pytest.approx(experiment.displacement, rel=1e-9)


@pytest.mark.parametrize(
    ("side", "normal"),
    [("x-", [-1, 0, 0]), ("x+", [1, 0, 0]), ("y-", [0, -1, 0]), ("y+", [0, 1, 0])],
)
def test_the_wall_stands_on_the_side_asked(stick, experiment, side, normal):
    there = replace(experiment, side=side)
    history = run_stick(stick, there, K=1e10, xi=XI)
    u = static_state(stick, there).reshape(3, 6)
    assert history.displacement[0] == pytest.approx(u[1:, :3] @ there.normal)
    assert history.displacement[0, 1] == pytest.approx(-0.02)
    assert floor_impacts(history, 3).first_complete().approach > 0.0
    # On the opposite side the same happens, mirrored; across, another section.
    opposite = run_stick(
        stick, replace(there, side=side[0] + "+-"["+-".index(side[1]) - 1]), K=1e10, xi=XI
    )
    across = run_stick(
        stick, replace(there, side={"x": "y", "y": "x"}[side[0]] + side[1]), K=1e10, xi=XI
    )
    assert there.normal.tolist() == normal
    assert np.allclose(history.force, opposite.force, rtol=1e-9, atol=1e-3)
    assert not np.allclose(history.force, across.force, rtol=1e-2, atol=1e3)


def test_impacts_are_those_of_the_pounding_stage(stick, experiment):
    """The evaluation of arrays against the one that knows the system."""
    near = replace(experiment, gap=0.002, duration=1.0)
    system = wall_system(stick, near, K=1e10, xi=XI)
    u0 = static_state(stick, near)
    response = simulate(system, np.zeros((near.n_t, 3)), near.time_step, u0=u0)
    history = run_stick(stick, near, K=1e10, xi=XI)
    assert [pair.name for pair in system.pairs] == ["tower.floor_2-wall", "tower.floor_3-wall"]
    expected = [impact for impact in impacts(response) if impact.pair.a.floor == 3]
    found = floor_impacts(history, 3, separation=0.0).impacts
    assert len(found) == len(expected) >= 2
    for ours, theirs in zip(found, expected, strict=True):
        assert ours.start == pytest.approx(theirs.start, abs=0.05 * experiment.time_step)
        assert ours.impulse == pytest.approx(theirs.impulse, rel=1e-9)
        assert ours.work == pytest.approx(theirs.dissipated, rel=1e-9)
        assert ours.approach == pytest.approx(theirs.approach, rel=1e-9)
        assert ours.rebound == pytest.approx(theirs.separation, rel=1e-9)


def test_energy_is_never_gained(stick, experiment):
    """No damping but that of the contact: what the building loses is the work of all floors."""
    undamped = replace(stick, C=np.zeros_like(stick.C), damping=None)
    system = wall_system(undamped, experiment, K=1e10, xi=XI)
    u0 = static_state(undamped, experiment)
    response = simulate(system, np.zeros((experiment.n_t, 3)), experiment.time_step, u0=u0)
    energy = 0.5 * np.sum(response.v * (response.v @ stick.M), axis=1) + 0.5 * np.sum(
        response.u * (response.u @ stick.K), axis=1
    )
    history = run_stick(undamped, experiment, K=1e10, xi=XI)
    work = sum(i.work for floor in (2, 3) for i in floor_impacts(history, floor).impacts)
    assert work > 0.05 * energy[0]
    assert energy[0] - energy[-1] == pytest.approx(work, rel=1e-6)


def test_a_floor_that_does_not_exist(stick, experiment):
    with pytest.raises(ImpactfemError, match="floor 9; its floors: 1, 2, 3"):
        run_stick(stick, replace(experiment, floors=(3, 9)), K=1e10, xi=XI)
    with pytest.raises(ImpactfemError, match="floor 7"):
        run_stick(stick, replace(experiment, displaced_floor=7), K=1e10, xi=XI)


def test_a_wall_inside_the_building_that_another_floor_finds(stick, experiment):
    """Floor 2 is 8 mm before its place: inside the gap; floor 3 above it is farther."""
    pushed = replace(experiment, displaced_floor=2, displacement=0.008)
    with pytest.raises(ImpactfemError, match=r"3 is displaced by 1.*"):
        run_stick(stick, pushed, K=1e10, xi=XI)


def test_gap_and_displacement_scaled_together_change_no_parameter(stick, experiment):
    """The problem is linear but for the wall, and that is a cone: all goes with the scale."""
    half = replace(experiment, displacement=-0.01, gap=0.005)
    narrow = replace(experiment, gap=0.005)
    one, other, third = (
        floor_impacts(run_stick(stick, e, K=2e11, xi=XI), 3).first_complete()
        for e in (experiment, half, narrow)
    )
    assert other.impulse == pytest.approx(0.5 * one.impulse, rel=1e-9)
    assert other.start == pytest.approx(one.start, rel=1e-9)
    scaled, whole, not_scaled = (penalty_parameters(i) for i in (other, one, third))
    assert scaled.epsilon == pytest.approx(whole.epsilon, rel=1e-9)
    assert scaled.K_Ceq == pytest.approx(whole.K_Ceq, rel=1e-9)
    assert abs(not_scaled.epsilon - whole.epsilon) > 1e-3


def test_release_at_the_wall_is_no_force(stick, experiment):
    """Let go at the wall, with no gap left: it swings away first."""
    touching = replace(experiment, displacement=experiment.gap, floors=(3,))
    history = run_stick(stick, touching, K=1e10, xi=XI)  # it may start there
    assert history.opening[0, 0] == pytest.approx(0.0, abs=1e-12)
    assert not history.force[:50].any()


def test_the_arrival_by_an_equation_of_its_own(stick, experiment):
    """The stick's own modes, undamped, superposed: when does the top get to the wall?"""
    undamped = replace(stick, C=np.zeros_like(stick.C), damping=None)
    fine = replace(experiment, time_step=2e-5)
    arrival = floor_impacts(run_stick(undamped, fine, K=1e10, xi=XI), 3).first_complete().start
    values, vectors = np.linalg.eigh(stick.M**0.5 @ np.linalg.inv(stick.K) @ stick.M**0.5)
    root = np.sqrt(np.diag(stick.M))
    amplitude = vectors.T @ (root * static_state(stick, experiment))
    top = 6 * stick.floor_master(3) + UY

    def distance(t):
        return 0.01 - float(vectors[top] @ (amplitude * np.cos(t / np.sqrt(values)))) / root[top]

    grid = np.linspace(0.0, 0.3, 3001)
    first = int(np.flatnonzero([distance(t) < 0.0 for t in grid])[0])
    expected = scipy.optimize.brentq(distance, grid[first - 1], grid[first])
    assert arrival == pytest.approx(expected, rel=1e-4)


@pytest.fixture(scope="module")
def paper_stick():
    """Building 1 of the paper as its case file gives it, before the fit of the last per cent."""
    case = load_case(Path(__file__).parents[3] / "geometry" / "npp_pair.toml")
    return stick_of(case.buildings[0])


PAPER = WallExperiment((6, 7, 8), 8, -0.02, 0.01, 1.3, 0.34e-3)


def test_times_of_the_paper():
    assert PAPER.n_t == 3825
    assert (PAPER.n_t - 1) * PAPER.time_step == pytest.approx(1.3, abs=0.17e-3)


def test_the_experiment_of_the_paper(paper_stick):
    """Its stick arrives 11.1 ms after 198 ms (figure 7); floors 7 and 8 hit, floor 6 does not."""
    history = run_stick(paper_stick, PAPER, K=K, xi=restitution.kelvin_voigt_xi(0.687))
    found = {floor: floor_impacts(history, floor) for floor in PAPER.floors}
    top = found[8].first_complete()
    assert top.start == pytest.approx(0.2091, abs=2e-3)
    assert top.approach == pytest.approx(0.163, rel=0.08)
    assert top.largest_impulse == pytest.approx(829e3, rel=0.06)
    assert top.duration == pytest.approx(17.37e-3, rel=0.04)
    assert [found[floor].number for floor in PAPER.floors] == [0, 1, 1]
    # The building drives the floor into the wall while it is stopped.
    assert penalty_parameters(top, at_end=True).epsilon > 1.02 * 0.687
    assert penalty_parameters(top, at_end=True).K_Ceq < 0.98 * K


def test_the_second_impact_of_the_paper_is_that_of_its_lagged_force(paper_stick):
    """At 0.737 s with 37 kN s in the paper, which prints ξ_c = 0.129 and a force one step late."""
    runs = {
        update: floor_impacts(run_stick(paper_stick, PAPER, K=K, xi=0.129, update=update), 8)
        for update in ("implicit", "lagged")
    }
    second = runs["lagged"].second
    assert second.start == pytest.approx(0.737, abs=4e-3)
    assert second.largest_impulse == pytest.approx(37e3, rel=0.25)
    # With the force at its own time the floor turns a fifth of a millimetre before the wall.
    assert runs["implicit"].number == 1
