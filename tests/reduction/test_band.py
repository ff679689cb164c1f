"""The error band of the reduced model."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.band import (
    LARGER,
    SAFETY,
    SMALLER,
    Band,
    peak_difference,
    response_band,
    spectrum_difference,
)
from impactfem.reduction.effectivity import Effectivity, effectivity
from impactfem.reduction.response import NodeResponse, modal_histories, node_response, node_spectra

from ..stages.transient.conftest import TOLERANCE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from impactfem.case import Spectra
    from impactfem.reduction.loads import Loads
    from impactfem.reduction.reduced_basis import ReducedBasis
    from impactfem.stages.transient.full_run import FullRun

    from ..stages.transient.conftest import Frame

    Array = NDArray[np.float64]

LOOSE = 0.2


def test_largest_difference_around_a_frequency() -> None:
    frequency = 2.0 ** (np.arange(25) / 12.0)  # twelve an octave: two to either side in a third
    used = np.ones((2, 25))
    other = used.copy()
    other[0, 10], other[0, 20], other[1, 0] = 1.3, 0.6, 2.0
    found = spectrum_difference(used, [other], frequency, 1.0 / 3.0)
    expected = np.zeros((2, 25))
    expected[0, 8:13], expected[0, 18:23], expected[1, :3] = 0.3, 0.4, 1.0
    assert found == pytest.approx(expected, abs=1e-12)


def test_the_worst_of_several_models_counts() -> None:
    frequency = np.array([1.0, 10.0])
    used, others = np.zeros((1, 2)), [np.array([[1.0, 0.0]]), np.array([[0.5, -3.0]])]
    assert spectrum_difference(used, others, frequency, 1.0 / 3.0).tolist() == [[1.0, 3.0]]
    histories = [np.array([[0.0, 1.0], [2.0, -4.0]]), np.array([[-3.0, 0.0], [0.0, 0.0]])]
    assert peak_difference(np.zeros((2, 2)), histories).tolist() == [3.0, 4.0]


class Compared:
    """A basis against the full model, both by Newmark at the same step."""

    def __init__(
        self,
        frame: Frame,
        loads: Loads,
        full: FullRun,
        damping: Rayleigh,
        spectra: Spectra,
        basis: ReducedBasis,
    ) -> None:
        self.case = basis, loads, damping, frame.nodes
        self.shown = spectra
        self.frequency = np.array(spectra.frequency_values)
        history = modal_histories(basis, loads, damping, scheme="newmark")
        self.response: NodeResponse = node_response(basis, history, loads, frame.nodes)
        self.psa: Array = node_spectra(self.response, spectra).psa
        self.truth: Array = node_spectra(full.response, spectra).psa
        self.apart: Array = np.abs(self.response.acceleration - full.response.acceleration)

    def band(self, kind: str = LARGER) -> Band:
        return response_band(
            *self.case, self.response, self.psa, self.shown, kind=kind, scheme="newmark"
        )

    def effectivity(self, kind: str = LARGER, factor: float = 1.0) -> Effectivity:
        """Of the band, with the spectra multiplied by a factor."""
        band = self.band(kind).psa[0]
        return effectivity(band, factor * self.psa[0], self.truth[0], self.frequency)


@pytest.mark.parametrize("tolerance", [LOOSE, TOLERANCE])
@pytest.mark.parametrize("name", ["the case's", "light"])
def test_band_is_the_error_to_within_a_factor(
    frame: Frame,
    loads: Loads,
    full_runs: dict[str, tuple[tuple[float, float], FullRun]],
    spectra: Spectra,
    name: str,
    tolerance: float,
) -> None:
    """Between 1 and 10 times at 95 % of all thirds of octaves; the safety factor is needed.

    So on accelerations, at any time.
    """
    damping, full = full_runs[name]
    basis = frame.basis(loads, tolerance=tolerance, larger=True)
    compared = Compared(frame, loads, full, damping, spectra, basis)
    found = compared.effectivity()
    assert found.good >= 0.95, found.misses
    largest = compared.apart.max(axis=0)
    told = largest > 1e-4 * np.abs(full.response.acceleration).max(axis=0)
    ratio = compared.band().acceleration[told] / largest[told]
    assert np.all((ratio >= 1.0) & (ratio <= 10.0))
    if name == "light":
        assert len(found.ratio) > 50
        # Smaller models tell their own error; without a safety factor much would be missed.
        assert compared.effectivity(SMALLER).good < 0.8
        assert np.mean(found.ratio < SAFETY[LARGER]) > 0.1
        # A band around wrong spectra does not hold what they lack.
        assert compared.effectivity(factor=1.05).held < 0.3


def test_band_grows_where_vectors_are_missing(
    frame: Frame,
    loads: Loads,
    full_runs: dict[str, tuple[tuple[float, float], FullRun]],
    spectra: Spectra,
) -> None:
    damping, full = full_runs["light"]
    fine, coarse = (
        Compared(
            frame,
            loads,
            full,
            damping,
            spectra,
            frame.basis(loads, tolerance=tolerance, larger=True),
        )
        for tolerance in (TOLERANCE, LOOSE)
    )
    assert np.median(coarse.band().psa / fine.band().psa) > 3.0
    assert coarse.effectivity().held >= 0.95


def test_basis_without_larger_models(
    frame: Frame, loads: Loads, basis: ReducedBasis, spectra: Spectra
) -> None:
    response = node_response(basis, modal_histories(basis, loads, frame.light), loads, frame.nodes)
    psa = node_spectra(response, spectra).psa
    case = basis, loads, frame.light, frame.nodes, response, psa, spectra
    with pytest.raises(ValueError, match="a basis without larger models"):
        response_band(*case)
    assert response_band(*case, kind=SMALLER).psa.shape == psa.shape
    alone = replace(basis, models=basis.models[:1])
    with pytest.raises(ValueError, match="a basis without smaller models"):
        response_band(alone, *case[1:], kind=SMALLER)
