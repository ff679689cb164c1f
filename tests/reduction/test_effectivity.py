"""Ratios of a band and a known error."""

from __future__ import annotations

import numpy as np
import pytest

from impactfem.reduction.effectivity import effectivity, together

# Three in each third of an octave: around 125, 157.5 and 198.4 Hz.
FREQUENCY = 125.0 * 2.0 ** (np.array([-0.4, 0.0, 0.4, 0.6, 1.0, 1.4, 1.6, 2.0, 2.4]) / 3.0)


def test_maxima_within_thirds_of_octaves() -> None:
    """The error of a third and the band of it need not be at the same frequency."""
    truth = np.full((2, 9), 10.0)
    computed, band = truth.copy(), np.zeros((2, 9))
    computed[0, 0], band[0, 2] = 10.5, 1.0
    computed[0, 4], band[0, 5] = 9.0, 0.5
    computed[1, 8], band[1, 6] = 10.1, 1.2
    found = effectivity(band, computed, truth, FREQUENCY)
    order = np.argsort(found.frequency)
    assert found.frequency[order] == pytest.approx([125.0, 157.49, 198.43], rel=1e-4)
    assert found.spectrum[order].tolist() == [0, 0, 1]
    assert found.ratio[order] == pytest.approx([2.0, 0.5, 12.0])
    assert found.good == pytest.approx(1 / 3) and found.held == pytest.approx(2 / 3)
    assert found.misses == [(0, pytest.approx(157.49, rel=1e-4), pytest.approx(0.5))]
    both = together([found, found])
    assert both.good == found.good and len(both.ratio) == 6 and len(both.misses) == 2


def test_errors_that_are_nothing() -> None:
    """Up to a ten-thousandth of the largest of the spectrum in the same third."""
    truth = np.ones((1, 9))
    truth[0, 1] = 100.0
    computed = truth.copy()
    computed[0, 0] += 0.9e-2
    computed[0, 4] += 0.9e-4
    none = effectivity(np.zeros((1, 9)), computed, truth, FREQUENCY)
    assert none.ratio.size == 0 and none.good == none.held == 1.0 and none.misses == []
    computed[0, 4] += 0.2e-4
    assert effectivity(np.zeros((1, 9)), computed, truth, FREQUENCY).held == 0.0
