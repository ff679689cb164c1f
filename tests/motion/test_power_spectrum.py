import numpy as np
import pytest

from impactfem.motion.design_spectrum import DesignSpectrum
from impactfem.motion.power_spectrum import (
    compatible_power_spectrum,
    power_spectrum,
    rg160_power_spectrum,
    strong_phase,
)
from impactfem.records.accelerogram import Accelerogram
from impactfem.spectra import response_spectra
from impactfem.system.errors import ImpactfemError

H = 0.005


@pytest.fixture(scope="module")
def white():
    """Stationary noise, density constant up to the Nyquist frequency."""
    return Accelerogram(H, np.random.default_rng(4).standard_normal(40_001))


def test_density_of_white_noise(white):
    # Variance 1 over ω from 0 to π/h: the one-sided density is h/π per rad/s.
    f = np.geomspace(1.0, 50.0, 60)
    ratio = power_spectrum(white, f) / (H / np.pi)
    assert np.mean(ratio) == pytest.approx(1.0, abs=0.03)
    assert np.all(np.abs(ratio - 1.0) < 0.35)


def test_its_integral_is_the_mean_square_of_the_strong_phase():
    t = np.arange(8001) * H
    sine = Accelerogram(H, 3.0 * np.sin(2.0 * np.pi * 5.0 * t))
    f = np.linspace(0.5, 20.0, 2000)
    total = np.sum(power_spectrum(sine, f)) * (f[1] - f[0]) * 2.0 * np.pi
    assert total == pytest.approx(4.5, rel=0.05)  # the mean over f (1 ± 0.2) skews it a little


def test_strong_phase_of_a_constant_amplitude():
    phase = strong_phase(Accelerogram(0.01, np.ones(10_001)))
    assert (phase.begin, phase.end) == pytest.approx((5.0, 75.0), abs=0.01)
    assert phase.duration == pytest.approx(70.0, abs=0.02)


def test_a_hole_shows_where_it_is(white):
    f = np.fft.rfftfreq(white.acceleration.size, H)
    spectrum = np.fft.rfft(white.acceleration)
    spectrum[(f > 4.0) & (f < 8.0)] *= 0.1
    holed = Accelerogram(H, np.fft.irfft(spectrum, white.acceleration.size))
    ratio = power_spectrum(holed, [2.0, 5.6, 20.0]) / power_spectrum(white, [2.0, 5.6, 20.0])
    assert ratio == pytest.approx([1.0, 0.01, 1.0], abs=0.08)


def test_density_described_by_a_spectrum():
    # Band-limited white noise: its own mean response spectrum must lead back to its density.
    rng = np.random.default_rng(8)
    duration, n = 40.0, 8000
    motions = rng.standard_normal((30, n))
    f = np.geomspace(0.5, 30.0, 120)
    mean = np.median(response_spectra(motions, H, f, [0.05]).psa[0], axis=0)

    class Measured:
        damping = 0.05

        def pseudo_acceleration(self, frequency):
            return np.exp(np.interp(np.log(frequency), np.log(f), np.log(mean)))

    wanted = np.geomspace(1.0, 15.0, 40)
    density = compatible_power_spectrum(Measured(), wanted, duration)
    assert np.median(density) == pytest.approx(H / np.pi, rel=0.1)
    assert density / (H / np.pi) == pytest.approx(1.0, abs=0.35)


def test_a_stronger_spectrum_asks_for_more_power_by_its_square():
    f = np.geomspace(0.3, 24.0, 30)
    one = compatible_power_spectrum(DesignSpectrum(1.0, (0.15, 0.4, 2.0)), f, 10.0)
    two = compatible_power_spectrum(DesignSpectrum(2.0, (0.15, 0.4, 2.0)), f, 10.0)
    assert two == pytest.approx(4.0 * one)
    assert np.all(one > 0.0)


def test_rg160_at_its_corners():
    f = [1.25, 2.5, 9.0 - 1e-9, 9.0, 16.0 - 1e-9, 16.0, 32.0]
    expected = [0.419 * 0.5**0.2, 0.419, 0.0417, 0.0418, 0.00744, 0.00742, 0.00742 / 256]
    assert rg160_power_spectrum(f, 9.80665) == pytest.approx(expected, rel=2e-3)
    assert rg160_power_spectrum(5.0, 4.903325) == pytest.approx(
        0.25 * rg160_power_spectrum(5.0, 9.80665)
    )


@pytest.mark.parametrize("frequency", [[0.0], [101.0], [-1.0]])
def test_frequencies_out_of_range(white, frequency):
    with pytest.raises(ImpactfemError, match="above the Nyquist"):
        power_spectrum(white, frequency)


def test_no_strong_phase():
    with pytest.raises(ImpactfemError, match="zero throughout"):
        strong_phase(Accelerogram(0.1, np.zeros(9)))
    with pytest.raises(ImpactfemError, match="strong phase"):
        power_spectrum(Accelerogram(0.1, np.ones(10)), [1.0])
    with pytest.raises(ImpactfemError, match="must be positive"):
        compatible_power_spectrum(DesignSpectrum(1.0, (0.1, 0.2, 2.0)), [1.0], 0.0)
