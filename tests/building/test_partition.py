import numpy as np
import pytest

from impactfem.building.assembly import bisect

RNG = np.random.default_rng(7)


@pytest.mark.parametrize("parts", [1, 2, 3, 4, 7])
def test_parts_weigh_about_the_same(parts):
    points = RNG.random((500, 3)) * [46.0, 15.0, 30.0]
    weights = RNG.choice([3.0, 6.0], 500)
    part = bisect(points, weights, parts)
    weight = np.bincount(part, weights, parts)
    # Each cut is off by less than one point; a point weighs 6 of at least 330.
    assert len(weight) == parts
    assert np.abs(weight - weights.sum() / parts).max() < 6.0 * np.ceil(np.log2(parts) + 1)


def test_the_longest_side_is_cut():
    x, y = np.meshgrid(np.arange(12.0), np.arange(3.0))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(36)])
    part = bisect(points, np.ones(36), 3)
    # Thirds of the length, 12 points each.
    assert part.tolist() == (points[:, 0] // 4).astype(int).tolist()


def test_a_heavy_point_is_alone():
    points = np.arange(5.0)[:, None] * [1.0, 0.0, 0.0]
    part = bisect(points, np.array([4.0, 1.0, 1.0, 1.0, 1.0]), 2)
    assert part.tolist() == [0, 1, 1, 1, 1]


def test_the_same_every_time():
    points = np.round(RNG.random((200, 3)), 1)  # with ties
    first, second = (bisect(points.copy(), np.ones(200), 5) for _ in range(2))
    assert first.tolist() == second.tolist()


def test_more_parts_than_points():
    part = bisect(np.eye(3), np.ones(3), 8)
    assert len(set(part)) == 3 and part.min() >= 0 and part.max() < 8


def test_no_point():
    assert bisect(np.zeros((0, 3)), np.zeros(0), 2).shape == (0,)
