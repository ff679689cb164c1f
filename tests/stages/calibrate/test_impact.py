"""Impacts on the wall, the penalty law that they give, and how stick and 3D model compare."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.coupling import restitution
from impactfem.stages.calibrate import impact
from impactfem.stages.calibrate.experiment import WallExperiment, WallHistory, run_stick
from impactfem.stages.calibrate.impact import WallImpact, compare, floor_impacts, penalty_parameters
from impactfem.sticks.stick import mass_on_spring
from impactfem.system.errors import ImpactfemError, SolutionError

DT = 1e-3


def half_sine(n_t=2000, first=500, steps=160, peak=7e4):
    """A pulse, zero at the times `first` and `first` + `steps`."""
    F = np.zeros(n_t)
    F[first : first + steps + 1] = peak * np.sin(np.pi * np.arange(steps + 1) / steps)
    return F


def test_a_half_sine(history):
    steps, peak = 160, 7e4
    found = floor_impacts(history(half_sine(steps=steps, peak=peak)), 8)
    impact = found.first_complete()
    assert found.number == 1 and found.second is None
    assert impact.impulse == pytest.approx(2.0 / np.pi * peak * steps * DT, rel=1e-4)
    assert impact.largest_impulse == pytest.approx(impact.impulse, rel=1e-12)
    assert impact.peak_force == pytest.approx(peak)
    # Between the times without force: a step of uncertainty, no more.
    assert impact.start == pytest.approx(0.5, abs=DT) and impact.start >= 0.5
    assert impact.duration == pytest.approx(steps * DT, abs=1.01 * DT)
    assert (impact.approach, impact.pulses, impact.complete) == (1.0, 1, True)
    # It flies at 1 m/s: the work is the impulse times that.
    assert impact.work == pytest.approx(impact.impulse, rel=1e-12)


def test_a_force_that_pulls_at_its_end(history):
    force = half_sine(peak=7e4) - half_sine(first=660, steps=40, peak=1e4)
    impact = floor_impacts(history(force), 8).first_complete()
    push, pull = 2.0 / np.pi * 7e4 * 0.160, 2.0 / np.pi * 1e4 * 0.040
    assert impact.largest_impulse == pytest.approx(push, rel=1e-4)
    assert impact.impulse == pytest.approx(push - pull, rel=1e-3)
    assert impact.pulses == 2 and impact.duration == pytest.approx(0.2, abs=1.01 * DT)
    assert impact.epsilon == pytest.approx(push / 1000.0 - 1.0, rel=1e-4)
    assert impact.epsilon_at_end == pytest.approx((push - pull) / 1000.0 - 1.0, rel=1e-3)


def test_chatter_is_one_impact_and_keeps_its_impulse(history):
    steady = half_sine()
    chatter = np.where(np.arange(steady.size) % 2 == 0, 2.0 * steady, 0.0)
    whole, found = (floor_impacts(history(F), 8) for F in (steady, chatter))
    assert found.number == 1 and found.first_complete().pulses == 80 - 1
    assert found.first_complete().impulse == pytest.approx(whole.first_complete().impulse, rel=1e-3)
    assert found.first_complete().duration == pytest.approx(
        whole.first_complete().duration, abs=2.01 * DT
    )
    # Not without the merging.
    assert floor_impacts(history(chatter), 8, separation=0.0).number == 79


@pytest.mark.parametrize(("quiet", "number"), [(4, 1), (5, 2)])
def test_pulses_are_apart_from_the_separation_on(history, quiet, number):
    F = np.zeros(100)
    F[20:30] = 3e3
    F[30 + quiet : 40] = 3e3
    found = floor_impacts(history(F), 8, separation=5 * DT)
    assert found.number == number
    assert sum(impact.impulse for impact in found.impacts) == pytest.approx(DT * F.sum())


def test_residual_of_a_solver_is_no_force(history, monkeypatch):
    noise = np.random.default_rng(1).uniform(-1.0, 1.0, 2000) * 1e-8 * 7e4
    with_noise = history(half_sine() + noise)
    assert floor_impacts(with_noise, 8).first_complete().start == pytest.approx(0.5, abs=DT)
    monkeypatch.setattr(impact, "THRESHOLD", 0.0)
    with pytest.raises(SolutionError, match="inside the building"):
        floor_impacts(with_noise, 8)


def test_residual_is_measured_by_the_largest_force_of_all_floors(monkeypatch):
    force = np.column_stack([half_sine(), 1e-9 * half_sine()])
    still = np.zeros_like(force)
    two = WallHistory((7, 8), np.ones(2), 0.01, DT, still, still, force)
    assert floor_impacts(two, 7).number == 1
    assert floor_impacts(two, 8).number == 0
    monkeypatch.setattr(impact, "THRESHOLD", 1e-10)
    assert floor_impacts(two, 8).number == 1


@pytest.mark.parametrize("late", [0, 1])
def test_limits_from_the_distance(history, late):
    """A floor flies in at 1 m/s and out at 0.5 m/s; the force may begin and end a step late."""
    begin, end = 0.0203, 0.0357
    t = DT * np.arange(80)
    away = np.where(t < begin + late * DT, begin - t, np.where(t > end, 0.5 * (t - end), -1e-4))
    F = np.where((t > begin + late * DT) & (t < end + late * DT), 1e3, 0.0)
    seen = floor_impacts(history(F, opening=away[:, None]), 8)
    assert seen.first_complete().start == pytest.approx(begin, abs=1e-12)
    assert seen.first_complete().end == pytest.approx(end, abs=1e-12)
    assert seen.closest == away.min() < 0.0
    # Without it the force alone tells, to half a step, and nothing of its being late.
    blind = floor_impacts(history(F), 8).first_complete()
    assert blind.start == pytest.approx(begin + late * DT, abs=0.5 * DT)
    assert blind.end == pytest.approx(end + late * DT, abs=0.5 * DT)


def test_limits_do_not_leave_the_step_for_a_floor_that_hardly_moves(history):
    F = half_sine(n_t=100, first=20, steps=40)
    # A drift of the distance that is large beside its rate.
    away = np.where(F > 1.0, 0.0, 1e-3) + 1e-7 * np.arange(100)[::-1]
    impact = floor_impacts(history(F, opening=away[:, None]), 8).first_complete()
    assert impact.start == pytest.approx(0.021) and impact.end == pytest.approx(0.0595)


def test_no_approach_gives_no_restitution(history):
    F = half_sine()
    impact = floor_impacts(history(F, velocity=-np.ones((F.size, 1))), 8).first_complete()
    assert np.isnan(impact.epsilon) and np.isnan(impact.epsilon_at_end)


def test_no_impact(history):
    short = history(np.zeros(15))
    found = floor_impacts(short, 8)
    assert found.number == 0 and found.second is None
    # It began 2 cm behind its place, flew 14 mm, and the wall is 1 cm beyond.
    assert found.closest == pytest.approx(0.016)
    message = (
        "no impact: floor 8 does not touch the wall within 0.014 s; "
        "it gets as near as 16 mm, of a gap of 10 mm"
    )
    with pytest.raises(SolutionError, match=message):
        found.first_complete()
    known = floor_impacts(history(np.zeros(15), opening=np.full((15, 1), 0.003)), 8)
    with pytest.raises(SolutionError, match="near as 3 mm"):
        known.first_complete()


@pytest.mark.parametrize(
    ("n_t", "complete"), [(640, False), (661, False), (664, False), (665, True)]
)
def test_an_impact_that_the_window_cuts_short(history, n_t, complete):
    """The last force is at index 659; another pulse could follow within five steps."""
    found = floor_impacts(history(half_sine(n_t=2000)[:n_t]), 8, separation=5 * DT)
    assert found.impacts[0].complete == complete
    if complete:
        assert found.first_complete().last == 659
    else:
        end = f"{DT * (n_t - 1):g} s"
        message = f"begins at 0.5005 s is still going on when the window ends, at {end}"
        with pytest.raises(SolutionError, match=message):
            found.first_complete()


def test_a_force_at_the_start(history):
    with pytest.raises(SolutionError, match="floor 8 carries 5e\\+04 N at t = 0"):
        floor_impacts(history(np.full(10, 5e4)), 8)


# The paper's own figures (section 3.2.2): floor 8, 829 kN s, 0.163 m/s, 16.5 ms.
PAPER = WallImpact(
    floor=8,
    mass=3014e3,
    first=583,
    last=631,
    pulses=1,
    start=0.198,
    end=0.198 + 16.5e-3,
    impulse=829e3,
    largest_impulse=829e3,
    peak_force=80e6,
    approach=0.163,
    rebound=0.11,
    work=2e4,
    complete=True,
)


def test_figures_of_the_paper():
    found = penalty_parameters(PAPER)
    assert found.epsilon == pytest.approx(0.687, abs=5e-4)
    # Equation 4 with 0.687; the 0.129 printed beside it goes with ε = 0.6645.
    assert found.xi_c == pytest.approx(0.1187, abs=5e-4)
    assert found.K_Ceq == pytest.approx(1.1e11, rel=0.01)
    assert np.exp(-np.pi * 0.129 / np.sqrt(1.0 - 0.129**2)) == pytest.approx(0.6645, abs=1e-4)


def test_elastic_impact_has_no_damping():
    elastic = replace(PAPER, largest_impulse=2.0 * PAPER.mass * PAPER.approach)
    found = penalty_parameters(elastic)
    assert (found.epsilon, found.xi_c) == (pytest.approx(1.0), 0.0)
    assert found.K_Ceq == pytest.approx(PAPER.mass * (np.pi / 16.5e-3) ** 2)


def test_without_tension_the_law_needs_more_damping_and_less_stiffness():
    pulls, pushes = (penalty_parameters(PAPER, tension=tension) for tension in (True, False))
    assert pushes.epsilon == pulls.epsilon
    assert pushes.xi_c > pulls.xi_c and pushes.K_Ceq < pulls.K_Ceq


@pytest.mark.parametrize("speed", [0.0, -0.02])
def test_a_floor_that_does_not_approach(speed):
    message = f"approach velocity of floor 8 before its impact at 0.198 s is {speed:g} m/s, not pos"
    with pytest.raises(SolutionError, match=message):
        penalty_parameters(replace(PAPER, approach=speed))


@pytest.mark.parametrize(
    ("impulse", "found"), [(400e3, "-0.1858"), (1e6, "1.035"), (491282.0, "0")]
)
def test_an_impulse_that_is_no_restitution(impulse, found):
    message = (
        f"gives the restitution {found} for floor 8, expected above 0 and at most 1: "
        f"impulse {impulse * 1e-3:.4g} kN s, momentum before the impact 491.3 kN s"
    )
    with pytest.raises(SolutionError, match=message):
        penalty_parameters(replace(PAPER, largest_impulse=impulse))


M, K, OMEGA = 1e6, 4e11, 10.0
EXPERIMENT = WallExperiment((1,), 1, -0.02, 0.0, 0.9, 1e-5)


def run_before_wall(xi, omega=OMEGA, **changes):
    """A mass on a spring that stands at its wall: ω is far below the Ω = 632 1/s of the contact."""
    stick = mass_on_spring("m", M, M * omega**2)
    return run_stick(stick, replace(EXPERIMENT, **changes), K=K, xi=xi)


def _approach_ratio(found):
    return found.stick.first_complete().approach / found.model.first_complete().approach


def test_less_restitution_rebounds_less():
    """Behind the wall the mass swings by ε u̇⁻ / ω and is back after half a period."""
    damped, lively = 0.2, 0.05
    found = compare(run_before_wall(damped), run_before_wall(lively), 1)
    ratio = restitution.kelvin_voigt(damped) / restitution.kelvin_voigt(lively)
    assert found.rebound_overshoot == pytest.approx(ratio - 1.0, rel=1e-3)
    assert found.delay == pytest.approx(0.0, abs=1e-9)
    assert _approach_ratio(found) == pytest.approx(1.0, rel=1e-9)
    assert found.stick_duration_ratio == pytest.approx(
        np.sqrt((1.0 - lively**2) / (1.0 - damped**2)), rel=1e-3
    )
    # Each impact is the one before it, smaller by ε; it comes half a period after it.
    second = found.stick.second
    assert second.start - found.stick.first_complete().end == pytest.approx(np.pi / OMEGA, rel=1e-3)
    ratio = second.largest_impulse / found.stick.first_complete().largest_impulse
    assert ratio == pytest.approx(restitution.kelvin_voigt(damped), rel=2e-3)


def test_a_slower_stick_is_late():
    found = compare(run_before_wall(0.1, omega=9.0), run_before_wall(0.1), 1)
    assert found.delay == pytest.approx(np.pi / 2.0 * (1.0 / 9.0 - 1.0 / OMEGA), rel=1e-3)
    assert _approach_ratio(found) == pytest.approx(0.9, rel=1e-4)
    assert found.stick_impulse_ratio == pytest.approx(0.9, rel=2e-3)
    # The farthest point goes with the speed over the frequency: the same.
    assert found.rebound_overshoot == pytest.approx(0.0, abs=2e-3)


def turning(history, back, near, n_t=3000):
    """Floor 8 touches at 1 cm, swings to `back`, then to `near`, and away again."""
    t = np.arange(n_t)
    u = np.interp(t, [0, 500, 1500, 2500, 3500], [-0.02, 0.01, back, near, back])
    force = np.zeros(n_t)
    force[500:520] = 1e3
    return history(force, displacement=u[:, None])


def test_overshoots(history):
    stick, model = turning(history, -0.012, 0.0099), turning(history, -0.010, 0.0090)
    found = compare(stick, model, 8)
    assert found.rebound_overshoot == pytest.approx(0.2)
    assert found.return_overshoot == pytest.approx(0.1)
    assert found.stick.second is None


def test_what_has_not_turned_gives_no_overshoot(history):
    model = turning(history, -0.010, 0.0090)
    short = turning(history, -0.012, 0.0099, n_t=2400)
    assert compare(short, model, 8).return_overshoot is None
    assert compare(short, model, 8).rebound_overshoot == pytest.approx(0.2)
    shorter = turning(history, -0.012, 0.0099, n_t=1400)
    assert compare(shorter, model, 8).rebound_overshoot is None
    stays = turning(history, 0.002, 0.0099)
    assert compare(stays, model, 8).rebound_overshoot is None
    assert compare(model, stays, 8).return_overshoot is None


def test_time_steps_may_differ():
    coarse = compare(run_before_wall(0.1, time_step=2e-5), run_before_wall(0.1), 1)
    assert coarse.delay == pytest.approx(0.0, abs=1e-6)
    assert coarse.stick_impulse_ratio == pytest.approx(1.0, abs=1e-2)


def test_runs_that_do_not_compare():
    with pytest.raises(ImpactfemError, match="floor 2 is none"):
        compare(run_before_wall(0.1), run_before_wall(0.1), 2)
    far = run_before_wall(0.1, gap=0.05)
    with pytest.raises(SolutionError, match="no impact: floor 1"):
        compare(far, far, 1)


def test_a_second_impact(history):
    found = floor_impacts(history(half_sine() + half_sine(first=1200, steps=40, peak=1e3)), 8)
    assert found.number == 2
    assert found.second.start == pytest.approx(1.2, abs=DT)
    assert found.second.impulse == pytest.approx(2.0 / np.pi * 1e3 * 0.040, rel=1e-3)
    assert (
        found.first_complete().impulse
        == floor_impacts(history(half_sine()), 8).first_complete().impulse
    )


def test_approach_and_rebound(history):
    F = half_sine()
    velocity = np.where(np.arange(F.size) <= 600, 1.0, -0.6)
    impact = floor_impacts(history(F, velocity=velocity[:, None]), 8).first_complete()
    assert (impact.approach, impact.rebound) == (1.0, 0.6)
