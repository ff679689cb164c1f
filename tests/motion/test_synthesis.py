import numpy as np
import pytest

from impactfem.motion.acceptance import spectral_misfit
from impactfem.motion.design_spectrum import DesignSpectrum
from impactfem.motion.synthesis import _to_peak, envelope, synthesise
from impactfem.records.accelerogram import Accelerogram, measures
from impactfem.system.errors import ImpactfemError

TARGET = DesignSpectrum(2.3, (0.05, 0.25, 2.5))
PAPER = {"duration": 16.79, "time_step": 0.005, "strong_phase": (2.0, 5.0)}
PAPER |= {"pga": 2.32, "iterations": 15}


@pytest.fixture(scope="module")
def motion():
    return synthesise(TARGET, seed=1, **PAPER)


def test_what_was_asked_is_kept(motion):
    a = motion.accelerogram
    m = measures(a)
    assert m.pga == pytest.approx(2.32, rel=1e-11)
    assert a.duration == pytest.approx(16.79)
    assert abs(m.end_velocity) < 1e-13
    assert abs(m.end_displacement) < 1e-12
    assert a.acceleration[[0, -1]] == pytest.approx(0.0, abs=1e-9)


def test_the_strong_phase_is_where_it_was_asked(motion):
    a, t = motion.accelerogram.acceleration, motion.accelerogram.time
    strong = np.sqrt(np.mean(a[(t > 2.0) & (t < 5.0)] ** 2))
    assert np.sqrt(np.mean(a[t < 1.0] ** 2)) < 0.4 * strong
    assert np.sqrt(np.mean(a[t > 13.0] ** 2)) < 0.2 * strong
    assert np.argmax(np.abs(a)) * 0.005 < 8.0


@pytest.mark.parametrize("seed", range(5))
def test_the_spectrum_meets_the_target(seed):
    misfit = synthesise(TARGET, seed=seed, **PAPER).misfit
    assert (misfit.frequency[0], misfit.frequency[-1]) == (0.2, 50.0)
    assert misfit.rms < 0.08
    assert abs(misfit.mean) < 0.04
    assert misfit.smallest_ratio > 0.75
    above = misfit.frequency > 0.3  # below it the strong phase is shorter than a cycle
    assert misfit.ratio[above].max() < 1.3


def test_the_misfit_reported_is_that_of_the_motion(motion):
    again = spectral_misfit(motion.accelerogram, TARGET, 0.2, 50.0)
    assert again.ratio == pytest.approx(motion.misfit.ratio)


def test_iterating_helps():
    raw = synthesise(TARGET, seed=1, **{**PAPER, "iterations": 0})
    assert raw.iterations == 0
    assert raw.misfit.rms > 0.15
    few = synthesise(TARGET, seed=1, **{**PAPER, "iterations": 3})
    assert few.misfit.rms < 0.5 * raw.misfit.rms
    assert 1 <= few.iterations <= 3


def test_a_seed_is_a_motion(motion):
    again = synthesise(TARGET, seed=1, **PAPER)
    assert np.array_equal(again.accelerogram.acceleration, motion.accelerogram.acceleration)
    other = synthesise(TARGET, seed=2, **PAPER)
    correlation = np.corrcoef(other.accelerogram.acceleration, motion.accelerogram.acceleration)
    assert abs(correlation[0, 1]) < 0.16  # the bound of nuclear practice for independence


def test_the_phases_of_a_seed_are_the_same_with_every_numpy():
    # First phases of PCG64, seed 1, as fractions of a turn: 53 bits of its raw output, by hand.
    raw = np.random.PCG64(1).random_raw(3)
    fractions = np.random.Generator(np.random.PCG64(1)).random(3)
    assert fractions.tolist() == [(int(word) >> 11) * 2.0**-53 for word in raw]
    assert fractions[0] == pytest.approx(0.5118216247002567)


def test_without_a_peak_asked_it_comes_as_it_comes():
    free = synthesise(TARGET, seed=1, **{**PAPER, "pga": None})
    assert measures(free.accelerogram).pga != pytest.approx(2.32, rel=1e-3)
    assert free.misfit.rms < 0.08


def test_coarse_steps_match_what_they_can_hold():
    coarse = synthesise(TARGET, seed=1, **{**PAPER, "duration": 16.0, "time_step": 0.02})
    assert coarse.misfit.frequency[-1] == pytest.approx(20.0)


@pytest.mark.parametrize("peak", [0.3, 0.95, 1.0, 1.7])
def test_bringing_to_the_peak(peak):
    a = np.linspace(-peak, 0.9 * peak, 2001)
    out = _to_peak(a, 1.0)
    assert np.abs(out).max() == pytest.approx(1.0, rel=1e-14)
    assert np.all(np.diff(out) > 0.0)  # ascending: the order of the samples stays
    small = np.abs(a) <= min(0.8, 0.5 * peak)
    assert np.array_equal(out[small], a[small])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"duration": 16.792}, "whole number of time steps"),
        ({"duration": -1.0}, "duration must be positive"),
        ({"time_step": 0.0}, "time step must be positive"),
        ({"strong_phase": (2.0, 20.0)}, "strong phase must lie inside"),
        ({"seed": -1}, "must not be negative"),
        ({"iterations": -1}, "must not be negative"),
        ({"pga": 0.0}, "peak ground acceleration must be positive"),
        ({"matched": (0.2, 101.0)}, "Nyquist"),
        ({"matched": (0.01, 33.0)}, "one cycle"),
        ({"matched": (33.0, 0.2)}, "matched frequencies"),
    ],
)
def test_bad_arguments_are_refused(change, message):
    with pytest.raises(ImpactfemError, match=message):
        synthesise(TARGET, **{"seed": 1, **PAPER, **change})


def test_a_stronger_target_needs_a_stronger_motion():
    weak = DesignSpectrum(1.15, TARGET.corner_periods)
    half = synthesise(weak, seed=1, **{**PAPER, "pga": 1.16})
    full = synthesise(TARGET, seed=1, **PAPER)
    assert isinstance(half.accelerogram, Accelerogram)
    scaled = 2.0 * half.accelerogram.acceleration
    assert scaled == pytest.approx(full.accelerogram.acceleration, abs=1e-6)


def test_envelope_by_hand():
    time = [0.0, 1.0, 2.0, 3.5, 5.0, 12.5, 19.5, 20.0]
    level = envelope(time, 20.0, (2.0, 5.0))
    assert level[:5].tolist() == [0.0, 0.25, 1.0, 1.0, 1.0]
    assert level[5] == pytest.approx(0.05**0.5)  # halfway through a decay to 0.05
    assert level[6] == pytest.approx(0.05 ** (14.5 / 15) * 0.5)  # half of the last twentieth
    assert level[7] == 0.0


def test_strong_phase_may_fill_the_motion():
    level = envelope([0.0, 5.0, 9.4, 10.0], 10.0, (0.0, 10.0))
    assert level.tolist() == [1.0, 1.0, 1.0, 0.0]


@pytest.mark.parametrize("phase", [(-1.0, 5.0), (5.0, 5.0), (6.0, 5.0), (2.0, 21.0)])
def test_envelopes_refused(phase):
    with pytest.raises(ImpactfemError, match="strong phase must"):
        envelope([0.0], 20.0, phase)
