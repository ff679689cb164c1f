import numpy as np
import pytest

from impactfem.motion import Accelerogram, resampled
from impactfem.system.errors import ImpactfemError

T = 20.0


def burst(step, frequency=3.0):
    t = np.arange(round(T / step) + 1) * step
    return np.exp(-(((t - 10.0) / 2.0) ** 2)) * np.sin(2.0 * np.pi * frequency * t)


@pytest.mark.parametrize("new", [0.002, 0.01, 0.005, 0.3358e-3, 0.0125])
def test_a_band_limited_signal_is_met(new):
    fine = resampled(Accelerogram(0.01, burst(0.01), "n", "o"), new)
    assert fine.time_step == new
    t = fine.time
    expected = np.exp(-(((t - 10.0) / 2.0) ** 2)) * np.sin(6.0 * np.pi * t)
    assert fine.acceleration == pytest.approx(expected, abs=1e-9)
    assert T - new < fine.duration <= T * (1.0 + 1e-12)


def test_a_finer_step_keeps_the_samples():
    a = np.random.default_rng(1).standard_normal(200)
    fine = resampled(Accelerogram(0.01, a), 0.0025)
    assert fine.acceleration[::4] == pytest.approx(a, abs=1e-12)


def test_a_coarser_step_folds_nothing_back():
    # 45 Hz lies above the new Nyquist frequency of 25 Hz: folded it would appear at 5 Hz.
    record = Accelerogram(0.005, burst(0.005) + burst(0.005, 45.0))
    coarse = resampled(record, 0.02)
    assert coarse.acceleration == pytest.approx(burst(0.02), abs=1e-6)
    assert np.abs(record.acceleration[::4] - burst(0.02)).max() > 0.5  # plain decimation folds


def test_origin_and_nothing_to_do():
    record = Accelerogram(0.01, burst(0.01), "n", "record x")
    assert resampled(record, 0.01) is record
    assert resampled(record, 0.005).origin == (
        "record x; resampled from 0.01 s to 0.005 s, band-limited"
    )
    assert "low-pass at 20 Hz" in resampled(record, 0.025).origin


@pytest.mark.parametrize(
    ("step", "message"),
    [
        (0.0, "must be positive and at most half the duration of 20 s, got 0.0 s"),
        (float("nan"), "must be positive"),
        (11.0, "at most half the duration"),
        (1e-9, "would make more than 1e.07 samples"),
        (0.01 / np.pi, "must have the ratio of whole numbers up to 100000"),
    ],
)
def test_refused(step, message):
    with pytest.raises(ImpactfemError, match=message):
        resampled(Accelerogram(0.01, burst(0.01)), step)
