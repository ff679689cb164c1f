"""A demand and its capacity."""

import json
import math

import pytest

from impactfem.stages.verdict import Verdict, pair_words, verdict_scalars


def verdict(demand=2.0, capacity=4.0, key="limits.gap"):
    return Verdict("stage.gap", "gap", "m", "a place", demand, capacity, key)


@pytest.mark.parametrize(
    ("demand", "capacity", "ratio", "passed"),
    [
        (2.0, 4.0, 0.5, True),
        (4.0, 4.0, 1.0, True),
        (4.4, 4.0, 1.1, False),
        (4.4, None, None, None),
        (None, 4.0, None, None),
        # A gap of zero.
        (0.0, 0.0, 0.0, True),
        (0.1, 0.0, math.inf, False),
    ],
)
def test_ratio(demand, capacity, ratio, passed):
    one = verdict(demand, capacity)
    assert one.ratio == (None if ratio is None else pytest.approx(ratio))
    assert one.passed is passed
    row = one.row("stage")
    json.dumps(row, allow_nan=False)
    assert (row["id"], row["stage"], row["passed"]) == ("stage.gap", "stage", passed)


def test_scalars_count_given_capacities_alone():
    assert verdict_scalars([verdict(capacity=None), verdict(key="")]) == []
    exceeded, largest = verdict_scalars([verdict(), verdict(6.0), verdict(9.0, key="")])
    assert (exceeded.value, largest.value) == (1.0, 1.5)


def test_a_pair_in_words():
    assert pair_words("west.floor_3-east.floor_2") == "floor 3 of west and floor 2 of east"
    assert pair_words("west.floor_3-wall#2").endswith("wall (pair 2)")
