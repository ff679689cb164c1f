"""What the functions of the package refuse, and in which words."""

from functools import partial

import numpy as np
import pytest

from impactfem.spectra import (
    at_common_frequencies,
    broaden,
    clip_peaks,
    combine,
    corner_frequencies,
    fractile,
    interpolate_damping,
    interpolate_frequency,
    logarithmic_frequencies,
    merged_frequencies,
    oscillator_response,
    response_spectra,
    rg_1_122_frequencies,
    rigid_frequency,
)
from impactfem.spectra.oscillator import step_coefficients
from impactfem.spectra.peaks import peak_responses
from impactfem.spectra.response_spectrum import upsample
from impactfem.spectra.statistics import over_members
from impactfem.system.errors import ImpactfemError

NAN, INF, ONE, TWO = float("nan"), float("inf"), np.ones((2, 3)), [0.02, 0.05]
F, PEAK = [1.0, 5.0, 10.0, 20.0, 100.0], [1.0, 1.0, 9.0, 1.0, 1.0]
RATIOS, RECORD = "ratios of at least 0", {"acceleration": [0.0, 1.0, 0.0], "time_step": 0.01}
RECORD |= {"frequencies": [1.0], "dampings": [0.05]}


def of(function, message, *rows):
    return [(partial(function, *row), message) for row in rows]


def spectra(message, **change):
    return partial(response_spectra, **(RECORD | change)), message


REFUSED = [
    *of(logarithmic_frequencies, "0 < minimum < maximum",
        (0.0, 1.0), (2.0, 1.0), (1.0, 1.0), (NAN, 1.0), (1.0, INF)),
    *of(logarithmic_frequencies, "at least 1 point", (1.0, 2.0, 0)),
    *of(rg_1_122_frequencies, "ends at 34 Hz", (34.0,), (10.0,), (NAN,)),
    *of(merged_frequencies, "positive finite", ([],), ([1.0, 0.0],), ([NAN],), ([INF],), ([-1.0],)),
    *of(merged_frequencies, "at least one", ()),
    *of(interpolate_frequency, "known from 1 Hz to 10 Hz",
        *(([1.0, 10.0], [1.0, 2.0], wanted) for wanted in ([0.999], [10.1], [NAN], []))),
    *of(interpolate_frequency, "ascending", ([2.0, 1.0], [1.0, 1.0], [1.0])),
    *of(interpolate_frequency, "positive", ([0.0, 1.0], [1.0, 1.0], [1.0]), ([], [], [1.0])),
    *of(interpolate_frequency, "as many ordinates", ([1.0, 2.0], [1.0, 1.0, 1.0], [1.0])),
    *of(interpolate_frequency, "not negative", ([1.0, 2.0], [1.0, -1.0], [1.0])),
    *of(interpolate_frequency, "finite", ([1.0, 2.0], [1.0, INF], [1.0])),
    *of(interpolate_damping, "ascend", ([0.05, 0.02], ONE, 0.03)),
    *of(interpolate_damping, "ratio < 1", ([0.02, 1.0], ONE, 0.03)),
    *of(interpolate_damping, "shape", (TWO, np.ones(3), 0.03), (TWO, np.ones((3, 3)), 0.03)),
    *of(interpolate_damping, "0.07 was requested", (TWO, ONE, 0.07)),
    *of(interpolate_damping, "0.01 was requested", (TWO, ONE, [0.02, 0.01, 0.05])),
    *of(at_common_frequencies, "no spectra", ([],)),
    *of(at_common_frequencies, "share no range",
        ([([1.0, 2.0], [1.0, 1.0]), ([3.0, 4.0], [1.0, 1.0])],)),
    *of(at_common_frequencies, "leading axes",
        ([([1.0, 2.0], [1.0, 1.0]), ([1.0, 2.0], [[1.0, 1.0]])],)),
    *((partial(make, F, of_one, ratio), RATIOS)
      for make, of_one in ((broaden, PEAK), (corner_frequencies, [(F, PEAK)]))
      for ratio in (-0.1, 1.0, (0.1, -0.1), (1.0, 0.1), NAN)),
    *of(broaden, "in this range only", (F, PEAK, 0.15, [0.5]), (F, PEAK, 0.15, [101.0])),
    *of(broaden, "as many ordinates", (F, PEAK[:-1])),
    *of(corner_frequencies, "no spectra", (F, [])),
    *of(clip_peaks, "one spectrum at a time", (F, [PEAK, PEAK])),
    *of(clip_peaks, "as many ordinates", (F, PEAK[1:])),
    *of(rigid_frequency, "tolerance", (F, np.ones(5), 1.0, 0.0)),
    *of(rigid_frequency, "zero-period accelerations of shape", (F, np.ones((2, 5)), [1.0] * 3)),
    *of(fractile, "between 0 and 1", *((ONE, p) for p in (0.0, 1.0, 84, NAN))),
    *of(fractile, "empirical", (ONE, 0.5, "normal")),
    *of(fractile, "above zero", ([1.0, 0.0], 0.5, "lognormal")),
    *of(fractile, "two values", ([1.0], 0.5, "lognormal")),
    *of(combine, "'envelope', 'mean' or the probability", (ONE, "largest")),
    *of(combine, "at least one value", *((np.empty((0, 3)), s) for s in ("envelope", "mean", 0.5))),
    *of(over_members, "one of median, mean, p84, p84_lognormal, got p95", (ONE, "p95")),
    *of(over_members, "lognormal fractile needs", (np.zeros((3, 2)), "p84_lognormal")),
    *of(upsample, "whole number >= 1", (np.ones((1, 4)), 0)),
    (partial(peak_responses, ONE, None, threads=0), "threads must be at least 1"),
    *of(step_coefficients, "time step must be positive",
        *((step, 1.0, 0.05) for step in (0.0, -0.01, NAN))),
    *of(step_coefficients, "positive finite numbers in Hz",
        *((0.01, f, 0.05) for f in (0.0, INF, []))),
    *of(step_coefficients, "over-damped", (0.01, 1.0, 1.0)),
    *of(step_coefficients, "0 <= ratio < 1", *((0.01, 1.0, xi) for xi in (5.0, -0.01, NAN))),
    *of(oscillator_response, "one record of finite numbers",
        *((record, 0.01, [1.0], [0.05]) for record in ([], [0.0, NAN], [[1.0, 2.0]]))),
    spectra("at least 2 samples", acceleration=[1.0]),
    spectra("at least 2 samples", acceleration=np.zeros((2, 2, 2))),
    spectra("record 1 holds a value", acceleration=[[0.0, 1.0], [0.0, NAN]]),
    spectra("time step must be positive", time_step=0.0),
    spectra("positive finite", frequencies=[-1.0]),
    spectra("0 <= ratio < 1", dampings=[1.0]),
    spectra("at least 2", points_per_cycle=1.9),
    spectra("at least 2", points_per_cycle=NAN),
    spectra("method is one of", method="sampled"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "message"), REFUSED)
def test_refused(make, message):
    with pytest.raises(ImpactfemError, match=message):
        make()
