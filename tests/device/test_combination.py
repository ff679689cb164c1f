from typing import get_args

import numpy as np
import pytest

from impactfem.device.combination import Combination, combine_modes, correlation
from impactfem.system.errors import ImpactfemError

F = np.array([10.0, 10.8, 11.5, 40.0])
XI = np.array([0.02, 0.03, 0.05, 0.02])
R = np.array([3.0, -4.0, 12.0, 5.0])


@pytest.mark.parametrize("rule", ["srss", "cqc", "dsc", "dsc-abs", "ten-percent", "grouping"])
def test_coefficients_are_a_correlation(rule):
    found = correlation(rule, F, XI, 10.0)
    assert np.diag(found) == pytest.approx(1.0)
    assert found == pytest.approx(found.T)
    assert found.min() >= 0.0 and found.max() <= 1.0 + 1e-12


def test_far_modes_do_not_correlate():
    for rule in ("cqc", "dsc"):
        found = correlation(rule, F, XI, 20.0)
        assert found[0, 3] < 0.01 < 0.1 < found[0, 1]


def test_a_long_motion_makes_the_double_sum_narrow():
    short, long = (correlation("dsc", F, XI, t)[0, 1] for t in (1.0, 100.0))
    assert short > 1.1 * long
    gap = 2 * np.pi * (10.8 * np.sqrt(1 - 0.03**2) - 10.0 * np.sqrt(1 - 0.02**2))
    rates = 2 * np.pi * (0.02 * 10.0 + 0.03 * 10.8) + 4.0
    assert short == pytest.approx(1.0 / (1.0 + (gap / rates) ** 2))


def test_signs_count_where_they_should():
    flipped = R * np.array([1.0, -1.0, 1.0, 1.0])
    for rule in get_args(Combination):
        one, other = (combine_modes(v, F, XI, rule, 10.0) for v in (R, flipped))
        if rule in ("cqc", "dsc"):
            assert one < 0.98 * other
        else:
            assert one == pytest.approx(other)


def test_order_of_the_rules():
    sizes = {rule: combine_modes(np.abs(R), F, XI, rule, 10.0) for rule in get_args(Combination)}
    assert sizes["srss"] == pytest.approx(np.sqrt(194.0))
    assert sizes["abs"] == pytest.approx(24.0)
    assert all(sizes["srss"] <= size <= sizes["abs"] for size in sizes.values())


def test_close_is_ten_per_cent_of_the_lower():
    f = np.array([10.0, 11.0, 12.11])
    assert correlation("ten-percent", f, XI[:3])[0].tolist() == [1.0, 1.0, 0.0]
    # 12.11 is more than 10 % above 11, and begins a group of its own.
    assert correlation("grouping", f, XI[:3])[1].tolist() == [1.0, 1.0, 0.0]
    assert correlation("ten-percent", f[::-1], XI[:3])[0, 1] == 0.0


def test_many_quantities_at_once():
    many = np.stack([R, 2.0 * R])
    assert combine_modes(many, F, XI) == pytest.approx(combine_modes(R, F, XI) * np.array([1, 2]))
    assert combine_modes(np.zeros((2, 0)), np.zeros(0), np.zeros(0)) == pytest.approx([0.0, 0.0])


def test_modes_that_cancel():
    pair = np.array([10.0, 10.0])
    assert combine_modes(np.array([1.0, -1.0]), pair, np.array([0.02, 0.02])) < 1e-7


def test_bad_rules_are_refused():
    with pytest.raises(ImpactfemError, match=r"is one of abs, srss.*: got 'sum'"):
        combine_modes(R, F, XI, "sum")
    with pytest.raises(ImpactfemError, match="has no coefficients"):
        correlation("abs", F, XI)
    for duration in (None, 0.0):
        with pytest.raises(ImpactfemError, match="the double sum needs the duration"):
            combine_modes(R, F, XI, "dsc", duration)
    with pytest.raises(ImpactfemError, match="CQC needs damped modes"):
        combine_modes(R, F, 0.0 * XI)
