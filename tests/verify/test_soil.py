"""The benchmarks of the ground see a wrong mass, period, impedance or delay."""

from dataclasses import replace

import pytest

from impactfem.coupling.ground import Ground
from impactfem.dynamics.impedance import Impedance
from impactfem.dynamics.soil import Soil
from impactfem.verify import soil


@pytest.mark.parametrize(
    ("of", "name", "altered", "run", "least"),
    [
        (Impedance, "matrices", lambda one: (1.0001 * one[0], *one[1:]), soil.soil_cones, 4),
        (
            Impedance,
            "scaled",
            lambda a: replace(a, stiffness=1.2 * a.stiffness),
            soil.soil_static,
            8,
        ),
        (Soil, "moved", lambda one: replace(one, K=1.00001 * one.K), soil.soil_period, 1),
    ],
)
def test_what_is_wrong_is_seen(wrong, failed, of, name, altered, run, least):
    wrong(of, name, lambda right, *arguments: altered(right(*arguments)))
    assert len(failed(run())) >= least


def test_wrong_dashpots_are_seen(monkeypatch, failed):
    """Soil whose dashpots take 10 % more than its impedance says."""
    made, right = soil._half_space(150.0, 0.03), soil._amplitudes
    monkeypatch.setattr(soil, "_half_space", lambda *_: replace(made, C=1.1 * made.C))
    monkeypatch.setattr(soil, "_amplitudes", lambda stick, _, ω: right(stick, made, ω))
    assert "amplitude of the raft" in failed(soil.soil_steady_state())


@pytest.mark.parametrize(
    ("row", "seen"),
    [(0, "first contact"), (1, "speed of approach"), (2, "amplitude of the distance")],
)
def test_ground_that_is_not_where_it_moves_is_seen(wrong, failed, row, seen):
    """A place, a speed or an acceleration of the later ground that is 2 % off."""

    def altered(right, *arguments):
        ground = right(*arguments)
        ground.relative["b"][row] *= 1.02
        return ground

    wrong(Ground, "under", altered)
    assert seen in failed(soil.wave_passage())
