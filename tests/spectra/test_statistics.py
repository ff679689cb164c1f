from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from impactfem.spectra import FloorSpectrumSet, Station, broaden, combine, fractile
from impactfem.spectra.statistics import STATISTICS, over_members, statistic_words

F = np.geomspace(1.0, 40.0, 30)
VALUES = np.random.default_rng(5).lognormal(0.0, 0.5, (9, 3, 4))


def test_empirical_fractiles_by_hand():
    four = np.array([4.0, 1.0, 3.0, 2.0])
    # The values stand at 1/8, 3/8, 5/8, 7/8.
    for p, value in ((0.125, 1.0), (0.25, 1.5), (0.5, 2.5), (0.625, 3.0), (0.99, 4.0), (0.01, 1.0)):
        assert fractile(four, p) == pytest.approx(value)


def test_lognormal_fractile_against_scipy():
    sample = VALUES[:, 0, 0]
    s = np.log(sample).std(ddof=1)
    expected = stats.lognorm.ppf(0.84, s, scale=np.exp(np.log(sample).mean()))
    lognormal = fractile(VALUES, 0.84, "lognormal")
    assert lognormal[0, 0] == pytest.approx(expected, rel=1e-12)
    assert lognormal[0, 0] != pytest.approx(fractile(VALUES, 0.84)[0, 0], rel=1e-3)


@pytest.mark.parametrize(
    ("statistic", "words", "expected"),
    [
        ("envelope", "envelope", VALUES.max(axis=0)),
        ("mean", "mean", VALUES.mean(axis=0)),
        (0.5, "median", np.median(VALUES, axis=0)),
        (0.84, "84 % fractile", np.quantile(VALUES, 0.84, axis=0, method="hazen")),
    ],
)
def test_combine_by_name(statistic, words, expected):
    assert statistic_words(statistic) == words
    np.testing.assert_allclose(combine(VALUES, statistic), expected)


def test_lognormal_sample():
    """Of a lognormal sample: median e^m, mean e^(m + s²/2), 84 % e^(m + 0.99446 s)."""
    m, s = 1.3, 0.4
    values = np.random.default_rng(5).lognormal(m, s, (40_000, 2))
    exponents = m, m + 0.5 * s * s, m + 0.994458 * s, m + 0.994458 * s
    for name, exponent in zip(STATISTICS, exponents, strict=True):
        np.testing.assert_allclose(over_members(values, name), np.exp(exponent), rtol=0.02)


def test_empirical_and_lognormal_differ_where_the_sample_is_not_lognormal():
    values = np.array([1.0] * 9 + [50.0])
    assert over_members(values, "p84") == 1.0
    assert over_members(values, "p84_lognormal") > 3.0


@pytest.fixture
def members():
    curve = 1.0 + 5.0 / (1.0 + (8.0 * (F / 7.0 - 1.0)) ** 2)
    psa = np.multiply.outer([1.0, 2.0, 4.0], curve)[:, None, None, None]
    return FloorSpectrumSet(
        frequency=F,
        damping=np.array([0.05]),
        stations=(Station("B", "1", ("centre_1", "edge_1"), 3.0),),
        directions=("y",),
        psa=psa,
        zpa=np.array([1.0, 2.0, 4.0])[:, None, None],
        motions=("a", "b", "c"),
        title="t",
        method="m",
    )


def test_set_of_a_statistic(members):
    result = members.of_members("mean")
    np.testing.assert_allclose(result.psa[0], members.psa[0] * 7.0 / 3.0)
    assert result.zpa[0, 0, 0] == pytest.approx(7.0 / 3.0)
    assert result.motions == ("mean of 3 motions",) and result.stations == members.stations
    design = result.design(0.15)
    assert design.motions_text == "mean of 3 motions"
    wanted = broaden(F, result.psa[0, 0, 0, 0], 0.15, design.frequency)
    np.testing.assert_allclose(design.psa[0, 0, 0], wanted)


def test_identical_members(members):
    same = replace(members, psa=np.repeat(members.psa[:1], 3, axis=0), zpa=np.ones((3, 1, 1)))
    alone = replace(members, psa=members.psa[:1], zpa=members.zpa[:1], motions=("a",))
    for name in STATISTICS:
        result, wanted = same.of_members(name).design(), alone.design()
        np.testing.assert_allclose(result.psa, wanted.psa, rtol=1e-12)
    assert np.all(members.of_members("p84").design().psa > 1.5 * alone.design().psa.min())
