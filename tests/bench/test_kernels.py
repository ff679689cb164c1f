import numpy as np
import pytest

from bench.kernels import filtered, plain_peaks, spectrum_figures
from impactfem.spectra import oscillator_response
from impactfem.spectra.oscillator import step_coefficients
from impactfem.spectra.peaks import peak_responses

FREQUENCIES = [2.0, 20.0, 70.0]


@pytest.fixture
def record():
    # Silent at both ends: nothing happens at the first sample, and no peak comes behind the last.
    return np.random.default_rng(0).standard_normal(400) * np.sin(np.linspace(0, np.pi, 400)) ** 4


def test_the_three_find_the_same_peaks(record):
    c = step_coefficients(0.01, FREQUENCIES, [0.05])
    exact = oscillator_response(record, 0.01, FREQUENCIES, [0.05]).relative_displacement[0]
    peaks = np.abs(exact).max(axis=1)
    assert peak_responses(record[None], c, absolute=False)[0][0] == pytest.approx(peaks, rel=1e-12)
    assert plain_peaks(record[None], c)[0] == pytest.approx(peaks, rel=1e-12)
    histories = np.array(filtered(record[None], c))[:, 0]
    assert np.abs(histories - exact).max() < 1e-10 * peaks.max()


def test_rates_are_rates():
    figures = {f.name: f.value for f in spectrum_figures(1, 200, 31, repeats=1)}
    assert min(figures.values()) > 0.0
    kernel, plain, library, over_plain, over_library = figures.values()
    assert over_plain == pytest.approx(kernel / plain)
    assert over_library == pytest.approx(kernel / library)
