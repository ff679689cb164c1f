import numpy as np
import pytest

from impactfem.spectra.sampling import upsample, upsampling_factor
from impactfem.system.errors import ImpactfemError


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
