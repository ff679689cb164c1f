import numpy as np
import pytest

from impactfem.spectra import at_common_frequencies, interpolate_damping, interpolate_frequency
from impactfem.system.errors import ImpactfemError


def test_powers_of_frequency_are_kept():
    f = np.array([1.0, 2.0, 7.0, 50.0])
    wanted = np.geomspace(1.0, 50.0, 23)
    values = np.stack([3.0 * f**1.7, f**-2.0])
    found = interpolate_frequency(f, values, wanted)
    np.testing.assert_allclose(found, [3.0 * wanted**1.7, wanted**-2.0], rtol=1e-13)
    # A straight line on linear axes is another thing.
    assert interpolate_frequency([1.0, 4.0], [1.0, 4.0**2], [2.0])[0] == pytest.approx(4.0)
    assert np.interp(2.0, [1.0, 4.0], [1.0, 16.0]) == pytest.approx(6.0)


def test_listed_ordinates_are_given_back():
    f, s = [1.0, 3.0, 13.0, 33.0], [1.0, 25.0, 24.0, 1.0]
    np.testing.assert_allclose(interpolate_frequency(f, s, f), s, rtol=1e-14)
    assert interpolate_frequency([5.0], [2.0], [5.0, 5.0]).tolist() == [2.0, 2.0]


def test_zero_has_no_logarithm():
    found = interpolate_frequency([1.0, 100.0, 1e4], [0.0, 8.0, 8.0], [1.0, 10.0, 100.0, 1e3])
    np.testing.assert_allclose(found, [0.0, 4.0, 8.0, 8.0], rtol=1e-14)


@pytest.mark.parametrize("wanted", [[0.999], [10.1], [float("nan")], []])
def test_nothing_is_extrapolated(wanted):
    with pytest.raises(ImpactfemError, match="known from 1 Hz to 10 Hz"):
        interpolate_frequency([1.0, 10.0], [1.0, 2.0], wanted)


@pytest.mark.parametrize(
    ("frequency", "values", "message"),
    [
        ([2.0, 1.0], [1.0, 1.0], "ascending"),
        ([0.0, 1.0], [1.0, 1.0], "positive"),
        ([], [], "positive"),
        ([1.0, 2.0], [1.0, 1.0, 1.0], "as many ordinates"),
        ([1.0, 2.0], [1.0, -1.0], "not negative"),
        ([1.0, 2.0], [1.0, float("inf")], "finite"),
    ],
)
def test_what_is_no_spectrum_is_refused(frequency, values, message):
    with pytest.raises(ImpactfemError, match=message):
        interpolate_frequency(frequency, values, [1.0])


def test_between_dampings_the_logarithm_is_linear():
    values = [[25.0, 4.0], [10.0, 1.0]]
    found = interpolate_damping([0.005, 0.05], values, [0.0275, 0.05])
    np.testing.assert_allclose(found, [250.0**0.5, 1.0], rtol=1e-14)
    # Not linear in the ordinate, and not in the logarithm of the damping.
    assert found[0] != pytest.approx(17.5, rel=0.05)
    halfway = np.sqrt(0.005 * 0.05)
    assert interpolate_damping([0.005, 0.05], values, halfway)[0] > 250.0**0.5 * 1.1
    assert interpolate_damping([0.02], [[3.0, 4.0]], 0.02).tolist() == [3.0, 4.0]


@pytest.mark.parametrize(
    ("damping", "values", "wanted", "message"),
    [
        ([0.05, 0.02], np.ones((2, 3)), 0.03, "ascend"),
        ([0.02, 1.0], np.ones((2, 3)), 0.03, "ratio < 1"),
        ([0.02, 0.05], np.ones(3), 0.03, "shape"),
        ([0.02, 0.05], np.ones((3, 3)), 0.03, "shape"),
        ([0.02, 0.05], np.ones((2, 3)), 0.07, "0.07 was asked for"),
        ([0.02, 0.05], np.ones((2, 3)), [0.02, 0.01, 0.05], "0.01 was asked for"),
    ],
)
def test_dampings_refused(damping, values, wanted, message):
    with pytest.raises(ImpactfemError, match=message):
        interpolate_damping(damping, values, wanted)


def test_common_list():
    f, values = at_common_frequencies(
        [([1.0, 4.0, 16.0], [1.0, 16.0, 256.0]), ([2.0, 8.0, 32.0], [2.0, 8.0, 32.0])]
    )
    assert f == pytest.approx([2.0, 4.0, 8.0, 16.0])
    np.testing.assert_allclose(values, [f**2, f], rtol=1e-13)


@pytest.mark.parametrize(
    ("curves", "message"),
    [
        ([], "no spectra"),
        ([([1.0, 2.0], [1.0, 1.0]), ([3.0, 4.0], [1.0, 1.0])], "share no range"),
        ([([1.0, 2.0], [1.0, 1.0]), ([1.0, 2.0], [[1.0, 1.0]])], "leading axes"),
    ],
)
def test_lists_that_do_not_go_together(curves, message):
    with pytest.raises(ImpactfemError, match=message):
        at_common_frequencies(curves)
