"""Slow oscillators in strides of samples: the peaks of those that go from sample to sample."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.spectra import peaks as module
from impactfem.spectra.oscillator import step_coefficients
from impactfem.spectra.peaks import peak_responses
from impactfem.spectra.strides import LANES, LEAST, LENGTHS, strides_of

H = 1e-3
FREQUENCIES = np.geomspace(0.05, 480.0, 203)
SLOW = 2.0 * np.pi * FREQUENCIES * H * 16.0 < 0.9


def records(n):
    """Noise that swells and dies, impulses early, late and at the end, nothing, shape (6, n)."""
    rng = np.random.default_rng(3)
    found = np.zeros((6, n))
    found[:2] = rng.standard_normal((2, n)) * np.hanning(n)
    for row, at in zip(found[2:5], (n // 7, n // 2 + 5, n - 2), strict=True):
        row[min(at, n - 2) :][:2] = 3.0, -1.0
    return found


@pytest.mark.parametrize("n", [2, 16, 17, 64, 65, 81, 2000, 20_011])
def test_the_peaks_are_those_of_all_samples(n):
    """For few and many strides, and what is left behind the last one; |x| as with |x'' + a|."""
    c = step_coefficients(H, FREQUENCIES, [0.0, 0.02, 0.7, 0.95])
    a = records(n)
    expected, found = peak_responses(a, c)[0], peak_responses(a, c, absolute=False)[0]
    assert found == pytest.approx(expected, rel=1e-10, abs=1e-13 * expected.max())


def test_which_oscillators_take_strides():
    """Each in one group, the slower the longer; less than one in radians; groups are large."""
    c = step_coefficients(H, FREQUENCIES[::-1], [0.05, 0.02])
    groups, others = strides_of(c, np.zeros((6, c.omega.size)))
    assert [one.length for one in groups] == list(LENGTHS)
    every = np.concatenate([others, *(one.index for one in groups)])
    assert np.array_equal(np.sort(every), np.arange(c.omega.size))
    for one in groups:
        assert one.length * H * c.omega[one.index].max() <= 1.0
        assert len(one.index) % LANES == 0 and len(one.index) >= LEAST
        assert one.columns.shape[1] < 14
    assert len(others) < c.omega.size - 2 * SLOW.sum() + LANES
    few = step_coefficients(H, FREQUENCIES[:20], [0.05])
    assert strides_of(few, np.zeros((6, 20)))[0] == []


def test_a_peak_inside_a_stride_is_found_by_its_bound(monkeypatch):
    """Without it most peaks are those at the ends of strides, a few per cent lower."""
    c, a = step_coefficients(H, FREQUENCIES, [0.05]), records(5000)
    expected = peak_responses(a, c, absolute=False)[0]

    def unbound(coefficients, rows):
        groups, others = strides_of(coefficients, rows)
        return [replace(one, bend=-1e9 * np.ones_like(one.bend)) for one in groups], others

    monkeypatch.setattr(module, "strides_of", unbound)
    lower = peak_responses(a, c, absolute=False)[0]
    assert np.all(lower <= expected * (1.0 + 1e-12))
    assert np.mean(lower[:, SLOW] < 0.9999 * expected[:, SLOW]) > 0.2


@pytest.mark.parametrize(("absolute", "close"), [(True, 0.0), (False, 1e-13)])
def test_threads_change_nothing(absolute, close):
    c, a = step_coefficients(H, FREQUENCIES, [0.05]), records(3000)
    one, three = (peak_responses(a, c, threads=k, absolute=absolute) for k in (1, 3))
    np.testing.assert_allclose(three, one, rtol=close)
