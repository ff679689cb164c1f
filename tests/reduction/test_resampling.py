"""From one grid of times to another: impulse and moment are kept."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from impactfem.reduction.loads import project

Array = NDArray[np.float64]

GIVEN = 0.25e-3
LAST = 0.1


def pulse(time: Array) -> Array:
    """An impact of 9 ms, and one of 2 ms."""
    long = np.where(np.abs(time - 0.03) < 4.5e-3, np.cos(np.pi * (time - 0.03) / 9e-3), 0.0)
    short = np.where(np.abs(time - 0.0711) < 1e-3, 1.0, 0.0)
    return np.column_stack([2e6 * long, short])


def moments(time: Array, values: Array, end: float) -> Array:
    """∫ f dt and ∫ t f dt up to a time, cell by cell; of a product of straight lines, exactly."""
    inside = np.append(time[time < end], min(end, time[-1]))
    f = np.column_stack([np.interp(inside, time, column) for column in values.T])
    h, t = np.diff(inside)[:, None], inside[:, None]
    impulse = h * (f[1:] + f[:-1]) / 2
    moment = h * (2 * t[1:] * f[1:] + 2 * t[:-1] * f[:-1] + t[1:] * f[:-1] + t[:-1] * f[1:]) / 6
    return np.array([impulse.sum(axis=0), moment.sum(axis=0)])


@pytest.mark.parametrize("step", [GIVEN, GIVEN / 4, 1e-3, 5e-3, 0.37e-3, np.pi * 1e-3])
def test_impulse_and_moment_are_kept(step: float) -> None:
    time = GIVEN * np.arange(round(LAST / GIVEN) + 1)
    n = int(np.ceil(LAST / step))
    found = project(time, pulse(time), step, n)
    assert found.shape == (n + 1, 2)
    grid = step * np.arange(n + 1)
    expected = moments(time, pulse(time), n * step)
    assert moments(grid, found, n * step) == pytest.approx(expected, rel=1e-12)


def test_linear_interpolation_keeps_neither() -> None:
    """Which is why it is not used: 5 ms between samples of a pulse of 2 ms."""
    time = GIVEN * np.arange(round(LAST / GIVEN) + 1)
    grid = 5e-3 * np.arange(21)
    interpolated = np.column_stack([np.interp(grid, time, f) for f in pulse(time).T])
    expected, found = moments(time, pulse(time), LAST), moments(grid, interpolated, LAST)
    assert np.abs(found / expected - 1.0)[:, 1].min() > 0.05


@pytest.mark.parametrize("end", [0.03, 0.0287, 0.0711])
def test_window_that_cuts_an_impulse(end: float) -> None:
    """What is before its end is kept, and nothing of what is behind."""
    time = GIVEN * np.arange(round(LAST / GIVEN) + 1)
    values = pulse(time)
    found = project(time, values, end / 40, 40)
    grid = end / 40 * np.arange(41)
    expected = moments(time, values, end)
    assert expected[0, 0] < 0.99 * moments(time, values, LAST)[0, 0] or end > 0.04
    assert moments(grid, found, end) == pytest.approx(expected, rel=1e-12)
    later = np.where((time > end + GIVEN)[:, None], 1e9, values)
    assert project(time, later, end / 40, 40) == pytest.approx(found, rel=1e-12)


@pytest.mark.parametrize("step", [1e-3, 0.0125, 0.1 / 7])
def test_straight_line_is_itself(step: float) -> None:
    time = np.linspace(0.0, 0.1, 12)
    n = round(0.1 / step)
    found = project(time, (3.0 - 40.0 * time)[:, None], step, n)
    assert found[:, 0] == pytest.approx(3.0 - 40.0 * step * np.arange(n + 1), abs=1e-12)


def test_finer_grid_with_the_same_corners_gives_the_same_function() -> None:
    rng = np.random.default_rng(1)
    time, values = np.linspace(0.0, 1.0, 21), rng.standard_normal((21, 3))
    found = project(time, values, 0.01, 100)
    grid = np.linspace(0.0, 1.0, 101)
    expected = np.column_stack([np.interp(grid, time, column) for column in values.T])
    assert found == pytest.approx(expected, abs=1e-12)


def test_it_is_the_nearest_one() -> None:
    """The error is at right angles to all hats: any other function is farther away."""
    rng = np.random.default_rng(2)
    time, values = np.linspace(0.0, 1.0, 31), rng.standard_normal((31, 1))
    found = project(time, values, 0.07, 14)
    fine = np.linspace(0.0, 0.98, 200_001)
    grid = 0.07 * np.arange(15)

    def distance(nodal: Array) -> float:
        difference = np.interp(fine, grid, nodal) - np.interp(fine, time, values[:, 0])
        return float(np.mean(difference**2))

    nearest = distance(found[:, 0])
    for k in range(15):
        for change in (-0.05, 0.05):
            other = found[:, 0].copy()
            other[k] += change
            assert distance(other) > nearest


def test_zero_outside_the_given_times() -> None:
    """A force that ends with a jump, before the window does."""
    time = np.linspace(0.0, 0.4, 5)
    found = project(time, np.ones((5, 1)), 0.03, 40)
    grid = 0.03 * np.arange(41)
    assert moments(grid, found, 1.2) == pytest.approx(np.array([[0.4], [0.08]]), rel=1e-12)
    assert np.abs(found[25:]).max() < 1e-3


def test_no_forces() -> None:
    assert project(np.array([0.0, 1.0]), np.zeros((2, 0)), 0.1, 10).shape == (11, 0)


def test_samples_outside_an_impact_alternate_and_fall() -> None:
    """As docs/theory/transient.md and the captions of figures 11, 16 and 17 say."""
    time = GIVEN * np.arange(round(LAST / GIVEN) + 1)
    found = project(time, pulse(time)[:, :1], 1e-3, 100)[:, 0]
    # The long pulse is from 25.5 ms to 34.5 ms: samples 25 and 35 are the last outside it.
    before, after = found[15:26][::-1], found[35:46]
    for samples in (before, after):
        assert samples[1:] / samples[:-1] == pytest.approx(np.sqrt(3.0) - 2.0, rel=1e-6)
    assert np.abs(before[0]) > 1e-3 * found.max()
    # Inside they do not.
    assert found[27:33].min() > 0.0
