import numpy as np
import pytest
from scipy import stats

from impactfem.spectra import combine, envelope, fractile, mean
from impactfem.spectra.statistics import statistic_words
from impactfem.system.errors import ImpactfemError

AXES = ("motion", "floor", "frequency")
VALUES = np.random.default_rng(5).lognormal(0.0, 0.5, (9, 3, 4))


def test_envelope_and_mean_by_name():
    np.testing.assert_array_equal(envelope(VALUES, AXES, ["motion"]), VALUES.max(axis=0))
    np.testing.assert_array_equal(envelope(VALUES, AXES, ["floor"]), VALUES.max(axis=1))
    np.testing.assert_allclose(mean(VALUES, AXES, ["motion", "floor"]), VALUES.mean(axis=(0, 1)))
    assert not np.array_equal(mean(VALUES, AXES, ["motion"]), envelope(VALUES, AXES, ["motion"]))


def test_empirical_fractiles_by_hand():
    four = np.array([4.0, 1.0, 3.0, 2.0])
    # The values stand at 1/8, 3/8, 5/8, 7/8.
    for p, value in ((0.125, 1.0), (0.25, 1.5), (0.5, 2.5), (0.625, 3.0), (0.99, 4.0), (0.01, 1.0)):
        assert fractile(four, ["motion"], ["motion"], p) == pytest.approx(value)


def test_median_is_the_middle_value():
    middle = np.median(VALUES, axis=0)
    np.testing.assert_allclose(fractile(VALUES, AXES, ["motion"], 0.5), middle)
    np.testing.assert_allclose(combine(VALUES, AXES, ["motion"], 0.5), middle)


def test_lognormal_fractile_against_scipy():
    sample = VALUES[:, 0, 0]
    s = np.log(sample).std(ddof=1)
    expected = stats.lognorm.ppf(0.84, s, scale=np.exp(np.log(sample).mean()))
    found = fractile(VALUES, AXES, ["motion"], 0.84, "lognormal")
    assert found[0, 0] == pytest.approx(expected, rel=1e-12)
    assert found[0, 0] != pytest.approx(fractile(VALUES, AXES, ["motion"], 0.84)[0, 0], rel=1e-3)


def test_both_fractiles_meet_for_many_values():
    many = np.random.default_rng(1).lognormal(0.3, 0.4, 20_000)
    empirical = fractile(many, ["motion"], ["motion"], 0.84)
    lognormal = fractile(many, ["motion"], ["motion"], 0.84, "lognormal")
    assert empirical == pytest.approx(lognormal, rel=0.02)


def test_combine_by_name():
    np.testing.assert_array_equal(
        combine(VALUES, AXES, ["floor"], "envelope"), envelope(VALUES, AXES, ["floor"])
    )
    np.testing.assert_array_equal(
        combine(VALUES, AXES, ["floor"], "mean"), mean(VALUES, AXES, ["floor"])
    )
    with pytest.raises(ImpactfemError, match="'envelope', 'mean' or the probability"):
        combine(VALUES, AXES, ["floor"], "largest")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("axes", "over", "message"),
    [
        (("motion", "floor"), ["motion"], "cannot have the axes"),
        (("motion", "motion", "floor"), ["motion"], "cannot have the axes"),
        (AXES, ["point"], "over point; the axes are motion, floor, frequency"),
        (AXES, [], "cannot take statistics"),
        (AXES, ["floor", "floor"], "cannot take statistics"),
        (AXES, "floor", "cannot take statistics"),
    ],
)
def test_names_that_do_not_fit(axes, over, message):
    with pytest.raises(ImpactfemError, match=message):
        envelope(VALUES, axes, over)


@pytest.mark.parametrize("probability", [0.0, 1.0, 84, float("nan")])
def test_no_probability(probability):
    with pytest.raises(ImpactfemError, match="between 0 and 1"):
        fractile(VALUES, AXES, ["motion"], probability)


def test_fractiles_refused():
    with pytest.raises(ImpactfemError, match="empirical"):
        fractile(VALUES, AXES, ["motion"], 0.5, "normal")  # type: ignore[arg-type]
    with pytest.raises(ImpactfemError, match="above zero"):
        fractile([1.0, 0.0], ["motion"], ["motion"], 0.5, "lognormal")
    with pytest.raises(ImpactfemError, match="two values"):
        fractile([1.0], ["motion"], ["motion"], 0.5, "lognormal")
    with pytest.raises(ImpactfemError, match="no spectrum over motion"):
        envelope(np.empty((0, 3)), ("motion", "frequency"), ["motion"])


def test_words():
    assert [statistic_words(s) for s in ("mean", 0.5, 0.84)] == ["mean", "median", "84 % fractile"]
