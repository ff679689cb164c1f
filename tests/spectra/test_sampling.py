import numpy as np
import pytest

from impactfem.spectra import response_spectra
from impactfem.spectra.response_spectrum import sampling_loss, upsample, upsampling_factor
from impactfem.system.errors import ImpactfemError

FREQUENCY, DAMPING = 10.0, 0.02


def resonant_loss(n: float, phase: float) -> float:
    """Loss of the steady peak 1 / 2ζ under a sine of amplitude one with n samples in a cycle."""
    time = np.arange(int(100 * n)) / (n * FREQUENCY)
    record = np.sin(2.0 * np.pi * FREQUENCY * time + phase)
    record *= np.minimum(1.0, time * FREQUENCY / 30.0)
    # The free vibration behind the record is exact: it must not hold the peak.
    record *= np.minimum(1.0, np.maximum(0.0, time[-1] - time) * FREQUENCY / 30.0)
    found = response_spectra(record, time[1], [FREQUENCY], [DAMPING], points_per_cycle=2.0)
    return 1.0 - float(found.psa[0, 0, 0]) * 2.0 * DAMPING


@pytest.mark.parametrize("n", [4.0, 8.0, 20.0])
def test_no_phase_loses_more(n: float) -> None:
    losses = [resonant_loss(n, phase) for phase in np.linspace(0.0, 2.0 * np.pi / n, 9)]
    steady = 0.02  # of the peak is not reached within the record
    assert max(losses) <= float(sampling_loss(n)) + steady
    # Nor much less in the worst phase: cos(π/n) alone is no bound.
    assert max(losses) >= float(sampling_loss(n)) - 0.02
    if n < 5.0:
        assert max(losses) > 1.0 - np.cos(np.pi / n) + 0.05


def test_ends() -> None:
    assert sampling_loss([2.0, 1.0]) == pytest.approx([1.0, 1.0])
    assert float(sampling_loss(1e4)) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("n", [2, 97, 1000])
@pytest.mark.parametrize("factor", [2, 3, 10])
def test_given_samples_are_kept(n, factor):
    a = np.random.default_rng(0).standard_normal((3, n))
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


def test_factor_one_gives_the_record_itself():
    a = np.ones((1, 4))
    assert upsample(a, 1) is a


def test_factor_below_one_is_refused():
    with pytest.raises(ImpactfemError, match="whole number >= 1"):
        upsample(np.ones((1, 4)), 0)


@pytest.mark.parametrize(
    ("step", "frequency", "points", "factor"),
    [(1e-3, 500.0, 20, 10), (1e-3, 501.0, 20, 11), (1e-3, 10.0, 20, 1), (5e-3, 33.0, 20, 4)],
)
def test_factor_is_the_smallest_that_suffices(step, frequency, points, factor):
    assert upsampling_factor(step, frequency, points) == factor
