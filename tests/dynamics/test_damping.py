import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh, checked_ratio
from impactfem.system.errors import ImpactfemError


def test_ratio_by_hand():
    # α / (2 ω) + β ω / 2 at ω = 2π 2 Hz.
    assert Rayleigh(0.5, 0.0).ratio(2.0) == pytest.approx(0.5 / (8 * np.pi))
    assert Rayleigh(0.0, 1e-3).ratio(2.0) == pytest.approx(2 * np.pi * 1e-3)
    assert Rayleigh(0.0, 0.0).ratio(2.0) == 0.0


def test_ratio_is_the_decay_of_the_oscillator():
    alpha, beta, m, k = 0.838, 1.06e-3, 3.0, 3.0 * (2 * np.pi * 7.3) ** 2
    c = alpha * m + beta * k
    pole = np.linalg.eigvals(np.array([[0.0, 1.0], [-k / m, -c / m]]))[0]
    found = Rayleigh(alpha, beta).ratio(7.3)
    assert found == pytest.approx(-pole.real / abs(pole), rel=1e-12)
    assert abs(found - Rayleigh(alpha, 2 * beta).ratio(7.3)) > 0.01


def test_two_frequencies_of_the_paper():
    # 7 % at 1 Hz and 20 Hz, lower between them, 28 % at 85 Hz (section 3.2.2).
    w = 2 * np.pi * np.array([1.0, 20.0])
    damping = Rayleigh(0.14 * w.prod() / w.sum(), 0.14 / w.sum())
    ratios = damping.ratio(np.array([1.0, np.sqrt(20.0), 20.0, 85.0]))
    assert ratios[[0, 2]] == pytest.approx(0.07, rel=1e-12)
    assert ratios[1] == pytest.approx(0.0298, abs=1e-4)
    assert ratios[3] == pytest.approx(0.28, abs=0.005)


def test_two_per_cent_at_30_and_80_hz():
    damping = Rayleigh.through(0.02, 30.0, 80.0)
    assert damping.ratio([30.0, 80.0]) == pytest.approx([0.02, 0.02], rel=1e-12)
    # The lowest ratio is at the geometric mean.
    assert damping.ratio(np.sqrt(2400.0)) < damping.ratio([45.0, 55.0]).min()
    assert damping.ratio(300.0) > 0.05


@pytest.mark.parametrize("ratio", [1.0, 1.5, -0.01, float("nan")])
def test_damping_of_100_per_cent_is_refused(ratio):
    with pytest.raises(ImpactfemError, match="expected 0 <= ratio < 1"):
        Rayleigh.through(ratio, 30.0, 80.0)
    with pytest.raises(ImpactfemError, match="expected 0 <= ratio < 1"):
        checked_ratio(ratio)
    assert checked_ratio(0.99) == 0.99


@pytest.mark.parametrize("pair", [(80.0, 30.0), (0.0, 30.0), (30.0, 30.0), (30.0, float("inf"))])
def test_frequencies_that_do_not_ascend_are_refused(pair):
    with pytest.raises(ImpactfemError, match="expected two frequencies, the lower first"):
        Rayleigh.through(0.02, *pair)


@pytest.mark.parametrize("pair", [(-1.0, 0.0), (0.0, -1e-9), (float("nan"), 0.0)])
def test_negative_coefficients_are_refused(pair):
    with pytest.raises(ImpactfemError, match="finite and not negative"):
        Rayleigh(*pair)
