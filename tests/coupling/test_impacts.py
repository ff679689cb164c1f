from dataclasses import replace

import numpy as np
import pytest

from impactfem.coupling.impacts import FORCE_BAND, impacts, low_passed
from impactfem.coupling.laws import Hertz, HertzDamp, HuntCrossley, Jankowski, KelvinVoigt
from impactfem.coupling.pounding import System, simulate
from impactfem.sticks.stick import mass_on_spring
from impactfem.verify.contact import against_wall, collision

M, K, V0 = 1.5e6, 1e11, 0.3
KINETIC = 0.5 * M * V0**2


def hit(xi, steps, *, phase=0.3, tension=True, update="implicit", law=None):
    """Two masses of 2 M, so that M is their effective mass."""
    law = law or KelvinVoigt(K, xi, mass=M, tension=tension)
    dt = law.duration(V0) / steps
    return collision(law, 2 * M, 2 * M, V0, dt, phase=phase, update=update)


def until(response, last):
    """The response cut off after an index."""
    cut = slice(0, last + 1)
    fields = ("u", "v", "force", "ground")
    return replace(response, **{name: getattr(response, name)[cut] for name in fields})


@pytest.mark.parametrize("tension", [True, False])
@pytest.mark.parametrize("steps", [16.3, 1000.3])
def test_impulse_is_the_change_of_momentum(steps, tension):
    response = hit(0.12, steps, tension=tension)
    (impact,) = impacts(response)
    change = 2 * M * (response.v[-1, 7] - response.v[0, 7])
    assert impact.impulse == pytest.approx(change, rel=1e-12)
    assert impact.impulse == pytest.approx(M * V0 * (1 + impact.restitution), rel=1e-12)
    assert impact.impulse != pytest.approx(M * V0, rel=0.1)


def test_numbers_of_a_fine_impact():
    response = hit(0.12, 4000.3)
    (impact,) = impacts(response)
    law, dt = response.system.pairs[0].law, response.time_step
    assert impact.approach == pytest.approx(V0, rel=1e-12)
    assert impact.separation == pytest.approx(law.epsilon * V0, rel=1e-3)
    assert impact.restitution == impact.separation / impact.approach
    assert impact.duration == pytest.approx(law.duration(V0), rel=1e-5)
    assert impact.start == pytest.approx(0.3 * dt, rel=1e-2)
    assert impact.steps == np.count_nonzero(response.force) == impact.last - impact.first + 1
    assert impact.peak_force == response.force.max()
    assert impact.peak_time == response.time[np.argmax(response.force)]
    # Largest penetration v₀/Ω exp(-ξ φ/√(1 - ξ²)) with tan φ = √(1 - ξ²)/ξ.
    root = np.sqrt(1 - 0.12**2)
    depth = V0 / np.sqrt(K / M) * np.exp(-0.12 / root * np.arctan2(root, 0.12))
    assert impact.penetration == pytest.approx(depth, rel=1e-3)
    assert impact.pair is response.system.pairs[0] and impact.index == 0


@pytest.mark.parametrize("phase", [0.1, 0.5, 0.9])
def test_dissipated_is_the_loss_of_kinetic_energy(phase):
    response = hit(0.12, 16.3, phase=phase)
    (impact,) = impacts(response)
    lost = M * (V0**2 - response.v[-1, 1] ** 2 - response.v[-1, 7] ** 2)
    assert impact.dissipated == pytest.approx(lost, rel=1e-10)
    assert impact.dissipated == pytest.approx(KINETIC * (1 - impact.restitution**2), rel=1e-10)
    assert impact.dissipated > 0.4 * KINETIC


def test_defect_of_an_elastic_contact_is_all_that_is_lost():
    # No dashpot: what is lost or won, the time stepping did; positive when lost.
    found = [impacts(hit(0.0, 16.3, phase=phase))[0] for phase in np.linspace(0.05, 0.95, 19)]
    for impact in found:
        assert impact.defect == pytest.approx(impact.dissipated, rel=1e-12)
        assert (impact.defect > 0.0) == (impact.restitution < 1.0)
    defects = [impact.defect for impact in found]
    assert min(defects) < -1e-4 * KINETIC and max(defects) > 1e-4 * KINETIC


def test_a_dashpot_that_moves_faster_takes_more():
    """Than was lost by the work."""
    response = hit(0.12, 1600.3)
    (sound,) = impacts(response)
    (faster,) = impacts(replace(response, v=1.1 * response.v))
    assert abs(sound.defect) < 1e-3 * KINETIC
    assert faster.defect < -0.09 * sound.dissipated


def largest_defect(steps, phases=(0.2, 0.5, 0.8), **changes):
    """Over the kinetic energy."""
    found = [impacts(hit(steps=steps, phase=phase, **changes))[0].defect for phase in phases]
    return max(np.abs(found)) / KINETIC


LAWS = {
    "damped": KelvinVoigt(K, 0.12, mass=M),
    "elastic": KelvinVoigt(K, 0.0, mass=M),
    "elastic without tension": KelvinVoigt(K, 0.0, mass=M, tension=False),
    "damped without tension": KelvinVoigt(K, 0.12, mass=M, tension=False),
    "much damped without tension": KelvinVoigt(K, 0.6, mass=M, tension=False),
    "hertz": Hertz(1e12, mass=M),
    "hertz-damp": HertzDamp(1e12, 0.5, mass=M),
    "hunt-crossley": HuntCrossley(1e12, 0.5, mass=M),
    "jankowski": Jankowski(1e12, 0.7, mass=M),
}


@pytest.mark.parametrize("name", LAWS)
def test_defect_of_every_law_vanishes_with_the_step(name):
    law = LAWS[name]
    coarse, middle, fine = (largest_defect(n, xi=None, law=law) for n in (16.3, 160.3, 1600.3))
    assert middle < 0.15 * coarse and fine < 0.15 * middle and fine < 2e-3
    # What is lost by the law is no defect; the elastic ones lose nothing.
    (impact,) = impacts(hit(None, 1600.3, law=law))
    lost = impact.dissipated / KINETIC
    assert lost == pytest.approx(1.0 - law.epsilon**2, abs=2e-3)
    assert (lost > 0.2) == (law.epsilon < 1.0)


def test_defect_of_another_law_does_not_vanish():
    # The motion of a damped contact, looked at with the law without its damping: most is defect,
    # all but the spring's energy where the damped contact lets go.
    response = hit(0.12, 1600.3, tension=False)
    (sound,) = impacts(response)
    elastic = replace(response.system.pairs[0], law=LAWS["elastic without tension"])
    (other,) = impacts(replace(response, system=System(response.system.sticks, (elastic,))))
    assert abs(sound.defect) < 1e-3 * KINETIC
    left = 0.5 * K * response.gap[sound.last, 0] ** 2
    assert other.defect == pytest.approx(other.dissipated - left, rel=2e-3)
    assert other.defect > 0.4 * KINETIC


@pytest.mark.parametrize("steps", [16.3, 50.3, 200.3])
@pytest.mark.parametrize("phase", [0.2, 0.8])
def test_lagged_contact_shows_the_energy_that_it_creates(steps, phase):
    response = hit(0.0, steps, phase=phase, update="lagged")
    (impact,) = impacts(response)
    gain = M * (response.v[-1, 1] ** 2 + response.v[-1, 7] ** 2 - V0**2)
    assert gain > 0.04 * KINETIC
    assert impact.defect == pytest.approx(-gain, rel=1e-6)
    assert impact.restitution == pytest.approx(np.sqrt(1.0 + gain / KINETIC))
    (implicit,) = impacts(hit(0.0, steps, phase=phase))
    assert abs(implicit.defect) < 0.05 * gain


@pytest.mark.parametrize("phase", [0.1, 0.5, 0.9])
def test_a_lagged_impact_starts_where_the_gap_closed(phase):
    response = hit(0.12, 30.3, phase=phase, update="lagged")
    (impact,) = impacts(response)
    # The gap closes in the first step, the first force comes a step later.
    assert impact.first == 2 and response.gap[1, 0] < 0.0
    assert impact.start == pytest.approx(phase * response.time_step)
    assert impact.approach == pytest.approx(V0)
    assert impact.penetration > -response.gap[1, 0]


def test_defect_counts_the_time_of_contact_only():
    # Over the place in the step where the gap closes it is first order with a mean of about zero;
    # whole steps, or none of the ones in which it begins and ends, would shift it by its size.
    places = np.linspace(0.05, 0.95, 19)
    defects = np.array([impacts(hit(0.12, 16.3, phase=phase))[0].defect for phase in places])
    assert abs(defects.mean()) < 0.2 * np.abs(defects).mean()
    assert defects.min() < 0.0 < defects.max()


def test_a_contact_that_begins_at_rest_has_no_restitution():
    # A mass on a spring, at rest against a wall that the ground moves towards it.
    law, n_t = KelvinVoigt(1e9, 0.1, mass=1e3), 400
    at_rest = against_wall(mass_on_spring("m", 1e3, 1e5), law, 0.0, 0.0, 1e-4, n_t)
    ground = np.zeros((n_t, 3))
    ground[:, 1] = -2.0
    (impact, *_) = impacts(simulate(at_rest.system, ground, 1e-4))
    assert impact.approach == 0.0 and np.isnan(impact.restitution)
    assert impact.peak_force > 0.0
    assert replace(impact, approach=0.5, separation=0.2).restitution == pytest.approx(0.4)
    assert np.isnan(replace(impact, approach=-1e-9).restitution)


def test_nothing_touches():
    wall = against_wall(
        mass_on_spring("m", M, 0.0), KelvinVoigt(K, 0.1, mass=M), 1.0, V0, 1e-3, 100
    )
    assert impacts(wall) == []
    assert (
        impacts(replace(wall, system=wall.system.without_contact(), force=np.zeros((100, 0)))) == []
    )


def test_several_impacts_of_several_pairs_in_order(row, shake):
    response = simulate(row(0.001), shake(), 2.5e-4)
    found = impacts(response)
    assert len({impact.index for impact in found}) == 2
    starts = [impact.start for impact in found]
    assert len(found) > 2 and starts == sorted(starts)
    for impact in found:
        force = response.force[:, impact.index]
        assert np.all(force[impact.first : impact.last + 1] != 0.0)
        assert force[impact.first - 1] == 0.0 and not force[impact.last + 1 : impact.last + 2].any()
        assert response.gap[impact.first - 1, impact.index] > 0.0
        assert response.time[impact.first - 1] <= impact.start <= response.time[impact.first]
    assert sum(impact.steps for impact in found) == np.count_nonzero(response.force)


def test_an_impact_that_is_still_going_on():
    whole = hit(0.12, 100.3)
    (complete,) = impacts(whole)
    middle = complete.first + 40
    (impact,) = impacts(until(whole, middle))
    assert impact.last == middle and impact.end == whole.time[middle]
    assert impact.first == complete.first and impact.start == complete.start
    assert impact.steps == 41
    assert impact.duration == pytest.approx(0.4 * complete.duration, rel=0.02)
    assert impact.impulse < complete.impulse
    # They have not parted: the speed of separation is what there is at the end.
    assert impact.separation == pytest.approx(whole.gap_rate[middle, 0])


def test_an_impact_that_begins_in_the_last_step():
    whole = hit(0.12, 100.3)
    first = impacts(whole)[0].first
    (impact,) = impacts(until(whole, first))
    assert impact.first == impact.last == first and impact.steps == 1
    assert impact.approach == pytest.approx(V0) and impact.separation < 0.0
    assert 0.0 < impact.duration <= whole.time_step
    assert impact.impulse == pytest.approx(0.5 * whole.time_step * whole.force[first, 0])
    assert impacts(until(whole, first - 1)) == []


def test_a_contact_that_lets_go_and_presses_again_before_the_gap_opens():
    # Pushed at a wall by 1 N while it bounces: without tension the force is zero for a while.
    law = KelvinVoigt(1.0, 0.5, mass=1.0, tension=False)
    system = against_wall(mass_on_spring("m", 1.0, 0.0), law, 0.0, 0.0, 0.005, 2).system
    ground, v0 = np.zeros((4000, 3)), np.zeros(6)
    ground[:, 1], v0[1] = -1.0, 8.0
    response = simulate(system, ground, 0.005, v0=v0)
    found = impacts(response)
    assert len(found) == 2 and response.gap[1:, 0].max() < 0.0
    whole = 0.005 * response.force[:, 0].sum()
    assert sum(impact.impulse for impact in found) == pytest.approx(whole, rel=1e-3)
    assert found[1].start >= found[0].end


def test_the_low_pass_of_forces_keeps_impulse_and_sign():
    """At its corner an amplitude falls to 1/√2, whatever the time step is."""
    for dt in (1e-3, 1e-4):
        t = dt * np.arange(round(0.4 / dt))
        pulse = np.where(np.abs(t - 0.2) < 5e-4, 1e6, 0.0)[:, None]
        found = low_passed(pulse, dt)
        assert found.min() >= 0.0 and found.sum() == pytest.approx(pulse.sum(), rel=1e-6)
        wave = np.sin(2.0 * np.pi * FORCE_BAND * t)[:, None]
        inner = np.abs(t - 0.2) < 0.1
        amplitude = np.abs(low_passed(wave, dt)[inner]).max() / np.abs(wave).max()
        assert amplitude == pytest.approx(np.sqrt(0.5), rel=0.02)
        slow = np.sin(2.0 * np.pi * 5.0 * t)[:, None]
        assert np.abs(low_passed(slow, dt) - slow)[inner].max() < 2e-3


def test_the_force_in_the_band_is_that_of_the_impact():
    """Not above the peak, and that of a shorter pulse with the same impulse is not larger."""
    response = hit(0.0, 16.3)
    (impact,) = impacts(response)
    filtered = low_passed(response.force, response.time_step)[:, 0]
    assert impact.band_force == filtered[impact.first : impact.last + 1].max()
    assert 0.0 < impact.band_force < impact.peak_force
