import numpy as np
import pytest

from impactfem.stages.calibrate.history import WallHistory
from impactfem.stages.calibrate.impact import floor_impacts
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


def test_a_second_impact(history):
    found = floor_impacts(history(half_sine() + half_sine(first=1200, steps=40, peak=1e3)), 8)
    assert found.number == 2
    assert found.second.start == pytest.approx(1.2, abs=DT)
    assert found.second.impulse == pytest.approx(2.0 / np.pi * 1e3 * 0.040, rel=1e-3)
    assert (
        found.first_complete().impulse
        == floor_impacts(history(half_sine()), 8).first_complete().impulse
    )


def test_residual_of_a_solver_is_no_force(history):
    noise = np.random.default_rng(1).uniform(-1.0, 1.0, 2000) * 1e-8 * 7e4
    with_noise = history(half_sine() + noise)
    assert floor_impacts(with_noise, 8).first_complete().start == pytest.approx(0.5, abs=DT)
    with pytest.raises(SolutionError, match="inside the building"):
        floor_impacts(with_noise, 8, threshold=0.0)


def test_residual_is_measured_by_the_largest_force_of_all_floors(history):
    force = np.column_stack([half_sine(), 1e-9 * half_sine()])
    still = np.zeros_like(force)
    two = WallHistory((7, 8), np.ones(2), 0.01, DT, still, still, force)
    assert floor_impacts(two, 7).number == 1
    assert floor_impacts(two, 8).number == 0
    assert floor_impacts(two, 8, threshold=1e-10).number == 1


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


def test_energy_lost(history):
    F = half_sine()
    velocity = np.where(np.arange(F.size) <= 600, 1.0, -0.6)
    impact = floor_impacts(history(F, velocity=velocity[:, None]), 8).first_complete()
    assert (impact.approach, impact.rebound) == (1.0, 0.6)
    assert impact.kinetic_energy_lost == pytest.approx(0.5 * 1000.0 * (1.0 - 0.36))


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
    with pytest.raises(SolutionError, match="as near as 3 mm"):
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


@pytest.mark.parametrize("bad", [{"separation": -1.0}, {"threshold": 1.0}, {"threshold": -0.1}])
def test_arguments_out_of_range(history, bad):
    with pytest.raises(ImpactfemError, match="separation must be at least 0 s and threshold"):
        floor_impacts(history(half_sine()), 8, **bad)
