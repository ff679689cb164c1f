from dataclasses import replace

import numpy as np
import pytest

from impactfem.building.shell_model import UX, UY
from impactfem.verify.waves import MovingModel, slab


def test_speeds_by_hand():
    """E = 33 GPa, ν = 0.2, ρ = 2500 kg/m3: the paper has 2345 m/s and 6.7 ms."""
    assert slab.SHEAR.speed == pytest.approx(2345.0, abs=0.5)
    assert slab.PLATE.speed == pytest.approx(3708.0, abs=0.5)
    assert pytest.approx(15.6) == slab.SECOND - slab.FIRST
    assert 15.6 / slab.SHEAR.speed == pytest.approx(6.7e-3, abs=0.05e-3)
    assert (slab.SHEAR.restrained, slab.PLATE.restrained) == (UX, UY)


def test_a_strip_with_free_long_edges_carries_other_waves(monkeypatch):
    """Stretched as a bar, √(E/ρ), 2 % slower; and bent instead of sheared."""
    monkeypatch.setattr(slab.Wave, "restrained", property(lambda self: 5))
    delay, _ = slab._pulse(slab.PLATE)
    speed = (slab.SECOND - slab.FIRST) / delay
    assert speed == pytest.approx(np.sqrt(33e9 / 2500.0), rel=0.005)
    assert abs(speed / slab.PLATE.speed - 1.0) > 0.015


def test_the_crossings_are_not_each_others():
    """A row that compared the plate wave with the paper's 6.7 ms would fail."""
    rows = {row.quantity: row for row in slab.slab_pulses()}
    normal = rows["time to cross 15.6 m, edge-normal pulse"]
    in_plane = rows["time to cross 15.6 m, in-plane shear pulse"]
    assert in_plane.reference == 6.7e-3 and "paper's crossing" in in_plane.source
    assert normal.computed < 0.65 * in_plane.reference


def test_a_held_far_edge_reflects_otherwise(wrong, failed):
    """A spring on the far edge, so stiff that it hardly moves."""

    def make(right):
        def stiff(self, model, loads, probes):
            K = model.K.tolil()
            K[probes[1], probes[1]] += 1e12
            right(self, replace(model, K=K.tocsr()), loads, probes)

        return stiff

    wrong(MovingModel, "__init__", make)
    found = failed(slab.slab_strip_impact())
    assert "first peak of the velocity, far edge over the wave's, full" in found
    assert "displacement of the far edge at the end, reduced" in found
