"""Buildings whose ground moves at different times, with and without impacts."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import trapezoid

from impactfem.coupling.ground import Ground
from impactfem.coupling.impacts import impacts, separations
from impactfem.coupling.laws import KelvinVoigt
from impactfem.coupling.pounding import End, Pair, System, simulate
from impactfem.sticks.stick import mass_on_spring
from impactfem.verify.soil import _half_space

from ..sticks.conftest import damped_stick

DT, STEPS = 1e-3, 3000
Y = np.array([0.0, 1.0, 0.0])


@pytest.fixture
def waves():
    """Ground motion along x and y, at rest at its end, later under b."""
    t = np.linspace(0.0, 1.0, 401)
    samples = np.sin(np.pi * t) ** 2 * np.sin(np.outer([13.0, 37.0], t)) * [[3.0], [6.0]]

    def make(delay, n_t=STEPS):
        motions = [(0, 5e-3, samples[0]), (1, 5e-3, samples[1])]
        return Ground.under(motions, DT, n_t, {"a": 0.0, "b": delay})

    return make


def towers(floors, gap, soil=None, second=1.0):
    """Two sticks of two floors, the roofs a gap apart along y; the second one stiffer or softer."""
    a, b = (damped_stick(name, floors(2), soil=soil) for name in "ab")
    b = replace(b, K=second * b.K, damping=None)
    law = KelvinVoigt(1e8, 0.1, mass=1e4)
    pair = Pair("a-b", End.of_floor(a, 2), End.of_floor(b, 2), Y, gap, law)
    return System((a, b), (pair,))


@pytest.mark.parametrize("on_soil", [False, True])
def test_equal_buildings_repeat_each_other(floors, waves, on_soil):
    """A delay of 20 steps: the second does what the first did then; not a step more or less."""
    soil = _half_space(200.0, 0.0) if on_soil else None
    response = simulate(towers(floors, 1.0, soil), waves(20 * DT), DT)
    u = response.deformation("u")
    a, b = (u[:, columns] for columns in (slice(0, 12), slice(12, 24)))
    assert b[20:] == pytest.approx(a[:-20], abs=1e-11 * np.abs(a).max())
    assert np.abs(b[21:] - a[:-21]).max() > 1e-3 * np.abs(a).max()
    assert response.absolute_acceleration[20:, 12:] == pytest.approx(
        response.absolute_acceleration[:-20, :12], abs=1e-9
    )
    assert response.energy.residual < 1e-10
    # The distance is that of the places, the ground under them included.
    moved = waves(20 * DT).relative["b"][0][:, 1]
    assert response.gap[:, 0] - 1.0 == pytest.approx(
        (b - a)[:, 7] + moved + (0.0 if not on_soil else _rigid(response)), abs=1e-12
    )


def _rigid(response):
    """What the motions of the bases on soil open the gap at the roof."""
    b, a = (response.bases[name].u @ response.system.stick(name).rigid_body()[7] for name in "ba")
    return b - a


def test_a_wall_moves_with_the_ground_under_its_building(floors, waves):
    """The second building meets one as the first one does alone, 20 steps earlier."""
    system = towers(floors, 1.0)
    a, b = system.sticks
    law = system.pairs[0].law
    at_a, at_b = (Pair("wall", End.of_floor(one, 2), None, Y, 1e-3, law) for one in (a, b))
    alone = simulate(System((a,), (at_a,)), waves(0.0), DT)
    later = simulate(System((a, b), (at_b,)), waves(20 * DT), DT)
    assert alone.force.any() and later.energy.residual < 1e-10
    for name, size in {"force": 1e-8, "gap": 1e-12, "gap_rate": 1e-10}.items():
        found, expected = (getattr(one, name) for one in (later, alone))
        assert found[20:] == pytest.approx(expected[:-20], abs=size * max(1.0, expected.max()))
        assert np.abs(found - expected).max() > 1e-3 * np.abs(expected).max()


def test_without_delay_nothing_changes(floors, waves):
    ground = waves(0.0)
    assert not ground.relative
    plain, passed = (
        simulate(towers(floors, 2e-3, second=0.8), given, DT)
        for given in (ground.acceleration, ground)
    )
    assert plain.force.any() and np.array_equal(plain.u, passed.u)
    # A hundredth of a microsecond changes next to nothing, and 2 ms a lot.
    little, much = (
        simulate(towers(floors, 2e-3, second=0.8), waves(delay), DT) for delay in (1e-8, 2e-3)
    )
    size = np.abs(plain.u).max()
    assert np.abs(little.u - plain.u).max() < 1e-4 * size < np.abs(much.u - plain.u).max()


def test_energy_and_momentum_with_impacts(floors, waves):
    """Balance at each step; forces on a mass are what its absolute momentum changes by."""
    system = towers(floors, 2e-3, second=0.8)
    response = simulate(system, waves(0.0137), DT)
    assert len(impacts(response)) > 3
    assert response.energy.residual < 1e-10
    # The force is that of the law with the speed at which the ground closes the gap, too.
    law, p, rate = system.pairs[0].law, -response.gap[:, 0], response.gap_rate[:, 0]
    closed = np.flatnonzero(response.force[:, 0])
    by_law = [law.at(p[t], -rate[t], (0.0,))[0] for t in closed]
    assert response.force[closed, 0] == pytest.approx(by_law, rel=1e-6, abs=1e-3)
    far = simulate(system.without_contact(), waves(0.0137), DT)
    (one,) = separations(far, response)
    assert one.required > 2e-3 and one.required == pytest.approx(far.closed(system.pairs).max())
    a_g = response.ground + waves(0.0137).relative["b"][2]
    held = response.deformation("u") @ system.K + response.deformation("v") @ system.C
    pushed = response.force[:, 0] - held[:, 12 + 7]
    velocity = response.deformation("v")[-1, 12 + 7] + trapezoid(a_g[:, 1], dx=DT)
    mass = system.M[12 + 7, 12 + 7]
    assert trapezoid(pushed, dx=DT) == pytest.approx(mass * velocity, rel=1e-9)


def test_masses_that_nothing_holds_stay_where_they_are(waves):
    """Relative to the ground under the first they go as much as it does; b does, too."""
    masses = [mass_on_spring(name, 1e3, 0.0) for name in "ab"]
    ground = waves(0.0137)
    response = simulate(System(tuple(masses), ()), ground, DT)
    first = Ground.under([(1, DT, ground.acceleration[:, 1])], DT, STEPS, {"a": 0.0, "b": 1e9})
    place = first.relative["b"][0][:, 1]  # of ground that never moves, from the first
    for column in (1, 7):
        assert response.u[:, column] == pytest.approx(place, abs=1e-4 * np.abs(place).max())
    # Relative to the ground under itself b goes elsewhere.
    assert np.abs(ground.relative["b"][0][:, 1]).max() > 0.1 * np.abs(place).max()
