from dataclasses import replace

import numpy as np
import pytest

from impactfem.coupling.contact import hertz, hertz_damp, hunt_crossley, jankowski
from impactfem.coupling.energy import EnergyBalance, energy_balance
from impactfem.coupling.impacts import impacts
from impactfem.coupling.pounding import System, simulate
from impactfem.sticks.stick import mass_on_spring

DT = 2.5e-4


@pytest.fixture(scope="module")
def pounding(row, shake):
    return simulate(row(0.003, x=2.0), shake(components=(0, 1, 2)), DT)


@pytest.mark.parametrize("update", ["implicit", "lagged"])
@pytest.mark.parametrize("tension", [True, False])
def test_identity_with_impacts(row, shake, update, tension):
    system = row(0.003, x=2.0, tension=tension)
    response = simulate(system, shake(components=(0, 1)), DT, update=update)
    assert response.force.any()
    assert energy_balance(response).residual < 1e-11


@pytest.mark.parametrize(
    "law",
    [
        hertz(5e11, 120e3),
        hertz_damp(5e11, 0.6, 120e3),
        hunt_crossley(5e11, 0.6, 120e3, exact=True),
        # With a restitution near 1: see the barely closed gap in test_newmark.
        jankowski(5e11, 0.9, 120e3),
    ],
    ids=lambda law: law.name,
)
def test_identity_with_the_laws_after_hertz(row, shake, law):
    response = simulate(row(0.003, x=2.0, law=law), shake(components=(0, 1)), DT)
    found = impacts(response)
    assert len(found) > 1 and response.force.min() == 0.0
    balance = energy_balance(response)
    assert balance.residual < 1e-11
    taken = -balance.contact[-1] / np.max(balance.kinetic)
    assert (taken > 1e-3) == (law.epsilon < 1.0)


def test_a_corrupted_response_violates_it(pounding):
    sound = energy_balance(pounding).residual
    step = int(np.argmax(pounding.force[:, 1]))
    for name, index, factor in (("force", (step, 1), 1.01), ("v", (step, 7), 1.001)):
        values = getattr(pounding, name).copy()
        values[index] *= factor
        assert energy_balance(replace(pounding, **{name: values})).residual > 1e4 * sound
    assert energy_balance(replace(pounding, time_step=1.01 * DT)).residual > 1e-4


def test_terms_of_an_oscillator_in_closed_form():
    # From 0.2 m at rest, damped: what is not stored any more was damped, and nothing came in.
    m, k = 10.0, 10.0 * 5.0**2
    system = System((mass_on_spring("m", m, k, dashpot=20.0),), ())
    u0 = np.zeros(6)
    u0[1] = 0.2
    energy = energy_balance(simulate(system, np.zeros((20001, 3)), 1e-3, u0=u0))
    assert energy.elastic[0] == pytest.approx(0.5 * k * 0.04) and energy.kinetic[0] == 0.0
    assert energy.damped[-1] == pytest.approx(energy.elastic[0], rel=1e-9)
    assert np.all(np.diff(energy.damped) >= 0.0)
    assert not energy.input.any() and not energy.contact.any()
    assert energy.residual < 1e-12
    stored = energy.kinetic + energy.elastic
    assert stored[-1] < 1e-9 * stored[0]


def test_input_is_the_work_of_the_ground():
    # A free mass on ground with constant acceleration a: v = -a t, input ½ m (a t)².
    system = System((mass_on_spring("m", 3.0, 0.0),), ())
    ground = np.tile([0.0, 2.0, 0.0], (101, 1))
    energy = energy_balance(simulate(system, ground, 0.01))
    assert energy.input[-1] == pytest.approx(0.5 * 3.0 * 2.0**2)
    assert energy.kinetic == pytest.approx(energy.input, rel=1e-12)


def test_contact_work_is_the_sum_over_the_impacts(pounding):
    found = impacts(pounding)
    assert len(found) > 1
    taken = -sum(impact.dissipated for impact in found)
    assert energy_balance(pounding).contact[-1] == pytest.approx(taken, rel=1e-9)


def test_nothing_moves():
    energy = energy_balance(
        simulate(System((mass_on_spring("m", 1.0, 1.0),), ()), np.zeros((5, 3)), 1.0)
    )
    assert energy.residual == 0.0


def test_residual_by_hand():
    zero, one = np.zeros(2), np.array([0.0, 1.0])
    balanced = EnergyBalance(
        kinetic=0.5 * one, elastic=zero, damped=0.25 * one, input=one, contact=-0.25 * one
    )
    assert balanced.residual == pytest.approx(0.0)
    assert replace(balanced, contact=zero).residual == pytest.approx(0.25)
    assert replace(balanced, damped=zero, input=4 * one).residual == pytest.approx(3.25 / 4.0)
