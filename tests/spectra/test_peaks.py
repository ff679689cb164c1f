import numpy as np
import pytest

from impactfem.spectra import oscillator_response
from impactfem.spectra.oscillator import step_coefficients
from impactfem.spectra.peaks import free_vibration_peak, in_step_peak_responses, peak_responses

H = 0.01
FREQUENCIES = [0.02, 1.0, 20.0, 49.0, 130.0, 300.0]  # Nyquist is 50 Hz
DAMPINGS = [0.0, 0.05, 0.6]


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6, 7, 200])
def test_kernels_agree_with_the_histories(n):
    # 270 oscillators a damping: more than a block, and no multiple of a vector.
    h, f, d = 0.01, np.geomspace(0.2, 120.0, 270), [0.0, 0.05, 0.3]
    a = np.random.default_rng(1).standard_normal((2, n))
    silent = np.concatenate([a, np.zeros((2, 1))], axis=1)
    c = step_coefficients(h, f, d)
    sd, sa = peak_responses(a, c)
    alone, none = peak_responses(a, c, absolute=False)
    assert alone == pytest.approx(sd, rel=1e-13) and np.isnan(none).all()
    for r in range(2):
        history = oscillator_response(a[r], h, f, d)
        x = np.abs(history.relative_displacement).max(axis=2).ravel()
        acc = np.abs(history.absolute_acceleration).max(axis=2).ravel()
        assert np.all(sd[r] >= x * (1 - 1e-12))
        assert np.all(sa[r] >= acc * (1 - 1e-12))
        late = np.abs(free_tail(silent[r, :-1], h, f, d)).max(axis=-1).ravel()
        assert sd[r] == pytest.approx(np.maximum(x, late), rel=1e-3)


def free_tail(a, h, frequencies, dampings):
    """Free vibration after the record, sampled at 200 points over its first period."""
    history = oscillator_response(a, h, frequencies, dampings)
    x0 = history.relative_displacement[..., -1:]
    v0 = history.relative_velocity[..., -1:]
    w = 2 * np.pi * history.frequency[None, :, None]
    xi = history.damping[:, None, None]
    wd = w * np.sqrt(1 - xi**2)
    t = np.linspace(0.0, 1.0, 200) * 2 * np.pi / wd
    return np.exp(-xi * w * t) * (x0 * np.cos(wd * t) + (v0 + xi * w * x0) / wd * np.sin(wd * t))


def test_a_peak_behind_the_record_is_found():
    # An impulse a·h at rest: free vibration with v0 = -a h, undamped peak a h / ω.
    f = 0.25
    a = np.array([[0.0, 1.0, 0.0]])
    sd, sa = peak_responses(a, step_coefficients(1e-3, [f], [0.0]))
    w = 2 * np.pi * f
    assert sd[0, 0] == pytest.approx(1e-3 / w, rel=1e-6)
    assert sa[0, 0] == pytest.approx(1e-3 * w, rel=1e-6)
    in_record = oscillator_response(a[0], 1e-3, [f], [0.0]).relative_displacement
    assert np.abs(in_record).max() < 0.01 * sd[0, 0]


def test_free_vibration_peak_in_closed_form():
    w, xi = 10.0, 0.2
    c = step_coefficients(0.01, [w / (2 * np.pi)], [xi])
    peak = free_vibration_peak(np.array([[1.0 + 0.0j]]), c.rate, -1j / c.omega_d)
    root = np.sqrt(1 - xi**2)
    assert peak[0, 0] == pytest.approx(np.exp(-xi / root * np.arccos(xi)) / w, rel=1e-14)
    assert free_vibration_peak(np.array([[0.0j]]), c.rate, -1j / c.omega_d) == 0.0


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
