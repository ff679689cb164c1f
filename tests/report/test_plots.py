"""Plots of the report."""

import numpy as np
import pytest

from impactfem.report.plots import SAMPLES, thinned


def test_a_short_history_stays():
    t = np.linspace(0.0, 1.0, SAMPLES)
    found = thinned(t, t**2)
    assert found[0] is t and np.array_equal(found[1], t**2)


@pytest.mark.parametrize("size", [4 * SAMPLES, 12 * SAMPLES + 7])
def test_a_long_history_keeps_its_extremes(size):
    t = np.linspace(0.0, 1.0, size)
    a = np.random.default_rng(3).normal(size=size)
    a[size // 3], a[-1] = 50.0, -40.0
    time, kept = thinned(t, a)
    assert time.size <= 1.1 * SAMPLES and np.all(np.diff(time) > 0.0)
    assert kept.max() == 50.0 and kept.min() == -40.0
    assert np.array_equal(kept, a[np.searchsorted(t, time)])
