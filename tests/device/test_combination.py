from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from impactfem.device.combination import (
    PLANES,
    Combination,
    Gupta,
    LindleyYow,
    combine_inputs,
    combine_modes,
    correlation,
)
from impactfem.device.spectrum import AnchorSpectrum
from impactfem.sticks.element import COMPONENTS
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


@pytest.mark.parametrize(
    ("rule", "duration", "words"),
    [
        ("sum", None, "is one of abs, srss.*: got 'sum'"),
        ("dsc", None, "the double sum needs the duration"),
        ("dsc", 0.0, "the double sum needs the duration"),
        ("cqc", None, "CQC needs damped modes"),
    ],
)
def test_bad_rules_are_refused(rule, duration, words):
    with pytest.raises(ImpactfemError, match=words):
        combine_modes(R, F, 0.0 * XI, rule, duration)
    with pytest.raises(ImpactfemError, match="has no coefficients"):
        correlation("abs", F, XI)


INPUTS = np.array([[3.0, 1.0], [4.0, 2.0], [12.0, 2.0]])


def test_rules_by_hand():
    assert combine_inputs(INPUTS, "srss") == pytest.approx([13.0, 3.0])
    assert combine_inputs(INPUTS, "abs") == pytest.approx([19.0, 5.0])
    assert combine_inputs(INPUTS, "100-40-40") == pytest.approx([12.0 + 2.8, 2.0 + 1.2])
    assert combine_inputs(INPUTS[::-1], "100-40-40") == pytest.approx([14.8, 3.2])

    for rule in ("srss", "abs", "100-40-40"):
        assert combine_inputs(INPUTS[:1], rule) == pytest.approx(INPUTS[0])
    with pytest.raises(ImpactfemError, match="abs, 100-40-40: got 'max'"):
        combine_inputs(INPUTS, "max")
    # Every component has its plane.
    assert sorted(c for plane in PLANES for c in plane) == sorted(COMPONENTS)


SPECTRUM = AnchorSpectrum(
    "y",
    np.array([1.0, 4.0, 8.0, 33.0, 60.0]),
    np.array([0.02, 0.05]),
    np.array([[2.0, 16.0, 16.0, 4.0, 4.0], [1.0, 8.0, 8.0, 4.0, 4.0]]),
    4.0,
)
RATIO = np.full(5, 0.02)
FREQUENCY = np.array([1.0, 5.0, 12.0, 33.0, 50.0])
S = SPECTRUM.at(FREQUENCY, RATIO)[0]


def test_gupta_from_the_spectrum():
    # Largest pseudo-velocity at 4 Hz: f1 = 16 / (16 / 4); rigid from 33 Hz on.
    f1, f2 = Gupta().corners(SPECTRUM, 0.02)
    assert (f1, f2) == pytest.approx((4.0, 70.0 / 3.0))
    found = Gupta().fraction(SPECTRUM, FREQUENCY, RATIO, S)
    assert found[[0, 3, 4]].tolist() == [0.0, 1.0, 1.0]
    assert found[2] == pytest.approx(np.log(12.0 / 4.0) / np.log(70.0 / 12.0))
    assert 0.0 < found[1] < found[2]


def test_gupta_with_given_frequencies():
    found = Gupta(10.0, 20.0).fraction(SPECTRUM, FREQUENCY, RATIO, S)
    assert found == pytest.approx([0.0, 0.0, np.log(1.2) / np.log(2.0), 1.0, 1.0])
    for corners in ((20.0, 10.0), (0.0, 10.0)):
        with pytest.raises(ImpactfemError, match="expected 0 < f1 < f2"):
            Gupta(*corners)
    with pytest.raises(ImpactfemError, match="expected both frequencies"):
        Gupta(f1=40.0).corners(SPECTRUM, 0.02)
    with pytest.raises(ImpactfemError, match="before it comes"):
        Gupta().corners(replace(SPECTRUM, zpa=1.0), 0.02)


def test_lindley_and_yow():
    found = LindleyYow().fraction(SPECTRUM, FREQUENCY, RATIO, S)
    assert found[[3, 4]] == pytest.approx([1.0, 1.0])
    assert found[2] == pytest.approx(4.0 / S[2])
    assert found[1] == pytest.approx(0.25)
    # Below the amplified range nothing is rigid, although S falls below ZPA.
    assert found[0] == 0.0


def test_a_spectrum_without_ordinates():
    none = replace(SPECTRUM, psa=0.0 * SPECTRUM.psa, zpa=0.0)
    assert np.isfinite(LindleyYow().fraction(none, FREQUENCY, RATIO, 0.0 * S)).all()
