"""The resolved band: limits by cause, and what other time steps change."""

import math

import numpy as np
import pytest

from impactfem.spectra.resolved import (
    COUNTS,
    ORDER,
    POINTS,
    ResolvedBand,
    agreement,
    band_limited_zpa,
    refinement_limit,
    step_limit,
)

F = np.array([1.0, 10.0, 20.0, 50.0, 100.0, 200.0])


def band(**limits):
    """A band that one cause limits by 500 Hz and others by what is given."""
    causes = ("time_step", "oscillators", "mesh", "basis", "contact", "refinement")
    return ResolvedBand(**(dict.fromkeys(causes, math.inf) | {"oscillators": 500.0} | limits))


@pytest.mark.parametrize(
    ("limits", "end", "cause"),
    [
        ({}, 500.0, "samples and highest frequency of the spectra"),
        ({"mesh": 143.0, "time_step": 200.0}, 143.0, "mesh of the slabs"),
        ({"refinement": 64.0, "time_step": 100.0}, 64.0, "sensitivity to the time steps"),
    ],
)
def test_the_lowest_limit_governs(limits, end, cause):
    found = band(**limits)
    assert (found.frequency, found.governing) == (end, cause)
    assert found.attributes == {"resolved_frequency": end, "resolved_by": cause}


def test_steps_in_a_cycle():
    assert step_limit(1e-3) == pytest.approx(1.0 / (POINTS * 1e-3))


@pytest.mark.parametrize(("order", "resolved"), [(0.049, math.inf), (0.051, 50.0)])
@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_an_error_of_first_order_is_extrapolated(order, resolved, ratio):
    """A quarter of the step changes the ordinates from 100 Hz on by 4.9 % and 5.1 %."""
    psa = np.ones((1, 3, F.size))
    error = np.where(F >= 100.0, order / 0.75, 0.0)  # c h
    other = psa + error * (ratio - 1.0)
    assert refinement_limit(F, psa, other, ratio) == resolved


def test_small_ordinates_do_not_count():
    """Below a tenth of the largest ordinate at the same damping a change does not count."""
    psa = np.ones((2, 2, F.size))
    for part, resolved in ((0.9, math.inf), (1.1, 10.0)):
        psa[1, 1] = part * COUNTS
        other = psa.copy()
        other[1, 1, 2:] *= 2.0
        assert agreement(F, psa, other) == resolved
    assert agreement(F, np.zeros_like(psa), psa) == math.inf


def test_at_least_the_lowest_frequency():
    psa = np.ones((1, F.size))
    assert agreement(F, psa, 2.0 * psa) == F[0]


@pytest.mark.parametrize("frequency", [10.0, 50.0, 100.0, 200.0])
def test_zpa_of_a_sine_by_the_response_of_the_filter(frequency):
    """Two passes of order 4: 1 / (1 + (tan(π f h) / tan(π f_c h))⁸), half at the corner."""
    step, corner = 1e-3, 50.0
    time = step * np.arange(4001)
    window = np.sin(np.pi * time / time[-1]) ** 2  # no step at either end
    motion = (window * np.sin(2.0 * np.pi * frequency * (time - time[2000]) + 1.0))[:, None]
    ratio = math.tan(math.pi * frequency * step) / math.tan(math.pi * corner * step)
    expected = 1.0 / (1.0 + ratio ** (2 * ORDER))
    found = band_limited_zpa(motion, step, corner)
    assert found.shape == (1,) and found[0] == pytest.approx(expected, rel=0.02, abs=1e-4)


def test_zpa_above_the_samples_is_the_peak():
    motion = np.array([[0.0], [-3.0], [1.0]])
    assert band_limited_zpa(motion, 1e-3, 500.0)[0] == 3.0
