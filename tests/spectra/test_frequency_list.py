import numpy as np
import pytest

from impactfem.spectra import (
    logarithmic_frequencies,
    merged_frequencies,
    rg_1_122_frequencies,
    structural_frequencies,
)
from impactfem.system.errors import ImpactfemError


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


@pytest.mark.parametrize("maximum", [34.0, 10.0, float("nan")])
def test_list_cannot_go_on_downwards(maximum):
    with pytest.raises(ImpactfemError, match="ends at 34 Hz"):
        rg_1_122_frequencies(maximum)


def test_merged_lists_ascend_without_repetition():
    f = merged_frequencies([3.0, 1.0], [2.0, 3.0 * (1 + 1e-12)], 5.0)
    assert f == pytest.approx([1.0, 2.0, 3.0, 5.0])
    assert merged_frequencies([3.0], [3.0 * (1 + 1e-6)]).size == 2


def test_structural_frequencies_with_their_uncertainty():
    assert structural_frequencies([7.0, 2.0], 0.15) == pytest.approx(
        [1.7, 2.0, 2.3, 5.95, 7.0, 8.05]
    )
    assert structural_frequencies([7.0, 2.0]) == pytest.approx([2.0, 7.0])


@pytest.mark.parametrize("bad", [[], [1.0, 0.0], [float("nan")], [float("inf")], [-1.0]])
def test_what_is_no_frequency_is_refused(bad):
    with pytest.raises(ImpactfemError, match="positive finite"):
        merged_frequencies(bad)
    with pytest.raises(ImpactfemError, match="positive finite"):
        structural_frequencies(bad)


def test_no_list_at_all_is_refused():
    with pytest.raises(ImpactfemError, match="at least one"):
        merged_frequencies()


@pytest.mark.parametrize("spread", [-0.1, 1.0, float("nan")])
def test_spread_out_of_range(spread):
    with pytest.raises(ImpactfemError, match="spread"):
        structural_frequencies([1.0], spread)
