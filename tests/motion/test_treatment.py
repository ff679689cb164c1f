import logging

import numpy as np
import pytest

from impactfem.motion.treatment import (
    BaselineCorrection,
    Treatment,
    refined_step,
    resampled,
    straight_line_loss,
)
from impactfem.records.accelerogram import Accelerogram
from impactfem.spectra import response_spectra
from impactfem.system.errors import ImpactfemError

H = 0.01
T = np.arange(4001) * H


def record(acceleration):
    return Accelerogram(H, acceleration, "north", "record north.csv")


def noise():
    return np.random.default_rng(2).standard_normal(T.size)


def test_nothing_is_done_by_default(caplog):
    before = record(noise())
    with caplog.at_level(logging.DEBUG, logger="impactfem"):
        assert Treatment()(before) is before
    assert not caplog.records


def test_mean_and_line():
    drift = record(0.3 + 0.02 * T)
    assert Treatment("linear")(drift).acceleration == pytest.approx(np.zeros(T.size), abs=1e-13)
    rest = Treatment("mean")(drift)
    assert rest.acceleration.mean() == pytest.approx(0.0, abs=1e-14)
    assert rest.acceleration[-1] == pytest.approx(0.4)  # the mean leaves the slope
    assert rest.origin.startswith("record north.csv; mean of 0.7 m/s2")
    assert "line 0.3 m/s2 + 0.02 m/s3 t taken out" in Treatment("linear")(drift).origin


def test_rest_is_the_last_step():
    treated = Treatment("rest", taper=1.0, band=(0.2, 20.0), resample=0.005)(record(noise()))
    assert abs(treated.velocity[-1]) < 1e-12
    assert abs(treated.displacement[-1]) < 1e-11
    steps = ["tapered over 1 s", "band-pass 0.2 Hz to 20 Hz", "resampled from", "brought to rest"]
    positions = [treated.origin.index(step) for step in steps]
    assert positions == sorted(positions)
    without = Treatment(taper=1.0, band=(0.2, 20.0), resample=0.005)(record(noise()))
    assert abs(without.velocity[-1]) > 1e-6


def test_taper():
    treated = Treatment(taper=2.0)(record(np.ones(T.size)))
    assert treated.acceleration[[0, 100, 200, 2000, -101, -1]] == pytest.approx(
        [0.0, 0.5, 1.0, 1.0, 0.5, 0.0], abs=1e-12
    )


@pytest.mark.parametrize(
    ("frequency", "gain"), [(2.0, 1.0), (0.5, 0.5), (10.0, 0.5), (0.05, 0.0), (40.0, 0.0)]
)
def test_band_pass_of_sines(frequency, gain):
    # Forward and backward: |H|² is a half at both corners and 1 between; no phase is shifted.
    burst = np.exp(-(((T - 20.0) / 6.0) ** 2)) * np.exp(2j * np.pi * frequency * T)
    out = Treatment(band=(0.5, 10.0))(record(burst.real)).acceleration
    assert 2.0 * out @ burst / np.sum(np.abs(burst) ** 2) == pytest.approx(gain, abs=0.02)


def test_band_pass_of_noise_outside_its_band():
    before, after = noise(), Treatment(band=(0.5, 10.0))(record(noise())).acceleration
    f, window = np.fft.rfftfreq(T.size, H), np.hanning(T.size)  # against leakage of the cut ends
    after, before = (np.abs(np.fft.rfft(window * a)) for a in (after, before))
    ratio = after[f > 30.0] / before[f > 30.0]
    assert np.median(ratio) < 1e-3


def test_each_step_is_logged(caplog):
    with caplog.at_level(logging.DEBUG, logger="impactfem"):
        Treatment("mean", resample=0.005)(record(noise()))
    (message,) = [entry.getMessage() for entry in caplog.records]
    assert message.startswith("north: mean of ")
    assert "from 0.01 s to 0.005 s" in message


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"taper": -1.0}, "the taper must be positive"),
        ({"taper": 21.0}, "the taper of 21 s is longer than half the record, 20 s"),
        ({"band": (2.0, 1.0)}, "corner frequencies must be 0 < low < high"),
        ({"band": (0.0, 1.0)}, "corner frequencies must be 0 < low < high"),
        ({"band": (1.0, 50.0)}, "high corner of 50 Hz must be below the Nyquist .* 50 Hz"),
        ({"band": (1e-6, 10.0)}, "low corner of 1e-06 Hz must be at least a tenth of a cycle"),
        ({"resample": 0.0}, "must be positive and at most half the duration of 40 s, got 0.0 s"),
        ({"resample": float("nan")}, "must be positive"),
        ({"resample": 30.0}, "at most half the duration"),
        ({"resample": 1e-9}, "would make more than 1e.07 samples"),
        ({"resample": 0.01 / np.pi}, "must have the ratio of whole numbers up to 100000"),
    ],
)
def test_refused(options, message):
    with pytest.raises(ImpactfemError, match=message):
        Treatment(**options)(record(noise()))


def burst(step, frequency=3.0):
    t = np.arange(round(20.0 / step) + 1) * step
    return np.exp(-(((t - 10.0) / 2.0) ** 2)) * np.sin(2.0 * np.pi * frequency * t)


@pytest.mark.parametrize("new", [0.002, 0.01, 0.005, 0.3358e-3, 0.0125])
def test_a_band_limited_signal_is_met(new):
    fine = resampled(Accelerogram(0.01, burst(0.01), "n", "o"), new)
    assert fine.time_step == new
    t = fine.time
    expected = np.exp(-(((t - 10.0) / 2.0) ** 2)) * np.sin(6.0 * np.pi * t)
    assert fine.acceleration == pytest.approx(expected, abs=1e-9)
    assert 20.0 - new < fine.duration <= 20.0 * (1.0 + 1e-12)


def test_a_finer_step_keeps_the_samples():
    a = np.random.default_rng(1).standard_normal(200)
    fine = resampled(Accelerogram(0.01, a), 0.0025)
    assert fine.acceleration[::4] == pytest.approx(a, abs=1e-12)


def test_an_offset_and_a_drift_do_not_ring():
    """An offset before the event does not come back at the other end."""
    line = 0.3 - 0.004 * np.arange(200)
    fine = resampled(Accelerogram(0.01, line), 0.0005)
    assert fine.acceleration == pytest.approx(np.interp(fine.time, 0.01 * np.arange(200), line))


@pytest.mark.parametrize(
    ("step", "refined"),
    [(0.02, 1e-3), (0.005, 0.25e-3), (1e-3, 0.25e-3), (0.5e-3, None), (0.3358e-3, None)],
)
def test_the_step_of_a_refined_record(step, refined):
    assert refined_step(step) == (refined and pytest.approx(refined))
    loss = straight_line_loss(refined or step, min(100.0, 0.5 / step))
    assert loss <= 0.01 and (refined is None) == (straight_line_loss(step, 100.0) <= 0.01)


def test_a_coarser_step_folds_nothing_back():
    # 45 Hz lies above the new Nyquist frequency of 25 Hz: folded it would appear at 5 Hz.
    motion = Accelerogram(0.005, burst(0.005) + burst(0.005, 45.0))
    coarse = resampled(motion, 0.02)
    assert coarse.acceleration == pytest.approx(burst(0.02), abs=1e-6)
    assert np.abs(motion.acceleration[::4] - burst(0.02)).max() > 0.5  # plain decimation folds


def test_origin_and_nothing_to_do():
    motion = Accelerogram(0.01, burst(0.01), "n", "record x")
    assert resampled(motion, 0.01) is motion
    assert "from 0.01 s to 0.005 s" in resampled(motion, 0.005).origin
    assert "20 Hz" in resampled(motion, 0.025).origin


@pytest.fixture
def samples():
    return np.random.default_rng(7).standard_normal(1001)


def test_the_end_is_at_rest_and_in_place(samples):
    before = Accelerogram(0.01, samples)
    after = Accelerogram(0.01, BaselineCorrection(1001, 0.01)(samples))
    assert min(abs(before.velocity[-1]), abs(before.displacement[-1])) > 1e-2
    assert abs(after.velocity[-1]) < 1e-14 and abs(after.displacement[-1]) < 1e-13


def test_it_begins_and_ends_at_zero_and_repeats_itself_as_nothing(samples):
    correct = BaselineCorrection(1001, 0.01)
    once = correct(samples)
    assert (once - samples)[[0, -1]] == pytest.approx(0.0, abs=1e-15)
    assert correct(once) == pytest.approx(once, abs=1e-14)


def test_oscillators_follow_it_statically(samples):
    correction = BaselineCorrection(1001, 0.01)(samples) - samples
    psa = response_spectra(correction, 0.01, [0.15, 1.0, 3.0, 30.0], [0.05]).psa[0, 0]
    largest = np.abs(correction).max()
    assert psa[1:] == pytest.approx(largest, rel=0.02)
    assert psa[0] > 1.2 * largest  # near 1.5/T = 0.15 Hz they do not


def test_too_few_samples_are_refused():
    with pytest.raises(ImpactfemError, match="at least 4 samples"):
        BaselineCorrection(3, 0.01)
