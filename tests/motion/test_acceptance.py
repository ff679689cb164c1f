from itertools import groupby

import numpy as np
import pytest

from impactfem.motion.acceptance import (
    CORRELATION_LIMIT,
    Criteria,
    Misfit,
    acceptance,
    pair_correlation,
    spectral_misfit,
)
from impactfem.motion.design_spectrum import DesignSpectrum, TableSpectrum
from impactfem.motion.power_spectrum import rg160_power_spectrum
from impactfem.motion.synthesis import synthesise
from impactfem.records.accelerogram import Accelerogram
from impactfem.spectra import logarithmic_frequencies, response_spectra
from impactfem.system.errors import ImpactfemError

TARGET = DesignSpectrum(3.0, (0.15, 0.4, 2.0))


@pytest.fixture(scope="module")
def motion():
    made = synthesise(TARGET, duration=20.0, time_step=0.01, strong_phase=(2.0, 12.0), seed=3)
    return made.accelerogram


def own_spectrum(motion, factor=1.0):
    """A target that the motion meets exactly, times a factor."""
    f = logarithmic_frequencies(0.5, 50.0, 400)
    psa = response_spectra(motion.acceleration, motion.time_step, f, [0.05]).psa[0, 0]
    return TableSpectrum(f, factor * psa)


def test_a_motion_that_meets_its_target_is_accepted(motion):
    result = acceptance(motion, own_spectrum(motion), minimum=0.5)
    assert result.accepted, [v for v in result.verdicts if not v.passed]
    assert result.verdict("smallest_ratio").value == pytest.approx(1.0, abs=0.01)
    assert result.misfit.frequency.size == 201
    assert result.verdict("points_per_decade").value == pytest.approx(100.0)


@pytest.mark.parametrize(
    ("factor", "name"), [(1.2, "smallest_ratio"), (0.7, "largest_ratio"), (1.05, "longest_below")]
)
def test_too_low_and_too_high(motion, factor, name):
    result = acceptance(motion, own_spectrum(motion, factor), minimum=0.5)
    assert not result.verdict(name).passed
    assert not result.accepted
    assert np.all((result.misfit.ratio < 1.0) == (factor > 1.0))
    assert result.verdict("longest_below").value == (201 if factor > 1.0 else 0)


def test_where_it_is_worst(motion):
    target = own_spectrum(motion)
    bump = np.where(np.abs(np.log(target.frequency / 5.0)) < 0.02, 1.5, 1.0)
    raised = TableSpectrum(target.frequency, target.acceleration * bump)
    result = acceptance(motion, raised, minimum=0.5)
    worst = result.misfit.frequency[np.argmin(result.misfit.ratio)]
    assert worst == pytest.approx(5.0, rel=0.03)
    assert result.misfit.smallest_ratio == pytest.approx(1 / 1.5, rel=0.03)
    below = [len(list(run)) for low, run in groupby(result.misfit.ratio < 1.0) if low]
    assert result.verdict("longest_below").value == max(below) < 10  # only the depth is refused
    assert not result.verdict("smallest_ratio").passed


def test_a_hole_in_the_density_is_refused(motion):
    f = np.fft.rfftfreq(8192, motion.time_step)
    spectrum = np.fft.rfft(motion.acceleration, 8192)
    spectrum[(f > 5.0) & (f < 8.5)] *= 0.2
    holed = Accelerogram(0.01, np.fft.irfft(spectrum, 8192)[: motion.acceleration.size])
    assert acceptance(motion, TARGET, minimum=0.5).verdict("psd_ratio").passed
    result = acceptance(holed, TARGET, minimum=0.5)
    assert not result.verdict("psd_ratio").passed
    worst = result.psd_frequency[np.argmin(result.psd / result.psd_target)]
    assert 5.0 < worst < 8.5


def test_a_target_density_given(motion):
    weak = acceptance(motion, TARGET, minimum=0.5, psd=lambda f: rg160_power_spectrum(f, 0.3))
    strong = acceptance(motion, TARGET, minimum=0.5, psd=lambda f: rg160_power_spectrum(f, 30.0))
    assert weak.verdict("psd_ratio").limit == 0.8
    assert weak.verdict("psd_ratio").passed
    assert not strong.verdict("psd_ratio").passed


def test_a_short_motion():
    made = synthesise(TARGET, duration=8.0, time_step=0.02, strong_phase=(1.0, 3.0), seed=1)
    result = acceptance(made.accelerogram, TARGET, minimum=0.5, maximum=25.0)
    failed = {verdict.name for verdict in result.verdicts if not verdict.passed}
    assert {"duration", "strong_phase", "nyquist"} <= failed
    lenient = Criteria(duration=8.0, strong_phase=1.0, nyquist=25.0)
    result = acceptance(made.accelerogram, TARGET, minimum=0.5, maximum=25.0, criteria=lenient)
    failed = {verdict.name for verdict in result.verdicts if not verdict.passed}
    assert not {"duration", "strong_phase", "nyquist"} & failed


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


NOISE = np.random.default_rng(6).standard_normal((2, 4000))
FIRST, SECOND = (Accelerogram(0.005, a) for a in NOISE)


def test_a_motion_with_another_and_with_itself():
    assert abs(pair_correlation(FIRST, SECOND)) < 0.05 < CORRELATION_LIMIT
    assert pair_correlation(FIRST, FIRST) == pytest.approx(1.0)
    assert pair_correlation(FIRST, FIRST.scaled(-3.0)) == pytest.approx(-1.0)


def test_a_known_share():
    share, first = 0.2, NOISE[0] - NOISE[0].mean()
    orthogonal = NOISE[1] - NOISE[1].mean()
    orthogonal -= first * (orthogonal @ first) / (first @ first)
    orthogonal *= np.sqrt((first @ first) / (orthogonal @ orthogonal))
    mixed = share * first + np.sqrt(1.0 - share**2) * orthogonal
    # An offset does not matter.
    assert pair_correlation(FIRST, Accelerogram(0.005, mixed + 7.0)) == pytest.approx(share)


def test_the_shorter_one_rests_after_its_end():
    short = Accelerogram(0.005, NOISE[0][:2000])
    continued = Accelerogram(0.005, np.pad(NOISE[0][:2000], (0, 2000)))
    assert pair_correlation(short, FIRST) == pair_correlation(continued, FIRST)


def test_refused(motion):
    with pytest.raises(ImpactfemError, match="maximum <= Nyquist frequency, 50"):
        acceptance(motion, TARGET, maximum=60.0)
    with pytest.raises(ImpactfemError, match="zero throughout"):
        acceptance(Accelerogram(0.01, np.zeros(3000)), TARGET)
    with pytest.raises(KeyError):
        acceptance(motion, TARGET).verdict("beauty")
    with pytest.raises(ImpactfemError, match=r"0.005 s and 0.01 s cannot"):
        pair_correlation(FIRST, Accelerogram(0.01, NOISE[1]))
    with pytest.raises(ImpactfemError, match="does not change"):
        pair_correlation(FIRST, Accelerogram(0.005, np.ones(4000)))
