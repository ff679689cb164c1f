"""Shapes of triangles with known circles."""

import numpy as np
import pytest

from impactfem.building.mesh import areas, radius_ratio, side_lengths

# 3-4-5: inscribed circle 1, circumscribed 2.5. Legs 1, 1: (2 - √2)/2 and √2/2.
TRIANGLES = [
    ([(0, 0, 0), (1, 0, 0), (0.5, np.sqrt(0.75), 0)], 1.0, np.sqrt(3.0) / 4.0),
    ([(0, 0, 0), (0, 3, 0), (0, 0, 4)], 0.8, 6.0),
    ([(5, 0, 0), (6, 0, 0), (5, 0, 1)], 2.0 * np.sqrt(2.0) - 2.0, 0.5),
    ([(0, 0, 0), (1, 1, 1), (2, 2, 2)], 0.0, 0.0),
    ([(0, 0, 0), (0, 0, 0), (0, 0, 0)], 0.0, 0.0),
]


@pytest.mark.parametrize(("points", "ratio", "area"), TRIANGLES)
def test_known_triangles(points, ratio, area):
    nodes, triangles = np.array(points, dtype=float), np.array([[0, 1, 2, 0, 0, 0]])
    assert radius_ratio(nodes, triangles) == pytest.approx(ratio, abs=1e-12)
    assert areas(nodes, triangles) == pytest.approx(area, abs=1e-12)


def test_side_lengths_in_order():
    nodes = np.array([(0.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 4.0)])
    np.testing.assert_allclose(side_lengths(nodes, np.array([[0, 1, 2]])), [[3.0, 5.0, 4.0]])


def test_the_ratio_does_not_know_size_and_place():
    nodes = np.random.default_rng(0).normal(size=(30, 3))
    triangles = np.arange(30).reshape(10, 3)
    turned = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    moved = 7.0 * nodes @ turned + 3.0
    np.testing.assert_allclose(radius_ratio(moved, triangles), radius_ratio(nodes, triangles))
