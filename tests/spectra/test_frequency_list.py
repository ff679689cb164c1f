import numpy as np
import pytest

from impactfem.spectra import (
    at_common_frequencies,
    interpolate_damping,
    interpolate_frequency,
    logarithmic_frequencies,
    merged_frequencies,
    rg_1_122_frequencies,
)


@pytest.mark.parametrize(
    ("low", "high", "per_decade", "size"), [(1.0, 100.0, 100, 201), (0.5, 500.0, 7, 22)]
)
def test_both_ends_and_at_least_the_density(low, high, per_decade, size):
    f = logarithmic_frequencies(low, high, per_decade)
    assert (f.size, f[0], f[-1]) == (size, low, high)
    steps = np.diff(np.log10(f))
    assert steps == pytest.approx(steps[0])
    assert steps[0] <= 1 / per_decade + 1e-12


def test_list_of_the_regulatory_guide():
    f = rg_1_122_frequencies()
    assert f.size == 75
    assert (f[0], f[-1]) == (0.2, 34.0)
    # Decimal values, not sums of 0.1: 0.3 is 0.3.
    assert {0.3, 2.9, 3.0, 3.15, 3.6, 3.8, 5.0, 5.25, 8.0, 8.5, 15.0, 16.0, 18.0, 20.0} <= set(f)
    assert {3.1, 3.5, 19.0, 24.0} & set(f) == set()


def test_list_goes_on_for_impacts():
    f = rg_1_122_frequencies(340.0, 10)
    assert f.size == 75 + 10
    np.testing.assert_array_equal(f[:75], rg_1_122_frequencies())
    assert f[75:] / f[74:-1] == pytest.approx(10**0.1)
    assert f[-1] == 340.0


def test_merged_lists_ascend_without_repetition():
    f = merged_frequencies([3.0, 1.0], [2.0, 3.0 * (1 + 1e-12)], 5.0)
    assert f == pytest.approx([1.0, 2.0, 3.0, 5.0])
    assert merged_frequencies([3.0], [3.0 * (1 + 1e-6)]).size == 2


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


def test_between_dampings_the_logarithm_is_linear():
    values = [[25.0, 4.0], [10.0, 1.0]]
    found = interpolate_damping([0.005, 0.05], values, [0.0275, 0.05])
    np.testing.assert_allclose(found, [250.0**0.5, 1.0], rtol=1e-14)
    # Not linear in the ordinate, and not in the logarithm of the damping.
    assert found[0] != pytest.approx(17.5, rel=0.05)
    halfway = np.sqrt(0.005 * 0.05)
    assert interpolate_damping([0.005, 0.05], values, halfway)[0] > 250.0**0.5 * 1.1
    assert interpolate_damping([0.02], [[3.0, 4.0]], 0.02).tolist() == [3.0, 4.0]


def test_common_list():
    f, values = at_common_frequencies(
        [([1.0, 4.0, 16.0], [1.0, 16.0, 256.0]), ([2.0, 8.0, 32.0], [2.0, 8.0, 32.0])]
    )
    assert f == pytest.approx([2.0, 4.0, 8.0, 16.0])
    np.testing.assert_allclose(values, [f**2, f], rtol=1e-13)
