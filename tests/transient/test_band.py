"""The error band of the reduced model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from impactfem.dynamics.error_band import SAFETY
from impactfem.transient.band import peak_band, spectrum_band
from impactfem.transient.response import modal_histories, node_response, node_spectra

from .conftest import TOLERANCE

if TYPE_CHECKING:
    from impactfem.case import Spectra
    from impactfem.transient.full_run import FullRun
    from impactfem.transient.loads import Loads

    from .conftest import Frame


def test_largest_difference_within_a_third_of_an_octave() -> None:
    frequency = 2.0 ** (np.arange(25) / 12.0)  # twelve an octave: two to either side count
    fine = np.ones((2, 25))
    coarse = fine.copy()
    coarse[0, 10], coarse[0, 20], coarse[1, 0] = 1.3, 0.6, 2.0
    band = spectrum_band(fine, [coarse], frequency) / SAFETY
    expected = np.zeros((2, 25))
    expected[0, 8:13], expected[0, 18:23], expected[1, :3] = 0.3, 0.4, 1.0
    assert band == pytest.approx(expected, abs=1e-12)


def test_the_worst_of_several_models_counts() -> None:
    frequency = np.array([1.0, 10.0])
    fine, others = np.zeros((1, 2)), [np.array([[1.0, 0.0]]), np.array([[0.5, -3.0]])]
    assert (spectrum_band(fine, others, frequency) / SAFETY).tolist() == [[1.0, 3.0]]
    histories = [np.array([[0.0, 1.0], [2.0, -4.0]]), np.array([[-3.0, 0.0], [0.0, 0.0]])]
    assert (peak_band(np.zeros((2, 2)), histories) / SAFETY).tolist() == [3.0, 4.0]


@pytest.mark.parametrize("tolerance", [0.1, TOLERANCE])
@pytest.mark.parametrize("name", ["the case's", "light"])
def test_band_holds_the_true_error(
    frame: Frame,
    loads: Loads,
    full_runs: dict[str, tuple[tuple[float, float], FullRun]],
    spectra: Spectra,
    name: str,
    tolerance: float,
) -> None:
    """Maxima within thirds of an octave, where the error is above 0.01 % of the spectrum.

    The band holds the error. It is often more than ten times as wide: this frame has few modes, and
    its basis converges at a stroke where it has them all.
    """
    damping, full = full_runs[name]
    basis = frame.basis(loads, damping=damping, tolerance=tolerance)
    responses = [
        node_response(
            basis,
            modal_histories(basis, loads, damping, scheme="newmark", model=model),
            loads,
            frame.nodes,
            model=model,
        )
        for model in basis.models
    ]
    known = node_spectra(full.response, spectra).psa[0]
    fine, *coarser = (node_spectra(response, spectra).psa[0] for response in responses)
    frequency = np.array(spectra.frequency_values)
    thirds = np.round(3.0 * np.log2(frequency / 1e3))
    band, error, truth = (
        np.array([values[:, thirds == third].max(axis=1) for third in np.unique(thirds)])
        for values in (spectrum_band(fine, coarser, frequency), np.abs(fine - known), known)
    )
    told = error > 1e-4 * truth
    effectivity = band[told] / error[told]
    assert np.mean(effectivity >= 1.0) >= 0.99
    assert np.median(effectivity) < 50.0
    if tolerance > TOLERANCE:
        assert told.sum() > 100 and (error / truth).max() > 1e-3
    peaks = peak_band(responses[0].acceleration, [r.acceleration for r in responses[1:]])
    apart = np.abs(
        np.abs(responses[0].acceleration).max(axis=0)
        - np.abs(full.response.acceleration).max(axis=0)
    )
    assert np.mean(apart <= peaks) >= 0.95
