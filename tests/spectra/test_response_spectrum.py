import numpy as np
import pytest

from impactfem.spectra import response_spectra
from impactfem.spectra import response_spectrum as module
from impactfem.spectra.response_spectrum import sampling_loss, upsample, upsampling_factor
from impactfem.system.errors import ImpactfemError


def wave(frequency, step, duration=4.0):
    """A sine in a smooth envelope that is silent at both ends."""
    t = np.arange(round(duration / step) + 1) * step
    return np.sin(2 * np.pi * frequency * t) * np.sin(np.pi * t / duration) ** 2


def test_shapes_and_pseudo_quantities():
    a = np.random.default_rng(0).standard_normal((3, 50))
    s = response_spectra(a, 0.01, [1.0, 5.0, 20.0, 2.0], [0.02, 0.05])
    part = response_spectra(a, 0.01, s.frequency, s.damping, absolute=False)
    assert part.sd == pytest.approx(s.sd, rel=1e-12) and np.isnan(part.sa).all()
    assert s.sd.shape == s.psv.shape == s.psa.shape == s.sa.shape == (2, 3, 4)
    omega = 2 * np.pi * s.frequency
    assert s.psv == pytest.approx(s.sd * omega)
    assert s.psa == pytest.approx(s.sd * omega**2)
    assert s.zpa == pytest.approx(np.abs(a).max(axis=1))
    for d in range(2):
        for r in range(3):
            alone = response_spectra(a[r], 0.01, s.frequency, [s.damping[d]])
            assert alone.sd[0, 0] == pytest.approx(s.sd[d, r], rel=1e-12)
            assert alone.sa[0, 0] == pytest.approx(s.sa[d, r], rel=1e-12)


def test_without_damping_absolute_and_pseudo_acceleration_agree():
    a = np.random.default_rng(0).standard_normal(80)
    s = response_spectra(a, 0.01, [0.3, 3.0, 30.0], [0.0, 0.2])
    assert s.sa[0] == pytest.approx(s.psa[0], rel=1e-12)
    assert np.abs(s.sa[1] / s.psa[1] - 1).max() > 1e-3


def test_high_frequencies_end_at_the_zero_period_acceleration():
    a = wave(2.0, 0.01)
    s = response_spectra(a, 0.01, [3000.0], [0.05], points_per_cycle=4)
    assert s.sa[0, 0, 0] == pytest.approx(s.zpa_interpolated[0], rel=2e-4)
    assert s.psa[0, 0, 0] == pytest.approx(s.zpa_interpolated[0], rel=2e-4)
    assert s.zpa[0] == np.abs(a).max()
    assert s.nyquist_frequency == pytest.approx(50.0)


def test_low_frequencies_end_at_the_ground_displacement():
    a = wave(2.0, 0.01)
    s = response_spectra(a, 0.01, [0.001], [0.05], method="in-step")
    velocity = np.concatenate([[0.0], np.cumsum((a[1:] + a[:-1]) / 2) * 0.01])
    displacement = np.cumsum(velocity) * 0.01
    assert s.sd[0, 0, 0] == pytest.approx(np.abs(displacement).max(), rel=0.02)


def test_near_nyquist_the_coarse_record_gives_what_the_fine_one_gives():
    # 90 Hz in 1/400 s samples: 4.4 points a cycle.
    f = [60.0, 90.0, 110.0]
    truth = response_spectra(wave(90.0, 1 / 40000, 1.0), 1 / 40000, f, [0.05])
    assert truth.upsampling_factor == 1
    coarse = response_spectra(wave(90.0, 1 / 400, 1.0), 1 / 400, f, [0.05])
    assert coarse.upsampling_factor == 6
    assert coarse.points_per_cycle == pytest.approx(6 * 400 / 110)
    error = np.abs(coarse.psa / truth.psa - 1).max()
    assert error < coarse.peak_error_bound
    bare = response_spectra(wave(90.0, 1 / 400, 1.0), 1 / 400, f, [0.05], points_per_cycle=2)
    assert bare.upsampling_factor == 1
    assert np.abs(bare.psa / truth.psa - 1).max() > 0.1


def exact_psa(frequency, damping, terms, duration):
    """max ω²|x| of (1) of `oscillator` from rest under Σ b exp(iwt), by its closed solution."""
    t = np.arange(0.0, duration, 2e-6)
    omega = 2 * np.pi * frequency
    omega_d = omega * np.sqrt(1 - damping**2)
    rate = -damping * omega + 1j * omega_d
    z = sum(b * (np.exp(rate * t) - np.exp(1j * w * t)) / (1j * w - rate) for b, w in terms)
    return omega**2 / omega_d * np.abs(z.imag).max()


@pytest.mark.parametrize("driven", [440.0, 450.0])
def test_near_nyquist_no_peak_loses_more_than_the_bound(driven):
    """Sines of 440 and 450 Hz, which rise and fade, at samples of 1 ms."""
    duration, losses = 0.4, []
    for phase in np.linspace(0.0, np.pi, 8, endpoint=False):
        # sin(wt + φ) sin²(πt/T) is the sum of three sines: at w, and at w ± 2π/T.
        terms = []
        for shift, amplitude in ((0, 0.5), (1, -0.25), (-1, -0.25)):
            w = 2 * np.pi * (driven + shift / duration)
            one = amplitude * np.exp(1j * phase) / 2j
            terms += [(one, w), (np.conj(one), -w)]
        t = np.arange(401) * 0.001
        record = sum(b * np.exp(1j * w * t) for b, w in terms).real
        found = response_spectra(record, 0.001, [450.0], [0.05])
        losses.append(1 - found.psa[0, 0, 0] / exact_psa(450.0, 0.05, terms, duration))
    assert found.points_per_cycle == pytest.approx(20.0)
    # The sides at ± 2.5 Hz are above the highest frequency, by 0.6 %.
    assert max(losses) < 1.005 * found.peak_error_bound and min(losses) > 0.0
    if driven == 450.0:
        # In resonance the worst phase reaches it; what is lost between the samples is no bound.
        assert max(losses) > 0.97 * found.peak_error_bound
        assert max(losses) > 1.5 * (1 - np.cos(np.pi / found.points_per_cycle))


def test_bounds_are_those_of_the_points_reached():
    a = wave(2.0, 0.001)
    s = response_spectra(a, 0.001, [500.0, 1.0], [0.05], points_per_cycle=20)
    assert (s.upsampling_factor, s.points_per_cycle) == (10, pytest.approx(20.0))
    assert s.peak_error_bound == pytest.approx(0.020409, abs=1e-6)  # 1 - sinc²(0.05) cos 9°
    assert s.interpolation_factor == pytest.approx(0.991802, abs=1e-6)  # sinc²(0.05)
    exact = response_spectra(a, 0.001, [500.0, 1.0], [0.05], method="in-step")
    assert (exact.upsampling_factor, exact.points_per_cycle) == (1, pytest.approx(2.0))
    assert exact.peak_error_bound == 0.0
    assert exact.interpolation_factor == pytest.approx(0.405285, abs=1e-6)  # sinc²(0.5)


def test_many_records_in_chunks_are_the_same(monkeypatch):
    a = np.random.default_rng(4).standard_normal((7, 60))
    whole = response_spectra(a, 0.01, [2.0, 40.0], [0.05])
    monkeypatch.setattr(module, "_SAMPLES_AT_ONCE", 60 * 8 * 2)
    parts = response_spectra(a, 0.01, [2.0, 40.0], [0.05], threads=2)
    for name in ("sd", "sa", "zpa_interpolated"):
        assert np.array_equal(getattr(whole, name), getattr(parts, name))


def test_record_too_long_to_hold_is_refused():
    with pytest.raises(ImpactfemError, match="too many"):
        response_spectra(np.ones(1000), 0.01, [1e6], [0.05])
    # The other method needs no finer record.
    assert response_spectra(np.ones(1000), 0.01, [1e6], [0.05], method="in-step").sd.size == 1


FREQUENCY, DAMPING = 10.0, 0.02


def resonant_loss(n, phase):
    """Loss of the steady peak 1 / 2ζ under a sine of amplitude one with n samples in a cycle."""
    time = np.arange(int(100 * n)) / (n * FREQUENCY)
    record = np.sin(2.0 * np.pi * FREQUENCY * time + phase)
    record *= np.minimum(1.0, time * FREQUENCY / 30.0)
    # The free vibration behind the record is exact: it must not hold the peak.
    record *= np.minimum(1.0, np.maximum(0.0, time[-1] - time) * FREQUENCY / 30.0)
    found = response_spectra(record, time[1], [FREQUENCY], [DAMPING], points_per_cycle=2.0)
    return 1.0 - float(found.psa[0, 0, 0]) * 2.0 * DAMPING


@pytest.mark.parametrize("n", [4.0, 8.0, 20.0])
def test_no_phase_loses_more(n):
    losses = [resonant_loss(n, phase) for phase in np.linspace(0.0, 2.0 * np.pi / n, 9)]
    steady = 0.02  # of the peak is not reached within the record
    assert max(losses) <= float(sampling_loss(n)) + steady
    # Nor much less in the worst phase: cos(π/n) alone is no bound.
    assert max(losses) >= float(sampling_loss(n)) - 0.02
    if n < 5.0:
        assert max(losses) > 1.0 - np.cos(np.pi / n) + 0.05


def test_ends_of_the_bound():
    assert sampling_loss([2.0, 1.0, 1e4]) == pytest.approx([1.0, 1.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("n", [2, 97, 1000])
@pytest.mark.parametrize("factor", [2, 3, 10])
def test_given_samples_are_kept(n, factor):
    a = np.random.default_rng(0).standard_normal((3, n))
    assert upsample(a, 1) is a
    fine = upsample(a, factor)
    assert fine.shape == (3, (n - 1) * factor + 1)
    assert np.abs(fine[:, ::factor] - a).max() < 1e-14 * n**0.5 * 10


def test_a_smooth_wave_near_nyquist_is_restored():
    # A wave packet at 3.3 samples a cycle that is silent at both ends.
    def packet(t):
        return np.sin(2 * np.pi * 30.0 * t) * np.exp(-(((t - 1.0) / 0.12) ** 2))

    fine = upsample(packet(np.arange(201) * 0.01)[None], 10)[0]
    t = np.arange(fine.size) * 0.001
    assert np.abs(fine - packet(t)).max() < 1e-12
    straight = np.interp(t, t[::10], packet(t[::10]))
    assert np.abs(straight - packet(t)).max() > 0.1  # what linear interpolation would do


def test_the_end_does_not_come_back_at_the_beginning():
    a = np.zeros((1, 400))
    a[0, -1] = 1.0
    fine = upsample(a, 4)[0]
    assert np.abs(fine[:800]).max() < 1.0 / 100
    assert np.abs(fine[:40]).max() < 2e-3


@pytest.mark.parametrize(
    ("step", "frequency", "points", "factor"),
    [(1e-3, 500.0, 20, 10), (1e-3, 501.0, 20, 11), (1e-3, 10.0, 20, 1), (5e-3, 33.0, 20, 4)],
)
def test_factor_is_the_smallest_that_suffices(step, frequency, points, factor):
    assert upsampling_factor(step, frequency, points) == factor
