import numpy as np
import pytest

from impactfem.motion import Accelerogram
from impactfem.motion.baseline import BaselineCorrection
from impactfem.spectra import response_spectra
from impactfem.system.errors import ImpactfemError


@pytest.fixture
def noise():
    return np.random.default_rng(7).standard_normal(1001)


def test_the_end_is_at_rest_and_in_place(noise):
    before = Accelerogram(0.01, noise)
    after = Accelerogram(0.01, BaselineCorrection(1001, 0.01)(noise))
    assert abs(before.velocity[-1]) > 1e-2
    assert abs(before.displacement[-1]) > 1e-2
    assert abs(after.velocity[-1]) < 1e-14
    assert abs(after.displacement[-1]) < 1e-13


def test_it_begins_and_ends_at_zero_and_repeats_itself_as_nothing(noise):
    correct = BaselineCorrection(1001, 0.01)
    once = correct(noise)
    assert (once - noise)[[0, -1]] == pytest.approx(0.0, abs=1e-15)
    assert correct(once) == pytest.approx(once, abs=1e-14)


def test_oscillators_follow_it_statically(noise):
    correction = BaselineCorrection(1001, 0.01)(noise) - noise
    psa = response_spectra(correction, 0.01, [0.15, 1.0, 3.0, 30.0], [0.05]).psa[0, 0]
    largest = np.abs(correction).max()
    assert psa[1:] == pytest.approx(largest, rel=0.02)
    assert psa[0] > 1.2 * largest  # near 1.5/T = 0.15 Hz they do not


def test_too_few_samples_are_refused():
    with pytest.raises(ImpactfemError, match="at least 4 samples"):
        BaselineCorrection(3, 0.01)
