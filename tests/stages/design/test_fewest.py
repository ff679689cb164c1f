"""The fewest curves whose envelope is near that of all."""

import itertools

import numpy as np
import pytest

from impactfem.stages.design.fewest import fewest

CURVES = np.random.default_rng(4).random((9, 6))


@pytest.mark.parametrize("missed", [0.0, 0.05, 0.3])
def test_near_everywhere(missed):
    chosen = fewest(CURVES, missed=missed)
    assert np.all(CURVES[chosen].max(axis=0) >= (1.0 - missed) * CURVES.max(axis=0))
    # One less is not enough: each was taken for a place that nothing before came near to.
    assert np.any(CURVES[chosen[:-1]].max(axis=0) < (1.0 - missed) * CURVES.max(axis=0))


@pytest.mark.parametrize("missed", [0.05, 0.3])
def test_against_every_choice(missed):
    """By trial of all: no smaller set does, but for what a greedy choice may have more."""
    near = (1.0 - missed) * CURVES.max(axis=0)
    best = next(
        size
        for size in range(1, 10)
        if any(
            np.all(CURVES[list(some)].max(axis=0) >= near)
            for some in itertools.combinations(range(9), size)
        )
    )
    assert best <= len(fewest(CURVES, missed=missed)) <= best + 1


def test_one_that_has_it_all():
    curves = np.vstack([CURVES, CURVES.max(axis=0)])
    assert fewest(curves) == [9]


def test_no_more_than_allowed():
    chosen = fewest(CURVES, missed=0.0, most=2)
    assert len(chosen) == 2
    assert np.any(CURVES[chosen].max(axis=0) < CURVES.max(axis=0))


def test_nothing_moves():
    assert fewest(np.zeros((3, 4))) == [] and fewest(np.zeros((0, 4))) == []
