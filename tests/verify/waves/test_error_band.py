"""The benchmark of the error band, and with bands that are wrong."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction import band
from impactfem.verify.waves import error_band
from impactfem.verify.waves.shell_motion import ReducedMotion

Failed = Callable[[list[Any]], set[str]]


def test_band_is_one_to_ten_times_the_error(failed: Failed) -> None:
    rows = error_band.band_on_frame()
    assert failed(rows) == set()
    assert 0.95 <= rows[0].computed < 1.0


@pytest.mark.parametrize("factor", [0.25, 20.0])
def test_too_narrow_or_too_wide_a_band(
    factor: float, monkeypatch: pytest.MonkeyPatch, failed: Failed
) -> None:
    monkeypatch.setitem(band.SAFETY, band.LARGER, factor * band.SAFETY[band.LARGER])
    (quantity,) = failed(error_band.band_on_frame())
    assert quantity.startswith("share of")


def test_reduced_model_of_another_damping(monkeypatch: pytest.MonkeyPatch, failed: Failed) -> None:
    """An error that is in all reduced models is not told by their differences."""
    right = ReducedMotion.motion

    def wrong(self: Any, amplitudes: Any, time_step: float, damping: Any, scheme: str) -> Any:
        other = Rayleigh(damping.alpha, 1.02 * damping.beta)
        return right(self, amplitudes, time_step, other, scheme)

    monkeypatch.setattr(ReducedMotion, "motion", wrong)
    assert any(quantity.startswith("share of") for quantity in failed(error_band.band_on_frame()))
