import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh, checked_ratio
from impactfem.system.errors import ImpactfemError


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
