import numpy as np
import pytest

from impactfem.errors import ImpactfemError
from impactfem.spectra import logarithmic_frequencies


def test_whole_decades():
    f = logarithmic_frequencies(1.0, 100.0, 100)
    assert f.size == 201
    assert (f[0], f[100], f[-1]) == (1.0, pytest.approx(10.0), 100.0)


def test_other_ranges_keep_both_ends_and_at_least_the_density():
    f = logarithmic_frequencies(0.5, 500.0, 7)
    assert (f[0], f[-1]) == (0.5, 500.0)
    steps = np.diff(np.log10(f))
    assert steps == pytest.approx(steps[0])
    assert steps[0] <= 1 / 7 + 1e-12


@pytest.mark.parametrize(
    "arguments", [(0.0, 1.0), (2.0, 1.0), (1.0, 1.0), (float("nan"), 1.0), (1.0, float("inf"))]
)
def test_empty_ranges_are_refused(arguments):
    with pytest.raises(ImpactfemError, match="0 < minimum < maximum"):
        logarithmic_frequencies(*arguments)


def test_no_points_are_refused():
    with pytest.raises(ImpactfemError, match="at least 1 point"):
        logarithmic_frequencies(1.0, 2.0, 0)
