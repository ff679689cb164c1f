"""Modes, factors and responses do not depend on the number of ranks."""

from pathlib import Path

import numpy as np
import pytest

SCRIPT = Path(__file__).with_name("on_ranks.py")
RANKS = (3,)


@pytest.fixture(scope="module")
def of_ranks(on_ranks):
    return on_ranks(SCRIPT)


def close(found, expected, tolerance):
    return np.abs(found - expected).max() <= tolerance * np.abs(expected).max() > 0.0


@pytest.mark.parametrize("ranks", RANKS)
def test_modes(of_ranks, ranks):
    one, many = of_ranks(1), of_ranks(ranks)
    assert many["ranks"] == ranks == len(many["rows"]) and min(many["rows"]) > 0
    assert np.array_equal(many["random"], one["random"])
    assert many["frequency"] == pytest.approx(one["frequency"], rel=1e-11)
    assert many["residual"].max() < 1e-10
    assert close(many["shapes"], one["shapes"], 1e-9)
    assert close(many["factor"], one["factor"], 1e-9)
    assert many["total"] == pytest.approx(one["total"], rel=1e-13)


@pytest.mark.parametrize("ranks", (1, *RANKS))
def test_factorisations(of_ranks, ranks):
    many = of_ranks(ranks)
    assert many["solved"] < 1e-9
    assert many["inertia"] == (5, 0, sum(many["rows"]) - 5)
    n = sum(many["rows"])
    said, row = many["island"]
    assert f"1 of {3 * n} eigenvalues" in said and n <= row < 2 * n
    assert f"5 negative eigenvalues of {n}" in many["indefinite"][0]
    said, row = many["empty"]
    assert f"1 of {n} diagonal entries" in said and row == 100


@pytest.mark.parametrize("ranks", RANKS)
def test_responses(of_ranks, ranks):
    one, many = of_ranks(1), of_ranks(ranks)
    for name, motion in one["motion"].items():
        assert motion.shape == (301, 4)
        assert close(many["motion"][name], motion, 1e-10), name
        assert close(many["resumed"][name], many["motion"][name][137:], 1e-10), name
    assert close(many["end"], one["end"], 1e-10)
    assert close(many["energy"], one["energy"], 1e-11)
    assert many["residual of energy"] < 1e-12


def test_on_one_rank_it_goes_on_bitwise(of_ranks):
    one = of_ranks(1)
    for name, motion in one["motion"].items():
        assert np.array_equal(one["resumed"][name], motion[137:]), name
