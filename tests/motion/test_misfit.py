import numpy as np
import pytest

from impactfem.motion import Accelerogram, DesignSpectrum, spectral_misfit
from impactfem.motion.misfit import Misfit

TARGET = DesignSpectrum(1.0, (0.05, 0.25, 2.5))


def test_statistics_by_hand():
    m = Misfit(np.array([1.0, 2.0]), np.array([1.2, 1.8]), np.array([1.0, 2.0]))
    assert m.ratio == pytest.approx([1.2, 0.9])
    assert m.mean == pytest.approx(0.05)
    assert m.rms == pytest.approx(np.sqrt((0.04 + 0.01) / 2))
    assert (m.largest_ratio, m.smallest_ratio) == (pytest.approx(1.2), pytest.approx(0.9))


def test_a_motion_twice_as_strong_has_twice_the_ratio():
    record = Accelerogram(0.01, np.random.default_rng(0).standard_normal(500))
    one = spectral_misfit(record, TARGET, 0.5, 20.0)
    two = spectral_misfit(record.scaled(2.0), TARGET, 0.5, 20.0)
    assert one.frequency[[0, -1]].tolist() == [0.5, 20.0]
    assert two.ratio == pytest.approx(2.0 * one.ratio)
    assert two.mean == pytest.approx(2.0 * (one.mean + 1.0) - 1.0)
