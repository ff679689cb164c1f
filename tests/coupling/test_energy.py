import numpy as np
import pytest

from impactfem.coupling.impacts import impacts
from impactfem.coupling.laws import Hertz, HertzDamp, HuntCrossley, Jankowski
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
    assert response.energy.residual < 1e-11


@pytest.mark.parametrize(
    "law",
    [
        Hertz(5e11, mass=120e3),
        HertzDamp(5e11, 0.6, mass=120e3),
        HuntCrossley(5e11, 0.6, mass=120e3, relation="exact"),
        # With a restitution near 1: see the barely closed gap in test_implicit.
        Jankowski(5e11, 0.9, mass=120e3),
    ],
    ids=lambda law: law.name,
)
def test_identity_with_the_laws_after_hertz(row, shake, law):
    response = simulate(row(0.003, x=2.0, law=law), shake(components=(0, 1)), DT)
    assert len(impacts(response)) > 1 and response.force.min() == 0.0
    balance = response.energy
    assert balance.residual < 1e-11
    taken = -balance.contact[-1] / np.max(balance.kinetic)
    assert (taken > 1e-3) == (law.epsilon < 1.0)


def test_energies_are_those_of_the_histories(pounding):
    """The sums of the loop, of coordinates, against the matrices and histories of all masters."""
    system, u, v, F = pounding.system, pounding.u, pounding.v, pounding.force
    w, f = v[:-1] + v[1:], pounding.external
    summed = {
        "damped": DT / 4.0 * np.einsum("ti,ij,tj->t", w, system.C, w),
        "input": 0.5 * np.sum(np.diff(u, axis=0) * (f[:-1] + f[1:]), axis=1),
        "contact": 0.5 * np.sum(np.diff(pounding.gap, axis=0) * (F[:-1] + F[1:]), axis=1),
    }
    expected = {name: np.append(0.0, np.cumsum(steps)) for name, steps in summed.items()}
    expected["kinetic"] = 0.5 * np.einsum("ti,ij,tj->t", v, system.M, v)
    expected["elastic"] = 0.5 * np.einsum("ti,ij,tj->t", u, system.K, u)
    for name, values in expected.items():
        found = getattr(pounding.energy, name)
        assert np.abs(found - values).max() < 1e-10 * np.abs(values).max() > 0.0, name


def test_nothing_moves():
    response = simulate(System((mass_on_spring("m", 1.0, 1.0),), ()), np.zeros((5, 3)), 1.0)
    assert response.u.shape == (5, 6) and not response.u.any() and not response.v.any()
    assert response.energy.residual == 0.0


def test_contact_work_is_the_sum_over_the_impacts(pounding):
    found = impacts(pounding)
    assert len(found) > 1
    taken = -sum(impact.dissipated for impact in found)
    assert pounding.energy.contact[-1] == pytest.approx(taken, rel=1e-9)
