import numpy as np
import pytest

from impactfem.spectra import (
    broaden,
    clip_peaks,
    corner_frequencies,
    interpolate_frequency,
    rigid_frequency,
)

F = np.array([1.0, 5.0, 10.0, 20.0, 100.0])
PEAK = np.array([1.0, 1.0, 9.0, 1.0, 1.0])
RIGID = [1.0, 2.0, 5.0, 10.0, 50.0]


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


@pytest.mark.parametrize(("s", "ratio"), [(PEAK, 0.0), (np.zeros(5), 0.15)])
def test_what_stays_as_it_is(s, ratio):
    """With a ratio of zero, a spectrum of zeros, one frequency, and the end of the list."""
    np.testing.assert_allclose(broaden(F, s, ratio), s, rtol=1e-14)
    np.testing.assert_array_equal(corner_frequencies(F, [(F, s)], ratio), F)
    assert broaden([3.0], [2.0]).tolist() == [2.0]
    # The zero-period acceleration at the high end is neither raised nor lost.
    ends = broaden([1.0, 10.0, 50.0, 60.0, 100.0], [1.0, 8.0, 2.0, 2.0, 2.0])
    assert ends[-1] == pytest.approx(2.0)


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


def test_narrow_peak_is_cut_flat():
    f, s, peaks = clip_peaks(F, PEAK)
    (peak,) = peaks
    assert (peak.frequency, peak.before, peak.after) == (10.0, 9.0, pytest.approx(7.65))
    assert s.max() == pytest.approx(7.65)
    fine = np.geomspace(1.0, 100.0, 999)
    fine[[0, -1]] = [1.0, 100.0]
    expected = np.minimum(interpolate_frequency(F, PEAK, fine), 7.65)
    np.testing.assert_allclose(interpolate_frequency(f, s, fine), expected, rtol=1e-12)
    assert broaden(f, s, 0.15, [8.5, 11.5]) == pytest.approx([7.65, 7.65])


def test_limit_of_the_bandwidth():
    # Vertical to the eye: between 0.8 P at f1 and f2, B = (f2 - f1) / ((f1 + f2) / 2).
    for width, narrow in ((0.29, True), (0.31, False)):
        f1, f2 = 10.0 * (1.0 - width / 2), 10.0 * (1.0 + width / 2)
        f = [1.0, f1 * (1 - 1e-9), f1 * (1 + 1e-9), 10.0, f2 * (1 - 1e-9), f2 * (1 + 1e-9), 100.0]
        _, _, peaks = clip_peaks(f, [1.0, 1.0, 9.5, 10.0, 9.5, 1.0, 1.0])
        assert bool(peaks) == narrow
        if narrow:
            assert peaks[0].bandwidth == pytest.approx(width, abs=1e-6)


SUMMITS = [1.0, 9.0, 9.8, 10.0, 10.2, 11.0, 100.0]
TWO = [1.0, 4.0, 5.0, 6.0, 20.0, 22.0, 24.0, 100.0]


@pytest.mark.parametrize(
    ("f", "s", "zpa", "peaks", "largest"),
    [
        # A wide peak is left, and one at the end of the list, which has no width.
        ([1.0, 2.0, 10.0, 50.0, 100.0], [1.0, 1.0, 2.0, 1.0, 1.0], 0.0, [], 2.0),
        *(([1.0, 2.0, 3.0], s, 0.0, [], max(s)) for s in ([1, 1, 9], [9, 1, 1], [8, 9, 8])),
        # Summits of one peak count once, two peaks are two.
        (SUMMITS, [1.0, 1.0, 10.0, 9.0, 9.6, 1.0, 1.0], 0.0, [(9.8, 10.0, 8.5)], 8.5),
        (
            *(TWO, [1.0, 1.0, 6.0, 1.0, 1.0, 10.0, 1.0, 1.0], 0.0),
            *([(5.0, 6.0, 5.1), (22.0, 10.0, 8.5)], 8.5),
        ),
        # Not below the zero-period acceleration; with zeros beside it.
        (F, PEAK, 8.0, [(10.0, 9.0, 8.0)], 8.0),
        (F, PEAK, 9.0, [], 9.0),
        ([1, 9, 10, 11, 20], [0.0, 0.0, 4.0, 0.0, 0.0], 0.0, [(10.0, 4.0, 3.4)], 3.4),
    ],
)
def test_which_peaks_are_cut(f, s, zpa, peaks, largest):
    at, values, found = clip_peaks(f, s, zpa=zpa)
    rows = [(one.frequency, one.before, one.after) for one in found]
    assert np.ravel(rows) == pytest.approx(np.ravel(peaks))
    assert values.max() == pytest.approx(largest) and (peaks or len(at) == len(f))
    for place, _, after in peaks:
        assert interpolate_frequency(at, values, [place])[0] == pytest.approx(after)


def test_first_frequency_from_which_on_it_stays():
    spectra = [[1.0, 9.0, 4.0, 2.05, 2.0], [2.0, 2.0, 2.2, 2.0, 2.0], [2.0] * 5]
    found = rigid_frequency(RIGID, spectra, [2.0, 2.0, 2.0])
    np.testing.assert_array_equal(found, [10.0, 10.0, 1.0])
    # Another tolerance, another frequency.
    np.testing.assert_array_equal(rigid_frequency(RIGID, spectra, [2.0] * 3, 0.2), [10.0, 1.0, 1.0])
    np.testing.assert_array_equal(rigid_frequency(RIGID, spectra, [2.0] * 3, 0.01)[:1], [50.0])
    # A list that ends too early, and a floor at rest.
    assert np.isnan(rigid_frequency(RIGID, [1.0, 2.0, 3.0, 4.0, 5.0], 2.0))
    assert rigid_frequency(RIGID, np.zeros(5), 0.0) == 1.0
