from dataclasses import replace

import numpy as np
import pytest

from impactfem.sticks.contact import kelvin_voigt
from impactfem.sticks.impacts import impacts
from impactfem.sticks.pounding import simulate
from impactfem.verify.models import against_wall, collision, mass_on_spring

M, K, V0 = 1.5e6, 1e11, 0.3
KINETIC = 0.5 * M * V0**2


def hit(xi, steps, *, phase=0.3, tension=True):
    """Two masses of 2 M, so that M is their effective mass."""
    law = kelvin_voigt(K, xi, M, tension=tension)
    return collision(law, 2 * M, 2 * M, V0, law.duration(V0) / steps, phase=phase)


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


def test_without_tension_the_force_ends_earlier():
    response = hit(0.12, 1000.3, tension=False)
    (impact,) = impacts(response)
    pulling = hit(0.12, 1000.3)
    assert response.force.min() == 0.0 > pulling.force.min()
    # At the phase θ, tan θ = 2 ξ √(1 - ξ²)/(2 ξ² - 1), of π.
    theta = np.arctan2(2 * 0.12 * np.sqrt(1 - 0.12**2), 2 * 0.12**2 - 1)
    full = impacts(pulling)[0].duration
    assert impact.duration == pytest.approx(full * theta / np.pi, rel=3e-3)
    assert impact.restitution == pytest.approx(response.system.pairs[0].law.epsilon, rel=2e-3)


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


def test_defect_of_kelvin_voigt_vanishes_with_the_step():
    coarse, fine = (
        max(abs(impacts(hit(0.12, steps, phase=phase))[0].defect) for phase in (0.2, 0.5, 0.8))
        for steps in (16.3, 1600.3)
    )
    assert fine < 0.02 * coarse and fine < 1e-3 * KINETIC
    # A dashpot that moves faster than the work says would have taken more than was lost.
    response = hit(0.12, 1600.3)
    (sound,) = impacts(response)
    (faster,) = impacts(replace(response, v=1.1 * response.v))
    assert abs(sound.defect) < 1e-3 * KINETIC
    assert faster.defect < -0.09 * sound.dissipated


def test_defect_counts_the_time_of_contact_only():
    # Over the place in the step where the gap closes it is first order with a mean of about zero;
    # whole steps, or none of the ones in which it begins and ends, would shift it by its size.
    places = np.linspace(0.05, 0.95, 19)
    defects = np.array([impacts(hit(0.12, 16.3, phase=phase))[0].defect for phase in places])
    assert abs(defects.mean()) < 0.2 * np.abs(defects).mean()
    assert defects.min() < 0.0 < defects.max()


def test_nothing_touches():
    wall = against_wall(mass_on_spring("m", M, 0.0), kelvin_voigt(K, 0.1, M), 1.0, V0, 1e-3, 100)
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
