import numpy as np
import pytest

from impactfem.spectra import oscillator_response
from impactfem.spectra.peaks import displacement_peaks, free_vibration_peak, peak_responses
from impactfem.spectra.recurrence import step_coefficients
from impactfem.system.errors import ImpactfemError


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6, 7, 200])
def test_kernels_agree_with_the_histories(n):
    # 270 oscillators a damping: more than a block, and no multiple of a vector.
    h, f, d = 0.01, np.geomspace(0.2, 120.0, 270), [0.0, 0.05, 0.3]
    a = np.random.default_rng(1).standard_normal((2, n))
    silent = np.concatenate([a, np.zeros((2, 1))], axis=1)
    c = step_coefficients(h, f, d)
    sd, sa = peak_responses(a, c)
    assert displacement_peaks(a, c) == pytest.approx(sd, rel=1e-13)
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


def test_threads_change_nothing():
    a = np.random.default_rng(2).standard_normal((5, 300))
    c = step_coefficients(0.01, np.geomspace(0.5, 50.0, 40), [0.05])
    one, four = peak_responses(a, c), peak_responses(a, c, threads=4)
    assert np.array_equal(one[0], four[0])
    assert np.array_equal(one[1], four[1])
    with pytest.raises(ImpactfemError, match="threads must be at least 1"):
        peak_responses(a, c, threads=0)
