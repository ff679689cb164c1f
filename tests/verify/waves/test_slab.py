from dataclasses import replace

import numpy as np
import pytest

from impactfem.building.shell_model import UX, UY
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction import response
from impactfem.verify.waves import MovingModel, ReducedMotion, frame, slab


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

    def stiff(right, self, model, loads, probes):
        K = model.K.tolil()
        K[probes[1], probes[1]] += 1e12
        right(self, replace(model, K=K.tocsr()), loads, probes)

    wrong(MovingModel, "__init__", stiff)
    found = failed(slab.slab_strip_impact())
    assert "first peak of the velocity, far edge over the wave's, full" in found
    assert "displacement of the far edge at the end, reduced" in found


def test_another_mean_is_not_reciprocal(wrong, failed):
    def uneven(right):
        made = right()
        return replace(made, weights=made.weights * np.linspace(0.8, 1.2, made.weights.shape[1]))

    wrong(frame, "shipped_frame", uneven)
    quantity = "acceleration of edge 2 by a pulse on edge 1 from the reverse"
    assert {f"{quantity}, full", f"{quantity}, reduced"} <= failed(frame.reciprocity())


def test_a_response_that_is_not_linear_is_seen(wrong, failed):
    def stiffening(right, *given):
        history = right(*given)
        motion = {k: v * (1.0 - 1e-7 * np.abs(v / v.max())) for k, v in history.motion.items()}
        return replace(history, motion=motion)

    wrong(MovingModel, "full", stiffening)
    assert failed(frame.superposition()) == {
        f"{name} under all loads from the sum over each, full"
        for name in ("displacement", "acceleration")
    }


@pytest.mark.parametrize("factor", [0.25, 20.0])
def test_too_narrow_or_too_wide_a_band(factor, monkeypatch, failed):
    monkeypatch.setattr(frame, "BASES", (66, 90))
    monkeypatch.setitem(response.SAFETY, response.LARGER, factor * response.SAFETY[response.LARGER])
    assert any(quantity.startswith("share of") for quantity in failed(frame.error_band()))


def test_reduced_model_of_another_damping(wrong, failed, monkeypatch):
    """An error that is in all reduced models is not told by their differences."""
    monkeypatch.setattr(frame, "BASES", (66, 90))

    def stiffer(right, self, amplitudes, time_step, damping, scheme):
        other = Rayleigh(damping.alpha, 1.02 * damping.beta)
        return right(self, amplitudes, time_step, other, scheme)

    wrong(ReducedMotion, "motion", stiffer)
    assert any(quantity.startswith("share of") for quantity in failed(frame.error_band()))
