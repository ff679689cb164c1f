from dataclasses import replace

import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction import response
from impactfem.verify.waves import MovingModel, ReducedMotion, frame


def test_another_mean_is_not_reciprocal(wrong, failed):
    def make(right):
        made = right()
        uneven = made.weights * np.linspace(0.8, 1.2, made.weights.shape[1])
        return lambda: replace(made, weights=uneven)

    wrong(frame, "shipped_frame", make)
    quantity = "acceleration of edge 2 by a pulse on edge 1 from the reverse"
    assert {f"{quantity}, full", f"{quantity}, reduced"} <= failed(frame.reciprocity())


def test_a_response_that_is_not_linear_is_seen(wrong, failed):
    def make(right):
        def stiffening(self, loads, *others):
            history = right(self, loads, *others)
            motion = {k: v * (1.0 - 1e-7 * np.abs(v / v.max())) for k, v in history.motion.items()}
            return replace(history, motion=motion)

        return stiffening

    wrong(MovingModel, "full", make)
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

    def make(right):
        def stiffer(self, amplitudes, time_step, damping, scheme):
            other = Rayleigh(damping.alpha, 1.02 * damping.beta)
            return right(self, amplitudes, time_step, other, scheme)

        return stiffer

    wrong(ReducedMotion, "motion", make)
    assert any(quantity.startswith("share of") for quantity in failed(frame.error_band()))
