"""Statistics over members by name, against normal quantiles and counting."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.spectra import FloorSpectrumSet, Station, broaden
from impactfem.spectra.member_statistics import STATISTICS, over_members, statistic_set
from impactfem.system.errors import ImpactfemError

F = np.geomspace(1.0, 40.0, 30)


def test_lognormal_sample():
    """Of a lognormal sample: median e^m, mean e^(m + s²/2), 84 % e^(m + 0.99446 s)."""
    m, s = 1.3, 0.4
    values = np.random.default_rng(5).lognormal(m, s, (40_000, 2))
    wanted = {
        "median": np.exp(m),
        "mean": np.exp(m + 0.5 * s * s),
        "p84": np.exp(m + 0.994458 * s),
        "p84_lognormal": np.exp(m + 0.994458 * s),
    }
    for name in STATISTICS:
        np.testing.assert_allclose(over_members(values, name), wanted[name], rtol=0.02)


def test_empirical_and_lognormal_differ_where_the_sample_is_not_lognormal():
    values = np.array([1.0] * 9 + [50.0])
    assert over_members(values, "p84") == 1.0
    assert over_members(values, "p84_lognormal") > 3.0


def test_refused():
    with pytest.raises(ImpactfemError, match="one of median, mean, p84, p84_lognormal, got p95"):
        over_members(np.ones((3, 2)), "p95")
    with pytest.raises(ImpactfemError, match="lognormal fractile needs"):
        over_members(np.zeros((3, 2)), "p84_lognormal")


@pytest.fixture
def members() -> FloorSpectrumSet:
    one = 1.0 + 5.0 / (1.0 + (8.0 * (F / 7.0 - 1.0)) ** 2)
    psa = np.multiply.outer([1.0, 2.0, 4.0], one)[:, None, None, None]
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
    found = statistic_set(members, "mean")
    np.testing.assert_allclose(found.psa[0], members.psa[0] * 7.0 / 3.0)
    assert found.zpa[0, 0, 0] == pytest.approx(7.0 / 3.0)
    assert found.motions == ("mean of 3 motions",) and found.stations == members.stations
    design = found.design(0.15)
    assert design.motions_text == "mean of 3 motions"
    wanted = broaden(F, found.psa[0, 0, 0, 0], 0.15, design.frequency)
    np.testing.assert_allclose(design.psa[0, 0, 0], wanted)


def test_identical_members(members):
    same = replace(members, psa=np.repeat(members.psa[:1], 3, axis=0), zpa=np.ones((3, 1, 1)))
    alone = replace(members, psa=members.psa[:1], zpa=members.zpa[:1], motions=("a",))
    for name in STATISTICS:
        found, wanted = statistic_set(same, name).design(), alone.design()
        np.testing.assert_allclose(found.psa, wanted.psa, rtol=1e-12)
    assert np.all(statistic_set(members, "p84").design().psa > 1.5 * alone.design().psa.min())
