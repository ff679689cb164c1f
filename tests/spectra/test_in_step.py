import numpy as np
import pytest

from impactfem.spectra.in_step import in_step_peak_responses
from impactfem.spectra.peaks import peak_responses
from impactfem.spectra.recurrence import step_coefficients

H = 0.01
FREQUENCIES = [0.02, 1.0, 20.0, 49.0, 130.0, 300.0]  # Nyquist is 50 Hz
DAMPINGS = [0.0, 0.05, 0.6]


@pytest.fixture(scope="module")
def record():
    return np.random.default_rng(5).standard_normal((2, 80))


def test_equals_the_limit_of_ever_finer_straight_lines(record):
    fine = 500
    t = np.arange(79 * fine + 1) * H / fine
    cut = np.array([np.interp(t, np.arange(80) * H, row) for row in record])
    limit = peak_responses(cut, step_coefficients(H / fine, FREQUENCIES, DAMPINGS))
    exact = in_step_peak_responses(record, step_coefficients(H, FREQUENCIES, DAMPINGS))
    for peak, sampled in zip(exact, limit, strict=True):
        assert np.all(peak >= sampled * (1 - 1e-10))
        assert np.all(peak <= sampled * (1 + 2e-4))  # 1 - cos(π/ppc), 167 points at 300 Hz


def test_samples_alone_would_lose_the_peaks(record):
    c = step_coefficients(H, FREQUENCIES, DAMPINGS)
    exact, sampled = in_step_peak_responses(record, c), peak_responses(record, c)
    assert np.all(exact[0] >= sampled[0] * (1 - 1e-12))
    assert np.max(exact[0] / sampled[0]) > 1.2


def test_step_of_the_base_reaches_twice_the_static_value():
    # Undamped, constant base acceleration: max |x| = 2 a / ω², at half a period, between samples.
    a = np.full((1, 20), 3.0)
    c = step_coefficients(0.1, [0.8, 3.7, 41.0], [0.0])
    sd, sa = in_step_peak_responses(a, c)
    assert sd[0] == pytest.approx(6.0 / c.omega**2, rel=1e-12)
    assert sa[0] == pytest.approx(6.0, rel=1e-12)


def test_very_small_steps_keep_their_digits():
    # ωh = 6e-7: x follows the base alone, max |x| = |∬ a|.
    a = np.array([[0.0, 1.0, 2.0, 1.0, 0.0, -1.0, -2.0, -1.0, 0.0]])
    sd, _ = in_step_peak_responses(a, step_coefficients(1e-3, [1e-4], [0.0]))
    velocity = np.concatenate([[0.0], np.cumsum((a[0, 1:] + a[0, :-1]) / 2)]) * 1e-3
    displacement = np.sum((velocity[1:] + velocity[:-1]) / 2) * 1e-3
    assert sd[0, 0] == pytest.approx(displacement, rel=1e-5)
