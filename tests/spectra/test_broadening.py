import numpy as np
import pytest

from impactfem.spectra import broaden, corner_frequencies, interpolate_frequency
from impactfem.system.errors import ImpactfemError

F = np.array([1.0, 5.0, 10.0, 20.0, 100.0])
PEAK = np.array([1.0, 1.0, 9.0, 1.0, 1.0])


def brute_force(f, s, lower, upper, wanted):
    """The definition, on a very fine window."""
    found = []
    for at in wanted:
        window = np.geomspace(at / (1.0 + upper), at / (1.0 - lower), 4001)
        window = window[(window >= f[0]) & (window <= f[-1])]
        found.append(interpolate_frequency(f, s, window).max())
    return np.array(found)


@pytest.mark.parametrize("ratio", [(0.15, 0.15), (0.1, 0.3), (0.0, 0.2), (0.25, 0.0)])
def test_definition_on_a_random_spectrum(ratio):
    rng = np.random.default_rng(8)
    f = np.unique(np.exp(rng.uniform(0.0, 5.0, 60)))
    s = rng.lognormal(0.0, 0.7, f.size)
    wanted = np.geomspace(f[0], f[-1], 91)
    wanted[[0, -1]] = f[[0, -1]]
    found = broaden(f, s, ratio, wanted)
    expected = brute_force(f, s, *ratio, wanted)
    # The fine window misses the very summit by a little, never exceeds it.
    assert np.all(found >= expected * (1.0 - 1e-12))
    np.testing.assert_allclose(found, expected, rtol=5e-3)


def test_never_below_the_computed_spectrum_and_no_higher_than_its_peak():
    rng = np.random.default_rng(2)
    f = np.geomspace(0.5, 500.0, 301)
    s = rng.lognormal(0.0, 0.5, (2, 3, f.size))
    found = broaden(f, s)
    assert found.shape == s.shape
    assert np.all(found >= s)
    np.testing.assert_array_equal(found.max(axis=-1), s.max(axis=-1))
    assert np.any(found > s)


def test_a_peak_of_another_program():
    # Verification case of an envelope-and-broaden command: 5 on 1 becomes 5 from 8.5 to 11.5.
    x, y = [1.0, 5.0, 9.0, 10.0, 11.0, 15.0, 20.0], [1.0, 1.0, 1.0, 5.0, 1.0, 1.0, 1.0]
    listed = corner_frequencies(x, [(x, y)])
    assert set(np.round([7.65, 8.5, 11.5, 12.65], 9)) <= set(np.round(listed, 9))
    assert broaden(x, y, 0.15, [7.65, 8.5, 10.0, 11.5, 12.65]) == pytest.approx([1, 5, 5, 5, 1])
    # With 10 % the plateau is narrower.
    assert broaden(x, y, 0.10, [8.5, 11.5])[0] < 5.0


def test_zero_ratio_changes_nothing():
    np.testing.assert_allclose(broaden(F, PEAK, 0.0), PEAK, rtol=1e-14)
    np.testing.assert_array_equal(corner_frequencies(F, [(F, PEAK)], 0.0), F)


def test_zero_spectrum_stays_zero():
    assert not broaden(F, np.zeros(5)).any()
    np.testing.assert_array_equal(corner_frequencies(F, [(F, np.zeros(5))]), F)
    assert broaden([3.0], [2.0]).tolist() == [2.0]


def test_end_of_the_list_is_kept():
    # The zero-period acceleration at the high end is neither raised nor lost.
    f = np.array([1.0, 10.0, 50.0, 60.0, 100.0])
    assert broaden(f, [1.0, 8.0, 2.0, 2.0, 2.0])[-1] == pytest.approx(2.0)


@pytest.mark.parametrize("seed", range(5))
def test_straight_lines_between_design_frequencies_are_safe(seed):
    rng = np.random.default_rng(seed)
    f = np.unique(np.exp(rng.uniform(0.0, 5.0, 40)))
    s = rng.lognormal(0.0, 0.7, (2, f.size))
    listed = corner_frequencies(f, [(f, one) for one in s])
    assert set(f) <= set(listed)
    fine = np.geomspace(f[0], f[-1], 1500)
    fine[[0, -1]] = f[[0, -1]]
    straight = interpolate_frequency(listed, broaden(f, s, 0.15, listed), fine)
    exact = broaden(f, s, 0.15, fine)
    assert np.min(straight / exact) > 1.0 - 1.001e-3
    # Through the list alone the corners are cut off.
    alone = interpolate_frequency(f, broaden(f, s, 0.15), fine)
    assert np.min(alone / exact) < 0.95


@pytest.mark.parametrize("ratio", [-0.1, 1.0, (0.1, -0.1), (1.0, 0.1), float("nan")])
def test_ratios_refused(ratio):
    with pytest.raises(ImpactfemError, match="ratios of at least 0"):
        broaden(F, PEAK, ratio)
    with pytest.raises(ImpactfemError, match="ratios of at least 0"):
        corner_frequencies(F, [(F, PEAK)], ratio)


def test_refused():
    with pytest.raises(ImpactfemError, match="in this range only"):
        broaden(F, PEAK, 0.15, [0.5])
    with pytest.raises(ImpactfemError, match="in this range only"):
        broaden(F, PEAK, 0.15, [101.0])
    with pytest.raises(ImpactfemError, match="as many ordinates"):
        broaden(F, PEAK[:-1])
    with pytest.raises(ImpactfemError, match="no spectra"):
        corner_frequencies(F, [])
