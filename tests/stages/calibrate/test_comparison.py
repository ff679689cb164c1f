from dataclasses import replace

import numpy as np
import pytest

from impactfem.coupling import restitution
from impactfem.stages.calibrate.experiment import WallExperiment
from impactfem.stages.calibrate.stick_run import compare, run_stick
from impactfem.sticks.stick import mass_on_spring
from impactfem.system.errors import ImpactfemError, SolutionError

M, K, OMEGA = 1e6, 4e11, 10.0
EXPERIMENT = WallExperiment((1,), 1, -0.02, 0.0, 0.9, 1e-5)


def run(xi, omega=OMEGA, **changes):
    """A mass on a spring that stands at its wall: ω is far below the Ω = 632 1/s of the contact."""
    stick = mass_on_spring("m", M, M * omega**2)
    return run_stick(stick, replace(EXPERIMENT, **changes), K=K, xi=xi)


def test_one_run_against_itself():
    same = compare(run(0.1), run(0.1), 1)
    assert (same.delay, same.rebound_overshoot) == (0.0, 0.0)
    assert (same.impulse_ratio, same.duration_ratio, same.approach_ratio) == (1.0, 1.0, 1.0)


def test_less_restitution_rebounds_less():
    """Behind the wall the mass swings by ε u̇⁻ / ω and is back after half a period."""
    damped, lively = 0.2, 0.05
    found = compare(run(damped), run(lively), 1)
    ratio = restitution.kelvin_voigt(damped) / restitution.kelvin_voigt(lively)
    assert found.rebound_overshoot == pytest.approx(ratio - 1.0, rel=1e-3)
    assert found.delay == pytest.approx(0.0, abs=1e-9)
    assert found.approach_ratio == pytest.approx(1.0, rel=1e-9)
    assert found.duration_ratio == pytest.approx(
        np.sqrt((1.0 - lively**2) / (1.0 - damped**2)), rel=1e-3
    )
    # Each impact is the one before it, smaller by ε; it comes half a period after it.
    second = found.stick.second
    assert second is not None
    assert second.start - found.stick.first_complete().end == pytest.approx(np.pi / OMEGA, rel=1e-3)
    assert found.second_impulse_ratio == pytest.approx(restitution.kelvin_voigt(damped), rel=2e-3)


def test_a_slower_stick_is_late():
    found = compare(run(0.1, omega=9.0), run(0.1), 1)
    assert found.delay == pytest.approx(np.pi / 2.0 * (1.0 / 9.0 - 1.0 / OMEGA), rel=1e-3)
    assert found.approach_ratio == pytest.approx(0.9, rel=1e-4)
    assert found.impulse_ratio == pytest.approx(0.9, rel=2e-3)
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
    assert found.stick.second is None and found.second_impulse_ratio == 0.0


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
    coarse = compare(run(0.1, time_step=2e-5), run(0.1), 1)
    assert coarse.delay == pytest.approx(0.0, abs=1e-6)
    assert coarse.impulse_ratio == pytest.approx(1.0, abs=1e-2)


def test_runs_that_do_not_compare():
    with pytest.raises(ImpactfemError, match="gaps of 0 and 1 mm"):
        compare(run(0.1), run(0.1, gap=0.001), 1)
    with pytest.raises(ImpactfemError, match="floor 2 is none of those that may hit the wall: 1"):
        compare(run(0.1), run(0.1), 2)
    far = run(0.1, gap=0.05)
    with pytest.raises(SolutionError, match="no impact: floor 1"):
        compare(far, far, 1)
