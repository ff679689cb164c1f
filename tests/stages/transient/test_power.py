"""Power spectral densities of signals whose densities are known."""

import numpy as np
import pytest

from impactfem.stages.transient.physics import force_spectra, impact_samples, power_spectrum

DT = 1e-4


def half_sine(time, force, lasts):
    return np.where((time >= 0) & (time <= lasts), force * np.sin(np.pi * time / lasts), 0.0)


def half_sine_density(frequency, force, lasts, duration):
    """2 |F(f)|² / T; the Fourier transform of half a sine in closed form."""
    x = 2.0 * frequency * lasts
    shape = np.cos(0.5 * np.pi * x) / (1.0 - x**2)
    return 2.0 * (force * 2.0 * lasts / np.pi * shape) ** 2 / duration


def test_power_of_a_sine():
    time = DT * np.arange(100_000)
    frequency, density = power_spectrum(3.0 * np.sin(2.0 * np.pi * 40.0 * time), DT)
    assert frequency[np.argmax(density)] == pytest.approx(40.0)
    # The integral of the density is the mean square.
    assert density.sum() * frequency[1] == pytest.approx(4.5, rel=1e-3)


def test_a_record_shorter_than_a_segment():
    frequency, density = power_spectrum(np.ones(50), 0.01)
    assert len(frequency) == len(density) == 26


def test_density_of_an_impact():
    time = DT * np.arange(20_000)
    force = np.stack([half_sine(time - 0.3, 5e6, 0.013), half_sine(time - 1.1, 1e6, 0.008)], axis=1)
    spectra = force_spectra(force, DT)
    # The density at 0 Hz has no other side.
    low = (spectra.frequency > 0.0) & (spectra.frequency < 60.0)
    for k, (peak, lasts) in enumerate(((5e6, 0.013), (1e6, 0.008))):
        exact = half_sine_density(spectra.frequency[low], peak, lasts, spectra.duration)
        assert spectra.density[k, low] == pytest.approx(exact, rel=2e-3)
    assert spectra.duration == pytest.approx(0.013, abs=2 * DT)
    # Parseval: the mean power over the duration.
    total = spectra.density.sum(axis=1) * spectra.frequency[1]
    assert total == pytest.approx((force**2).sum(axis=0) * DT / spectra.duration, rel=1e-6)


def test_only_the_main_impact_counts():
    time = DT * np.arange(20_000)
    alone = half_sine(time - 0.3, 5e6, 0.013)
    more = alone + half_sine(time - 1.1, 4e6, 0.013)
    larger = alone + half_sine(time - 1.1, 6e6, 0.013)
    of = [force_spectra(f[:, None], DT).density[0, 0] for f in (alone, more, larger)]
    assert of[1] == pytest.approx(of[0]) and of[2] == pytest.approx(1.44 * of[0], rel=1e-3)


def test_where_an_impact_begins_and_ends():
    force = np.array([0.0, 2.0, 0.0, 1.0, 5.0, 3.0, -1.0, 0.0, 4.0])
    # Tension at its end belongs to it.
    assert impact_samples(force) == (3, 7)
    assert impact_samples(np.ones(4)) == (0, 4)
