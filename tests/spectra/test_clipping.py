import numpy as np
import pytest

from impactfem.spectra import broaden, clip_peaks, interpolate_frequency
from impactfem.system.errors import ImpactfemError

F = np.array([1.0, 5.0, 10.0, 20.0, 100.0])
NARROW = np.array([1.0, 1.0, 9.0, 1.0, 1.0])


def test_narrow_peak_is_cut_flat():
    f, s, peaks = clip_peaks(F, NARROW)
    (peak,) = peaks
    assert (peak.frequency, peak.before, peak.after) == (10.0, 9.0, pytest.approx(7.65))
    assert s.max() == pytest.approx(7.65)
    fine = np.geomspace(1.0, 100.0, 999)
    fine[[0, -1]] = [1.0, 100.0]
    expected = np.minimum(interpolate_frequency(F, NARROW, fine), 7.65)
    np.testing.assert_allclose(interpolate_frequency(f, s, fine), expected, rtol=1e-12)
    assert broaden(f, s, 0.15, [8.5, 11.5]) == pytest.approx([7.65, 7.65])


def test_wide_peak_is_left():
    f, s, peaks = clip_peaks([1.0, 2.0, 10.0, 50.0, 100.0], [1.0, 1.0, 2.0, 1.0, 1.0])
    assert peaks == ()
    assert s.max() == 2.0
    assert f.size == 5


def test_limit_of_the_bandwidth():
    # Vertical to the eye: between 0.8 P at f1 and f2, B = (f2 - f1) / ((f1 + f2) / 2).
    for width, narrow in ((0.29, True), (0.31, False)):
        f1, f2 = 10.0 * (1.0 - width / 2), 10.0 * (1.0 + width / 2)
        f = [1.0, f1 * (1 - 1e-9), f1 * (1 + 1e-9), 10.0, f2 * (1 - 1e-9), f2 * (1 + 1e-9), 100.0]
        _, _, peaks = clip_peaks(f, [1.0, 1.0, 9.5, 10.0, 9.5, 1.0, 1.0])
        assert bool(peaks) == narrow
        if narrow:
            assert peaks[0].bandwidth == pytest.approx(width, abs=1e-6)


def test_summits_of_one_peak_count_once():
    f = [1.0, 9.0, 9.8, 10.0, 10.2, 11.0, 100.0]
    _, s, peaks = clip_peaks(f, [1.0, 1.0, 10.0, 9.0, 9.6, 1.0, 1.0])
    assert [peak.frequency for peak in peaks] == [9.8]
    assert s.max() == pytest.approx(8.5)


def test_two_peaks_are_two():
    f = [1.0, 4.0, 5.0, 6.0, 20.0, 22.0, 24.0, 100.0]
    _, _, peaks = clip_peaks(f, [1.0, 1.0, 6.0, 1.0, 1.0, 10.0, 1.0, 1.0])
    assert [(peak.frequency, peak.before) for peak in peaks] == [(5.0, 6.0), (22.0, 10.0)]


def test_peak_at_the_end_of_the_list_has_no_width():
    for s in ([1.0, 1.0, 9.0], [9.0, 1.0, 1.0], [8.0, 9.0, 8.0]):
        assert clip_peaks([1.0, 2.0, 3.0], s)[2] == ()


def test_not_below_the_zero_period_acceleration():
    _, s, peaks = clip_peaks(F, NARROW, zpa=8.0)
    assert peaks[0].after == 8.0
    assert s.max() == 8.0
    assert clip_peaks(F, NARROW, zpa=9.0)[2] == ()


def test_zero_beside_a_peak():
    f, s, peaks = clip_peaks([1.0, 9.0, 10.0, 11.0, 20.0], [0.0, 0.0, 4.0, 0.0, 0.0])
    assert peaks[0].after == pytest.approx(3.4)
    assert interpolate_frequency(f, s, [10.0])[0] == pytest.approx(3.4)


def test_refused():
    with pytest.raises(ImpactfemError, match="one spectrum at a time"):
        clip_peaks(F, [NARROW, NARROW])
    with pytest.raises(ImpactfemError, match="as many ordinates"):
        clip_peaks(F, NARROW[1:])
