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


@pytest.mark.parametrize(
    ("make", "pair", "words"),
    [
        *((Rayleigh.through, pair, "expected two frequencies, the lower first")
          for pair in ((80.0, 30.0), (0.0, 30.0), (30.0, 30.0), (30.0, float("inf")))),
        *((Rayleigh, pair, "finite and not negative")
          for pair in ((-1.0, 0.0), (0.0, -1e-9), (float("nan"), 0.0))),
    ],
)  # fmt: skip
def test_pairs_that_are_refused(make, pair, words):
    with pytest.raises(ImpactfemError, match=words):
        make(*([0.02, *pair] if make == Rayleigh.through else pair))
