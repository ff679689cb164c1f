import numpy as np
import pytest

from impactfem.motion import (
    Accelerogram,
    Criteria,
    DesignSpectrum,
    TableSpectrum,
    acceptance,
    rg160_power_spectrum,
    synthesise,
)
from impactfem.motion.acceptance import _longest_run
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
    assert result.points_below + result.points_above <= 201


@pytest.mark.parametrize(
    ("factor", "name"), [(1.2, "smallest_ratio"), (0.7, "largest_ratio"), (1.05, "longest_below")]
)
def test_too_low_and_too_high(motion, factor, name):
    result = acceptance(motion, own_spectrum(motion, factor), minimum=0.5)
    assert not result.verdict(name).passed
    assert not result.accepted
    assert result.points_below == (201 if factor > 1.0 else 0)
    assert result.points_above == (0 if factor > 1.0 else 201)


def test_where_it_is_worst(motion):
    target = own_spectrum(motion)
    bump = np.where(np.abs(np.log(target.frequency / 5.0)) < 0.02, 1.5, 1.0)
    raised = TableSpectrum(target.frequency, target.acceleration * bump)
    result = acceptance(motion, raised, minimum=0.5)
    assert result.frequency_of_smallest_ratio == pytest.approx(5.0, rel=0.03)
    assert result.misfit.smallest_ratio == pytest.approx(1 / 1.5, rel=0.03)
    assert result.verdict("longest_below").value < 10  # narrow: only the depth is refused
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


def test_zero_crossings():
    t = np.arange(4001) * 0.005
    result = acceptance(Accelerogram(0.005, np.sin(2 * np.pi * 3.0 * t + 0.1)), TARGET, minimum=1.0)
    assert result.zero_crossings == pytest.approx(6.0, abs=0.1)


def test_longest_run():
    assert _longest_run(np.array([], dtype=bool)) == 0
    assert _longest_run(np.array([True, False, True, True, False])) == 2
    assert _longest_run(np.array([False, True, True, True])) == 3
    assert _longest_run(np.zeros(4, dtype=bool)) == 0


def test_refused(motion):
    with pytest.raises(ImpactfemError, match="0 < minimum < maximum <= Nyquist frequency, 50 Hz"):
        acceptance(motion, TARGET, maximum=60.0)
    with pytest.raises(ImpactfemError, match="zero throughout"):
        acceptance(Accelerogram(0.01, np.zeros(3000)), TARGET)
    with pytest.raises(KeyError):
        acceptance(motion, TARGET).verdict("beauty")
